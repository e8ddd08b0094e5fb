//! Tests of the whole file.

mod fixture;
mod round_trip;
