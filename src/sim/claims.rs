//! The set of claimed items, with one bit per item.

/// A set of item indices.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Claims {
    words: Vec<u64>,
}

impl Claims {
    /// The empty set for `items` items.
    pub(super) fn none(items: usize) -> Self {
        Self {
            words: vec![0; items.div_ceil(64)],
        }
    }

    /// Clears the set and resizes it for `items` items.
    pub(super) fn reset(&mut self, items: usize) {
        self.words.clear();
        self.words.resize(items.div_ceil(64), 0);
    }

    #[inline(always)]
    pub(super) fn contains(&self, item: u32) -> bool {
        self.words[item as usize / 64] >> (item % 64) & 1 == 1
    }

    #[inline(always)]
    pub(super) fn insert(&mut self, item: u32) {
        self.words[item as usize / 64] |= 1 << (item % 64);
    }

    pub(super) fn remove(&mut self, item: u32) {
        self.words[item as usize / 64] &= !(1 << (item % 64));
    }

    /// Becomes a copy of `other`, whatever its size was.
    pub(super) fn reset_to(&mut self, other: &Self) {
        self.words.clone_from(&other.words);
    }

    /// The bits, 64 items a word.
    pub(super) fn words(&self) -> &[u64] {
        &self.words
    }

    pub(super) fn copy_from_words(&mut self, words: &[u64]) {
        self.words.copy_from_slice(words);
    }

    /// The highest index below `items` that is not in the set. This is the last unpicked item to
    /// leave the belt, because patterns are sorted downstream first.
    pub(super) fn last_missing(&self, items: usize) -> Option<usize> {
        let last = self.words.len() - 1;
        (0..=last).rev().find_map(|w| {
            let used = if w == last { (items - 1) % 64 + 1 } else { 64 };
            let missing = !self.words[w] & (u64::MAX >> (64 - used));
            (missing != 0).then(|| w * 64 + 63 - missing.leading_zeros() as usize)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_missing_is_the_highest_free_index() {
        for items in [1, 63, 64, 65, 130] {
            let mut claims = Claims::none(items);
            for expected in (0..items).rev() {
                assert_eq!(claims.last_missing(items), Some(expected));
                claims.insert(expected as u32);
            }
            assert_eq!(claims.last_missing(items), None);
        }
    }
}
