//! `--sim-age`: what changes of a simulated courier while a command runs.

use core::f64::consts::{SQRT_2, TAU};
use effects::plant::PlantEffect;
use effects::random::{ChaCha8Rng, uniform};
use hal_sim::ageing::{Course, ExchangedPlaten, Knock, OwnWave, WeakMagnets};
use hal_sim::spec::CourierSpec;

/// One change, as it is named: `wave:2:4=0.6@30`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ageing {
    kind: Kind,
    size: f64,
    course: Course,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Segment and order.
    Wave(usize, u8),
    WeakMagnets(usize),
    Knock(usize),
    Platen,
    /// The temperature goes up and down; the course is the length of a day.
    Days,
}

/// What is wanted, for refusals.
const WANTED: &str = "wanted wave:SEGMENT:ORDER=UM, weak-magnets:SEGMENT=PERCENT, knock:SEGMENT=UM or platen=UM, each with @SECOND or @FROM..TO behind it, or days=KELVIN@SECONDS";
/// Offset of the electronics of a segment whose magnets weaken, of its amplitude: 6 % has been seen (lib_sincos_enc).
const OFFSET: f64 = 0.06;
/// A knocked segment is shifted so many times as far as its waves change. A choice of the simulation: a bent mount shifts more than it
/// tilts.
const KNOCK_SHIFT: f64 = 10.0;
impl Ageing {
    /// Gives it to a courier; what is not stated of it is drawn.
    pub fn give(self, spec: &mut CourierSpec, rng: &mut ChaCha8Rng) {
        if self.kind == Kind::Days {
            spec.temperature.swing_k = self.size;
            spec.temperature.swing_period_s = self.course.to_s;
        } else {
            spec.effects.extend(self.effect(rng));
        }
    }

    fn effect(self, rng: &mut ChaCha8Rng) -> Option<Box<dyn PlantEffect>> {
        let Self { kind, size, course } = self;
        let (sine, cosine) = uniform(rng, 0.0, TAU).sin_cos();
        Some(match kind {
            Kind::Days => return None,
            Kind::Wave(segment, order) => Box::new(OwnWave {
                segment,
                order: f64::from(order),
                amounts_m: [sine, cosine].map(|part| SQRT_2 * 1.0e-6 * size * part),
                course,
            }),
            Kind::WeakMagnets(segment) => Box::new(WeakMagnets {
                segment,
                loss: 0.01 * size,
                offset: [OFFSET * sine, OFFSET * cosine],
                course,
            }),
            Kind::Knock(segment) => {
                let size_m = 1.0e-6 * size;
                Box::new(Knock {
                    segment,
                    at_s: course.from_s,
                    shift_m: KNOCK_SHIFT * size_m,
                    // Half of the power in each order.
                    waves_m: [
                        [size_m * sine, size_m * cosine],
                        [size_m * cosine, size_m * sine],
                    ],
                })
            }
            Kind::Platen => Box::new(ExchangedPlaten::drawn(rng, 1.0e-6 * size, course.from_s)),
        })
    }
}

/// Reads `wave:2:4=0.6@30` and the like.
///
/// # Errors
/// What was found, and what was wanted.
pub fn ageing(text: &str) -> Result<Ageing, String> {
    let refuse = || format!("{text}: {WANTED}");
    let (what, when) = text.split_once('@').ok_or_else(refuse)?;
    let (name, size) = what.split_once('=').ok_or_else(refuse)?;
    let mut words = name.split(':');
    let kind = match (words.next(), words.next(), words.next(), words.next()) {
        (Some("wave"), Some(s), Some(order), None) => Kind::Wave(segment(s)?, order_of(order)?),
        (Some("weak-magnets"), Some(s), None, None) => Kind::WeakMagnets(segment(s)?),
        (Some("knock"), Some(s), None, None) => Kind::Knock(segment(s)?),
        (Some("platen"), None, None, None) => Kind::Platen,
        (Some("days"), None, None, None) => Kind::Days,
        _ => return Err(refuse()),
    };
    let most = match kind {
        Kind::WeakMagnets(_) => 90.0,
        Kind::Days => MOST_K,
        _ => 100.0,
    };
    let size = number(size, 0.0, most)?;
    if kind == Kind::Days {
        let course = Course::step(number(when, SHORTEST_DAY_S, LATEST_S)?);
        return Ok(Ageing { kind, size, course });
    }
    let (from, to) = when.split_once("..").unwrap_or((when, when));
    let from_s = number(from, 0.0, LATEST_S)?;
    let course = Course {
        from_s,
        to_s: number(to, from_s, LATEST_S)?,
    };
    Ok(Ageing { kind, size, course })
}

/// Largest swing of the temperature, kelvin. A choice of the simulation, beyond what an unheated hall sees in a year.
const MOST_K: f64 = 40.0;
/// Shortest day, seconds. A choice of the simulation: what is faster is a vibration, and none of the temperature.
const SHORTEST_DAY_S: f64 = 1.0;
/// A simulated year.
const LATEST_S: f64 = 3.2e7;

fn segment(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(segment @ 1..=4) => Ok(segment - 1),
        _ => Err(format!("{text}: no segment, wanted 1 to 4")),
    }
}

fn order_of(text: &str) -> Result<u8, String> {
    match text.parse() {
        Ok(order @ 1..=16) => Ok(order),
        _ => Err(format!("{text}: no order, wanted 1 to 16")),
    }
}

fn number(text: &str, low: f64, high: f64) -> Result<f64, String> {
    match text.parse() {
        Ok(number) if (low..=high).contains(&number) => Ok(number),
        _ => Err(format!("{text}: wanted a number from {low} to {high}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::SeedableRng;

    #[test]
    fn each_kind_is_read_and_what_is_none_is_refused_with_what_was_wanted() {
        let read = ageing("wave:2:4=0.6@30..90").expect("a wave");
        assert_eq!(read.kind, Kind::Wave(1, 4));
        assert_eq!(
            (read.size, read.course.from_s, read.course.to_s),
            (0.6, 30.0, 90.0)
        );
        let weak = ageing("weak-magnets:4=10@5").expect("weak magnets");
        assert_eq!(
            (weak.kind, weak.course),
            (Kind::WeakMagnets(3), Course::step(5.0))
        );
        assert_eq!(ageing("knock:1=2@0").expect("a knock").kind, Kind::Knock(0));
        assert_eq!(ageing("platen=2@7").expect("a platen").kind, Kind::Platen);
        let days = ageing("days=3@600").expect("days");
        assert_eq!((days.kind, days.size), (Kind::Days, 3.0));
        for wrong in [
            "days=3@0",
            "days=3@10..20",
            "days=50@600",
            "days:1=3@600",
            "wave:2=1@0",
            "wave:5:1=1@0",
            "wave:0:1=1@0",
            "wave:1:99=1@0",
            "wave:1:1=x@0",
            "wave:1:1=1",
            "wave:1:1@0",
            "weak-magnets:1=95@0",
            "platen:1=1@0",
            "flood=1@0",
            "knock:1=-1@0",
            "knock:1=1@9..3",
            "knock:1=NaN@0",
            "",
        ] {
            let error = ageing(wrong).expect_err(wrong);
            assert!(error.contains("wanted"), "{wrong}: {error}");
        }
    }

    /// After a quarter of a day it is warmer by the swing, half a day later colder by as much, and so day after day.
    #[test]
    fn the_temperature_goes_with_the_days() {
        let mut spec = CourierSpec::flawless();
        spec.temperature.rise_k = 0.0;
        let days = ageing("days=3@600").expect("days");
        days.give(&mut spec, &mut ChaCha8Rng::seed_from_u64(1));
        assert!(spec.effects.is_empty());
        let start_c = spec.temperature.start_c;
        for (time_s, wanted_k) in [(150.0, 3.0), (450.0, -3.0), (6150.0, 3.0)] {
            let found_k = spec.temperature.at_c(time_s) - start_c;
            assert!((found_k - wanted_k).abs() < 1.0e-9, "{time_s} s: {found_k}");
        }
    }
}
