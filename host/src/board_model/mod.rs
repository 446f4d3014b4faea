//! The diagnosed model as the board's error model: which of its effects are terms there, and with which coefficients.

mod refit;
mod row;
mod sources;
mod terms;

use anyhow::{Result, ensure};
use comparison::estimate::Wave;
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, MAX_LATERAL_ORDER, MAX_TERMS, Term, TermTable};
use diagnosis::Model;
use diagnosis::linearization::baseline::{Baseline, ORDERS};
use diagnosis::transfer::model::EffectAmounts;
use refit::{Diagnosed, Refitted, refit};
use row::Row;
use sources::{Effects, effects};
use std::collections::HashMap;
use terms::{COORDINATES_ON_BOARD, Place, on_board, places};

/// What an effect's amounts add to a segment's correction, by the amounts' names; nothing of what the board has no term for.
pub fn waves(diagnosed: &Model, effect: &EffectAmounts) -> HashMap<String, Wave> {
    let wave = |place: Place| Wave {
        segment: place.segment,
        term: place.term,
        cosine: place.part == 1,
        share: place.share,
    };
    let places = places(diagnosed, effect).into_iter();
    places.map(|(name, place)| (name, wave(place))).collect()
}

/// Terms smaller than this are left out, m: each costs the interrupt its time, and a tenth of what the sensor resolves (0.2 µm,
/// paper, section 1) shows nowhere.
const LEAST_M: f64 = 20.0e-9;

/// A model for the board.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardModel {
    /// Terms and coefficients.
    pub model: ErrorModel,
    /// Effects that became terms, and how many each.
    pub taken: Vec<(String, usize)>,
    /// What the board has no term for, one line each.
    pub left: Vec<String>,
    /// What the board's terms leave of the model's correction, rms of a segment, m.
    pub left_m: f64,
}

impl BoardModel {
    /// Takes over equation (3) and every effect that the board has terms for, fitted to the board's phases; where nothing is named, what a
    /// correction without a name adds.
    ///
    /// # Errors
    /// Nothing of it is a term of the board, or a coefficient is out of the board's range.
    pub fn new(diagnosed: &Model, geometry: &Geometry) -> Result<Self> {
        let baseline = match &diagnosed.nameless {
            Some(nameless) => &nameless.baseline,
            None => &diagnosed.baseline_with_effects,
        };
        let own = equation_3(baseline);
        let Effects {
            all,
            chosen,
            taken,
            mut left,
        } = effects(diagnosed, &own);
        ensure!(
            !taken.is_empty(),
            "found {}, wanted an effect that the board's error model has terms for ({}), or a correction without a name over the {}",
            if left.is_empty() {
                "no effect in the model".into()
            } else {
                left.join("; ")
            },
            on_board(),
            COORDINATES_ON_BOARD
        );
        let correction = Diagnosed {
            own: &own,
            effects: &all,
            constants_m: baseline.k_m.map(|k| k[0]),
        };
        let mut candidates = [own.as_slice(), &chosen].concat();
        let lateral = chosen.iter().any(|row| row.term.lateral_order != 0);
        if lateral && candidates.len() < MAX_TERMS {
            candidates.push(Row::empty(Term::lateral(MAX_LATERAL_ORDER as i8)));
        }
        let mut refitted = refit(&correction, &candidates, geometry)?;
        let worth = |row: &Row| row.is_equation_3() || row.size_m() >= LEAST_M;
        let kept: Vec<Row> = refitted.rows.iter().copied().filter(worth).collect();
        if kept.len() < refitted.rows.len() {
            left.push(format!(
                "{} terms below 20 nm are left out",
                refitted.rows.len() - kept.len()
            ));
            refitted = refit(&correction, &kept, geometry)?;
        }
        if refitted.left_m > LEAST_M {
            left.push(format!(
                "{:.3} µm rms of the model's correction is in no term of the board's",
                1.0e6 * refitted.left_m
            ));
        }
        Ok(Self {
            model: model(&refitted)?,
            taken,
            left,
            left_m: refitted.left_m,
        })
    }
}

fn equation_3(baseline: &Baseline) -> Vec<Row> {
    let k = &baseline.k_m;
    let row = |(j, &order): (usize, &usize)| Row {
        term: Term::own(order as u8),
        coefficients: std::array::from_fn(|s| [k[s][1 + 2 * j], k[s][2 + 2 * j]]),
    };
    ORDERS.iter().enumerate().map(row).collect()
}

fn model(refitted: &Refitted) -> Result<ErrorModel> {
    let terms: Vec<Term> = refitted.rows.iter().map(|row| row.term).collect();
    let table = TermTable::new(&terms)
        .map_err(|(index, error)| anyhow::anyhow!("term {index}: {error}"))?;
    let mut model = ErrorModel::zero(table);
    model.constants_m = refitted.constants_m.map(|k| k as f32);
    for (slot, row) in model.coefficients.iter_mut().zip(&refitted.rows) {
        *slot = row.coefficients.map(|pair| pair.map(|value| value as f32));
    }
    model.validate()?;
    Ok(model)
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::frame::SEGMENTS;
    use courier_sensor::model::Multiplier;
    use diagnosis::transfer::model::NamelessAmounts;
    use diagnosis::verdict::answer::Magnitude;
    use effects::identity::{Factor, Wave};
    use effects::sensor::{BasisInputs, NestedForms};

    fn amount(name: &str, value: f64) -> Magnitude {
        Magnitude {
            name: name.into(),
            value,
            deviation: None,
            unit: "m".into(),
        }
    }

    fn diagnosed(effect: &str, amounts: Vec<Magnitude>) -> Model {
        Model {
            effects: vec![EffectAmounts {
                name: effect.into(),
                carries_over: true,
                amounts,
            }],
            inputs: inputs(),
            ..Model::default()
        }
    }

    /// A recording that offers all that the effects need.
    fn inputs() -> BasisInputs {
        BasisInputs {
            segments: [true; 4],
            turning: true,
            moving: true,
            lateral: true,
            beacon: true,
            temperature: true,
            pitch_m: 1.0e-3,
            tan_full_scale: 0.1,
            top_speed_m_s: [0.05; 4],
            ..BasisInputs::default()
        }
    }

    /// The place of an amount of a model with all fuller forms.
    fn at(effect: &str, amount: &str) -> Option<(Term, usize, usize)> {
        let forms = NestedForms {
            lag_waves: true,
            memory_waves: true,
            softens: true,
            pairs_warm: true,
            ..NestedForms::default()
        };
        let mut model = diagnosed(effect, Vec::new());
        model.inputs.forms = forms;
        let places = places(&model, &model.effects[0]);
        let known = effects::effect(effect).expect(effect);
        let all = known.regressors(&model.inputs);
        assert!(all.iter().any(|r| r.name == amount), "{effect}: {amount}");
        let place = places.get(amount)?;
        Some((place.term, place.part, place.segment))
    }

    #[test]
    fn amounts_become_the_terms_that_they_are() {
        assert_eq!(
            at("lateral_dependence", "order 2 cosine, segment 3"),
            Some((Term::lateral(2), 1, 2))
        );
        let mixed = Term {
            own_order: 2,
            lateral_order: -1,
            ..Term::default()
        };
        assert_eq!(
            at(
                "lateral_dependence",
                "own order 2, lateral order -1 sine, segment 1"
            ),
            Some((mixed, 0, 0))
        );
        assert_eq!(
            at("angle_dependence", "theta times order 1 sine, segment 4"),
            Some((Term::own(1).with_theta(1), 0, 3))
        );
        assert_eq!(
            at("velocity_lag", "delay, segment 2"),
            Some((Term::default().with(Multiplier::Speed), 1, 1))
        );
        assert_eq!(
            at("velocity_lag", "delay times order 2 cosine, segment 3"),
            Some((Term::own(2).with(Multiplier::Speed), 1, 2))
        );
        let wave = "direction turned evenly over 12 um times order 1 sine, segment 3";
        assert_eq!(
            at("hysteresis", wave),
            Some((Term::own(1).with(Multiplier::Direction), 0, 2))
        );
        assert_eq!(
            at("thermal_drift", "warmth times order 2 sine, segment 4"),
            Some((Term::own(2).with(Multiplier::Temperature), 0, 3))
        );
        assert_eq!(
            at("thermal_drift", "offset, segment 1"),
            Some((Term::default().with(Multiplier::Temperature), 1, 0))
        );
        let slow = "direction that is less below 12 mm/s, segment 3";
        assert_eq!(at("hysteresis", slow), None);
        assert_eq!(at("velocity_lag", "square of speed, segment 2"), None);
        assert_eq!(at("psd_nonlinearity", "x^3 y^0 on x"), None);
    }

    #[test]
    fn a_power_of_the_angle_becomes_the_nearest_one_that_the_board_has() {
        let sum = |power: i32| -> f64 {
            let angles = (-500..=500).map(|k| row::USUAL_ANGLE_RAD * f64::from(k) / 500.0);
            angles.map(|theta| theta.powi(power)).sum()
        };
        let of_power = |power: i32| {
            let wave = Wave {
                own_order: 2,
                ..Wave::constant(0, Factor::Angle(power))
            };
            terms::place(&wave)
        };
        let fourth = of_power(4).expect("a place");
        assert_eq!(fourth.term, Term::own(2).with_theta(2));
        let nearest = sum(4 + 2) / sum(2 + 2);
        assert!((fourth.share / nearest - 1.0).abs() < 0.01);
        assert_eq!(of_power(2).expect("a place").share, 1.0);
        assert_eq!(of_power(3), None);
    }

    #[test]
    fn every_effect_that_says_so_gives_terms_of_the_board() {
        let on_board = |e: &&&dyn effects::Effect| !e.card().on_board.is_empty();
        for side in effects::EFFECTS.iter().filter(on_board) {
            let amounts = side
                .regressors(&inputs())
                .iter()
                .map(|r| amount(&r.name, if r.unit == "m" { 1.0e-6 } else { 1.0e-5 }))
                .collect();
            let name = side.name();
            let board = BoardModel::new(&diagnosed(name, amounts), &Geometry::PAPER).expect(name);
            assert!(board.model.terms.len() > 4, "{name}");
        }
    }

    #[test]
    fn the_largest_harmonics_are_kept_where_not_all_have_room() {
        let amounts = [(3, 1.0e-7), (5, 3.0e-6), (8, 2.0e-6)]
            .map(|(n, v)| amount(&format!("order {n} sine, segment 1"), v));
        let board = BoardModel::new(
            &diagnosed("extra_harmonics", amounts.to_vec()),
            &Geometry::PAPER,
        )
        .unwrap();
        let orders: Vec<u8> = board
            .model
            .terms
            .iter()
            .map(|term| term.own_order)
            .collect();
        assert_eq!(orders, [1, 2, 4, 6, 5, 8]);
        assert!(
            board.left[0].contains("no room in the board's error model: 1"),
            "{:?}",
            board.left
        );
        // Order 3's 0.035 µm, and what the phases' own error makes of the others.
        assert!(
            (0.035e-6..0.15e-6).contains(&board.left_m),
            "{:e}",
            board.left_m
        );
    }

    /// The error of equation (3) moves the phases that the diagnosis speaks of: terms taken over as they are miss more than
    /// terms fitted to the board's own phases.
    #[test]
    fn terms_are_fitted_to_the_board_s_own_phases() {
        let amounts = [
            ("order 1 sine, segment 1", 6.0e-6),
            ("order 1 cosine, segment 2", -4.0e-6),
        ];
        // As many as a board has room for beside them.
        let mixed = [1, 2].into_iter().flat_map(|order| {
            [-1, 1].map(|lateral| {
                format!("own order {order}, lateral order {lateral} sine, segment 3")
            })
        });
        let mut list = amounts.map(|(name, value)| amount(name, value)).to_vec();
        list.extend(mixed.map(|name| amount(&name, 1.0e-12)));
        list.push(amount("order 2 sine, segment 1", 1.0e-12));
        let mut model = diagnosed("lateral_dependence", list);
        for k in &mut model.baseline_with_effects.k_m {
            k[1] = 14.0e-6;
        }
        let geometry = Geometry::PAPER;
        let (own, board) = (
            equation_3(&model.baseline_with_effects),
            BoardModel::new(&model, &geometry).unwrap(),
        );
        let Effects { all, chosen, .. } = effects(&model, &own);
        let as_they_are: Vec<Row> = [own.as_slice(), &chosen].concat();
        let correction = Diagnosed {
            own: &own,
            effects: &all,
            constants_m: [0.0; SEGMENTS],
        };
        let refitted = refit(&correction, &as_they_are, &geometry).unwrap();
        assert!(refitted.left_m < 0.1e-6, "{:e}", refitted.left_m);
        let unchanged = refit::miss_m(&correction, &as_they_are, &geometry);
        assert!(
            unchanged > 5.0 * refitted.left_m,
            "{unchanged:e} against {:e}",
            refitted.left_m
        );
        assert!(board.model.terms.len() > 5);
    }

    /// A correction without a name brings its own equation (3), and what is a term of the board's becomes that term.
    #[test]
    fn a_correction_without_a_name_becomes_terms() {
        let wave = |own_order, factor| Wave {
            segment: 2,
            own_order,
            lateral_order: 0,
            part: effects::identity::Part::Cosine,
            factor,
        };
        let mut nameless = NamelessAmounts {
            coordinates: vec!["speed and own tooth phase".into()],
            waves: vec![
                (wave(2, Factor::Speed), 3.0e-5),
                (wave(1, Factor::Logged), 1.0e-6),
            ],
            other_shapes: 4,
            ..NamelessAmounts::default()
        };
        nameless.baseline.k_m[0][2] = 5.0e-6;
        let model = Model {
            nameless: Some(nameless),
            ..Model::default()
        };
        let board = BoardModel::new(&model, &Geometry::PAPER).unwrap();
        let term = Term::own(2).with(Multiplier::Speed);
        let slot = board.model.terms.iter().position(|t| *t == term).unwrap();
        let [sine, cosine] = board.model.coefficients[slot][2];
        assert_eq!((sine, cosine), (0.0, 3.0e-5));
        assert!((board.model.coefficients[0][0][1] - 5.0e-6).abs() < 0.2e-6);
        let name = "shapes without a name over speed and own tooth phase";
        assert_eq!(board.taken, [(name.to_owned(), 1)]);
        assert!(board.left[0].contains(": 5"), "{:?}", board.left);
    }

    #[test]
    fn a_model_without_a_term_for_the_board_is_refused() {
        assert!(BoardModel::new(&Model::default(), &Geometry::PAPER).is_err());
        assert!(
            BoardModel::new(
                &diagnosed("psd_nonlinearity", vec![amount("x^3 y^0 on x", 1.0)]),
                &Geometry::PAPER
            )
            .is_err()
        );
    }
}
