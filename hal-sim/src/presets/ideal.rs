//! `ideal`: equation (3) and the stated noise, nothing else.

use crate::spec::CourierSpec;
use crate::waveform::Waveform;
use effects::random::{ChaCha8Rng, SeedableRng, normal};

/// Rms of the drawn amplitudes of orders 1, 2, 4 and 6, metres: an offset of 6 %, a gain mismatch of 8 %, third harmonics
/// of 2 % and a remainder, by domain sizes of such sensors (1 % of amplitude is 1.6 um).
const AMPLITUDES_M: [f64; 4] = [9.0e-6, 7.0e-6, 3.0e-6, 1.2e-6];

/// A courier whose segments follow equation (3) exactly, its coefficients drawn from `seed`.
#[must_use]
pub fn ideal(seed: u64) -> CourierSpec {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x1dea_1000);
    let waveforms = core::array::from_fn(|_| {
        let mut k = [0.0; 9];
        k[0] = 5.0e-6 * normal(&mut rng);
        for (order, pair) in k[1..].chunks_exact_mut(2).enumerate() {
            pair.iter_mut()
                .for_each(|k| *k = AMPLITUDES_M[order] * normal(&mut rng));
        }
        Waveform::Equation3(k)
    });
    CourierSpec {
        device: format!("simulated courier, ideal, seed {seed}"),
        waveforms,
        ..CourierSpec::flawless()
    }
}
