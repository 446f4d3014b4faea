//! The diagnosed model as the board's error model: which of its effects are terms there, and with which coefficients.

use anyhow::{Result, ensure};
use courier_sensor::frame::SEGMENTS;
use courier_sensor::model::{ErrorModel, MAX_TERMS, Multiplier, Term, TermTable};
use diagnosis::Model;
use diagnosis::baseline::ORDERS;

/// Most terms of the own phase alone that the board can recalibrate with (`calibration::StartError::Terms`).
const MOST_OWN: usize = 6;

/// A model for the board.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardModel {
    /// Terms and coefficients.
    pub model: ErrorModel,
    /// Effects that became terms, and how many each.
    pub taken: Vec<(String, usize)>,
    /// What the board has no term for, one line each.
    pub left: Vec<String>,
}

/// A term with the coefficients of all segments.
#[derive(Clone, Copy)]
struct Row {
    term: Term,
    coefficients: [[f64; 2]; SEGMENTS],
}

impl Row {
    /// Largest magnitude of any coefficient.
    fn size(&self) -> f64 {
        self.coefficients
            .as_flattened()
            .iter()
            .fold(0.0, |largest, c| c.abs().max(largest))
    }
}

impl BoardModel {
    /// Takes over equation (3) and every effect that the board has terms for.
    ///
    /// # Errors
    /// No effect is one, or a coefficient is out of the board's range.
    pub fn new(diagnosed: &Model) -> Result<Self> {
        let mut rows: Vec<Row> = equation_3(diagnosed);
        let (mut taken, mut left) = (Vec::new(), Vec::new());
        for effect in &diagnosed.effects {
            let mut own: Vec<Row> = Vec::new();
            let mut unknown = 0;
            for amount in &effect.amounts {
                match place(&effect.name, &amount.name) {
                    Some((term, part, segment)) => set(&mut own, term, part, segment, amount.value),
                    None => unknown += 1,
                }
            }
            let dropped = fit_in(&rows, &mut own);
            let count = own.len();
            rows.extend(own);
            if count > 0 {
                taken.push((effect.name.clone(), count));
            }
            if unknown + dropped > 0 {
                left.push(format!("{}: {unknown} amounts are no term of the board's error model, {dropped} terms have no room in it", effect.name));
            }
        }
        ensure!(
            !taken.is_empty(),
            "found {}, wanted an effect that the board's error model has terms for (lateral_dependence, extra_harmonics, angle_dependence, velocity_lag, hysteresis, thermal_drift)",
            if diagnosed.effects.is_empty() {
                "no effect in the model".into()
            } else {
                left.join("; ")
            }
        );
        Ok(Self {
            model: model(diagnosed, &rows)?,
            taken,
            left,
        })
    }
}

fn equation_3(diagnosed: &Model) -> Vec<Row> {
    let k = &diagnosed.baseline_with_effects.k_m;
    let row = |(j, &order): (usize, &usize)| Row {
        term: Term::own(order as u8),
        coefficients: std::array::from_fn(|s| [k[s][1 + 2 * j], k[s][2 + 2 * j]]),
    };
    ORDERS.iter().enumerate().map(row).collect()
}

fn set(rows: &mut Vec<Row>, term: Term, part: usize, segment: usize, value: f64) {
    if !rows.iter().any(|row| row.term == term) {
        rows.push(Row {
            term,
            coefficients: [[0.0; 2]; SEGMENTS],
        });
    }
    if let Some(row) = rows.iter_mut().find(|row| row.term == term) {
        row.coefficients[segment][part] += value;
    }
}

/// Keeps the largest rows that there is room for beside those before, and tells how many had none.
fn fit_in(before: &[Row], rows: &mut Vec<Row>) -> usize {
    let all = rows.len();
    let own = |row: &Row| row.term == Term::own(row.term.own_order);
    rows.sort_by(|a, b| b.size().total_cmp(&a.size()));
    let mut room_own = MOST_OWN.saturating_sub(before.iter().filter(|row| own(row)).count());
    rows.retain(|row| {
        let fits = !own(row) || room_own > 0;
        room_own -= usize::from(own(row) && fits);
        fits
    });
    rows.truncate(MAX_TERMS - before.len());
    all - rows.len()
}

fn model(diagnosed: &Model, rows: &[Row]) -> Result<ErrorModel> {
    let terms: Vec<Term> = rows.iter().map(|row| row.term).collect();
    let table = TermTable::new(&terms)
        .map_err(|(index, error)| anyhow::anyhow!("term {index}: {error}"))?;
    let mut model = ErrorModel::zero(table);
    model.constants_m = diagnosed.baseline_with_effects.k_m.map(|k| k[0] as f32);
    for (slot, row) in model.coefficients.iter_mut().zip(rows) {
        *slot = row.coefficients.map(|pair| pair.map(|value| value as f32));
    }
    model.validate()?;
    Ok(model)
}

/// Term, its part (0 sine, 1 cosine) and segment of a named amount; none where the board has no such term.
fn place(effect: &str, amount: &str) -> Option<(Term, usize, usize)> {
    let segment = number(amount, "segment ")?
        .checked_sub(1)
        .filter(|s| *s < SEGMENTS as i64)? as usize;
    let constant = |multiplier| Some((Term::default().with(multiplier), 1, segment));
    match effect {
        "velocity_lag" if amount.starts_with("delay,") => return constant(Multiplier::Speed),
        "hysteresis" if amount.starts_with("direction of travel,") => {
            return constant(Multiplier::Direction);
        }
        "thermal_drift" if amount.starts_with("offset, segment") => {
            return constant(Multiplier::Temperature);
        }
        _ => {}
    }
    let part = if amount.contains(" sine,") {
        0
    } else if amount.contains(" cosine,") {
        1
    } else {
        return None;
    };
    let order = |mark| number(amount, mark).and_then(|n| i8::try_from(n).ok());
    let term = match effect {
        "lateral_dependence" if amount.starts_with("own order ") => Term {
            own_order: order("own order ")?.unsigned_abs(),
            lateral_order: order("lateral order ")?,
            ..Term::default()
        },
        "lateral_dependence" => Term::lateral(order("order ")?),
        "extra_harmonics" => Term::own(order("order ")?.unsigned_abs()),
        "angle_dependence" if amount.starts_with("theta times ") => {
            Term::own(order("order ")?.unsigned_abs()).with_theta(1)
        }
        "angle_dependence" if amount.starts_with("theta squared times ") => {
            Term::own(order("order ")?.unsigned_abs()).with_theta(2)
        }
        _ => return None,
    };
    Some((term, part, segment))
}

/// The whole number behind a mark.
fn number(text: &str, mark: &str) -> Option<i64> {
    let rest = text.split(mark).nth(1)?;
    let end = rest
        .char_indices()
        .find(|(i, c)| !(c.is_ascii_digit() || *i == 0 && *c == '-'))
        .map_or(rest.len(), |(i, _)| i);
    rest[..end].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use diagnosis::model::EffectAmounts;
    use diagnosis::report::Magnitude;

    fn amount(name: &str, value: f64) -> Magnitude {
        Magnitude {
            name: name.into(),
            value,
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
            ..Model::default()
        }
    }

    #[test]
    fn amounts_become_the_terms_that_they_are() {
        let at = |effect, name| place(effect, name);
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
        assert_eq!(at("velocity_lag", "square of speed, segment 2"), None);
        assert_eq!(at("psd_nonlinearity", "cubic x"), None);
    }

    #[test]
    fn every_term_that_the_sensor_sides_can_give_is_one_of_the_board() {
        let survey = effects::sensor::Survey {
            segments: [true; 4],
            turning: true,
            moving: true,
            lateral: true,
            temperature: true,
            pitch_m: 1.0e-3,
            top_speed_m_s: [0.05; 4],
            ..Default::default()
        };
        for name in [
            "lateral_dependence",
            "extra_harmonics",
            "angle_dependence",
            "velocity_lag",
            "hysteresis",
            "thermal_drift",
        ] {
            let side = effects::sensor_sides()
                .into_iter()
                .find(|side| side.name() == name)
                .expect(name);
            let amounts = side
                .regressors(&survey)
                .iter()
                .map(|r| amount(&r.name, 1.0e-6))
                .collect();
            let board = BoardModel::new(&diagnosed(name, amounts)).expect(name);
            assert!(board.model.terms.len() > 4, "{name}");
        }
    }

    #[test]
    fn the_largest_harmonics_are_kept_where_not_all_have_room() {
        let amounts = [(3, 1.0e-7), (5, 3.0e-6), (8, 2.0e-6)]
            .map(|(n, v)| amount(&format!("order {n} sine, segment 1"), v));
        let board = BoardModel::new(&diagnosed("extra_harmonics", amounts.to_vec())).unwrap();
        let orders: Vec<u8> = board
            .model
            .terms
            .iter()
            .map(|term| term.own_order)
            .collect();
        assert_eq!(orders, [1, 2, 4, 6, 5, 8]);
        assert_eq!(board.left.len(), 1);
    }

    #[test]
    fn a_model_without_a_term_for_the_board_is_refused() {
        assert!(BoardModel::new(&Model::default()).is_err());
        assert!(
            BoardModel::new(&diagnosed("psd_nonlinearity", vec![amount("cubic x", 1.0)])).is_err()
        );
    }
}
