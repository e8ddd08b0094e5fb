//! Packed words that may be read past their end.

use super::unpack::MOST_WORDS;

/// A copy of the last clusters' words in an array, with zeros behind them.
///
/// Kernels read lines in whole vectors, the last of which reaches into what follows the line. Only at the end of
/// the array does nothing follow; a check for that inside the loops would cost them their registers.
#[derive(Clone, Debug)]
pub(super) struct PaddedEnd {
    /// Where in the array the copy starts.
    start: usize,
    words: Vec<u32>,
}

impl PaddedEnd {
    /// For an array in which clusters start at `offsets` (ascending).
    pub(super) fn new(words: &[u32], offsets: impl DoubleEndedIterator<Item = u64>) -> Self {
        let start = offsets
            .rev()
            .map(|offset| offset as usize)
            .find(|offset| offset + MOST_WORDS <= words.len())
            .unwrap_or(0);
        Self { start, words: [&words[start..], &[0; MOST_WORDS]].concat() }
    }

    /// The array's words from `offset` on, with at least [`MOST_WORDS`] behind the cluster that starts there.
    #[inline]
    pub(super) fn words_from<'a>(&'a self, words: &'a [u32], offset: u64) -> &'a [u32] {
        match (offset as usize).checked_sub(self.start) {
            Some(offset) => &self.words[offset..],
            None => &words[offset as usize..],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cluster_has_words_behind_it() {
        let words: Vec<u32> = (0..30).collect();
        let offsets = [0, 3, 21, 22, 22, 27, 30, 30];
        let end = PaddedEnd::new(&words, offsets.into_iter());
        for (cluster, offset) in offsets.into_iter().enumerate() {
            let length = offsets.get(cluster + 1).map_or(30, |next| *next) - offset;
            let read = end.words_from(&words, offset);
            assert!(read.len() >= length as usize + MOST_WORDS, "cluster {cluster}");
            assert!(
                read.iter().zip(offset as u32..).all(|(word, expected)| *word == expected || expected >= 30)
            );
        }
        assert_eq!(end.words.len(), 8 + MOST_WORDS, "the copy is longer than it must be");
    }

    #[test]
    fn arrays_may_be_short_or_empty() {
        let of_nothing = PaddedEnd::new(&[], [0].into_iter());
        assert_eq!(of_nothing.words_from(&[], 0), [0; MOST_WORDS]);
        assert_eq!(PaddedEnd::new(&[], [].into_iter()).words_from(&[], 0), [0; MOST_WORDS]);
        assert_eq!(PaddedEnd::new(&[7], [0, 1].into_iter()).words_from(&[7], 1), [0; MOST_WORDS]);
    }
}
