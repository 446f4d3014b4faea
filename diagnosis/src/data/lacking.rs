//! Which motion a recording lacks, from what its readings leave undetermined.
//!
//! Equation (3) of a segment wants its tooth phase seen all round, which a run along the segment's own direction does. The two segments of
//! an axis are told apart by turning, where neither a beacon nor a reference tells them.

use crate::algebra::statistics::{deviation, median};
use crate::data::coverage::{PHASES, SIXTEENTHS, TURNED_MRAD, phases};
use crate::data::observations::Observations;

/// Samples of each sixteenth of a tooth that a run should see: twice what a single one would need, for a start in the middle of
/// one. A derivation: a uniform run then has one at least in each, wherever it starts.
const SAMPLES_A_SIXTEENTH: f64 = 2.0;
/// Teeth that a run passes at least, so that each phase is seen in it whatever place it starts from. A derivation: one whole
/// tooth, and as much again for the ends at which a courier gathers speed.
const TEETH: f64 = 2.0;

/// A planar motor's speed, m/s: where the rate of sampling allows more, no speed is named. A prior: delays of such sensors are
/// stated for 1.5 m/s, and a third more is taken.
const FASTEST_M_S: f64 = 2.0;

/// The motions, each as what is to be recorded besides. Empty where motion is not what lacks.
pub fn motions(o: &Observations) -> Vec<String> {
    let mut list = Vec::new();
    for (axis, name) in ["x", "y"].into_iter().enumerate() {
        let dark: Vec<usize> = [axis, axis + 2]
            .into_iter()
            .filter(|s| o.has_segment(*s) && phases(o, *s) < PHASES)
            .collect();
        if !dark.is_empty() {
            list.push(along(o, name, TEETH));
        }
    }
    list.extend(turn(o));
    list
}

/// A run in a direction over so many teeth, as slowly as the rate of sampling wants.
fn along(o: &Observations, direction: &str, teeth: f64) -> String {
    let way_m = teeth * o.pitch_m;
    let mut steps: Vec<f64> = (1..o.len())
        .filter(|&i| o.run[i] == o.run[i - 1])
        .map(|i| o.t_s[i] - o.t_s[i - 1])
        .collect();
    let samples = SAMPLES_A_SIXTEENTH * SIXTEENTHS as f64;
    let step_s = median(&mut steps).filter(|step_s| *step_s > 0.0);
    let speed_m_s = step_s.map(|step_s| o.pitch_m / (samples * step_s));
    let slowly = speed_m_s
        .filter(|v| *v < FASTEST_M_S)
        .map_or(String::new(), |speed_m_s| {
            format!(
                ", at {} mm/s or less ({} s or more)",
                figure(1e3 * speed_m_s),
                figure(way_m / speed_m_s)
            )
        });
    format!(
        "a run along {direction} over {} mm or more{slowly}",
        figure(1e3 * way_m)
    )
}

/// A turn, where the segments of an axis are told apart by nothing else.
fn turn(o: &Observations) -> Option<String> {
    let all = (0..4).all(|s| o.has_segment(s));
    let others = o.tan_psi.iter().any(|t| t.iter().any(|v| v.is_finite()))
        || o.reference.iter().any(|r| !r.is_empty());
    if !all || others {
        return None;
    }
    let angle_mrad = |i: usize| 1e3 * (o.position_m[0][i] - o.position_m[2][i]) / o.span_m;
    let known = (0..o.len()).map(angle_mrad).filter(|a| a.is_finite());
    let turned = deviation(&known.collect::<Vec<f64>>());
    // A steady turn from one side to the other deviates by its half width over the root of three.
    let wanted = 3.0_f64.sqrt() * TURNED_MRAD;
    (turned < TURNED_MRAD).then(|| format!("a turn by {wanted:.1} mrad or more to either side"))
}

/// Two digits.
fn figure(value: f64) -> String {
    let digits = (1 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::motion::Pose;
    use effects::plant::Geometry;
    use hal_sim::courier::Courier;
    use hal_sim::presets::ideal;
    use hal_sim::trajectory::{OpenLoop, Plan};

    /// What a courier lacks that made this motion, without a beacon.
    fn lacking(motion: impl Fn(Plan) -> Plan) -> Vec<String> {
        let plan = Plan::new(Pose::default(), Geometry::PAPER, OpenLoop::EXACT, 5);
        let spec = hal_sim::spec::CourierSpec {
            beacon_over: None,
            ..ideal(5)
        };
        let recording =
            hal_sim::record::record(&mut Courier::new(spec, 5).unwrap(), &motion(plan), false);
        motions(&Observations::new(&recording).unwrap())
    }

    #[test]
    fn what_a_motion_leaves_open_is_told_and_what_it_shows_is_not() {
        let x = Pose::new(5.0e-3, 0.0, 0.0);
        let both = [x.plus(x, -2.0), x];
        let along_x = lacking(|plan| plan.sweep_both_ways("x", both, 0.02));
        assert!(
            along_x[0].starts_with("a run along y over 2.0 mm or more, at 32 mm/s or less"),
            "{along_x:?}"
        );
        // A slanted way with a turn shows everything.
        let turned = [
            Pose::new(-5.0e-3, -5.0e-3, -0.01),
            Pose::new(5.0e-3, 5.0e-3, 0.01),
        ];
        assert_eq!(lacking(|plan| plan.sweep("slanted", turned, 0.02)), [""; 0]);
    }
}
