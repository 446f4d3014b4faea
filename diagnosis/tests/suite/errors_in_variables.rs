//! Noise that columns carry, against what a sine of the own phase must carry.
use specimens::rig;

use diagnosis::Options;
use diagnosis::data::prepare::prepare;
use diagnosis::design::assembly::{DesignOptions, assemble};
use diagnosis::inference::fit::{Fit, solve, squares};
use specimens::{Case, Conditions};
use std::f64::consts::TAU;

/// g_p has four readings' noise, n each. An amount `a` of sin(3 f p) takes a 3 f cos(3 f p) n from one of them: squares a row
/// grow by (3 a f)² / 2 over 4 where the place is the reading's own, and a steep slope of either sign gives nearly the same.
#[test]
fn a_sine_of_the_own_phase_adds_what_its_slope_says() {
    let options = rig::Options {
        samples: 6000,
        beacon: false,
        ..rig::Options::default()
    };
    let (recording, courier) = rig::record(31, &[], &options);
    let prepared = prepare(&recording).unwrap();
    let design = assemble(
        &prepared,
        &Options::default(),
        &prepared.point(),
        DesignOptions::default(),
    );
    let blocks = &design.columns.blocks;
    let own = blocks.iter().find(|b| b.name == "extra_harmonics").unwrap();
    let name = |c: &usize| design.columns.regressors[*c].name == "order 3 sine, segment 1";
    let column = own.columns.clone().find(name).unwrap();
    let quiet = (0..design.linearized.len()).filter(|&i| design.linearized.is_quiet(0, i));
    let noisy = 1.0 - quiet.count() as f64 / design.linearized.len() as f64;
    let slope = 4.0;
    let amount_m = slope * courier.pitch / (3.0 * TAU);
    let fit = solve(
        design.gram.training(None),
        &[column],
        &design.gram.centre,
        1.0,
    )
    .unwrap();
    for sign in [-1.0, 1.0] {
        let fit = Fit {
            coefficient: fit
                .coefficient
                .map(|_| sign * amount_m / design.gram.scale[column]),
            ..fit.clone()
        };
        let allowance = design.errors_in_variables.allowance(squares(
            design.errors_in_variables.products(),
            &fit.columns,
            &fit.coefficient,
        ));
        let expected = slope * slope / 8.0 * noisy;
        assert!(
            (allowance / expected - 1.0).abs() < 0.25,
            "{allowance} for {expected}"
        );
    }
}

/// A courier that goes along y under the beacon and keeps within two thirds of a tooth along x: there a gain of the diode looks like waves of
/// equation (3), and is told by its prior alone. A gain that is too small by a percent takes a percent of the diode's noise away. Nothing
/// is wrong with this one, and no shape over the deflection leaves less than the baseline but by the chance of its columns.
#[test]
fn a_gain_of_the_diode_that_the_motion_hardly_tells_rebuilds_no_noise() {
    let case = Case::draw(24, 6056, Conditions::Drawn);
    let prepared = prepare(&case.known_exactly()).unwrap();
    let (options, point) = (Options::default(), prepared.point());
    let design = assemble(&prepared, &options, &point, DesignOptions::default());
    let mut validation = design.cross_validation();
    let baseline = validation.score(&[]).squares;
    for name in ["psd_misalignment", "psd_nonlinearity"] {
        let mut blocks = design.columns.blocks.iter();
        let block = blocks.position(|block| block.name == name).unwrap();
        let columns = design.columns.blocks[block].columns.len() as f64;
        let with = validation.score(&[block]).squares;
        let chance = 4.0 * (2.0 * columns).sqrt();
        assert!(with > baseline - chance, "{name}: {baseline}, then {with}");
    }
}
