//! Levels of detail that hold a similarity of pictures.

/// Nearest and farthest levels that are tried, as powers of two on their distances.
const OCTAVES: [f32; 2] = [-6.0, 3.0];

/// Times that the middle is tried.
const BISECTIONS: u32 = 6;

/// Finds, by bisection, how near levels may begin so that a picture stays as similar as wanted to the one without levels.
///
/// Whoever has it draws the picture of each [`scale`](Self::scale), by
/// [`with_distances_scaled`](crate::LodSettings::with_distances_scaled), and [notes](Self::note) how similar it is.
#[derive(Clone, Debug)]
pub struct SimilaritySearch {
    least: f64,
    too_near: f32,
    /// Nothing nearer is known to be similar enough.
    far_enough: f32,
    tried: u32,
}

impl SimilaritySearch {
    /// For pictures that are at least so similar.
    pub fn new(least: f64) -> Self {
        let [too_near, far_enough] = OCTAVES;
        Self { least, too_near, far_enough, tried: 0 }
    }

    /// The factor on distances to be tried next; `None` once the answer is found. The first is the largest.
    pub fn scale(&self) -> Option<f32> {
        let octave = if self.tried == 0 { self.far_enough } else { self.too_near.midpoint(self.far_enough) };
        (self.tried <= BISECTIONS).then_some(octave.exp2())
    }

    /// Takes how similar the picture of [`scale`](Self::scale) is. Returns whether that is enough.
    pub fn note(&mut self, similarity: f64) -> bool {
        let is_enough = similarity >= self.least;
        if self.tried > 0 {
            let octave = self.too_near.midpoint(self.far_enough);
            *(if is_enough { &mut self.far_enough } else { &mut self.too_near }) = octave;
        }
        self.tried += 1;
        is_enough
    }

    /// The smallest factor whose picture was similar enough; the largest one if none was.
    pub fn found(&self) -> f32 {
        self.far_enough.exp2()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn search(similarity: impl Fn(f32) -> f64) -> f32 {
        let mut search = SimilaritySearch::new(0.98);
        let mut pictures = 0;
        while let Some(scale) = search.scale() {
            search.note(similarity(scale));
            pictures += 1;
        }
        assert_eq!(pictures, 1 + BISECTIONS);
        search.found()
    }

    #[test]
    fn the_nearest_levels_that_are_similar_enough_are_found() {
        for limit in [0.05f32, 0.4, 1.0, 3.0] {
            let found = search(|scale| if scale >= limit { 0.99 } else { 0.9 });
            assert!(found >= limit && found < 1.2 * limit, "{found} for {limit}");
        }
        assert_eq!(search(|_| 0.5), 8.0, "none is: the farthest levels there are");
        assert!(search(|_| 1.0) < 0.02, "all are");
    }
}
