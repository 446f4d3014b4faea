//! The found effects fitted once more about themselves: shapes over the tooth phase are evaluated where a segment really is, which
//! a reading that is off by the effect does not say.

use crate::data::folds::folds;
use crate::design::gram::{Columns, Gram};
use crate::design::unlisted;
use crate::hypothesis::Hypothesis;
use crate::inference::fit::solve;
use crate::inference::residuals::Residuals;
use crate::linearization::calibrate::baseline_columns;
use crate::linearization::groups::GROUP_SAMPLES;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::recording::{LatentDisplacement, LinearizedRecording};
use crate::trace::log;
use effects::effect::Acts;
use effects::over::Extent;
use effects::sensor::{BasisInputs, Covariates, READINGS, Regressor};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Most rounds of the fixed point. Each shrinks what is left by the slope of the effect: some tenths. A bound on the work: the
/// round that leaves least is kept where none stands, and eight shrink what is left by 0.3^8 where each does by some tenths.
const MOST_ROUNDS: usize = 8;
/// Rounds that find the prior sizes anew and go all the way. Where amounts nearly cancel, the places that they lead to decide
/// which of them do, and rounds may go from one such set to another and back for ever; so may places, where what a segment
/// remembers of its way turns over within less than it does. A bound on the work: after these the sizes stay, and each round goes
/// half way.
const FREE_ROUNDS: usize = 3;
/// See [`FREE_ROUNDS`].
const DAMPED_STEP: f64 = 0.5;
/// Rounds that leave so many times what one before has left lead astray: of courses in time, some knots hardly show on the motion, and
/// move the segments and with these what they are told by. The round that leaves least is kept, as it is where none stands.
const DIVERGES: f64 = 1.2;
/// It stands where a round moves the segments by less than this share of their stated noise, rms. Derived from squares: a tenth
/// of the noise adds a hundredth to a mean square, and half of that to an rms.
const CONVERGED: f64 = 0.1;
/// The same where a coarser mesh has led, and each round is one of thousands of columns: micrometres do not count where shapes are smooth
/// over a tooth.
const CONVERGED_FROM_MESH: f64 = 10.0;

/// A model of some effects, fitted about itself.
pub struct RelinearizedFit<'a> {
    /// What it is a fit of.
    pub hypothesis: Hypothesis,
    /// The recording, linearised about the model.
    pub linearized: LinearizedRecording<'a>,
    /// Baseline, then one block an effect in the order asked for.
    pub columns: Columns,
    /// Their products.
    pub gram: Gram,
    /// Amounts by all samples in use, in prior deviations.
    pub coefficients: Vec<f64>,
    /// What it is linearised about.
    pub point: LinearizationPoint,
    folds: Vec<u8>,
    residuals: OnceLock<Residuals>,
    left_out: OnceLock<Option<Residuals>>,
}

/// What is fitted to: a recording, and the point that the steps of the fit begin at.
#[derive(Clone)]
pub struct Data<'s, 'a> {
    /// The recording, linearised about any point. Its speeds stay, and so do its amplitudes.
    pub recording: &'s LinearizedRecording<'a>,
    /// Where the steps begin.
    pub start: LinearizationPoint,
}

/// Fits a hypothesis: equations (3), (5) and (11) with the columns of its effects, about the point that the fit itself leads to. Pure: the
/// same data and hypothesis give the same bits. Cost: up to nine times that of [`Gram::new`].
pub fn fit<'a>(data: &Data<'_, 'a>, hypothesis: &Hypothesis) -> RelinearizedFit<'a> {
    RelinearizedFit::relinearize(data, hypothesis)
}

impl<'a> RelinearizedFit<'a> {
    /// Fits the effects named, in the forms of a linearized recording, from a point on. Of two hypotheses about skewed rulings
    /// ([`Hypothesis::by_place`]) the one that leaves less, held out.
    pub fn new(
        recording: &LinearizedRecording<'a>,
        start: LinearizationPoint,
        names: &[String],
    ) -> Self {
        let data = Data { recording, start };
        let by_teeth = Hypothesis::new(names, recording);
        let teeth = fit(&data, &by_teeth);
        let Some(by_place) = by_teeth.by_place() else {
            return teeth;
        };
        let place = fit(&data, &by_place);
        if place.residuals().white_rms() < teeth.residuals().white_rms() {
            place
        } else {
            teeth
        }
    }

    /// Other effects in the forms of this fit, of which more is told.
    pub fn with_forms(
        &self,
        recording: &LinearizedRecording<'a>,
        start: LinearizationPoint,
        names: &[String],
        more: &dyn Fn(&mut BasisInputs),
    ) -> Self {
        let hypothesis = Hypothesis::new(names, recording)
            .in_forms_of(&self.hypothesis)
            .with(more);
        fit(&Data { recording, start }, &hypothesis)
    }

    fn relinearize(data: &Data<'_, 'a>, hypothesis: &Hypothesis) -> Self {
        let folds = folds(&data.recording.observations.stretch);
        let mut point = data.start.clone();
        let mut round = 0;
        let mut sizes = Vec::new();
        let mut best: Option<Self> = None;
        loop {
            let (linearized, columns) = linearize(data.recording, &point, hypothesis);
            // Of single teeth there are thousands, and their folds are asked for once.
            let by_teeth = linearized.inputs.teeth.is_some();
            let mut gram = if by_teeth {
                Gram::without_folds(&linearized, &columns)
            } else {
                Gram::new(&linearized, &columns, &folds)
            };
            if round < FREE_ROUNDS {
                sizes = crate::inference::ard::factors(&gram, &columns, &sizes);
            }
            gram.rescale(&sizes);
            let list: Vec<usize> = (0..gram.width()).collect();
            let coefficients: Vec<f64> = solve(gram.training(None), &list, &gram.centre, 1.0)
                .map_or(vec![0.0; list.len()], |fit| {
                    fit.coefficient.iter().copied().collect()
                });
            let gauss_newton_step = gauss_newton_step(&linearized, &columns, &gram, &coefficients);
            let (led, near) = if by_teeth {
                (true, CONVERGED_FROM_MESH)
            } else {
                (round > 0, CONVERGED)
            };
            let courses = columns.regressors.iter().any(|r| r.course.is_some());
            let done = hypothesis.effects.is_empty()
                || led && has_converged(&linearized, &gauss_newton_step.1, near);
            let share = if round < FREE_ROUNDS {
                1.0
            } else {
                DAMPED_STEP
            };
            let next = moved(&linearized, gauss_newton_step, share);
            let here = Self {
                hypothesis: hypothesis.clone(),
                linearized,
                columns,
                gram,
                coefficients,
                point,
                folds: folds.clone(),
                residuals: OnceLock::new(),
                left_out: OnceLock::new(),
            };
            if done || round == MOST_ROUNDS && !courses {
                return here;
            }
            // The first is about places that are off by all of the effect.
            if courses && round > 0 {
                let left = here.squares();
                let (kept, diverged) = match best.take() {
                    Some(best) if best.squares() < left => {
                        let diverged = left > DIVERGES * best.squares();
                        (best, diverged)
                    }
                    _ => (here, false),
                };
                if diverged || round == MOST_ROUNDS {
                    return kept;
                }
                best = Some(kept);
            }
            point = next;
            round += 1;
        }
    }

    /// Held-out residuals.
    pub fn residuals(&self) -> &Residuals {
        let list = || (0..self.gram.width()).collect::<Vec<usize>>();
        let (linearized, columns, gram) = (&self.linearized, &self.columns, &self.gram);
        self.residuals
            .get_or_init(|| Residuals::new(linearized, columns, gram, &self.folds, &list()))
    }

    /// Whitened squares that the fit leaves of all samples in use, which it has seen.
    pub fn squares(&self) -> f64 {
        let coefficients = self.coefficients.iter().copied().enumerate();
        let target = (self.gram.width(), -1.0);
        self.gram.total.quadratic(coefficients.chain([target]))
    }

    /// Residuals of short pieces, each predicted from all other samples.
    pub fn left_out(&self) -> Option<&Residuals> {
        let predicted =
            || crate::inference::left_out::left_out(&self.linearized, &self.columns, &self.gram);
        self.left_out.get_or_init(predicted).as_ref()
    }

    /// Amounts in their own units.
    pub fn coefficient(&self, column: usize) -> f64 {
        self.coefficients[column] * self.gram.scale[column]
    }
}

/// The linearized recording about where known amounts say that the segments are.
pub fn at_fixed_point<'a>(
    mut linearized: LinearizedRecording<'a>,
    columns: &Columns,
    list: &[usize],
    coefficients: &[f64],
) -> LinearizedRecording<'a> {
    let remembers = remembers(columns);
    let mut last = None;
    for round in 0..2 * MOST_ROUNDS {
        let there = displacement(&linearized, columns, list, coefficients);
        if has_converged(&linearized, &there, CONVERGED) {
            break;
        }
        let next = match &last {
            Some(last) if !remembers => anderson_step(last, &linearized.displacement, &there),
            _ if remembers && round >= FREE_ROUNDS => {
                damped(&linearized.displacement, there.clone(), DAMPED_STEP)
            }
            _ => there.clone(),
        };
        last = Some((linearized.displacement.clone(), there));
        linearized = linearized.moved(linearized.baseline.clone(), next);
    }
    linearized
}

/// Farthest that a sample is taken beyond the step of the fixed point, and back. Derived from the slope s of the fixed point,
/// where the step over 1 - s is exact: of slopes of 0.9 and of -9.
const ANDERSON_BOUNDS: [f64; 2] = [-9.0, 0.9];

/// Where each sample's last two steps of the fixed point would meet (Anderson 1965, of one step back): `last` is a shift and
/// where it led, `here` led `there`.
fn anderson_step(
    last: &(LatentDisplacement, LatentDisplacement),
    here: &LatentDisplacement,
    there: &LatentDisplacement,
) -> LatentDisplacement {
    let at = |displacement: &LatentDisplacement, s: usize, i: usize| {
        displacement.total_m[s].get(i).copied().unwrap_or(0.0)
    };
    let samples = there.total_m.iter().map(Vec::len).max().unwrap_or(0);
    let back = |i: usize| {
        let (mut along, mut square) = (0.0, 0.0);
        for s in 0..4 {
            let step = at(there, s, i) - at(here, s, i);
            let change = step - at(&last.1, s, i) + at(&last.0, s, i);
            along += step * change;
            square += change * change;
        }
        if square > 0.0 {
            (along / square).clamp(ANDERSON_BOUNDS[0], ANDERSON_BOUNDS[1])
        } else {
            0.0
        }
    };
    let back: Vec<f64> = (0..samples).map(back).collect();
    let damped = |there: &[Vec<f64>; 4], last: &[Vec<f64>; 4]| {
        std::array::from_fn(|s| {
            let pairs = there[s].iter().zip(&last[s]).zip(&back);
            pairs.map(|((t, l), back)| t - back * (t - l)).collect()
        })
    };
    LatentDisplacement {
        total_m: damped(&there.total_m, &last.1.total_m),
        electronic_m: damped(&there.electronic_m, &last.1.electronic_m),
        channels_m: there.channels_m.clone(),
    }
}

/// True if a displacement is what the linearized recording is about already.
fn has_converged(linearized: &LinearizedRecording, next: &LatentDisplacement, near: f64) -> bool {
    let steps = (0..4).filter(|s| linearized.scope.segments[*s]).map(|s| {
        let noise = linearized.observations.position_noise_m[s].iter().copied();
        let noise = crate::algebra::statistics::rms(noise.filter(|n| n.is_finite()));
        let finite = |v: Option<&f64>| v.copied().filter(|v| v.is_finite()).unwrap_or(0.0);
        let now = &linearized.displacement.total_m[s];
        let step =
            (0..linearized.len()).map(|i| finite(next.total_m[s].get(i)) - finite(now.get(i)));
        crate::algebra::statistics::rms(step) / noise
    });
    let most = steps.fold(0.0, f64::max);
    log(&format!("about itself, moved by {most:.3} of the noise"));
    most < near
}

fn linearize<'a>(
    recording: &LinearizedRecording<'a>,
    point: &LinearizationPoint,
    hypothesis: &Hypothesis,
) -> (LinearizedRecording<'a>, Columns) {
    let (baseline, displacement) = (point.baseline.clone(), point.displacement.clone());
    let mut linearized = recording.moved_at(baseline, displacement, hypothesis.noise);
    linearized.inputs = hypothesis.inputs.clone();
    // Here equation (3) is told about the clip itself.
    linearized.inputs.beneath = Default::default();
    let mut columns = baseline_columns(&linearized);
    let sides = effects::sensor_sides();
    for name in &hypothesis.effects {
        if let Some(side) = sides.iter().find(|side| side.name() == name) {
            columns.push(name.clone(), side.regressors(&linearized.inputs));
        } else if let Some(regressors) = unlisted::regressors(name, &linearized.inputs) {
            columns.push(name.clone(), regressors);
        }
    }
    (linearized, columns)
}

/// Where amounts lead: a step of the baseline's parameters, and a shift.
fn gauss_newton_step(
    linearized: &LinearizedRecording,
    columns: &Columns,
    gram: &Gram,
    coefficients: &[f64],
) -> (Vec<f64>, LatentDisplacement) {
    let first = columns.blocks[0].columns.end;
    let each = coefficients.iter().zip(&gram.scale);
    let mut step: Vec<f64> = each
        .map(|(coefficient, scale)| coefficient * scale)
        .collect();
    let effects = step.split_off(first);
    let list: Vec<usize> = (first..first + effects.len()).collect();
    (step, displacement(linearized, columns, &list, &effects))
}

/// That, or a share of the way there.
fn moved(
    linearized: &LinearizedRecording,
    (step, there): (Vec<f64>, LatentDisplacement),
    share: f64,
) -> LinearizationPoint {
    let step: Vec<f64> = step.iter().map(|s| s * share).collect();
    let mut baseline = linearized.baseline.clone();
    baseline.add(linearized.scope, &step);
    LinearizationPoint {
        baseline,
        displacement: damped(&linearized.displacement, there, share),
        noise: None,
    }
}

/// A share of the way from one displacement to another.
fn damped(here: &LatentDisplacement, there: LatentDisplacement, share: f64) -> LatentDisplacement {
    LatentDisplacement {
        total_m: part_way(&here.total_m, there.total_m, share),
        electronic_m: part_way(&here.electronic_m, there.electronic_m, share),
        channels_m: part_way(&here.channels_m, there.channels_m, share),
    }
}

fn part_way<const N: usize>(
    here: &[Vec<f64>; N],
    mut there: [Vec<f64>; N],
    share: f64,
) -> [Vec<f64>; N] {
    for (here, there) in here.iter().zip(&mut there) {
        for (i, there) in there.iter_mut().enumerate() {
            let here = here.get(i).copied().unwrap_or(0.0);
            *there = here + share * (*there - here);
        }
    }
    there
}

/// A regressor on readings, what it adds, its amount, and whether it acts on the pair.
type ActiveRegressor<'r> = (&'r Regressor, f64, bool);

/// What some columns with given amounts add to the four readings' places over the teeth, and where one remembers its way, to the
/// channels beside.
pub fn displacement(
    linearized: &LinearizedRecording,
    columns: &Columns,
    list: &[usize],
    coefficients: &[f64],
) -> LatentDisplacement {
    let acts_on = |acts: Acts, c: usize| {
        let mut blocks = columns.blocks.iter().filter(|b| b.columns.contains(&c));
        blocks.any(|b| effects::has(&b.name, |card| card.acts == acts))
    };
    let acts = list.iter().zip(coefficients);
    let acts = acts.filter(|(_, coefficient)| **coefficient != 0.0);
    let mut acting: Vec<ActiveRegressor> = Vec::new();
    let mut beside = Vec::new();
    for (c, coefficient) in acts {
        let regressor = &columns.regressors[*c];
        let coefficient = coefficient - regressor.aligned_by;
        let moves = linearized.inputs.skew_moves || !acts_on(Acts::Teeth, *c);
        if moves && regressor.action.is_on_readings() {
            acting.push((regressor, coefficient, acts_on(Acts::Electronics, *c)));
        } else {
            beside.push((regressor, coefficient));
        }
    }
    let mut out = LatentDisplacement::default();
    if acting.is_empty() {
        return out;
    }
    let estimate = remembers(columns) && !linearized.scope.reference;
    let one = |i: usize, covariates: &Covariates, acting: &[&ActiveRegressor]| {
        let (mut total, mut early) = ([0.0; READINGS], [0.0; READINGS]);
        for (regressor, coefficient, electronic) in acting {
            if !regressor.acts(covariates) {
                continue;
            }
            let readings = regressor.action.on_readings(covariates);
            for (reading, value) in readings.iter().enumerate().filter(|r| *r.1 != 0.0) {
                total[reading] += coefficient * value;
                if *electronic {
                    early[reading] += coefficient * value;
                }
            }
        }
        let channels_m = estimate.then(|| {
            let rows = linearized.rows(i);
            let mut sum_m = [0.0; 3];
            for row in 0..rows.count {
                let sum_m = &mut sum_m[rows.channel[row]];
                *sum_m += (4..READINGS)
                    .map(|r| rows.by_reading[row][r] * total[r])
                    .sum::<f64>();
            }
            for (regressor, coefficient) in &beside {
                let response = rows.response(regressor, covariates);
                for row in 0..rows.count {
                    sum_m[rows.channel[row]] += coefficient * response[row];
                }
            }
            sum_m
        });
        (total, early, channels_m)
    };
    let together = |samples: &[usize]| {
        let moments: Vec<Covariates> = samples.iter().map(|i| linearized.covariates(*i)).collect();
        let extent = Extent::of(&moments);
        let acting: Vec<&ActiveRegressor> =
            acting.iter().filter(|a| a.0.may_act(&extent)).collect();
        let each = samples.iter().zip(&moments);
        each.map(|(i, covariates)| one(*i, covariates, &acting))
            .collect::<Vec<_>>()
    };
    let samples: Vec<usize> = (0..linearized.len()).collect();
    let parts: Vec<_> = samples.par_chunks(GROUP_SAMPLES).map(together).collect();
    for (total, early, channels_m) in parts.into_iter().flatten() {
        for s in (0..4).filter(|s| linearized.scope.segments[*s]) {
            out.total_m[s].push(total[s]);
            out.electronic_m[s].push(early[s]);
        }
        for (list, channels_m) in out
            .channels_m
            .iter_mut()
            .zip(channels_m.into_iter().flatten())
        {
            list.push(channels_m);
        }
    }
    out
}

/// True if an effect is among them whose output depends on the way there, and so on other samples than its own.
pub fn remembers(columns: &Columns) -> bool {
    let mut blocks = columns.blocks.iter();
    blocks.any(|b| effects::has(&b.name, |card| card.remembers))
}
