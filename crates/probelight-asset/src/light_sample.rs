//! What the bytes of a light sample say.

use crate::LightSample;

impl LightSample {
    /// Whether the sample lies on the back face of its triangle.
    #[inline]
    pub fn is_back_face(&self) -> bool {
        self.base_color_and_side[3] != 0
    }
}
