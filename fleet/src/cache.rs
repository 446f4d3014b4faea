//! A cache of two: what was made for the key that was asked for last, and for the one that was last asked for twice in turn.
//!
//! A pattern search asks for many neighbours of its best guess, one after the other along each coordinate. What does not depend on a coordinate is the
//! same for both neighbours along it, and in the next round as well.

/// What was made for two keys.
pub struct Cache<K, V> {
    last: Option<(K, V)>,
    twice: Option<(K, V)>,
}

impl<K: PartialEq, V> Cache<K, V> {
    /// Of none yet.
    pub fn new() -> Self {
        Self {
            last: None,
            twice: None,
        }
    }

    /// What was made for a key, or is made now.
    pub fn get(&mut self, key: K, make: impl FnOnce() -> V) -> &V {
        let is_of = |made: &Option<(K, V)>| made.as_ref().is_some_and(|(of, _)| *of == key);
        if is_of(&self.last) {
            self.twice = self.last.take();
        }
        if is_of(&self.twice) {
            &self.twice.get_or_insert_with(|| (key, make())).1
        } else {
            &self.last.insert((key, make())).1
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One that was asked for twice in turn is kept while others are asked for once.
    #[test]
    fn what_was_asked_for_twice_is_made_once() {
        let (mut cache, mut made) = (Cache::new(), Vec::new());
        for key in [1, 2, 2, 3, 4, 2, 5, 2, 6, 6, 2] {
            let found = *cache.get(key, || {
                made.push(key);
                10 * key
            });
            assert_eq!(found, 10 * key);
        }
        assert_eq!(made, [1, 2, 3, 4, 5, 6, 2]);
    }
}
