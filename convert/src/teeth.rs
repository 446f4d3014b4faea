//! Tooth counts of a log that has none: the phase of sine and cosine, followed from sample to sample.

/// Tooth counts, and how sure they are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counted {
    /// The whole count of each sample; none where the pair was not measured.
    pub teeth: Vec<Option<i32>>,
    /// The output in pitches: count and phase together; NaN where not measured.
    pub turns: Vec<f64>,
    /// Largest step from one sample to the next, pitches.
    pub largest_step: f64,
    /// Steps that are as likely to be whole pitches longer or shorter, and the first sample of such a step.
    pub unsure: usize,
    /// Index of the first sample behind such a step.
    pub first_unsure: Option<usize>,
    /// Steps that the reference made whole pitches longer or shorter.
    pub guided: usize,
}

/// An encoder that nobody calibrated is wrong by up to so much of its pitch: 30 µm of a millimetre, the largest that the paper's sensor
/// and real encoders show.
pub const OWN_ERROR_PITCHES: f64 = 0.03;
/// A step to the next sample that differs from the step before by more than half a pitch, and one of at least this length, is
/// unsure: at half a pitch the shorter way round and the longer one are alike, and the sensor's own error at both ends decides.
pub const UNSURE_STEP: f64 = 0.5 - 2.0 * OWN_ERROR_PITCHES;

/// Counts teeth.
///
/// `phases` are turns in [-0.5, 0.5] with NaN where not measured, `guide` is the reference's place in pitches with NaN where it was
/// not measured. With a guide each step is the one nearest to the guide's; without, the shorter way round the circle.
#[must_use]
pub fn count(phases: &[f64], guide: Option<&[f64]>) -> Counted {
    let mut counted = Counted::default();
    let mut last: Option<(usize, f64)> = None;
    let mut step_before: Option<f64> = None;
    for (index, &phase) in phases.iter().enumerate() {
        if phase.is_nan() {
            counted.teeth.push(None);
            counted.turns.push(f64::NAN);
            continue;
        }
        let turns = match last {
            None => phase + first_tooth(phase, guide.map(|guide| guide[index])),
            Some((before, turns_before)) => {
                let step = nearest_step(phase - turns_before);
                let expected = guide.map_or(f64::NAN, |guide| guide[index] - guide[before]);
                let step = counted.decide(index, step, expected, step_before);
                step_before = Some(step);
                turns_before + step
            }
        };
        last = Some((index, turns));
        counted.teeth.push(Some((turns - phase).round() as i32));
        counted.turns.push(turns);
    }
    counted
}

impl Counted {
    fn decide(&mut self, index: usize, step: f64, expected: f64, before: Option<f64>) -> f64 {
        if expected.is_finite() {
            let whole = (expected - step).round();
            self.guided += usize::from(whole != 0.0);
            self.largest_step = self.largest_step.max((step + whole).abs());
            return step + whole;
        }
        self.largest_step = self.largest_step.max(step.abs());
        let turned = before.is_some_and(|before| (step - before).abs() > 0.5);
        if turned || step.abs() > UNSURE_STEP {
            self.unsure += 1;
            self.first_unsure.get_or_insert(index);
        }
        step
    }
}

/// The difference of two phases by the shorter way round, [-0.5, 0.5].
fn nearest_step(difference: f64) -> f64 {
    difference - difference.round()
}

/// The count with which the first output is where the guide is.
fn first_tooth(phase: f64, guide: Option<f64>) -> f64 {
    guide
        .filter(|place| place.is_finite())
        .map_or(0.0, |place| (place - phase).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn phases(turns: &[f64]) -> Vec<f64> {
        turns.iter().map(|turns| turns - turns.round()).collect()
    }

    #[test]
    fn a_path_is_followed_both_ways_and_across_what_was_not_measured() {
        let turns: Vec<f64> = (0..200)
            .map(|k| 3.0 * (0.05 * f64::from(k)).sin())
            .collect();
        let mut seen = phases(&turns);
        seen[50] = f64::NAN;
        let counted = count(&seen, None);
        assert_eq!((counted.unsure, counted.teeth[50]), (0, None));
        for (index, turns) in turns.iter().enumerate().filter(|(index, _)| *index != 50) {
            assert!((counted.turns[index] - turns).abs() < 1e-9, "{index}");
        }
    }

    #[test]
    fn steps_of_over_half_a_pitch_are_seen_and_a_reference_decides() {
        let turns: Vec<f64> = (0..100).map(|k| 0.01 * f64::from(k * k) / 2.0).collect();
        let alone = count(&phases(&turns), None);
        assert!(alone.unsure > 0 && (alone.turns[99] - turns[99]).abs() > 1.0);
        let guide: Vec<f64> = turns
            .iter()
            .map(|turns| turns + 0.1 * turns.sin() + 7.0)
            .collect();
        let guided = count(&phases(&turns), Some(&guide));
        assert_eq!(guided.unsure, 0);
        assert!(guided.guided > 0 && (guided.turns[99] - turns[99] - 7.0).abs() < 1e-9);
    }

    #[test]
    fn even_steps_near_half_a_pitch_are_unsure() {
        let even = |step: f64| (0..50).map(|k| step * f64::from(k)).collect::<Vec<f64>>();
        assert_eq!(count(&phases(&even(0.46)), None).unsure, 49);
        assert_eq!(count(&phases(&even(0.4)), None).unsure, 0);
    }
}
