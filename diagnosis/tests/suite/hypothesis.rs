//! A fit is a pure function of the data and a hypothesis.
use specimens::rig;

use diagnosis::Options;
use diagnosis::data::prepare::{Prepared, prepare};
use diagnosis::design::assembly::{Design, DesignOptions, assemble};
use diagnosis::hypothesis::Hypothesis;
use diagnosis::linearization::relinearized::{Data, RelinearizedFit, fit};
use std::collections::BTreeMap;

const EFFECTS: [&str; 3] = ["velocity_lag", "extra_harmonics", "psd_nonlinearity"];

fn prepared() -> Prepared {
    let options = rig::Options {
        samples: 2000,
        ..rig::Options::default()
    };
    let effects = [("velocity_lag", 3.0e-6), ("extra_harmonics", 2.0e-6)];
    let (recording, _) = rig::record(7, &effects, &options);
    prepare(&recording).unwrap()
}

/// Fits effects in this order, each time from the recording on.
fn fitted<'a>(prepared: &'a Prepared, effects: &[&str]) -> RelinearizedFit<'a> {
    let design_options = DesignOptions {
        only: Some(&[]),
        ..DesignOptions::default()
    };
    let start = prepared.point();
    let design = assemble(prepared, &Options::default(), &start, design_options);
    let names: Vec<String> = effects.iter().map(|name| (*name).into()).collect();
    let hypothesis = Hypothesis::new(&names, &design.linearized);
    let data = Data {
        recording: &design.linearized,
        start,
    };
    let first = fit(&data, &hypothesis);
    assert_eq!(first.hypothesis, hypothesis);
    first
}

/// Coefficient of each column, in prior deviations, by block and name.
fn coefficients(fit: &RelinearizedFit) -> BTreeMap<(String, String), f64> {
    let of = |c: usize| {
        let mut blocks = fit.columns.blocks.iter();
        let block = blocks.find(|b| b.columns.contains(&c)).unwrap();
        let name = fit.columns.regressors[c].name.clone();
        ((block.name.clone(), name), fit.coefficients[c])
    };
    (0..fit.coefficients.len()).map(of).collect()
}

#[test]
fn the_same_hypothesis_gives_the_same_bits() {
    let prepared = prepared();
    let [one, other] = [(); 2].map(|()| fitted(&prepared, &EFFECTS));
    let bits = |fit: &RelinearizedFit| -> Vec<u64> {
        fit.coefficients.iter().map(|c| c.to_bits()).collect()
    };
    assert_eq!(bits(&one), bits(&other));
    assert_eq!(one.point.baseline, other.point.baseline);
    assert_eq!(one.point.displacement, other.point.displacement);
}

/// Sums are formed in another order, and each round passes on what that rounds off: of a deviation of the prior far less than the noise
/// lets a coefficient be known to, which is a thousandth and more.
#[test]
fn the_order_of_effects_does_not_matter() {
    const TOLERANCE: f64 = 1.0e-6;
    let prepared = prepared();
    let one = coefficients(&fitted(&prepared, &EFFECTS));
    let reversed: Vec<&str> = EFFECTS.iter().rev().copied().collect();
    let other = coefficients(&fitted(&prepared, &reversed));
    assert!(one.keys().eq(other.keys()));
    let off = one.iter().map(|(name, value)| (value - other[name]).abs());
    let most = off.fold(0.0, f64::max);
    assert!(most < TOLERANCE, "{most}");
    assert!(one.values().any(|value| value.abs() > 0.1));
}

/// A comparison about the same point as another takes its recording over instead of linearising it again, whatever was told of that one: the same
/// columns come of it, to the last bit.
#[test]
fn what_is_taken_over_from_another_comparison_is_what_was_linearised() {
    let prepared = prepared();
    let mut point = fitted(&prepared, &["velocity_lag", "hysteresis"]).point;
    point.noise = None;
    let options = Options::default();
    let of = |design_options| assemble(&prepared, &options, &point, design_options);
    let anew = of(DesignOptions::default());
    let mut told = anew.linearized.inputs.clone();
    told.segment_lines_hz = [50.0].into();
    told.gap_told = true;
    let other = of(DesignOptions {
        previous_inputs: Some(&told),
        samples: Some(500),
        field: true,
        ..DesignOptions::default()
    });
    let over = of(DesignOptions {
        like: Some(&other.linearized),
        ..DesignOptions::default()
    });
    assert!(other.gram.total_rows() < anew.gram.total_rows() / 2);
    assert_eq!(over.gram.total_rows(), anew.gram.total_rows());
    assert_eq!(over.gram.scale, anew.gram.scale);
    let scores = |design: &Design| {
        let mut validation = design.cross_validation();
        let blocks = 0..design.columns.blocks.len();
        blocks
            .map(|b| validation.score(&[b]).squares.to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(scores(&over), scores(&anew));
}
