//! A reference that was logged more slowly than the segments, each value standing until the next: where it stands it is no measurement.

use crate::data::channels::{FEWEST_STEPS, MOVED, STEP_PITCHES};
use crate::data::observations::Observations;

/// Names of the columns.
const NAMES: [&str; 2] = ["ref_x_m", "ref_y_m"];

/// Leaves the repeated values of such a reference aside; what was left aside, a line for each column.
pub fn leave_aside(o: &mut Observations) -> Vec<String> {
    (0..2).filter_map(|axis| of_axis(o, axis)).collect()
}

fn of_axis(o: &mut Observations, axis: usize) -> Option<String> {
    let repeated: Vec<bool> = repeated(o, axis)?;
    let list = &mut o.reference[axis];
    let count = repeated.iter().filter(|r| **r).count();
    let samples = list.len();
    for (value, repeated) in list.iter_mut().zip(repeated) {
        if repeated {
            *value = f64::NAN;
        }
    }
    Some(format!(
        "{}: stands still while its segment moves: {count} of {samples} samples repeat the one before and are left out",
        NAMES[axis]
    ))
}

/// True where a value repeats the one before, if it does so while a segment of its axis moves; `None` of a reference that moves with it.
fn repeated(o: &Observations, axis: usize) -> Option<Vec<bool>> {
    let reference = &o.reference[axis];
    let own = [axis, axis + 2]
        .into_iter()
        .map(|s| &o.position_m[s])
        .find(|p| !p.is_empty())?;
    let same = |i: usize| {
        i > 0 && o.stretch[i] == o.stretch[i - 1] && reference.get(i) == reference.get(i - 1)
    };
    let (mut steps, mut stands) = (0usize, 0usize);
    for i in 1..reference.len() {
        let far = (own[i] - own[i - 1]).abs() > STEP_PITCHES * o.pitch_m;
        if far && o.stretch[i] == o.stretch[i - 1] && reference[i].is_finite() {
            steps += 1;
            stands += usize::from(same(i));
        }
    }
    let holds = steps >= FEWEST_STEPS && stands as f64 > (1.0 - MOVED) * steps as f64;
    holds.then(|| (0..reference.len()).map(same).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::motion::Pose;
    use effects::plant::Geometry;
    use hal_sim::courier::Courier;
    use hal_sim::presets::ideal;
    use hal_sim::trajectory::{OpenLoop, Plan};

    /// A sweep of 40 mm along x.
    fn observations() -> Observations {
        let half = Pose::new(0.02, 0.0, 0.0);
        let plan = Plan::new(Pose::default(), Geometry::PAPER, OpenLoop::COURIER, 5);
        let plan = plan.sweep_both_ways("x", [half.plus(half, -2.0), half], 0.05);
        let mut courier = Courier::new(ideal(5), 5).unwrap();
        Observations::new(&hal_sim::record::record(&mut courier, &plan, true)).unwrap()
    }

    fn finite(o: &Observations) -> usize {
        let list = o.reference[0].iter();
        list.filter(|r| r.is_finite()).count()
    }

    #[test]
    fn a_reference_that_stands_for_five_samples_is_taken_once() {
        let mut o = observations();
        let whole = o.clone();
        for i in 0..o.len() {
            o.reference[0][i] = whole.reference[0][i - i % 5];
        }
        let told = leave_aside(&mut o);
        assert!(
            told.len() == 1 && told[0].starts_with("ref_x_m"),
            "{told:?}"
        );
        let kept: Vec<usize> = (0..o.len())
            .filter(|&i| o.reference[0][i].is_finite())
            .collect();
        assert!(finite(&o).abs_diff(o.len() / 5) < 10, "{}", finite(&o));
        let right = |i: &&usize| o.reference[0][**i] == whole.reference[0][**i];
        assert!(kept.iter().filter(right).count() + 2 >= kept.len());
    }

    /// A reference that tells whole micrometres repeats itself where it is slow, and is right.
    #[test]
    fn a_reference_that_moves_with_the_segments_is_left_as_it_is() {
        let mut o = observations();
        let count = finite(&o);
        assert_eq!(leave_aside(&mut o), [""; 0]);
        for value in &mut o.reference[0] {
            *value = (*value * 1.0e6).round() / 1.0e6;
        }
        assert_eq!(leave_aside(&mut o), [""; 0]);
        assert_eq!(finite(&o), count);
    }
}
