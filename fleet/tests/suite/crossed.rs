//! Couriers over one platen: what is found against the truth of the plant, and against what the fit predicts of its own errors.

use crate::simulated::{along_a_strip, field_m, home_teeth, member, wider};
use effects::plant::SEGMENTS;
use fleet::{
    Answer, Cells, Fitted, Function, Key, Member, Platen, Posterior, SPAN, State, answer, bound,
    field_functions, fit, off_plane, value, visited,
};
use hal_sim::presets::of_the_make;
use nalgebra::DVector;
use std::fmt::{self, Display, Formatter};

/// Squares of errors beside what is predicted of them.
#[derive(Clone, Copy, Default)]
struct Squares {
    errors: f64,
    /// Trace of the errors' predicted covariance, and of its square.
    predicted: f64,
    of_covariance: f64,
}

impl Squares {
    /// Errors of functions of one platen.
    fn add(&mut self, errors: &[f64], by: &Posterior, platen: &Platen, functions: &[Function]) {
        let covariance = by.covariance(platen, functions);
        self.errors += errors.iter().map(|e| e * e).sum::<f64>();
        self.predicted += covariance.trace();
        self.of_covariance += covariance.norm_squared();
    }

    /// Adds those of another platen.
    fn join(&mut self, other: &Self) {
        self.errors += other.errors;
        self.predicted += other.predicted;
        self.of_covariance += other.of_covariance;
    }

    /// Root of the errors' mean square over the predicted.
    fn ratio(&self) -> f64 {
        (self.errors / self.predicted).sqrt()
    }

    /// Degrees of freedom: those of the chi-squared variable that has the mean and the variance that normal errors of the predicted
    /// covariance give their squares' sum (Satterthwaite 1946).
    fn freedoms(&self) -> f64 {
        self.predicted.powi(2) / self.of_covariance
    }

    /// Standard deviation of the ratio about 1 where the prediction is right.
    fn spread(&self) -> f64 {
        (2.0 * self.freedoms()).sqrt().recip()
    }
}

impl Display for Squares {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (ratio, spread, freedoms) = (self.ratio(), self.spread(), self.freedoms());
        write!(
            f,
            "{ratio:.3} (1 ± {spread:.3}, {freedoms:.0} degrees of freedom)"
        )
    }
}

/// The number behind a courier's name.
fn number(courier: &str) -> u64 {
    courier.trim_start_matches("courier ").parse().unwrap()
}

/// Functions whose values a fit and a prediction give, and their true values.
struct Asked {
    functions: Vec<Function>,
    truths: Vec<f64>,
}

/// A platen's field at all cells that were visited, less its plane.
fn field(members: &[Member], state: &State, platen: u64) -> Asked {
    let mut cells = [Cells::new(), Cells::new()];
    for member in members {
        let own = visited(member, state);
        cells
            .iter_mut()
            .zip(own)
            .for_each(|(all, own)| all.extend(own));
    }
    // The platen's count is that of its first recording.
    let home = home_teeth(&of_the_make(Some(number(&members[0].courier)), None));
    let lattice = state.unknowns(&members[0]).lattice();
    let (mut functions, mut truths) = (Vec::new(), Vec::new());
    for (direction, cells) in cells.iter().enumerate() {
        let absolute = |[i, j]: [i32; 2]| [i + home[direction], j + home[1 - direction]];
        let truth = cells
            .iter()
            .map(|cell| field_m(platen, direction, absolute(*cell)));
        let truth = off_plane(cells) * DVector::from_iterator(cells.len(), truth);
        functions.extend(field_functions(lattice, direction as u8, cells));
        truths.extend(truth.iter());
    }
    Asked { functions, truths }
}

/// The couriers' spans, less their mean.
fn spans(members: &[Member]) -> Asked {
    let count = members.len();
    let truths = members.iter().map(|member| {
        let spec = of_the_make(Some(number(&member.courier)), None);
        spec.geometry.span_m - spec.nominal.span_m
    });
    let truths = DVector::from_iterator(count, truths);
    let less_mean = |of: usize| {
        let weight = |i: usize| f64::from(u8::from(i == of)) - 1.0 / count as f64;
        let each = members.iter().enumerate();
        each.map(|(i, member)| (Key::Courier(member.courier.clone(), SPAN), weight(i)))
            .collect()
    };
    Asked {
        functions: (0..count).map(less_mean).collect(),
        truths: truths.add_scalar(-truths.mean()).data.into(),
    }
}

/// Equation (3)'s waves of all couriers.
fn waves(members: &[Member]) -> Asked {
    let (mut functions, mut truths) = (Vec::new(), Vec::new());
    for member in members {
        let truth = of_the_make(Some(number(&member.courier)), None);
        let unknowns = tooth_map::Unknowns::new(member.grids);
        for segment in 0..SEGMENTS {
            let hal_sim::waveform::Waveform::Equation3(k) = &truth.waveforms[segment] else {
                panic!("the make's waveforms are equation (3)")
            };
            for (number, truth_m) in k[1..].iter().enumerate() {
                let at = (unknowns.own(segment, 0) + number) as u16;
                functions.push(vec![(Key::Courier(member.courier.clone(), at), 1.0)]);
                truths.push(*truth_m);
            }
        }
    }
    Asked { functions, truths }
}

/// Errors of field, spans and waves over what a fit of one platen predicts, and over the bound. `couriers` are a recording of each courier.
fn errors_of(
    members: &[Member],
    fitted: &Fitted,
    platen: u64,
    couriers: &[Member],
) -> [[Squares; 3]; 2] {
    let state = &fitted.state;
    let bound = bound(members, state).unwrap();
    let name = &members[0].platen;
    // The bound does not know the aperture's spreads, but the readings tell them: to 0.1 to 5 %, where the prior alone leaves 66 %.
    for spread in 0..2 {
        let left = bound.deviation(name, &[(Key::Aperture(spread), 1.0)]);
        assert!((1.0e-3..5.0e-2).contains(&left), "{left}");
    }
    let mut all = [[Squares::default(); 3]; 2];
    let asked = [
        field(members, state, platen),
        spans(couriers),
        waves(couriers),
    ];
    for (k, of) in asked.into_iter().enumerate() {
        let found = of.functions.iter().map(|f| value(state, name, f));
        let errors: Vec<f64> = found.zip(of.truths).map(|(f, truth)| f - truth).collect();
        for (squares, by) in all.iter_mut().zip([&fitted.solution.posterior, &bound]) {
            squares[k].add(&errors, by, name, &of.functions);
        }
    }
    all
}

/// Errors of field, spans and waves over what the fit predicts, and over the bound, over some platens that the same couriers cross.
fn judged(couriers: u64, platens: std::ops::Range<u64>, poses: usize) -> [[Squares; 3]; 2] {
    let mut all = [[Squares::default(); 3]; 2];
    for platen in platens {
        let one = |c: u64| member(c, platen, 100 * platen + c, poses, 2.0);
        let members: Vec<Member> = (1..=couriers).map(one).collect();
        let fitted = fit(&members, &|| ()).unwrap();
        let state = &fitted.state;
        assert!(fitted.is_settled(), "{} steps", state.steps);
        println!("{} steps, {:?}", state.steps, state.aperture);
        assert!(state.aperture.is_some(), "an aperture");
        let answer = answer(&members, &fitted).unwrap();
        assert!(answer.couriers.iter().all(|of| !of.fits.is_astray()));
        let of_it = errors_of(&members, &fitted, platen, &members);
        let [field, spans, waves] = of_it[1];
        println!("platen {platen} over the bound: field {field}, spans {spans}, waves {waves}");
        for (sum, of_it) in all.iter_mut().flatten().zip(of_it.iter().flatten()) {
            sum.join(of_it);
        }
    }
    for (what, squares) in ["the prediction", "the bound"].iter().zip(&all) {
        let [field, spans, waves] = squares;
        println!("errors over {what}: field {field}, spans {spans}, waves {waves}");
    }
    all
}

/// A prediction holds what a field's form cannot follow, so errors are below it; the bound does not. Errors of neighbouring cells go together: half as
/// large again is chance.
#[test]
fn errors_are_no_larger_than_predicted() {
    let [predicted, [field, _, waves]] = judged(3, 5..6, 150);
    for squares in predicted {
        assert!((0.1..1.2).contains(&squares.ratio()), "{squares}");
    }
    for squares in [field, waves] {
        assert!((0.3..1.5).contains(&squares.ratio()), "{squares}");
    }
}

/// Eight couriers over each of six platens: what is asked of fields and waves is a tenth over the Cramér-Rao bound (van Trees 1968, with the
/// priors), which knows the readings' noise. The aperture is among its unknowns.
#[test]
#[ignore = "nightly: three minutes of processor time"]
fn eight_couriers_reach_the_bound() {
    let [predicted, [field, _, waves]] = judged(8, 164..170, 250);
    for squares in predicted {
        assert!(squares.ratio() < 1.1, "{squares}");
    }
    for squares in [field, waves] {
        assert!(squares.ratio() < 1.1, "{squares}");
    }
}

/// A field of 150 teeth is too long for splines half a pitch apart: those a pitch apart tell the aperture, by a part of it. Two couriers cross it, each
/// in two recordings that overlap. Errors are within the prediction and two deviations of chance; those of splines that stay as they are, without an
/// aperture, were 1.25 of theirs.
#[test]
#[ignore = "nightly: three minutes of processor time"]
fn a_long_field_is_told_under_its_aperture() {
    let platen = 270;
    let one = |k: u64| {
        let about_pitches = [-33.0, 33.0][k as usize % 2];
        along_a_strip([1 + k / 2, platen, 100 * platen + k], 300, about_pitches)
    };
    let members: Vec<Member> = (0..4).map(one).collect();
    let fitted = fit(&members, &|| ()).unwrap();
    assert!(fitted.is_settled(), "{} steps", fitted.state.steps);
    assert!(fitted.state.aperture.is_some(), "an aperture");
    let couriers: Vec<Member> = members.iter().step_by(2).cloned().collect();
    let [predicted, [field, spans, waves]] = errors_of(&members, &fitted, platen, &couriers);
    println!("over the bound: field {field}, spans {spans}, waves {waves}");
    for squares in predicted {
        assert!(squares.ratio() < 1.0 + 2.0 * squares.spread(), "{squares}");
    }
}

/// A courier of two platens and one of each: the field of a platen is not taken for the sensor's, nor the other way round.
#[test]
fn a_crossed_fleet_leaves_less_than_each_recording_alone() {
    let members = [(1, 5), (2, 5), (2, 6), (3, 6)]
        .map(|(c, platen)| member(c, platen, 10 * platen + c, 150, 2.0));
    let fitted = fit(&members, &|| ()).unwrap();
    let answer = answer(&members, &fitted).unwrap();
    assert!(answer.is_settled);
    let mut squares = [0.0; 3];
    for of in &answer.recordings {
        let of = [of.plain_m, of.alone_m, of.fleet_m].map(|g| g[0].powi(2) + g[1].powi(2));
        squares.iter_mut().zip(of).for_each(|(sum, of)| *sum += of);
    }
    let [plain, alone, fleet] = squares;
    assert!(fleet < 0.04 * plain && fleet < alone, "{squares:?}");
    for of in &answer.couriers {
        assert!(of.waves_m.deviation < of.waves_m.alone, "{of:?}");
        assert!(of.span_m.deviation < 0.5 * of.span_m.alone, "{of:?}");
    }
    assert_eq!(answer.platens.len(), 2);
    assert_eq!(answer.platens[0].couriers, 2);
    what_was_separated_is_what_is_told_of_it(&members[0], &fitted, &answer);
}

/// Cells are the fields' functions at their places, and waves have the rms and the deviation that stand beside them.
fn what_was_separated_is_what_is_told_of_it(of_first: &Member, fitted: &Fitted, answer: &Answer) {
    let is_near = |of: f64, told: f64| (of / told - 1.0).abs() < 1.0e-6;
    let lattice = fitted.state.unknowns(of_first).lattice();
    for platen in &answer.platens {
        assert_eq!(platen.field.len(), platen.cells);
        for (direction, name) in [(0, 'x'), (1, 'y')] {
            let of_it = platen.field.iter().filter(|cell| cell.field == name);
            let cells: Cells = of_it.clone().map(|cell| cell.teeth).collect();
            let functions = field_functions(lattice, direction, &cells);
            assert!(functions.len() > 20, "{}", functions.len());
            for (cell, function) in of_it.zip(functions) {
                let displacement_m = value(&fitted.state, &platen.platen, &function);
                let posterior = &fitted.solution.posterior;
                let deviation_m = posterior.deviation(&platen.platen, &function);
                assert!(is_near(cell.displacement_m, displacement_m), "{cell:?}");
                assert!(is_near(cell.deviation_m, deviation_m), "{cell:?}");
            }
        }
    }
    for courier in &answer.couriers {
        let amplitudes = courier.waves.iter().flat_map(|wave| wave.amplitudes_m);
        let squares: f64 = amplitudes.map(|m| m * m).sum();
        assert!(is_near((squares / 8.0).sqrt(), courier.waves_m.value));
        let trace: f64 = (0..80).map(|k| courier.covariance_m2[k][k]).sum();
        assert!(is_near((trace / 8.0).sqrt(), courier.waves_m.deviation));
        let last = &courier.waves[39];
        assert_eq!((last.segment, last.orders), (4, [2, -1]));
        let [sine, cosine] = last.deviations_m;
        assert!(
            courier.covariance_m2[78][79].abs() < sine * cosine,
            "{last:?}"
        );
    }
}

/// A courier of another make among those of one, who are alike (see [`judged`]), is the one that fits worst.
#[test]
fn a_courier_of_another_make_is_named() {
    let make = |c: u64| member(c, 5, 500 + c, 150, 2.0);
    let members = [make(1), wider(2, 5, 502, 150, 2.0), make(3)];
    let fitted = fit(&members, &|| ()).unwrap();
    let mut couriers = answer(&members, &fitted).unwrap().couriers;
    couriers.sort_by(|a, b| b.fits.deviations.total_cmp(&a.fits.deviations));
    let worst = &couriers[0];
    assert!(
        worst.fits.is_astray() && worst.courier == "courier 2",
        "{couriers:?}"
    );
}
