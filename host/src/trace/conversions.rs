//! What belongs to one conversion: from one pulse of CONVST to the next.

use super::{Line, Lines, Pulse, Signal, Span};

/// A conversion, and what the other lines do until the next one. A line that is not recorded has no pulses.
#[derive(Clone, Debug, PartialEq)]
pub struct Conversion {
    /// CONVST rises, seconds.
    pub at_s: f64,
    /// Pulses of BUSY.
    pub busy: Vec<Pulse>,
    /// Times for which converter 0 and converter 1 are selected.
    pub selected: [Vec<Pulse>; 2],
}

/// The usual time between two of these instants, which is none where there are not two: of those in the middle the lesser.
pub fn usual_period_s(at_s: &[f64]) -> Option<f64> {
    let mut periods: Vec<f64> = at_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    periods.sort_by(f64::total_cmp);
    let middle = periods.len().checked_sub(1)? / 2;
    periods.get(middle).copied()
}

/// The conversions that the recording has whole. `period_s`: how long the last one lasts.
pub fn conversions(lines: &Lines, span: Span, period_s: f64) -> Vec<Conversion> {
    let begins_s: Vec<f64> = lines
        .get(Line::Convst)
        .map(|convst| convst.edges_to(true).collect())
        .unwrap_or_default();
    let pulses = |line, high| {
        let signal: Option<&Signal> = lines.get(line);
        signal.map(|signal| signal.pulses(high)).unwrap_or_default()
    };
    let busy = pulses(Line::Busy, true);
    let selected = [0, 1].map(|chip| pulses(Line::Select(chip), false));
    let ends_s = begins_s.iter().skip(1).copied();
    let last_s = begins_s.last().map(|begin_s| begin_s + period_s);
    let ends_s = ends_s.chain(last_s.filter(|end_s| *end_s <= span.end_s + span.step_s));
    // What follows CONVST at once may be recorded a step before it.
    let of = |pulses: &[Pulse], begin_s: f64, end_s: f64| {
        let place = |limit_s: f64| pulses.partition_point(|p| p.begin_s < limit_s - span.step_s);
        pulses[place(begin_s)..place(end_s)].to_vec()
    };
    begins_s
        .iter()
        .zip(ends_s)
        .map(|(begin_s, end_s)| Conversion {
            at_s: *begin_s,
            busy: of(&busy, *begin_s, end_s),
            selected: [0, 1].map(|chip| of(&selected[chip], *begin_s, end_s)),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_conversion_has_what_comes_before_the_next() {
        let mut lines = Lines::default();
        lines.put(
            Line::Convst,
            Signal::new(false, vec![1.0, 1.1, 2.0, 2.1, 3.0]),
        );
        lines.put(
            Line::Busy,
            Signal::new(true, vec![0.5, 0.99, 1.2, 2.0, 2.2]),
        );
        lines.put(Line::Select(1), Signal::new(true, vec![1.5]));
        let span = Span {
            begin_s: 0.0,
            end_s: 3.5,
            step_s: 0.02,
        };
        let found = conversions(&lines, span, 1.0);
        let pulse = |begin_s, end_s| Pulse { begin_s, end_s };
        let wanted = [
            Conversion {
                at_s: 1.0,
                busy: vec![pulse(0.99, Some(1.2))],
                selected: [vec![], vec![pulse(1.5, None)]],
            },
            Conversion {
                at_s: 2.0,
                busy: vec![pulse(2.0, Some(2.2))],
                selected: [vec![], vec![]],
            },
        ];
        assert_eq!(found, wanted);
        let longer = Span { end_s: 4.0, ..span };
        assert_eq!(conversions(&lines, longer, 1.0).len(), 3);
    }

    #[test]
    fn one_period_twice_as_long_is_not_the_usual_one() {
        assert_eq!(usual_period_s(&[0.0, 1.0, 3.0]), Some(1.0));
        assert_eq!(usual_period_s(&[0.0, 2.0, 4.0, 5.0]), Some(2.0));
        assert_eq!(usual_period_s(&[0.0]), None);
    }
}
