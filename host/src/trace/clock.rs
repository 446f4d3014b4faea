//! The clock of a converter's bus, frame by frame.

use super::measure::Measured;
use super::{Pulse, Signal, Span};

/// What a bus's clock does in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Where the chip is selected, seconds.
    pub at_s: f64,
    /// Falling edges: a bit each.
    pub bits: usize,
    /// Its frequency, hertz; none where it has no two edges one after the other.
    pub frequency_hz: Option<f64>,
    /// What this frequency may be off by the recording's step, a share.
    pub off_share: f64,
}

/// The frames that the recording has whole.
pub fn frames(clock: &Signal, selected: &[Pulse], span: Span) -> Vec<Frame> {
    let falls_s: Vec<f64> = clock.edges_to(false).collect();
    let whole = selected
        .iter()
        .filter_map(|pulse| Some((pulse.begin_s, pulse.end_s?)));
    whole
        .map(|(begin_s, end_s)| {
            let place = |limit_s: f64| falls_s.partition_point(|at_s| *at_s < limit_s);
            let range = place(begin_s - span.step_s)..place(end_s + span.step_s);
            frame(begin_s, &falls_s[range], span.step_s)
        })
        .collect()
}

fn frame(at_s: f64, falls_s: &[f64], step_s: f64) -> Frame {
    let run = longest_run(falls_s, step_s);
    let length_s = run
        .last()
        .zip(run.first())
        .map(|(last, first)| last - first);
    let length_s = length_s.filter(|length_s| *length_s > 0.0);
    Frame {
        at_s,
        bits: falls_s.len(),
        frequency_hz: length_s.map(|length_s| (run.len() - 1) as f64 / length_s),
        off_share: length_s.map_or(0.0, |length_s| step_s / length_s),
    }
}

/// The longest run of edges without a pause: between two bytes a bus may rest.
fn longest_run(falls_s: &[f64], step_s: f64) -> &[f64] {
    let Some(period_s) = super::conversions::usual_period_s(falls_s) else {
        return falls_s;
    };
    let follows = |before: &f64, after: &f64| after - before <= 1.5 * period_s + step_s;
    falls_s
        .chunk_by(follows)
        .max_by_key(|run| run.len())
        .unwrap_or_default()
}

/// Edges of the clock while its chip is not selected.
pub fn astray(clock: &Signal, select: &Signal, span: Span) -> Vec<f64> {
    let mut low: Vec<Pulse> = select.pulses(false);
    if !select.first() {
        let end_s = select.edges_s().first().copied();
        low.insert(
            0,
            Pulse {
                begin_s: span.begin_s,
                end_s,
            },
        );
    }
    let is_astray = |at_s: &f64| {
        let before = low.partition_point(|pulse| pulse.begin_s - span.step_s <= *at_s);
        let last = before.checked_sub(1).and_then(|place| low.get(place));
        last.is_none_or(|pulse| pulse.end_s.is_some_and(|end_s| *at_s > end_s + span.step_s))
    };
    clock.edges_s().iter().copied().filter(is_astray).collect()
}

/// The frames' frequencies, and the most that one of them may be off, hertz.
pub fn frequencies_hz(frames: &[Frame]) -> (Vec<Measured>, f64) {
    let known = frames.iter().filter_map(|frame| {
        let value = frame.frequency_hz?;
        let at_s = frame.at_s;
        Some((Measured { at_s, value }, value * frame.off_share))
    });
    let (values, off_hz): (Vec<Measured>, Vec<f64>) = known.unzip();
    (values, off_hz.into_iter().fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPAN: Span = Span {
        begin_s: 0.0,
        end_s: 100.0,
        step_s: 0.01,
    };

    /// Clocks at these instants, low for half a second.
    fn clock(falls_s: &[f64]) -> Signal {
        Signal::new(
            true,
            falls_s
                .iter()
                .flat_map(|at_s| [*at_s, at_s + 0.5])
                .collect(),
        )
    }

    #[test]
    fn a_rest_between_bytes_does_not_count_into_the_frequency() {
        let falls_s = [11.0, 12.0, 13.0, 14.0, 20.0, 21.0, 22.0];
        let select = Signal::new(true, vec![10.0, 30.0, 40.0]);
        let found = frames(&clock(&falls_s), &select.pulses(false), SPAN);
        assert_eq!(found.len(), 1, "the second frame has no end");
        assert_eq!((found[0].bits, found[0].frequency_hz), (7, Some(1.0)));
        assert!((found[0].off_share - 0.01 / 3.0).abs() < 1.0e-12);
    }

    #[test]
    fn edges_outside_a_select_are_found() {
        let select = Signal::new(false, vec![5.0, 10.0, 20.0]);
        let found = astray(&clock(&[4.0, 4.505, 7.0, 12.0, 25.0]), &select, SPAN);
        assert_eq!(found, [7.0, 7.5, 25.0, 25.5]);
    }

    #[test]
    fn a_frame_without_clocks_has_no_frequency() {
        let select = Signal::new(true, vec![10.0, 30.0]);
        let found = frames(&clock(&[]), &select.pulses(false), SPAN);
        assert_eq!((found[0].bits, found[0].frequency_hz), (0, None));
    }
}
