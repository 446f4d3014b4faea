//! Couriers of the paper's make: many of them, as a hall has, over the same or other platens.

use super::paper::{Build, FIELD_SEED, built};
use crate::spec::CourierSpec;
use effects::motion::Pose;
use effects::random::{ChaCha8Rng, SeedableRng, normal, uniform};

/// How far the make's brackets are off the drawing, m: height, lever arms, both spans. The paper's courier is off by 1.1, 0.7 and 0.4 mm; a span
/// is milled into one block.
const HEIGHT_M: f64 = 1.0e-3;
/// See [`HEIGHT_M`].
const LEVER_M: f64 = 0.6e-3;
/// See [`HEIGHT_M`].
const SPAN_M: f64 = 20.0e-6;
/// Where a courier is switched on, teeth either way from the corner of its usual runs.
const HOME_TEETH: f64 = 6.0;

/// A courier of the paper's make: its waves, its diode and its mounts are drawn by `courier`, of the sizes that those of the paper's courier have;
/// the teeth under it by `platen`. None: the paper's own.
#[must_use]
pub fn of_the_make(courier: Option<u64>, platen: Option<u64>) -> CourierSpec {
    let platen = platen.unwrap_or(FIELD_SEED);
    let Some(seed) = courier else {
        return built("simulated courier, paper".into(), &Build::PAPER, platen);
    };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let build = drawn(&mut rng);
    let mut spec = built(
        format!("simulated courier {seed} of the paper's make"),
        &build,
        platen,
    );
    spec.number = super::device_number("make", seed);
    let pitch_m = build.geometry.pitch_m;
    let mut home_m = || pitch_m * uniform(&mut rng, -HOME_TEETH, HOME_TEETH);
    spec.places.scatter_corner = Pose::new(home_m(), home_m(), 0.0);
    spec
}

/// Each coefficient of the rms of its like in the paper's courier.
fn drawn(rng: &mut ChaCha8Rng) -> Build {
    let mut build = Build::PAPER;
    for order in 0..4 {
        let of_it = 2 * order..2 * order + 2;
        let values = Build::PAPER
            .waveforms_um
            .map(|k| [k[of_it.start], k[of_it.start + 1]]);
        let rms = rms(values.as_flattened());
        for segment in &mut build.waveforms_um {
            segment[of_it.clone()]
                .iter_mut()
                .for_each(|k| *k = rms * normal(rng));
        }
    }
    let rms_um = rms(Build::PAPER.lateral_um.as_flattened().as_flattened());
    let lateral = build.lateral_um.as_flattened_mut().as_flattened_mut();
    lateral.iter_mut().for_each(|k| *k = rms_um * normal(rng));
    build
        .psd
        .as_flattened_mut()
        .iter_mut()
        .for_each(|k| *k *= normal(rng));
    let geometry = &mut build.geometry;
    let nominal = effects::plant::Geometry::PAPER;
    geometry.height_m = nominal.height_m + HEIGHT_M * normal(rng);
    geometry.lever_m = nominal.lever_m.map(|l| l + LEVER_M * normal(rng));
    geometry.span_m = nominal.span_m + SPAN_M * normal(rng);
    build
}

fn rms(values: &[f64]) -> f64 {
    effects::shape::root_mean_square(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coordination::origin_under;

    #[test]
    fn couriers_differ_and_their_beacon_does_not() {
        let specs = [
            of_the_make(None, None),
            of_the_make(Some(1), None),
            of_the_make(Some(2), Some(9)),
        ];
        let origins = specs
            .each_ref()
            .map(|spec| origin_under(&spec.geometry, spec.beacon_over.expect("a beacon")));
        for origin in origins {
            assert!((0..2).all(|k| (origin[k] - origins[0][k]).abs() < 1e-12));
        }
        assert_ne!(specs[1].geometry, specs[2].geometry);
        assert_ne!(specs[1].number, specs[2].number);
        assert_eq!(of_the_make(Some(2), None).geometry, specs[2].geometry);
    }
}
