//! Simulated shafts: what is learned is right, and as well known as is said.

use crate::spun::{PITCH_M, Spins, left_m, pair_read, places_read, random, rms_about_mean};
use encoder::{Answer, Input, Question, learn};
use std::f64::consts::TAU;

/// Offset, gain, angle, and a third harmonic of negative sequence: order 4 of the angle, and of the radius.
fn signals(turns: f64) -> [f64; 2] {
    let phase = TAU * turns;
    let [sine, cosine] = [
        phase.sin() - 0.006 * (3.0 * phase).sin(),
        (phase + 0.07).cos() + 0.006 * (3.0 * phase).cos(),
    ];
    [600.0 + 15_000.0 * sine, -300.0 + 15_900.0 * cosine]
}

fn after_m(answer: &Answer, input: &Input, places: &[f64]) -> f64 {
    left_m(
        input
            .place
            .iter()
            .zip(&input.counts)
            .map(|(place, counts)| answer.calibrated(*place, Some(*counts))),
        places,
    )
}

/// What the true places tell: the same model with its constants by a search that is given them.
fn with_reference_m(answer: &Answer, input: &Input, places: &[f64]) -> f64 {
    let corrected: Vec<f64> = input
        .counts
        .iter()
        .map(|counts| answer.corrected(*counts))
        .collect();
    let errors: Vec<f64> = corrected
        .iter()
        .zip(places)
        .map(|(turns, place)| place - turns - (place - turns).round())
        .collect();
    let columns = 17;
    let function = |turns: f64, column: usize| match column {
        0 => 1.0,
        odd if odd % 2 == 1 => (TAU * odd.div_ceil(2) as f64 * turns).sin(),
        even => (TAU * (even / 2) as f64 * turns).cos(),
    };
    let matrix = nalgebra::DMatrix::from_fn(errors.len(), columns, |row, column| {
        function(corrected[row], column)
    });
    let right = nalgebra::DVector::from_vec(errors);
    let values = (matrix.tr_mul(&matrix))
        .cholesky()
        .expect("well determined")
        .solve(&matrix.tr_mul(&right));
    let left = right - matrix * values;
    rms_about_mean(left.as_slice()) * PITCH_M
}

#[test]
fn a_pair_spun_by_hand_is_calibrated_as_well_as_with_a_reference() {
    for seed in 1..4 {
        let mut random = random(seed);
        let (t_s, places) = Spins::by_hand().places(&mut random);
        let input = pair_read(&t_s, &places, signals, 8.0, &mut random);
        let answer = learn(&input, &Question::default()).unwrap();
        let [after, with] = [
            after_m(&answer, &input, &places),
            with_reference_m(&answer, &input, &places),
        ];
        println!(
            "seed {seed}: {:.3} -> {:.4} µm, with a reference {:.4}",
            1e6 * left_m(input.place.iter().copied(), &places),
            1e6 * after,
            1e6 * with
        );
        assert!(after <= 1.1 * with, "{after} {with}");
        let channels = answer.channels.as_ref().unwrap();
        let found = [
            channels.offset_counts[0],
            channels.offset_counts[1],
            channels.gain,
            channels.angle_rad,
        ];
        let [sine, cosine] = channels.offset_deviation_counts;
        let deviations = [
            sine,
            cosine,
            channels.gain_deviation,
            channels.angle_deviation_rad,
        ];
        for (n, wanted) in [600.0, -300.0, 1.06, 0.07].into_iter().enumerate() {
            // With skewed channels the third harmonic is partly of the other sequence, which is order 2 of the radius: their product.
            let product = [0.0, 0.0, 0.006 * 0.07, 0.006 * 0.07][n];
            assert!(
                (found[n] - wanted).abs() < 4.5 * deviations[n] + 1.1 * product,
                "{n}: {found:?} ± {deviations:?}"
            );
        }
    }
}

fn error(turns: f64) -> f64 {
    2.0e-3 * (TAU * turns).sin()
        + 1.0e-3 * (TAU * 2.0 * turns).cos()
        + 5.0e-4 * (TAU * 4.0 * turns).sin()
}

/// The truth of one number, turns: sine and cosine of orders 1, 2, 4.
fn wanted(order: usize) -> [f64; 2] {
    match order {
        1 => [2.0e-3, 0.0],
        2 => [0.0, 1.0e-3],
        4 => [5.0e-4, 0.0],
        _ => [0.0, 0.0],
    }
}

/// Over many seeds the errors are as large as their deviations say: order by order, with motion that is pushed about by a torque
/// that is white noise, so that low orders are known less well than high ones.
#[test]
fn deviations_are_right_over_many_seeds() {
    let seeds = 60;
    let spins = Spins {
        seconds: 2.5,
        ..Spins::by_hand()
    };
    let mut squares = [0.0; 8];
    for seed in 0..seeds {
        let mut random = random(1000 + seed);
        let (t_s, places) = spins.places(&mut random);
        let input = places_read(&t_s, &places, error, 2.0e-5, &mut random);
        let answer = learn(&input, &Question::default()).unwrap();
        for harmonic in &answer.harmonics {
            for (found, wanted) in [harmonic.sine_m, harmonic.cosine_m]
                .into_iter()
                .zip(wanted(harmonic.order))
            {
                squares[harmonic.order - 1] +=
                    ((found / PITCH_M - wanted) * PITCH_M / harmonic.deviation_m).powi(2)
                        / f64::from(2 * seeds as u32);
            }
        }
    }
    println!("{squares:.2?}");
    // 120 squares of a t distribution of 30 to 40 freedoms: they scatter by 14 % about 1.06.
    for (order, square) in squares.iter().enumerate() {
        assert!(
            (0.6..1.6).contains(square),
            "order {}: {squares:?}",
            order + 1
        );
    }
    let mean = squares.iter().sum::<f64>() / 8.0;
    // 960 of them: 5 %.
    assert!((0.9..1.25).contains(&mean), "{squares:?}");
}

/// A torque that is locked to the phase makes a ripple of order 4 of the sensor's error's size: with several speeds it is told apart, and
/// is as large as the equation of motion says.
#[test]
fn a_ripple_of_the_motion_is_told_from_an_error_by_several_speeds() {
    let size = 2.0;
    let spins = Spins {
        ripple: vec![(4, size)],
        ..Spins::by_hand()
    };
    let mut random = random(5);
    let (t_s, places) = spins.places(&mut random);
    let input = places_read(&t_s, &places, error, 2.0e-5, &mut random);
    let answer = learn(&input, &Question::default()).unwrap();
    let harmonic = &answer.harmonics[3];
    let ripple = size / (TAU * 4.0 * answer.ripple_speed_hz).powi(2) * PITCH_M;
    let found = harmonic.ripple_m.expect("named");
    // The speed of a stretch stands for all speeds in it, which decay by up to a tenth: the ripple's square root of a mean is off
    // by less than the square of that.
    assert!((found / ripple - 1.0).abs() < 0.1, "{found} {ripple}");
    let off = [harmonic.sine_m - 5.0e-4 * PITCH_M, harmonic.cosine_m];
    assert!(
        off.iter()
            .all(|off| off.abs() < 4.0 * harmonic.deviation_m + 0.1 * ripple),
        "{off:?} {harmonic:?}"
    );
    assert!(
        answer
            .remarks
            .iter()
            .any(|remark| remark.what.contains("in order 4") && remark.tell.contains("coasting")),
        "{:#?}",
        answer.remarks
    );
    // Beside it only its products with the error: 2 π 4 times 2e-3 turns of it, 5 %.
    let others = answer
        .harmonics
        .iter()
        .filter(|harmonic| harmonic.order != 4)
        .filter_map(|harmonic| harmonic.ripple_m);
    assert!(
        others.into_iter().all(|other| other < 0.06 * found),
        "{:#?}",
        answer.harmonics
    );
}

/// At one speed the same ripple is taken for the sensor's, and the answer says that it may be one, and what would tell.
#[test]
fn at_one_speed_the_answer_says_what_it_cannot_tell() {
    let spins = Spins {
        speeds: vec![5.0],
        seconds: 16.0,
        decay: 0.0,
        ripple: vec![(4, 20.0)],
        ..Spins::by_hand()
    };
    let mut random = random(6);
    let (t_s, places) = spins.places(&mut random);
    let input = places_read(&t_s, &places, |_| 0.0, 2.0e-5, &mut random);
    let answer = learn(&input, &Question::default()).unwrap();
    assert!(answer.harmonics[3].applied && answer.harmonics[3].ripple_m.is_none());
    let said = |what: &str, tell: &str| {
        answer
            .remarks
            .iter()
            .any(|remark| remark.what.contains(what) && remark.tell.contains(tell))
    };
    assert!(
        said("at one speed", "half or twice the speed"),
        "{:#?}",
        answer.remarks
    );
    assert!(said("one way", "the other way"), "{:#?}", answer.remarks);
    assert!(
        said("only a position", "sine and cosine"),
        "{:#?}",
        answer.remarks
    );
}

#[test]
fn too_little_motion_and_no_circle_are_refused_with_what_was_found() {
    let mut random = random(7);
    let spins = Spins {
        speeds: vec![5.0],
        seconds: 0.7,
        ..Spins::by_hand()
    };
    let (t_s, places) = spins.places(&mut random);
    let input = places_read(&t_s, &places, error, 2.0e-5, &mut random);
    let refusal = learn(&input, &Question::default()).unwrap_err().to_string();
    assert!(
        refusal.starts_with("found 2 stretches of 1.25 periods"),
        "{refusal}"
    );
    let arc = pair_read(&t_s, &vec![0.1; t_s.len()], signals, 8.0, &mut random);
    let refusal = learn(&arc, &Question::default()).unwrap_err().to_string();
    assert!(refusal.contains("no whole circle"), "{refusal}");
    assert!(learn(&Input::default(), &Question::default()).is_err());
}
