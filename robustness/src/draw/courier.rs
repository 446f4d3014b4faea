//! A courier drawn at random: what is wrong with it, how noisy it is.

use super::chance::chance;
use effects::CATALOGUE;
use effects::motion::Pose;
use effects::plant::Scene;
use effects::random::{ChaCha8Rng, index, log_uniform, normal};
use effects::unlisted::UNLISTED;
use hal_sim::presets::ideal;
use hal_sim::spec::CourierSpec;
use hal_sim::waveform::Waveform;

/// Sizes of effects, rms m: from below the noise to a tenth of a tooth.
const SIZES_M: [f64; 2] = [1.0e-8, 1.0e-4];
/// Most effects of one courier.
const MOST: usize = 3;

/// Share whose error is a table: equation (3) is inverted point by point, which takes longer than all else of a small recording.
const TABLES: f64 = 0.8;
/// Points of a table: 16 a period of equation (3)'s highest order.
const POINTS: usize = 96;

/// The same error over the true displacement.
fn tabulated(waveform: &Waveform) -> Waveform {
    let at = |i| waveform.at(i as f64 / POINTS as f64);
    Waveform::Table((0..POINTS).map(at).collect())
}

/// The courier: equation (3), noise, bracket and effects drawn. `duration_s` is that of its motion.
pub fn spec(duration_s: f64, rng: &mut ChaCha8Rng) -> CourierSpec {
    let mut spec = ideal((normal(rng).abs() * 1.0e9) as u64);
    if chance(rng, TABLES) {
        spec.waveforms = spec.waveforms.map(|waveform| tabulated(&waveform));
    }
    spec.geometry.height_m *= 1.0 + 0.05 * normal(rng);
    spec.geometry.lever_m[0] *= 1.0 + 0.05 * normal(rng);
    spec.electronics.quadrature_noise_counts = log_uniform(rng, 0.1, 200.0);
    spec.electronics.psd_noise_counts = log_uniform(rng, 0.1, 20.0);
    spec.beacon_over = chance(rng, 0.7).then(Pose::default);
    let count = if chance(rng, 0.5) {
        0
    } else {
        1 + index(rng, MOST)
    };
    let scene = Scene {
        geometry: spec.geometry,
        duration_s,
        amplitude_counts: spec.electronics.amplitude_counts,
    };
    for _ in 0..count {
        let list = if chance(rng, 0.8) {
            CATALOGUE
        } else {
            UNLISTED
        };
        let entry = &list[index(rng, list.len())];
        let size_m = log_uniform(rng, SIZES_M[0], SIZES_M[1]);
        spec.effects.push((entry.draw)(&scene, rng, size_m));
    }
    spec
}
