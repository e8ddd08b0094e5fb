// Scalar signals whose largest change counts for all of them.
const SOURCE_SIGNALS: u32 = 64u;
