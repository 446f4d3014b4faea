//! Whole teeth: which segment lost them, told by its own step or by the beacon.
use specimens::rig;

use diagnosis::data::motion::Motion;
use diagnosis::data::observations::Observations;
use diagnosis::data::slips::repair_slips;

fn observations(beacon: bool) -> Observations {
    let options = rig::Options {
        samples: 4000,
        beacon,
        commanded: false,
        ..rig::Options::default()
    };
    Observations::new(&rig::record(41, &[], &options).0).unwrap()
}

/// Slips each segment by each of one tooth at a sample and looks what is found.
fn told(clean: &Observations, sample: usize) {
    for segment in 0..4 {
        for teeth in [-1, 1] {
            let mut slipped = clean.clone();
            let step_m = f64::from(teeth) * clean.pitch_m;
            for position in &mut slipped.position_m[segment][sample..] {
                *position += step_m;
            }
            let slips = repair_slips(&mut slipped);
            assert_eq!(slips.len(), 1, "segment {segment}, {teeth} teeth");
            let slip = slips[0];
            assert_eq!(
                (slip.segment, slip.teeth, slip.sample),
                (segment, teeth, sample)
            );
            assert!(slip.sure);
            let off = |i: usize| slipped.position_m[segment][i] - clean.position_m[segment][i];
            assert!((0..clean.len()).all(|i| off(i).abs() < 1.0e-9));
        }
    }
}

#[test]
fn in_travel_the_segment_that_steps_is_told() {
    let clean = observations(false);
    let smooth = Motion::new(&clean, &clean.position_m).smooth;
    let along =
        |i: usize| (i - 40..i + 40).all(|j| smooth[j] && clean.stretch[j] == clean.stretch[i]);
    let middle = (100..clean.len() - 40).find(|&i| along(i)).unwrap();
    told(&clean, middle);
}

#[test]
fn between_two_poses_the_beacon_tells_the_segment() {
    let clean = observations(true);
    let seen = |i: &usize| clean.sees_beacon(*i);
    let place = (200..clean.len())
        .find(|&i| {
            clean.stretch[i] != clean.stretch[i - 1]
                && (i - 100..i).filter(seen).count() > 50
                && (i..(i + 100).min(clean.len())).filter(seen).count() > 50
        })
        .unwrap();
    told(&clean, place);
}
