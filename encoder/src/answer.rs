//! What is learned, for people and programs.

use crate::index::Index;
use crate::input::{LogUnit, error};
use serde::Serialize;
use std::f64::consts::TAU;

/// The channels by the radius, in counts of the recording; ± are standard deviations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Channels {
    /// Mean radius, counts of the sine channel.
    pub amplitude_counts: f64,
    /// Offsets of sine and cosine, counts.
    pub offset_counts: [f64; 2],
    #[allow(missing_docs)]
    pub offset_deviation_counts: [f64; 2],
    /// Amplitude of the cosine over that of the sine.
    pub gain: f64,
    #[allow(missing_docs)]
    pub gain_deviation: f64,
    /// How far the channels are from a right angle, rad.
    pub angle_rad: f64,
    #[allow(missing_docs)]
    pub angle_deviation_rad: f64,
    /// What is left of the radius: size of orders 3 and 4 as a share of it, and the standard deviation of each.
    pub radius_orders: [[f64; 2]; 2],
}

/// One order of the angle's error, m: `sine_m sin(n phi) + cosine_m cos(n phi)` is added.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Harmonic {
    /// n.
    pub order: usize,
    #[allow(missing_docs)]
    pub sine_m: f64,
    #[allow(missing_docs)]
    pub cosine_m: f64,
    /// Standard deviation of each of the two.
    pub deviation_m: f64,
    /// Whether it is more than chance, and so applied.
    pub applied: bool,
    /// Size of a ripple of the true motion of this order at [`Answer::ripple_speed_hz`], m, which is told apart and not applied.
    pub ripple_m: Option<f64>,
    /// Size of what reverses with the direction, m, which is told apart and not applied.
    pub reversing_m: Option<f64>,
}

/// Orders of the turn.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Turn {
    /// Periods of a turn.
    pub periods: u32,
    /// `[a_m, b_m]` of orders 1 and up of the turn, periods of the signal, added to the place; the angle is counted from where the index
    /// says that a turn begins, without one from the place zero of the recording's count.
    pub orders: Vec<[f64; 2]>,
    /// What stretches show before, and what is left by orders fitted to the others, rms periods.
    pub before_turns: f64,
    #[allow(missing_docs)]
    pub after_turns: f64,
    /// Stretches of one to two turns.
    pub stretches: usize,
    /// Where a turn begins, if there is an index.
    pub index: Option<Index>,
}

impl Turn {
    /// The same counted from where the index says, where there is one.
    pub(crate) fn counted_from(self, index: Option<Index>) -> Self {
        let start = index.as_ref().map_or(0, |index| index.zero_periods);
        let start = start.rem_euclid(i64::from(self.periods));
        let angle = TAU * start as f64 / f64::from(self.periods);
        let moved = |([a, b], order): (&[f64; 2], u32)| {
            let (sine, cosine) = (f64::from(order) * angle).sin_cos();
            [a * cosine - b * sine, a * sine + b * cosine]
        };
        Self {
            orders: self.orders.iter().zip(1..).map(moved).collect(),
            index,
            ..self
        }
    }

    /// What the orders add so far, periods of the signal, from where a turn begins, periods of the signal.
    #[must_use]
    pub fn at(&self, place: f64) -> f64 {
        error(&self.orders, place / f64::from(self.periods))
    }
}

/// Something that cannot be told, or that the motion tells beside the errors.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Remark {
    /// What is so.
    pub what: String,
    /// The motion, or the option, that would tell.
    pub tell: String,
}

/// All that is learned.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// Samples of the recording.
    pub samples: usize,
    /// Length of a period, m.
    pub pitch_m: f64,
    /// How the counts came from the log's values.
    pub unit: LogUnit,
    /// Stretches of motion, and the periods of each.
    pub stretches: usize,
    #[allow(missing_docs)]
    pub stretch_periods: f64,
    /// Slower and faster tenth of their speeds, periods a second.
    pub speeds_hz: [f64; 2],
    /// The speed that ripples are stated at, periods a second.
    pub ripple_speed_hz: f64,
    /// Left within the median stretch by motion and all orders, rms m.
    pub noise_m: f64,
    /// The channels, where counts were logged.
    pub channels: Option<Channels>,
    /// Orders 1 to 8 of the angle.
    pub harmonics: Vec<Harmonic>,
    /// Orders of the turn, where they foretell anything.
    pub turn: Option<Turn>,
    /// What cannot be told.
    pub remarks: Vec<Remark>,
}

impl Answer {
    /// `[a_n, b_n]` of the orders that are applied, periods.
    #[must_use]
    pub fn applied(&self) -> Vec<[f64; 2]> {
        let of = |harmonic: &Harmonic| {
            if harmonic.applied {
                [harmonic.sine_m, harmonic.cosine_m].map(|k| k / self.pitch_m)
            } else {
                [0.0; 2]
            }
        };
        self.harmonics.iter().map(of).collect()
    }

    /// Offsets of sine and cosine in the log's unit; none where only places were logged.
    #[must_use]
    pub fn offsets(&self) -> Option<[f64; 2]> {
        let channels = self.channels.as_ref()?;
        Some([0, 1].map(|k| channels.offset_counts[k] / self.unit.scale + self.unit.centre[k]))
    }

    /// The phase, periods (-0.5 to 0.5), of counts with offset, gain and angle taken out.
    #[must_use]
    pub fn corrected(&self, [sine, cosine]: [f64; 2]) -> f64 {
        let Some(channels) = &self.channels else {
            return sine.atan2(cosine) / TAU;
        };
        let s = sine - channels.offset_counts[0];
        let c = (cosine - channels.offset_counts[1]) / (channels.gain * channels.angle_rad.cos())
            + s * channels.angle_rad.tan();
        s.atan2(c) / TAU
    }

    /// A calibrated place, periods, from an unmodified one and, where they were logged, its counts.
    #[must_use]
    pub fn calibrated(&self, place: f64, counts: Option<[f64; 2]>) -> f64 {
        let place = match counts {
            Some(counts) => {
                let moved = self.corrected(counts) - place;
                place + moved - moved.round()
            }
            None => place,
        };
        let place = place + error(&self.applied(), place);
        place + self.of_turn(place)
    }

    /// What the orders of the turn add at a place of the recording's count, periods.
    #[must_use]
    pub fn of_turn(&self, place: f64) -> f64 {
        self.turn.as_ref().map_or(0.0, |turn| {
            let start = turn.index.as_ref().map_or(0, |index| index.zero_periods);
            turn.at(place - start as f64)
        })
    }
}
