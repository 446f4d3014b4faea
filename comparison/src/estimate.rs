//! One calibration as an estimate: unknowns, their values, how well they are known together.

use crate::lateral::Lateral;
use crate::significance::Scale;
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{Multiplier, Term};
use nalgebra::{DMatrix, DVector};

/// What an unknown adds to a segment's correction: a term of the error model, times a share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Segment, 0 to 3.
    pub segment: usize,
    /// Which functions of phases, angle and multiplier.
    pub term: Term,
    /// Its cosine; its sine otherwise.
    pub cosine: bool,
    /// What an unknown of 1 is of the term.
    pub share: f64,
}

/// One unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// The effect that it belongs to, or [`EQUATION_3`].
    pub effect: String,
    /// Its name among its effect's.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What it does to a segment; none of what is no term of the board's error model.
    pub wave: Option<Wave>,
}

/// What the own orders of equation (3) belong to.
pub const EQUATION_3: &str = "equation (3)";
/// What height and lever arm belong to.
pub const EQUATION_11: &str = "equation (11)";
/// What the diode's own errors of a joint calibration belong to.
pub const COORDINATION_SENSOR: &str = "coordination sensor";

impl Unknown {
    /// A coefficient of the error model, named as the diagnosis names it.
    #[must_use]
    pub fn of_wave(wave: Wave) -> Self {
        Self {
            effect: effect(&wave.term).into(),
            name: format!(
                "{} {}, segment {}",
                term_name(&wave.term),
                part(wave.cosine),
                wave.segment + 1
            ),
            unit: unit(&wave.term),
            wave: Some(wave),
        }
    }

    /// Whether it belongs to an effect of the catalogue, which may be there or not.
    #[must_use]
    pub fn is_of_an_effect(&self) -> bool {
        ![EQUATION_3, EQUATION_11, COORDINATION_SENSOR].contains(&self.effect.as_str())
    }

    /// Whether it is the same as another: of two estimates.
    #[must_use]
    pub fn is(&self, other: &Self) -> bool {
        match (&self.wave, &other.wave) {
            (Some(one), Some(two)) => one == two,
            (None, None) => self.effect == other.effect && self.name == other.name,
            _ => false,
        }
    }
}

/// A term in words: `order 2`, `lateral order 1`, with what it is multiplied by.
#[must_use]
pub fn term_name(term: &Term) -> String {
    let waves = match (term.own_order, term.lateral_order) {
        (0, 0) => "offset".to_owned(),
        (own, 0) => format!("order {own}"),
        (0, lateral) => format!("lateral order {lateral}"),
        (own, lateral) => format!("own order {own}, lateral order {lateral}"),
    };
    let angle = match term.theta_power {
        0 => String::new(),
        1 => "theta times ".to_owned(),
        power => format!("theta^{power} times "),
    };
    let multiplier = match term.multiplier {
        Multiplier::None => "",
        Multiplier::Speed => "speed times ",
        Multiplier::Temperature => "warmth times ",
        Multiplier::Direction => "direction times ",
    };
    format!("{angle}{multiplier}{waves}")
}

fn part(cosine: bool) -> &'static str {
    if cosine { "cosine" } else { "sine" }
}

fn unit(term: &Term) -> String {
    let angle = if term.theta_power > 0 {
        format!("/rad^{}", term.theta_power)
    } else {
        String::new()
    };
    let multiplier = match term.multiplier {
        Multiplier::None | Multiplier::Direction => "",
        Multiplier::Speed => " s/m",
        Multiplier::Temperature => "/K",
    };
    format!("m{angle}{multiplier}")
}

/// The effect of the catalogue whose shape a term has.
fn effect(term: &Term) -> &'static str {
    match term.multiplier {
        Multiplier::Speed => "velocity_lag",
        Multiplier::Temperature => "thermal_drift",
        Multiplier::Direction => "hysteresis",
        Multiplier::None if term.theta_power > 0 => "angle_dependence",
        Multiplier::None if term.lateral_order != 0 => "lateral_dependence",
        Multiplier::None if courier_sensor::equations::OWN_ORDERS.contains(&term.own_order) => {
            EQUATION_3
        }
        Multiplier::None => "extra_harmonics",
    }
}

/// How well unknowns are known together.
#[derive(Clone, Debug, PartialEq)]
pub struct Certainty {
    /// Covariance of the unknowns, in products of their units; a row of zeros where one was held and not estimated.
    pub covariance: DMatrix<f64>,
    /// Degrees of freedom with which the covariance's scale is known; infinite where the noise is.
    pub freedom: f64,
    /// Share of that scale, for each direction, that is the estimate's own error: [`own_share`](crate::significance::own_share).
    pub own: f64,
    /// What lateral terms that it does not hold make of the unknowns, where that is known.
    pub lateral: Option<Lateral>,
    /// Where it comes from, for people.
    pub source: String,
}

impl Certainty {
    /// How well its scale is known.
    #[must_use]
    pub fn scale(&self) -> Scale {
        Scale {
            freedom: self.freedom,
            own: self.own,
        }
    }
}

/// One calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// What it is called.
    pub name: String,
    /// What it is, for people: a calibration of a board, a recording.
    pub about: String,
    /// When it was made, seconds since 1970 UTC, if known.
    pub made_s: Option<f64>,
    /// Geometry: pitch, span and lateral offset are used.
    pub geometry: Geometry,
    /// Unknowns.
    pub unknowns: Vec<Unknown>,
    /// Their values, in their units.
    pub values: DVector<f64>,
    /// How well they are known; or why that is not known.
    pub certainty: Result<Certainty, String>,
    /// Standard deviation of the parity of readings that were not fitted, metres, and its degrees of freedom.
    pub parity: Option<(f64, f64)>,
    /// Amplitude of each segment, counts; zero where not known.
    pub amplitude_counts: [f64; 4],
    /// Whether effects that it does not have were looked for and not found: a diagnosis looks for all, a calibration fits what it is told.
    pub looked_for_all: bool,
    /// What is left out of it, and why.
    pub left_out: Vec<String>,
}

impl Estimate {
    /// Whether its unknown at an index was estimated, and not held.
    #[must_use]
    pub fn is_estimated(&self, index: usize) -> bool {
        self.certainty
            .as_ref()
            .is_ok_and(|certainty| certainty.covariance[(index, index)] > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(term: Term) -> Unknown {
        Unknown::of_wave(Wave {
            segment: 1,
            term,
            cosine: true,
            share: 1.0,
        })
    }

    #[test]
    fn terms_have_the_names_and_units_of_the_diagnosis() {
        let cases = [
            (Term::own(2), "order 2 cosine, segment 2", EQUATION_3, "m"),
            (
                Term::own(3),
                "order 3 cosine, segment 2",
                "extra_harmonics",
                "m",
            ),
            (
                Term::lateral(1),
                "lateral order 1 cosine, segment 2",
                "lateral_dependence",
                "m",
            ),
            (
                Term::own(1).with_theta(1),
                "theta times order 1 cosine, segment 2",
                "angle_dependence",
                "m/rad^1",
            ),
            (
                Term::default().with(Multiplier::Speed),
                "speed times offset cosine, segment 2",
                "velocity_lag",
                "m s/m",
            ),
        ];
        for (term, name, effect, unit) in cases {
            let found = wave(term);
            assert_eq!(
                (
                    found.name.as_str(),
                    found.effect.as_str(),
                    found.unit.as_str()
                ),
                (name, effect, unit)
            );
        }
    }

    #[test]
    fn a_wave_is_itself_whatever_it_is_called() {
        let mut other = wave(Term::own(2));
        other.name = "another".into();
        assert!(wave(Term::own(2)).is(&other) && !wave(Term::own(1)).is(&other));
        let named = |name: &str| Unknown {
            effect: "e".into(),
            name: name.into(),
            unit: "1".into(),
            wave: None,
        };
        assert!(
            named("a").is(&named("a")) && !named("a").is(&named("b")) && !named("a").is(&other)
        );
    }
}
