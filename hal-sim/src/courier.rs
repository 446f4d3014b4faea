//! The plant: at each sampling instant from the true pose to the converter's codes.
//!
//! Equation (4) places the segments, [`crate::waveform`] gives each one's unmodified output, [`crate::coordination`] the
//! diode's deflection; effects act along the way through [`effects::plant::PlantEffect`].

use crate::coordination;
use crate::electronics::convert;
use crate::spec::CourierSpec;
use crate::waveform::{Inverse, NotMonotonic};
use core::f64::consts::TAU;
use effects::motion::{Motion, Pose};
use effects::plant::{Channels, Instant, SEGMENTS, Signal};
use effects::random::{ChaCha8Rng, SeedableRng, fork, normal};

/// One instant's conversion of all channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// `[segment][sine, cosine]`.
    pub quadrature: [[i16; 2]; SEGMENTS],
    /// `x+, x-, y+, y-`.
    pub electrodes: [i16; 4],
    /// Board temperature, Celsius.
    pub temperature_c: f64,
}

/// What no sensor knows: for tests and for the tooth counts of recordings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// True pose.
    pub pose: Pose,
    /// Each segment's unmodified output without noise, signal errors or rounding, metres.
    pub unmodified_m: [f64; SEGMENTS],
    /// Whether the coordination sensor sees the beacon.
    pub beacon_seen: bool,
    /// Teeth that the counters are off by.
    pub slipped_teeth: [i32; SEGMENTS],
}

/// A courier that is switched on. The same specification and seed give the same counts for the same calls.
pub struct Courier {
    spec: CourierSpec,
    inverses: [Inverse; SEGMENTS],
    origin_m: Option<[f64; 2]>,
    rng: ChaCha8Rng,
    reference_rng: ChaCha8Rng,
    time_s: f64,
    truth: Truth,
    sample: Sample,
}

impl Courier {
    /// Switches a courier on.
    ///
    /// # Errors
    /// [`NotMonotonic`] if a segment's error has no unique inverse.
    pub fn new(spec: CourierSpec, seed: u64) -> Result<Self, NotMonotonic> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let inverse =
            |segment: usize| Inverse::new(&spec.waveforms[segment], spec.geometry.pitch_m);
        Ok(Self {
            inverses: [inverse(0)?, inverse(1)?, inverse(2)?, inverse(3)?],
            origin_m: spec
                .beacon_over
                .map(|pose| coordination::origin_under(&spec.geometry, pose)),
            reference_rng: fork(&mut rng),
            rng,
            spec,
            time_s: 0.0,
            truth: Truth::default(),
            sample: Sample::default(),
        })
    }

    /// What it was built from.
    #[must_use]
    pub fn spec(&self) -> &CourierSpec {
        &self.spec
    }

    /// Switches the beacon on over a pose, or off.
    pub fn set_beacon(&mut self, over: Option<Pose>) {
        self.origin_m = over.map(|pose| coordination::origin_under(&self.spec.geometry, pose));
    }

    /// Converts all channels at one instant. Times must not decrease from call to call: effects keep state.
    pub fn counts_at(&mut self, motion: &dyn Motion, time_s: f64) -> Sample {
        let pose = motion.pose(time_s);
        let temperature_c = self.spec.temperature.at_c(time_s);
        let at = Instant {
            time_s,
            pose,
            temperature_delta_k: temperature_c - self.spec.temperature.start_c,
            motion,
            geometry: &self.spec.geometry.clone(),
        };
        let signals = self.signals(&at);
        let electronics = self.spec.electronics;
        let deflection = self.deflection(&at);
        let psd_sum_counts = if deflection.is_some() {
            electronics.psd_sum_counts
        } else {
            0.0
        };
        let mut channels = Channels {
            quadrature: signals
                .map(|s| [s.sine, s.cosine].map(|v| v * electronics.amplitude_counts)),
            electrodes: coordination::electrodes(deflection.unwrap_or_default(), psd_sum_counts),
            amplitude_counts: electronics.amplitude_counts,
            psd_sum_counts,
        };
        electronics.add_noise(&mut self.rng, &mut channels);
        for effect in &mut self.spec.effects {
            effect.analog(&at, &mut channels);
        }
        let mut codes = convert(&channels);
        let mut slipped_teeth = [0; SEGMENTS];
        for effect in &mut self.spec.effects {
            effect.codes(&at, &mut codes);
            add(&mut slipped_teeth, effect.teeth(&at));
        }
        self.time_s = time_s;
        self.truth = Truth {
            pose,
            beacon_seen: deflection.is_some(),
            slipped_teeth,
            ..self.truth
        };
        self.sample = Sample {
            quadrature: codes.quadrature,
            electrodes: codes.electrodes,
            temperature_c,
        };
        self.sample
    }

    /// True pose to electrical signals; notes the unmodified outputs.
    fn signals(&mut self, at: &Instant) -> [Signal; SEGMENTS] {
        let mut points = at.geometry.points(at.pose);
        for effect in &mut self.spec.effects {
            effect.platen(at, &mut points);
        }
        let mut displaced = points.map(|point| point.own_m);
        for effect in &mut self.spec.effects {
            add(&mut displaced, effect.displacement_m(at, &points));
        }
        let pitch_m = at.geometry.pitch_m;
        let mut signals = [Signal::default(); SEGMENTS];
        for (segment, signal) in signals.iter_mut().enumerate() {
            let unmodified_m = self.inverses[segment].unmodified_m(displaced[segment]);
            self.truth.unmodified_m[segment] = unmodified_m;
            let turns = unmodified_m / pitch_m;
            let (sine, cosine) = (TAU * (turns - turns.round())).sin_cos();
            *signal = Signal {
                phase_rad: TAU * turns,
                sine,
                cosine,
            };
        }
        for effect in &mut self.spec.effects {
            effect.signal(at, &mut signals);
        }
        signals
    }

    /// Normalised deflection of the coordination sensor, if it sees the beacon.
    fn deflection(&mut self, at: &Instant) -> Option<[f64; 2]> {
        let mut origin_m = self.origin_m?;
        let delay_s: f64 = self
            .spec
            .effects
            .iter()
            .map(|effect| effect.coordination_delay_s())
            .sum();
        let pose = if delay_s == 0.0 {
            at.pose
        } else {
            at.motion.pose(at.time_s + delay_s)
        };
        for effect in &mut self.spec.effects {
            add(&mut origin_m, effect.beacon_m(at));
        }
        let mut normalised = coordination::deflection(at.geometry, origin_m, pose);
        if normalised.iter().any(|u| u.abs() > 1.0) {
            return None;
        }
        for effect in &mut self.spec.effects {
            effect.deflection(at, &mut normalised);
        }
        Some(normalised.map(|u| u.clamp(-1.0, 1.0)))
    }

    /// The last sample.
    #[must_use]
    pub fn sample(&self) -> &Sample {
        &self.sample
    }

    /// The truth at the last sample: for tests, never for an estimator.
    #[must_use]
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// Interferometer's reading at the last sample.
    pub fn reference(&mut self, motion: &dyn Motion) -> Pose {
        let mut pose = self.truth.pose;
        let at = Instant {
            time_s: self.time_s,
            pose,
            temperature_delta_k: self.sample.temperature_c - self.spec.temperature.start_c,
            motion,
            geometry: &self.spec.geometry,
        };
        for effect in &mut self.spec.effects {
            effect.reference(&at, &mut pose);
        }
        let noise = self.spec.interferometer;
        let rng = &mut self.reference_rng;
        pose.x_m += noise.position_noise_m * normal(rng);
        pose.y_m += noise.position_noise_m * normal(rng);
        pose.theta_rad += noise.angle_noise_rad * normal(rng);
        pose
    }

    /// What the machine logs beside the readings at the last sample: name of the column and its value.
    #[must_use]
    pub fn logged(&self, motion: &dyn Motion) -> Option<(&'static str, f64)> {
        self.logged_at(motion, self.time_s)
    }

    /// The same at any time of the motion, s.
    #[must_use]
    pub fn logged_at(&self, motion: &dyn Motion, time_s: f64) -> Option<(&'static str, f64)> {
        let at = Instant {
            time_s,
            pose: motion.pose(time_s),
            temperature_delta_k: self.spec.temperature.at_c(time_s) - self.spec.temperature.start_c,
            motion,
            geometry: &self.spec.geometry,
        };
        let mut effects = self.spec.effects.iter();
        effects.find_map(|effect| effect.logged(&at))
    }

    /// Tooth counts of the last sample: `n` of `n * pitch + pitch / (2 pi) * atan2(sine, cosine)`, slips included.
    #[must_use]
    pub fn teeth(&self) -> [i32; SEGMENTS] {
        core::array::from_fn(|segment| {
            let [sine, cosine] = self.sample.quadrature[segment].map(f64::from);
            let turns = self.truth.unmodified_m[segment] / self.spec.geometry.pitch_m;
            (turns - sine.atan2(cosine) / TAU).round() as i32 + self.truth.slipped_teeth[segment]
        })
    }
}

fn add<T: core::ops::AddAssign + Copy, const N: usize>(sum: &mut [T; N], more: [T; N]) {
    sum.iter_mut()
        .zip(more)
        .for_each(|(sum, more)| *sum += more);
}
