//! What a blind case is: a courier, what is wrong with it, and how it is recorded. All of it drawn from a seed.

use effects::Detection;
use effects::plant::Scene;
use effects::random::{ChaCha8Rng, SeedableRng, index, log_uniform, normal, uniform};
use effects::{CATALOGUE, entry, unlisted::UNLISTED};
use hal_sim::courier::Courier;
use hal_sim::presets::ideal;
use hal_sim::spec::CourierSpec;
use hal_sim::trajectory::{OpenLoop, Plan};
use recording::Recording;
use serde::{Deserialize, Serialize};

/// Sizes of effects, rms m.
pub const SIZES_M: [f64; 2] = [0.7e-6, 4.0e-6];
/// Still poses of each kind: with the moving runs some 10 500 samples.
const POSES: usize = 2000;
/// Relative error of the beacon's height and levers as built.
const BUILD_ERROR: f64 = 0.02;

/// What is wrong with a courier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Nothing.
    None,
    /// One catalogued effect.
    Single,
    /// Two catalogued effects.
    Pair,
    /// One effect that is in no catalogue.
    Unlisted,
}

/// One effect of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drawn {
    /// Its name.
    pub name: String,
    /// Rms over the motion that its file states, m.
    pub size_m: f64,
}

/// One case: everything follows from these.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Number, from 0.
    pub number: usize,
    /// Seed of the courier, its effects and its motion.
    pub seed: u64,
    /// What is wrong.
    pub kind: Kind,
    /// With which sizes.
    pub effects: Vec<Drawn>,
}

impl Case {
    /// Draws case `number` of a campaign: nothing in 15 %, one effect in 45 %, two in 20 %, an unlisted one in 20 %.
    #[must_use]
    pub fn draw(number: usize, campaign: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(campaign);
        rng.set_stream(number as u64);
        let seed = (uniform(&mut rng, 0.0, 1.0) * 2.0_f64.powi(52)) as u64;
        let kind = match uniform(&mut rng, 0.0, 1.0) {
            u if u < 0.15 => Kind::None,
            u if u < 0.60 => Kind::Single,
            u if u < 0.80 => Kind::Pair,
            _ => Kind::Unlisted,
        };
        let names: Vec<&str> = match kind {
            Kind::None => Vec::new(),
            Kind::Single => vec![CATALOGUE[index(&mut rng, CATALOGUE.len())].name],
            Kind::Unlisted => vec![UNLISTED[index(&mut rng, UNLISTED.len())].name],
            Kind::Pair => {
                let first = index(&mut rng, CATALOGUE.len());
                let second = (first + 1 + index(&mut rng, CATALOGUE.len() - 1)) % CATALOGUE.len();
                vec![CATALOGUE[first].name, CATALOGUE[second].name]
            }
        };
        let effects = names
            .into_iter()
            .map(|name| Drawn {
                name: name.into(),
                size_m: log_uniform(&mut rng, SIZES_M[0], SIZES_M[1]),
            })
            .collect();
        Self {
            number,
            seed,
            kind,
            effects,
        }
    }

    /// The recording as it is: with all its effects.
    #[must_use]
    pub fn recorded(&self, take: u64) -> Recording {
        self.record(take, |_| true)
    }

    /// The first recording again, with exactly what its effects add taken out of the readings: the same motion, the same draws of
    /// noise. Noise stays, since knowing how much there is does not take it out.
    #[must_use]
    pub fn known_exactly(&self) -> Recording {
        self.record(0, |name| effects::is(name, Detection::AsNoise))
    }

    /// The first recording again with one of its effects alone.
    #[must_use]
    pub fn with_only(&self, effect: &str) -> Recording {
        self.record(0, |name| name == effect)
    }

    /// Records the courier with those of its effects that are kept. `take` 0 and 1 differ in poses, noise and place errors, and
    /// in nothing else.
    ///
    /// # Panics
    /// Never: the preset's waveforms have an inverse, and names are the catalogues'.
    fn record(&self, take: u64, keep: impl Fn(&str) -> bool) -> Recording {
        let mut spec = self.courier();
        // The mirror that creeps is seen against the reference only.
        let reference = self.effects.iter().any(|e| e.name == "reference_mirror");
        if reference {
            spec.beacon_over = None;
        }
        let plan = Plan::usual(
            POSES,
            spec.nominal,
            &spec.places,
            OpenLoop::COURIER,
            self.seed ^ (0x5eed_0000 + take),
        );
        // The first take's length for both: the effects are the courier's own, not the recording's.
        let scene = Scene {
            geometry: spec.geometry,
            duration_s: plan.duration_s(),
            amplitude_counts: spec.electronics.amplitude_counts,
        };
        for (k, drawn) in self.effects.iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(self.seed ^ 0xeffe_c700);
            rng.set_stream(k as u64);
            let found =
                entry(&drawn.name).or_else(|| UNLISTED.iter().find(|e| e.name == drawn.name));
            let entry = found
                .unwrap_or_else(|| panic!("{}: an effect of a catalogue was wanted", drawn.name));
            if keep(&drawn.name) {
                let effect = (entry.draw)(&scene, &mut rng, drawn.size_m);
                spec.effects.push(effect);
            }
        }
        let mut courier = Courier::new(spec, self.seed ^ (0x0150_0000 + take))
            .unwrap_or_else(|error| panic!("{error}"));
        hal_sim::record::record(&mut courier, &plan, reference)
    }

    /// The courier without effects: equation (3) drawn anew, bracket and electronics within their tolerance.
    fn courier(&self) -> CourierSpec {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed ^ 0xc0de_0000);
        let mut spec = ideal(self.seed);
        spec.device = "simulated courier of a blind check".into();
        let [height, x, y] = core::array::from_fn(|_| 1.0 + BUILD_ERROR * normal(&mut rng));
        spec.geometry.height_m *= height;
        spec.geometry.lever_m[0] *= x;
        spec.geometry.lever_m[1] *= y;
        spec.electronics.quadrature_noise_counts = log_uniform(&mut rng, 6.0, 25.0);
        spec.electronics.psd_noise_counts = log_uniform(&mut rng, 1.0, 3.0);
        spec
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_follow_from_their_seed() {
        let draw = |seed| (0..200).map(|n| Case::draw(n, seed)).collect::<Vec<_>>();
        assert_eq!(draw(5), draw(5));
        assert_ne!(draw(5), draw(6));
        for kind in [Kind::None, Kind::Single, Kind::Pair, Kind::Unlisted] {
            assert!(draw(5).iter().any(|c| c.kind == kind));
        }
        assert!(
            draw(5)
                .iter()
                .flat_map(|c| &c.effects)
                .all(|e| (SIZES_M[0]..=SIZES_M[1]).contains(&e.size_m))
        );
    }
}
