//! What a blind case is: a courier, what is wrong with it, and how it is recorded. All of it drawn from a seed.

use crate::conditions::{Conditions, Layout};
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
/// Sizes of effects where the conditions are drawn too, in noise floors: the rms of a segment's position by its noise alone.
pub const SIZES_FLOORS: [f64; 2] = [1.0 / 3.0, 20.0];
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
    /// Three catalogued effects.
    Triple,
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
    /// How it is moved and recorded.
    #[serde(default, skip_serializing_if = "Conditions::is_usual")]
    pub conditions: Conditions,
}

impl Case {
    /// Draws case `number` of a campaign. Under the usual conditions: nothing in 15 %, one effect in 45 %, two in 20 %, an unlisted
    /// one in 20 %, of [`SIZES_M`]. Under drawn ones three effects in 8 % beside fewer of the others, of [`SIZES_FLOORS`].
    #[must_use]
    pub fn draw(number: usize, campaign: u64, conditions: Conditions) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(campaign);
        rng.set_stream(number as u64);
        let seed = (uniform(&mut rng, 0.0, 1.0) * 2.0_f64.powi(52)) as u64;
        let kind = kind(uniform(&mut rng, 0.0, 1.0), conditions);
        let names = names(kind, &mut rng);
        let mut case = Self {
            number,
            seed,
            kind,
            effects: Vec::new(),
            conditions,
        };
        let [low_m, high_m] = match conditions {
            Conditions::Usual => SIZES_M,
            Conditions::Drawn => SIZES_FLOORS.map(|floors| floors * floor_m(&case.courier())),
        };
        let sized = |name: &str| Drawn {
            name: name.into(),
            size_m: log_uniform(&mut rng, low_m, high_m),
        };
        case.effects = names.into_iter().map(sized).collect();
        case
    }

    /// What is drawn of its conditions; none where these are the usual ones.
    fn layout(&self) -> Option<Layout> {
        match self.conditions {
            Conditions::Usual => None,
            Conditions::Drawn => Some(Layout::draw(self.seed ^ 0x1a70_0000)),
        }
    }

    /// The readings' own noise over the one that the recording states, without any effect.
    #[must_use]
    pub fn noise_over_stated(&self) -> f64 {
        self.layout()
            .map_or(1.0, |layout| layout.noise_over_stated())
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

    /// The first recording, and the same without one of its effects, which an observer compares who knows all others. `noise` 0 is the
    /// first recording's noise; any other gives both of them other draws.
    #[must_use]
    pub fn with_and_without(&self, effect: &str, noise: u64) -> [Recording; 2] {
        [
            self.record_by(0, noise, |_| true),
            self.record_by(0, noise, |name| name != effect),
        ]
    }

    /// Share of the cases that are drawn under its conditions in which one given effect of the catalogue acts; for an effect that is in no
    /// catalogue, one given effect of those.
    #[must_use]
    pub fn share_that_acts(&self) -> f64 {
        let [none, single, pair, triple] = kinds_until(self.conditions);
        let catalogued = (single - none) + 2.0 * (pair - single) + 3.0 * (triple - pair);
        if self.kind == Kind::Unlisted {
            (1.0 - triple) / UNLISTED.len() as f64
        } else {
            catalogued / CATALOGUE.len() as f64
        }
    }

    /// Records the courier with those of its effects that are kept. `take` 0 and 1 differ in poses, noise and place errors, and
    /// in nothing else.
    fn record(&self, take: u64, keep: impl Fn(&str) -> bool) -> Recording {
        self.record_by(take, 0, keep)
    }

    /// The same with other draws of noise for each `noise` but 0.
    ///
    /// # Panics
    /// Never: the preset's waveforms have an inverse, and names are the catalogues'.
    fn record_by(&self, take: u64, noise: u64, keep: impl Fn(&str) -> bool) -> Recording {
        let mut spec = self.courier();
        let layout = self.layout();
        // The mirror that creeps is seen against the reference only.
        let mut reference = self.effects.iter().any(|e| e.name == "reference_mirror");
        if let Some(layout) = &layout {
            layout.apply(&mut spec);
            reference |= layout.reference;
        }
        if reference {
            spec.beacon_over = None;
        }
        let plan = self.plan(&spec, layout.as_ref(), take);
        let first = self.plan(&spec, layout.as_ref(), 0);
        // The first take's length for both: the effects are the courier's own, not the recording's.
        let scene = Scene {
            geometry: spec.geometry,
            duration_s: first.duration_s(),
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
        let own_noise = self.seed ^ (0x0150_0000 + take) ^ (noise << 32);
        let mut courier = Courier::new(spec, own_noise).unwrap_or_else(|error| panic!("{error}"));
        let whole = hal_sim::record::record(&mut courier, &plan, reference);
        match layout {
            None => whole,
            Some(layout) => layout.kept(whole, self.seed ^ (0xc070_0000 + take)),
        }
    }

    /// The motions of a recording.
    fn plan(&self, spec: &CourierSpec, layout: Option<&Layout>, take: u64) -> Plan {
        let seed = self.seed ^ (0x5eed_0000 + take);
        match layout {
            Some(layout) => layout.plan(spec, seed),
            None => Plan::usual(POSES, spec.nominal, &spec.places, OpenLoop::COURIER, seed),
        }
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

/// Numbers from 0 to 1 below which nothing, one effect, two and three effects act; above the last it is one of no catalogue.
fn kinds_until(conditions: Conditions) -> [f64; 4] {
    match conditions {
        Conditions::Usual => [0.15, 0.60, 0.80, 0.80],
        Conditions::Drawn => [0.15, 0.55, 0.75, 0.83],
    }
}

/// What is wrong, by a number from 0 to 1.
fn kind(number: f64, conditions: Conditions) -> Kind {
    let until = kinds_until(conditions);
    let kinds = [Kind::None, Kind::Single, Kind::Pair, Kind::Triple];
    let found = kinds.into_iter().zip(until).find(|(_, end)| number < *end);
    found.map_or(Kind::Unlisted, |(kind, _)| kind)
}

/// Names of different effects.
fn names(kind: Kind, rng: &mut ChaCha8Rng) -> Vec<&'static str> {
    match kind {
        Kind::None => Vec::new(),
        Kind::Single => vec![CATALOGUE[index(rng, CATALOGUE.len())].name],
        Kind::Unlisted => vec![UNLISTED[index(rng, UNLISTED.len())].name],
        Kind::Pair => {
            let first = index(rng, CATALOGUE.len());
            let second = (first + 1 + index(rng, CATALOGUE.len() - 1)) % CATALOGUE.len();
            vec![CATALOGUE[first].name, CATALOGUE[second].name]
        }
        Kind::Triple => {
            let mut left: Vec<&str> = CATALOGUE.iter().map(|entry| entry.name).collect();
            let mut taken = || left.swap_remove(index(rng, left.len()));
            vec![taken(), taken(), taken()]
        }
    }
}

/// Rms of a segment's position by the noise of its counts, m.
fn floor_m(spec: &CourierSpec) -> f64 {
    let electronics = &spec.electronics;
    let noise_rad = electronics.quadrature_noise_counts / electronics.amplitude_counts;
    noise_rad * spec.nominal.pitch_m / core::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_follow_from_their_seed() {
        let usual = |seed| -> Vec<Case> {
            let draw = |number| Case::draw(number, seed, Conditions::Usual);
            (0..200).map(draw).collect()
        };
        assert_eq!(usual(5), usual(5));
        assert_ne!(usual(5), usual(6));
        for kind in [Kind::None, Kind::Single, Kind::Pair, Kind::Unlisted] {
            assert!(usual(5).iter().any(|c| c.kind == kind));
        }
        assert!(
            usual(5)
                .iter()
                .flat_map(|c| &c.effects)
                .all(|e| (SIZES_M[0]..=SIZES_M[1]).contains(&e.size_m))
        );
    }

    #[test]
    fn drawn_conditions_differ_between_couriers_and_hold_for_both_recordings() {
        let cases: Vec<Case> = (0..12)
            .map(|number| Case::draw(number, 5, Conditions::Drawn))
            .collect();
        let recordings: Vec<[Recording; 2]> = cases
            .iter()
            .map(|case| [0, 1].map(|take| case.recorded(take)))
            .collect();
        for [first, second] in &recordings {
            assert!(!first.samples.is_empty() && !second.samples.is_empty());
            let beacons = [first, second].map(|r| r.meta.coordination.is_some());
            assert_eq!(beacons[0], beacons[1]);
            assert_eq!(first.meta.electronics, second.meta.electronics);
            assert_ne!(first.samples, second.samples);
        }
        let lengths: std::collections::BTreeSet<usize> = recordings
            .iter()
            .map(|[first, _]| first.samples.len())
            .collect();
        assert!(lengths.len() > 10, "{lengths:?}");
    }

    #[test]
    fn a_triple_has_three_different_effects() {
        let draw = |number| Case::draw(number, 3, Conditions::Drawn);
        let triples = (0..100).map(draw).filter(|case| case.kind == Kind::Triple);
        let sets: Vec<std::collections::BTreeSet<String>> = triples
            .map(|case| case.effects.into_iter().map(|e| e.name).collect())
            .collect();
        assert!(
            !sets.is_empty() && sets.iter().all(|set| set.len() == 3),
            "{sets:?}"
        );
    }
}
