//! How long handlers take, from entry to return, what interrupts them included.

use std::collections::BTreeMap;

/// Cycles of one exception's handlers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spent {
    /// The longest.
    pub worst: u64,
    /// All together.
    pub sum: u64,
    /// How many.
    pub count: u64,
}

/// Handlers that run, and what those before them took.
#[derive(Clone, Debug, Default)]
pub struct Times {
    running: Vec<(u16, u64)>,
    spent: BTreeMap<u16, Spent>,
}

impl Times {
    /// An exception is taken, at this number of cycles.
    pub fn enter(&mut self, exception: u16, cycles: u64) {
        self.running.push((exception, cycles));
    }

    /// The innermost handler returns.
    pub fn leave(&mut self, cycles: u64) {
        if let Some((exception, since)) = self.running.pop() {
            let spent = self.spent.entry(exception).or_default();
            spent.worst = spent.worst.max(cycles - since);
            spent.sum += cycles - since;
            spent.count += 1;
        }
    }

    /// What an exception's handlers took so far.
    pub fn of(&self, exception: u16) -> Spent {
        self.spent.get(&exception).copied().unwrap_or_default()
    }

    /// Begins to count anew; handlers that run are not counted.
    pub fn restart(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_handlers_are_told_apart() {
        let mut times = Times::default();
        times.enter(20, 100);
        times.enter(30, 120);
        times.leave(150);
        times.leave(200);
        times.enter(20, 300);
        times.leave(310);
        let spent = |worst, sum, count| Spent { worst, sum, count };
        assert_eq!(times.of(20), spent(100, 110, 2));
        assert_eq!(times.of(30), spent(30, 30, 1));
    }
}
