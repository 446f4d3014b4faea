//! Platens whose lines are not two equal rulings at right angles, against the truth of the plant.

use crate::simulated::{field_m, home_teeth, ruled, ruling_m};
use effects::axis_skew::AxisSkew;
use fleet::{Answer, Cells, Fitted, Member, PlatenAnswer, State, Told, answer, fit};
use hal_sim::presets::of_the_make;
use nalgebra::{DMatrix, DVector};

/// Two equal rulings at right angles.
const STRAIGHT: AxisSkew = AxisSkew {
    skew_rad: 0.0,
    pitch_difference: 0.0,
    bow_per_m: 0.0,
};

/// A platen and its rulings.
type Ruled = (u64, AxisSkew);

/// Recordings of each courier over each platen.
fn recordings(couriers: &[u64], platens: &[Ruled], poses: usize) -> Vec<Member> {
    let one = |(platen, ruling): &Ruled| -> Vec<Member> {
        let each = couriers.iter().map(|c| {
            let seeds = [*c, *platen, 10_000 * platen + c];
            ruled(*ruling, seeds, poses, 2.0)
        });
        each.collect()
    };
    platens.iter().flat_map(one).collect()
}

fn name(platen: u64) -> String {
    format!("platen {platen}")
}

/// Slopes along and across of what teeth and rulings add to readings, over the cells of the segments of one direction. Each segment has its own height.
fn slopes((platen, ruling): &Ruled, direction: usize, cells: [&Cells; 2]) -> [f64; 2] {
    let pitch_m = of_the_make(None, None).geometry.pitch_m;
    let (mut rows, mut values) = (Vec::new(), Vec::new());
    for (k, cells) in cells.into_iter().enumerate() {
        for cell in cells {
            let first = f64::from(u8::from(k == 0));
            let place_m = cell.map(|tooth| f64::from(tooth) * pitch_m);
            rows.extend([first, 1.0 - first, place_m[0], place_m[1]]);
            values.push(field_m(*platen, direction, *cell) + ruling_m(ruling, direction, *cell));
        }
    }
    let design = DMatrix::from_row_slice(values.len(), 4, &rows).svd(true, true);
    let found = design.solve(&DVector::from_vec(values), 1e-12).unwrap();
    [found[2], found[3]]
}

/// The truth of a platen's pitch of x over y and of its angle, over the cells that its recordings crossed.
fn truth(of: &Ruled, members: &[&Member], state: &State) -> [f64; 2] {
    let courier = members[0].courier.trim_start_matches("courier ");
    let home = home_teeth(&of_the_make(Some(courier.parse().unwrap()), None));
    let mut cells: [Cells; 4] = Default::default();
    for member in members {
        let visited = fleet::visited_by_segments(member, state);
        for (s, (all, own)) in cells.iter_mut().zip(visited).enumerate() {
            let own = own.into_iter();
            all.extend(own.map(|[i, j]| [i + home[s % 2], j + home[1 - s % 2]]));
        }
    }
    let [x, y, other_x, other_y] = &cells;
    let [x_along, x_across] = slopes(of, 0, [x, other_x]);
    let [y_along, y_across] = slopes(of, 1, [y, other_y]);
    [x_along - y_along, x_across + y_across]
}

fn of_platen(answer: &Answer, platen: u64) -> &PlatenAnswer {
    let mut all = answer.platens.iter();
    let of_it = all.find(|of| of.platen.platen_id == name(platen));
    of_it.unwrap()
}

/// What is told of each platen's pitches and angle less the mean, and the truth.
fn told(members: &[Member], fitted: &Fitted, platens: &[Ruled]) -> Vec<[(Told, f64); 2]> {
    let answer = answer(members, fitted).unwrap();
    let of_one = |of: &Ruled| {
        let own = members.iter().filter(|m| m.platen.platen_id == name(of.0));
        truth(of, &own.collect::<Vec<_>>(), &fitted.state)
    };
    let truths: Vec<[f64; 2]> = platens.iter().map(of_one).collect();
    let mean = [0, 1].map(|k| truths.iter().map(|t| t[k]).sum::<f64>() / truths.len() as f64);
    let each = platens.iter().zip(&truths);
    each.map(|((platen, _), truth)| {
        let of_it = of_platen(&answer, *platen);
        let numbers = [of_it.pitch_difference, of_it.out_of_square_rad];
        std::array::from_fn(|k| (numbers[k], truth[k] - mean[k]))
    })
    .collect()
}

/// Two couriers tell two platens apart, of which one has lines that are askew, bent and of two pitches. No recording alone tells that.
#[test]
fn platens_are_told_apart_by_their_lines() {
    let askew = AxisSkew {
        skew_rad: 1.5e-3,
        pitch_difference: 0.8e-3,
        bow_per_m: 0.02,
    };
    let platens = [(5, STRAIGHT), (6, askew)];
    let members = recordings(&[1, 2], &platens, 120);
    let fitted = fit(&members, &|| ()).unwrap();
    assert!(fitted.is_settled());
    for (told, truth) in told(&members, &fitted, &platens).into_iter().flatten() {
        assert!(told.is_told() && !told.is_told_alone(), "{told:?}");
        assert!(truth.abs() > 5.0 * told.deviation, "{truth:e} {told:?}");
        let error = told.value - truth;
        assert!(error.abs() < 3.0 * told.deviation, "{truth:e} {told:?}");
    }
}

/// Errors over what is predicted of them, of pairs of platens with drawn rulings that three couriers cross. Chance is that of as many numbers as there are
/// pairs.
#[test]
#[ignore = "nightly: four minutes of processor time"]
fn errors_of_lines_are_those_that_are_predicted() {
    let pairs = 12_u32;
    let mut squares = [0.0; 2];
    for pair in 0..pairs {
        let turned = (f64::from(pair) * 2.4).sin();
        let askew = AxisSkew {
            skew_rad: 2.0e-3 * turned,
            pitch_difference: 1.0e-3 * (f64::from(pair) * 1.7).cos(),
            bow_per_m: 0.02 * (f64::from(pair) * 0.9).sin(),
        };
        let first = FIRST_PLATEN + 2 * u64::from(pair);
        let platens = [(first, STRAIGHT), (first + 1, askew)];
        let members = recordings(&[1, 2, 3], &platens, 150);
        let fitted = fit(&members, &|| ()).unwrap();
        assert!(fitted.is_settled());
        for (k, (told, truth)) in told(&members, &fitted, &platens)[1].into_iter().enumerate() {
            let error = (told.value - truth) / told.deviation;
            println!(
                "{first} {k}: {truth:.3e} found {:.3e} ± {:.1e}: {error:.2}",
                told.value, told.deviation
            );
            squares[k] += error * error / f64::from(pairs);
        }
    }
    println!("mean squares {squares:?}");
    // Two deviations of a mean of squares of normal numbers.
    let most = 1.0 + 2.0 * (2.0 / f64::from(pairs)).sqrt();
    for mean in squares {
        assert!((0.1..most).contains(&mean), "{squares:?}");
    }
}

/// The first of platens that were not looked at before. A choice.
const FIRST_PLATEN: u64 = 410;
