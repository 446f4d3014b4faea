//! What changes of a courier in service: a segment's wave that grows, magnets that weaken, a segment that is knocked, another platen.
//!
//! Each is an effect of the plant with a [`Course`] in simulated seconds. Time is accelerated by stating a short course: what takes a month
//! in a factory is a ramp of some minutes here, since nothing of the sensor knows how fast it ages. A course of the temperature over days
//! is [`crate::spec::Temperature`]'s swing with a period of a day, accelerated alike.

use effects::plant::{Geometry, Instant, PlantEffect, SEGMENTS, SegmentPoint, Signal};
use effects::random::ChaCha8Rng;
use effects::tooth_variation::ToothVariation;

/// How far a change has gone at a time: 0 before, 1 after, in proportion between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Begin, seconds since the courier was switched on.
    pub from_s: f64,
    /// End; a change at once ends where it begins.
    pub to_s: f64,
}

impl Course {
    /// At once.
    #[must_use]
    pub const fn step(at_s: f64) -> Self {
        Self {
            from_s: at_s,
            to_s: at_s,
        }
    }

    /// Share at a time.
    #[must_use]
    pub fn share(&self, time_s: f64) -> f64 {
        if time_s < self.from_s {
            0.0
        } else if time_s >= self.to_s {
            1.0
        } else {
            (time_s - self.from_s) / (self.to_s - self.from_s)
        }
    }
}

/// One segment's output changes by a wave of its own phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnWave {
    /// Segment, 0 to 3.
    pub segment: usize,
    /// Waves a tooth.
    pub order: f64,
    /// Amounts of sine and cosine at the end, metres.
    pub amounts_m: [f64; 2],
    /// When.
    pub course: Course,
}

impl OwnWave {
    /// What it adds to the output at a phase of the unmodified output, metres.
    fn at_m(&self, time_s: f64, phase_rad: f64) -> f64 {
        let (sine, cosine) = (self.order * phase_rad).sin_cos();
        self.course.share(time_s) * (self.amounts_m[0] * sine + self.amounts_m[1] * cosine)
    }
}

impl PlantEffect for OwnWave {
    fn scale(&mut self, factor: f64) {
        self.amounts_m = self.amounts_m.map(|m| m * factor);
    }

    fn signal(&mut self, at: &Instant, signals: &mut [Signal; SEGMENTS]) {
        let signal = &mut signals[self.segment];
        turn(signal, self.at_m(at.time_s, signal.phase_rad), at.geometry);
    }
}

/// Turns a signal's phase by a length.
fn turn(signal: &mut Signal, by_m: f64, geometry: &Geometry) {
    let (sine, cosine) = (geometry.wavenumber() * by_m).sin_cos();
    (signal.sine, signal.cosine) = (
        signal.sine * cosine + signal.cosine * sine,
        signal.cosine * cosine - signal.sine * sine,
    );
}

/// One segment's magnets lose strength, while the offset of its electronics stays: the smaller the signal, the more the offset shifts its
/// phase (order 1), and the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeakMagnets {
    /// Segment, 0 to 3.
    pub segment: usize,
    /// Share of the strength that is lost at the end, below 1.
    pub loss: f64,
    /// Offset of sine and cosine, of the amplitude at the begin; there from the begin, so that a calibration has it.
    pub offset: [f64; 2],
    /// When.
    pub course: Course,
}

impl PlantEffect for WeakMagnets {
    fn scale(&mut self, factor: f64) {
        self.loss *= factor;
    }

    fn signal(&mut self, at: &Instant, signals: &mut [Signal; SEGMENTS]) {
        let left = 1.0 - self.loss * self.course.share(at.time_s);
        let signal = &mut signals[self.segment];
        signal.sine = left * signal.sine + self.offset[0];
        signal.cosine = left * signal.cosine + self.offset[1];
    }
}

/// A segment that is knocked: it stands elsewhere, along its own direction, and its coils another way, of which its waves of orders 1 and 2
/// change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knock {
    /// Segment, 0 to 3.
    pub segment: usize,
    /// When, seconds.
    pub at_s: f64,
    /// By how far, metres.
    pub shift_m: f64,
    /// Change of its waves of orders 1 and 2, amounts of sine and cosine, metres.
    pub waves_m: [[f64; 2]; 2],
}

impl PlantEffect for Knock {
    fn scale(&mut self, factor: f64) {
        self.shift_m *= factor;
        self.waves_m = self.waves_m.map(|pair| pair.map(|m| m * factor));
    }

    fn displacement_m(
        &mut self,
        at: &Instant,
        _points: &[SegmentPoint; SEGMENTS],
    ) -> [f64; SEGMENTS] {
        let mut displacement = [0.0; SEGMENTS];
        displacement[self.segment] = self.shift_m * Course::step(self.at_s).share(at.time_s);
        displacement
    }

    fn signal(&mut self, at: &Instant, signals: &mut [Signal; SEGMENTS]) {
        for (order, amounts_m) in [1.0, 2.0].into_iter().zip(self.waves_m) {
            let mut wave = OwnWave {
                segment: self.segment,
                order,
                amounts_m,
                course: Course::step(self.at_s),
            };
            wave.signal(at, signals);
        }
    }
}

/// Another platen from a time on: what one does to the readings, then the other.
pub struct ExchangedPlaten {
    /// The first's teeth.
    pub before: Box<dyn PlantEffect>,
    /// The second's.
    pub after: Box<dyn PlantEffect>,
    /// When, seconds.
    pub at_s: f64,
}

/// Aperture of a segment either way, teeth: a segment is somewhat shorter than the pair's span (the preset `paper`).
const APERTURE: [f64; 2] = [3.0, 3.0];

impl ExchangedPlaten {
    /// Two platens whose teeth are off by as much, rms, m.
    pub fn drawn(rng: &mut ChaCha8Rng, size_rms_m: f64, at_s: f64) -> Self {
        let mut teeth = || {
            let field =
                ToothVariation::new(&Geometry::PAPER, rng, APERTURE, [1.0, 0.0], size_rms_m);
            Box::new(field)
        };
        Self {
            before: teeth(),
            after: teeth(),
            at_s,
        }
    }

    fn present(&mut self, at: &Instant) -> &mut dyn PlantEffect {
        if at.time_s < self.at_s {
            &mut *self.before
        } else {
            &mut *self.after
        }
    }
}

impl PlantEffect for ExchangedPlaten {
    fn scale(&mut self, factor: f64) {
        self.before.scale(factor);
        self.after.scale(factor);
    }

    fn platen(&mut self, at: &Instant, points: &mut [SegmentPoint; SEGMENTS]) {
        self.present(at).platen(at, points);
    }

    fn displacement_m(
        &mut self,
        at: &Instant,
        points: &[SegmentPoint; SEGMENTS],
    ) -> [f64; SEGMENTS] {
        self.present(at).displacement_m(at, points)
    }
}
