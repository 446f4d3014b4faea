//! One sine/cosine pair by itself: its signal path, its error model, and what tells the errors without any reference.
//!
//! For a shaft or a slide with one encoder and nothing beside it. Two things are known of such a sensor even so:
//!
//! * **its amplitude.** Sine and cosine lie on a circle. [`Circle`] fits what the radius does over a period: an offset of a channel
//!   is its first order, unequal gains and a skewed angle are its second.
//! * **its motion is smooth.** What repeats with every period, at every speed and both ways, is not the motion but the sensor.
//!   [`Stretch`] takes the phase over two periods as a cubic of time plus the error; [`Learner`] adds stretches up.
//!
//! Where it is known how many periods make a turn, what repeats with the turn is told in the same way, single poles and eccentricity:
//! [`TurnLearner`] takes two turns at a time as a quintic plus the error, and [`TurnTable`] has the sum for the interrupt.
//!
//! What each sees, exactly. Written as one complex number, `cosine + i sine = A (exp(i phi) + sum over k of z_k exp(i k phi))`. To first
//! order the radius has, at order n, the real part of `(z_(1+n) + conj z_(1-n)) exp(i n phi)`, and the angle the imaginary part of
//! `(z_(1+n) - conj z_(1-n)) exp(i n phi)`. So the radius tells the angle's order n only where one of the two is known to be absent. An
//! offset is `z_0` and an ellipse is `z_-1`: with these alone (no second or third harmonic of the signals, `z_2` and `z_3`) the
//! radius tells orders 1 and 2. Whatever the signals' harmonics are, the motion tells the angle's orders, if it is smooth.
//!
//! ```
//! use courier_signal::encoder::{Encoder, EncoderConfig, Harmonics, Learner};
//! use courier_signal::quadrature::PairCorrection;
//!
//! let mut encoder = Encoder::new(EncoderConfig::new(&PairCorrection::default(), &Harmonics::default(), 0.2, 0.25).unwrap());
//! let mut learner = Learner::new();
//! // In the interrupt: counts to a position.
//! let reading = encoder.step([12_000, 16_000]);
//! // Below it: what is learned.
//! learner.enter(&reading);
//! assert!(learner.circle.solve().is_err()); // one sample tells no circle
//! ```
//!
//! It is the same code that the courier's interrupt and calibration run on: the pair's interpolation ([`crate::quadrature`]) and the
//! rotation of rows into a factor ([`crate::lsq`]).

mod circle;
mod harmonics;
mod learner;
mod pair;
mod stretch;
mod turn;
mod turn_half;
mod turn_table;

pub use circle::{CIRCLE_ORDERS, CIRCLE_UNKNOWNS, Circle, Round};
pub use harmonics::{Harmonics, ORDERS};
pub use learner::{Learned, Learner, PERIODS};
pub use pair::{Encoder, EncoderConfig, Reading};
pub use stretch::{COLUMNS, DRIFT, Stretch};
pub use turn::{LearnedTurn, TurnError, TurnLearner};
pub use turn_half::TURN_DRIFT;
pub use turn_table::TurnTable;
