//! A diagnosed model as an estimate.

use super::source::Compared;
use crate::board_model::waves;
use anyhow::{Result, ensure};
use comparison::estimate::{Certainty, EQUATION_3, EQUATION_11, Estimate, Unknown, Wave};
use courier_sensor::frame::SEGMENTS;
use courier_sensor::geometry::Geometry;
use courier_sensor::model::Term;
use diagnosis::Model;
use diagnosis::inference::covariance::PosteriorCovariance;
use diagnosis::linearization::baseline::ORDERS;
use diagnosis::verdict::answer::Magnitude;
use nalgebra::{DMatrix, DVector};
use std::collections::HashMap;

/// What the baseline's unknowns belong to in a model.
const BASELINE: &str = "baseline";

/// One unknown with its value, and its name in the model's covariance.
struct Amount {
    unknown: Unknown,
    value: f64,
    key: [String; 2],
}

/// Of a model that is called `name`.
///
/// # Errors
/// It is of another version, or two lengths of it are no lengths.
pub fn estimate(name: &str, model: &Model) -> Result<Compared> {
    ensure!(
        model.schema == 1,
        "schema: found {}, wanted 1",
        model.schema
    );
    let pitch_m = model.inputs.pitch_m;
    ensure!(
        pitch_m > 0.0 && pitch_m.is_finite(),
        "survey.pitch_m: found {pitch_m}, wanted above 0"
    );
    let amounts = amounts(model);
    let certainty = match &model.certainty {
        Some(certainty) if certainty.draws.is_empty() => Ok(of_amounts(certainty, model, &amounts)),
        Some(_) => Err("its covariance is kept as draws of a field of teeth".to_owned()),
        None => Err("no effect is named in it, and then a model keeps no covariance: compare the recordings".to_owned()),
    };
    let values: Vec<f64> = amounts.iter().map(|amount| amount.value).collect();
    let parity = model
        .claimed
        .channels
        .iter()
        .find(|channel| channel.channel == "g_p");
    let estimate = Estimate {
        name: name.into(),
        about: format!("model of {}", model.recording),
        made_s: None,
        geometry: Geometry {
            pitch_m: pitch_m as f32,
            ..Geometry::PAPER
        },
        unknowns: amounts.into_iter().map(|amount| amount.unknown).collect(),
        values: DVector::from_vec(values),
        certainty,
        parity: parity.map(|channel| (channel.after_rms_m, f64::INFINITY)),
        amplitude_counts: [0.0; SEGMENTS],
        looked_for_all: true,
        left_out: vec![
            "offsets, and the beacon's place: they go with where the tooth counts began (gauge)"
                .to_owned(),
        ],
    };
    Ok(Compared {
        estimate,
        device: None,
        stated: [None; 2],
    })
}

/// Equation (3), height and lever arms, and each effect that carries over.
fn amounts(model: &Model) -> Vec<Amount> {
    let mut list = own(model);
    let baseline = &model.baseline_with_effects;
    if model.inputs.beacon {
        let lengths = [
            ("height h", baseline.height_m),
            ("lever l_x", baseline.lever_m[0]),
            ("lever l_y", baseline.lever_m[1]),
        ];
        list.extend(lengths.map(|(name, value)| Amount {
            unknown: Unknown {
                effect: EQUATION_11.into(),
                name: name.into(),
                unit: "m".into(),
                wave: None,
            },
            value,
            key: [BASELINE.into(), name.into()],
        }));
    }
    for effect in model.effects.iter().filter(|effect| effect.carries_over) {
        let waves = waves(model, effect);
        list.extend(effect.amounts.iter().map(|amount| Amount {
            unknown: of_effect(&effect.name, amount, waves.get(&amount.name)),
            value: amount.value,
            key: [effect.name.clone(), amount.name.clone()],
        }));
    }
    list
}

/// An amount; what is a term of the board's error model is named as that.
fn of_effect(effect: &str, amount: &Magnitude, wave: Option<&Wave>) -> Unknown {
    let named = match wave {
        Some(wave) if wave.share == 1.0 => Unknown::of_wave(*wave),
        wave => Unknown {
            effect: String::new(),
            name: amount.name.clone(),
            unit: amount.unit.clone(),
            wave: wave.copied(),
        },
    };
    Unknown {
        effect: effect.into(),
        ..named
    }
}

fn own(model: &Model) -> Vec<Amount> {
    let mut list = Vec::new();
    for segment in (0..SEGMENTS).filter(|segment| model.inputs.segments[*segment]) {
        for (place, order) in ORDERS.into_iter().enumerate() {
            for part in 0..2 {
                let wave = Wave {
                    segment,
                    term: Term::own(order as u8),
                    cosine: part == 1,
                    share: 1.0,
                };
                let unknown = Unknown::of_wave(wave);
                let key = [BASELINE.into(), unknown.name.clone()];
                let value = model.baseline_with_effects.k_m[segment][1 + 2 * place + part];
                list.push(Amount {
                    unknown: Unknown {
                        effect: EQUATION_3.into(),
                        ..unknown
                    },
                    value,
                    key,
                });
            }
        }
    }
    list
}

/// The covariance for a list of amounts, times the square of the Birge ratio, as the diagnosis tells each ±.
fn of_amounts(certainty: &PosteriorCovariance, model: &Model, amounts: &[Amount]) -> Certainty {
    let places: HashMap<&[String; 2], usize> = certainty.amounts.iter().zip(0..).collect();
    let places: Vec<Option<usize>> = amounts
        .iter()
        .map(|amount| places.get(&amount.key).copied())
        .collect();
    let birge = model.claimed.whitened_after.max(1.0);
    let element = |a: usize, b: usize| {
        let (high, low) = (a.max(b), a.min(b));
        let value = certainty.covariance.get(high * (high + 1) / 2 + low);
        birge * birge * value.copied().unwrap_or(0.0)
    };
    let covariance = DMatrix::from_fn(amounts.len(), amounts.len(), |a, b| {
        match (places[a], places[b]) {
            (Some(a), Some(b)) => element(a, b),
            _ => 0.0,
        }
    });
    Certainty {
        covariance,
        freedom: f64::INFINITY,
        own: 0.0,
        lateral: None,
        source: format!(
            "by the diagnosis: noise, motion and priors, times a Birge ratio of {birge:.2}"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use diagnosis::transfer::model::EffectAmounts;

    fn model() -> Model {
        let mut model = Model {
            schema: 1,
            ..Model::default()
        };
        (model.inputs.pitch_m, model.inputs.segments) = (1.016e-3, [true; 4]);
        (model.inputs.lateral, model.inputs.turning) = (true, true);
        model.baseline_with_effects.k_m[1][3] = 2.0e-6;
        let amount = |name: &str| Magnitude {
            name: name.into(),
            value: 1.0e-6,
            deviation: None,
            unit: "m".into(),
        };
        model.effects = vec![EffectAmounts {
            name: "lateral_dependence".into(),
            carries_over: true,
            amounts: vec![amount("order 2 cosine, segment 3")],
        }];
        model.certainty = Some(PosteriorCovariance {
            amounts: vec![
                ["baseline".into(), "order 2 sine, segment 2".into()],
                [
                    "lateral_dependence".into(),
                    "order 2 cosine, segment 3".into(),
                ],
            ],
            covariance: vec![4.0e-14, 1.0e-14, 9.0e-14],
            ..PosteriorCovariance::default()
        });
        model.claimed.whitened_after = 2.0;
        model
    }

    #[test]
    fn amounts_have_their_covariance_and_the_birge_ratio() {
        let estimate = estimate("m.json", &model()).unwrap().estimate;
        let place = |name: &str| {
            estimate
                .unknowns
                .iter()
                .position(|of| of.name == name)
                .unwrap()
        };
        let (own, lateral) = (
            place("order 2 sine, segment 2"),
            place("lateral order 2 cosine, segment 3"),
        );
        assert_eq!(
            (estimate.values[own], estimate.values[lateral]),
            (2.0e-6, 1.0e-6)
        );
        assert_eq!(
            estimate.unknowns[lateral].wave.map(|wave| wave.term),
            Some(Term::lateral(2))
        );
        let covariance = &estimate.certainty.as_ref().unwrap().covariance;
        let near =
            |found: f64, wanted: f64| assert!((found / wanted - 1.0).abs() < 1.0e-9, "{found:e}");
        near(covariance[(own, own)], 16.0e-14);
        near(covariance[(lateral, own)], 4.0e-14);
        near(covariance[(lateral, lateral)], 36.0e-14);
        // What the model keeps no covariance of was held.
        assert!(!estimate.is_estimated(place("order 1 sine, segment 1")));
    }

    #[test]
    fn a_model_that_keeps_no_covariance_says_why() {
        let told = |change: fn(&mut Model)| {
            let mut model = model();
            change(&mut model);
            estimate("m.json", &model)
                .unwrap()
                .estimate
                .certainty
                .unwrap_err()
        };
        assert!(told(|m| m.certainty = None).contains("no effect"));
        assert!(
            told(|m| m.certainty.as_mut().unwrap().draws = vec![vec![0.0; 2]])
                .contains("field of teeth")
        );
        let mut other = model();
        other.inputs.pitch_m = 0.0;
        assert!(estimate("m.json", &other).is_err());
    }
}
