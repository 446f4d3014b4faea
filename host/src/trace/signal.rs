//! A line's level over time.

/// A line's level over time: the first level and the instants at which it changes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signal {
    first: bool,
    edges_s: Vec<f64>,
}

/// A time for which a line has one level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Its begin, seconds.
    pub begin_s: f64,
    /// Its end; none if the recording ends before.
    pub end_s: Option<f64>,
}

impl Signal {
    /// A line with this level that changes at these instants, which must not fall.
    pub fn new(first: bool, edges_s: Vec<f64>) -> Self {
        Self { first, edges_s }
    }

    /// A line from the levels that were told one after the other; those that are no change are left out.
    pub fn of_levels(levels: impl IntoIterator<Item = (f64, bool)>) -> Self {
        let mut signal = Self::default();
        let mut last = None;
        for (at_s, high) in levels {
            match last.replace(high) {
                None => signal.first = high,
                Some(before) if before != high => signal.edges_s.push(at_s),
                Some(_) => {}
            }
        }
        signal
    }

    /// Its level before the first change.
    pub fn first(&self) -> bool {
        self.first
    }

    /// The instants at which it changes, seconds.
    pub fn edges_s(&self) -> &[f64] {
        &self.edges_s
    }

    /// Its level just before an instant.
    pub fn is_high_at(&self, at_s: f64) -> bool {
        let before = self.edges_s.partition_point(|edge_s| *edge_s < at_s);
        self.first ^ (before % 2 == 1)
    }

    /// The instants at which it becomes high, or low.
    pub fn edges_to(&self, high: bool) -> impl Iterator<Item = f64> {
        let skipped = usize::from(self.first == high);
        self.edges_s.iter().skip(skipped).step_by(2).copied()
    }

    /// The times for which it is high, or low, that begin in the recording.
    pub fn pulses(&self, high: bool) -> Vec<Pulse> {
        let mut ends = self.edges_to(!high).peekable();
        let begins = self.edges_to(high);
        let pulse = |begin_s| {
            while ends.next_if(|end_s| *end_s < begin_s).is_some() {}
            let end_s = ends.peek().copied();
            Pulse { begin_s, end_s }
        };
        begins.map(pulse).collect()
    }

    /// Its changes from one instant up to another.
    pub fn between(&self, begin_s: f64, end_s: f64) -> &[f64] {
        let place = |limit_s: f64| self.edges_s.partition_point(|at_s| *at_s < limit_s);
        let (begin, end) = (place(begin_s), place(end_s));
        &self.edges_s[begin..end.max(begin)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_begin_in_the_recording_and_may_outlast_it() {
        let signal = Signal::new(true, vec![1.0, 2.0, 3.0, 4.0]);
        let pulse = |begin_s, end_s| Pulse { begin_s, end_s };
        let low = [pulse(1.0, Some(2.0)), pulse(3.0, Some(4.0))];
        assert_eq!(signal.pulses(false), low);
        assert_eq!(
            signal.pulses(true),
            [pulse(2.0, Some(3.0)), pulse(4.0, None)]
        );
        assert_eq!(signal.between(2.0, 4.0), [2.0, 3.0]);
        assert_eq!(signal.between(4.0, 2.0), [0.0; 0]);
    }

    #[test]
    fn a_level_told_again_is_no_change() {
        let told = [(0.0, true), (1.0, true), (2.0, false), (3.0, false)];
        assert_eq!(Signal::of_levels(told), Signal::new(true, vec![2.0]));
        assert_eq!(Signal::of_levels([]), Signal::default());
    }
}
