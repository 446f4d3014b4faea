//! The found effects fitted once more about themselves: shapes over the tooth phase are evaluated where a segment really is, which
//! a reading that is off by the effect does not say.

use crate::data::folds::folds;
use crate::design::gram::{Columns, Gram, solve};
use crate::inference::residuals::Residuals;
use crate::linearization::calibrate::baseline_columns;
use crate::linearization::groups::TOGETHER;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::scene::{LatentDisplacement, Scene};
use crate::trace::log;
use effects::effect::Acts;
use effects::over::Extent;
use effects::sensor::{Action, BasisInputs, Covariates, READINGS, Regressor};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Most rounds of the fixed point. Each shrinks what is left by the slope of the effect: some tenths.
const ROUNDS: usize = 8;
/// Rounds that find the prior sizes anew and go all the way. Where amounts nearly cancel, the places that they lead to decide which of
/// them do, and rounds may go from one such set to another and back for ever; so may places, where what a segment remembers of its way
/// turns over within less than it does. After these the sizes stay, and each round goes half way.
const FREE_ROUNDS: usize = 3;
/// See [`FREE_ROUNDS`].
const HALF_WAY: f64 = 0.5;
/// Rounds that leave so many times what one before has left lead astray: of courses in time, some knots hardly show on the motion, and
/// move the segments and with these what they are told by. The round that leaves least is kept, as it is where none stands.
const STRAYS: f64 = 1.2;
/// It stands where a round moves the segments by less than this share of their stated noise, rms.
const STANDS: f64 = 0.1;
/// The same where a coarser mesh has led, and each round is one of thousands of columns: micrometres do not count where shapes are smooth
/// over a tooth.
const LED: f64 = 10.0;

/// A model of some effects, fitted about itself.
pub struct RelinearizedFit<'a> {
    /// The recording, linearised about the model.
    pub scene: Scene<'a>,
    /// Baseline, then one block an effect in the order asked for.
    pub columns: Columns,
    /// Their products.
    pub gram: Gram,
    /// Amounts by all samples in use, in prior deviations.
    pub amounts: Vec<f64>,
    /// What it is linearised about.
    pub about: LinearizationPoint,
    folds: Vec<u8>,
    residuals: OnceLock<Residuals>,
    left_out: OnceLock<Option<Residuals>>,
}

impl<'a> RelinearizedFit<'a> {
    /// Fits the effects named, whose columns are those of the survey of `start`. Where rulings are skewed, what is periodic beside
    /// that may go with the teeth, as their readings tell, or with the place: that which leaves less is kept.
    pub fn new(start: &Scene<'a>, about: LinearizationPoint, names: &[String]) -> Self {
        let skewed = names
            .iter()
            .any(|n| effects::has(n, |card| card.acts == Acts::Teeth));
        let moving =
            |skew_moves: bool| move |inputs: &mut BasisInputs| inputs.skew_moves = skew_moves;
        if !skewed || names.len() == 1 {
            return Self::about_itself(start, about, names, &moving(false));
        }
        let [teeth, place] =
            [false, true].map(|m| Self::about_itself(start, about.clone(), names, &moving(m)));
        if place.residuals().white_rms() < teeth.residuals().white_rms() {
            place
        } else {
            teeth
        }
    }

    /// Other effects in the same survey, of which more is told.
    pub fn telling(
        &self,
        start: &Scene<'a>,
        about: LinearizationPoint,
        names: &[String],
        more: &dyn Fn(&mut BasisInputs),
    ) -> Self {
        let known = &self.scene.inputs;
        let tell = |inputs: &mut BasisInputs| {
            inputs.skew_moves = known.skew_moves;
            inputs.growth_told = known.growth_told;
            inputs.gap_told = known.gap_told;
            inputs.forms = known.forms;
            more(inputs);
        };
        Self::about_itself(start, about, names, &tell)
    }

    fn about_itself(
        start: &Scene<'a>,
        about: LinearizationPoint,
        names: &[String],
        tell: &dyn Fn(&mut BasisInputs),
    ) -> Self {
        let folds = folds(&start.observations.stretch);
        let mut about = about;
        let mut round = 0;
        let mut sizes = Vec::new();
        let mut best: Option<Self> = None;
        loop {
            let (scene, columns) = linearised(start, &about, names, tell);
            // Of single teeth there are thousands, and their folds are asked for once.
            let by_teeth = scene.inputs.teeth.is_some();
            let mut gram = if by_teeth {
                Gram::whole(&scene, &columns)
            } else {
                Gram::new(&scene, &columns, &folds)
            };
            if round < FREE_ROUNDS {
                sizes = crate::inference::ard::factors(&gram, &columns, &sizes);
            }
            gram.rescale(&sizes);
            let list: Vec<usize> = (0..gram.width()).collect();
            let amounts: Vec<f64> = solve(gram.training(None), &list, &gram.centre, 1.0)
                .map_or(vec![0.0; list.len()], |fit| {
                    fit.amount.iter().copied().collect()
                });
            let lead = lead(&scene, &columns, &gram, &amounts);
            let (led, near) = if by_teeth {
                (true, LED)
            } else {
                (round > 0, STANDS)
            };
            let courses = columns.regressors.iter().any(|r| r.course.is_some());
            let done = names.is_empty() || led && stands(&scene, &lead.1, near);
            let share = if round < FREE_ROUNDS { 1.0 } else { HALF_WAY };
            let next = moved(&scene, lead, share);
            let here = Self {
                scene,
                columns,
                gram,
                amounts,
                about,
                folds: folds.clone(),
                residuals: OnceLock::new(),
                left_out: OnceLock::new(),
            };
            if done || round == ROUNDS && !courses {
                return here;
            }
            // The first is about places that are off by all of the effect.
            if courses && round > 0 {
                let left = here.squares();
                let (kept, astray) = match best.take() {
                    Some(best) if best.squares() < left => {
                        let astray = left > STRAYS * best.squares();
                        (best, astray)
                    }
                    _ => (here, false),
                };
                if astray || round == ROUNDS {
                    return kept;
                }
                best = Some(kept);
            }
            about = next;
            round += 1;
        }
    }

    /// Held-out residuals.
    pub fn residuals(&self) -> &Residuals {
        let list = || (0..self.gram.width()).collect::<Vec<usize>>();
        let (scene, columns, gram) = (&self.scene, &self.columns, &self.gram);
        self.residuals
            .get_or_init(|| Residuals::new(scene, columns, gram, &self.folds, &list()))
    }

    /// Whitened squares that the fit leaves of all samples in use, which it has seen.
    pub fn squares(&self) -> f64 {
        let amounts = self.amounts.iter().copied().enumerate();
        let target = (self.gram.width(), -1.0);
        self.gram.total.quadratic(amounts.chain([target]))
    }

    /// Residuals of short pieces, each predicted from all other samples.
    pub fn left_out(&self) -> Option<&Residuals> {
        let predicted =
            || crate::inference::left_out::left_out(&self.scene, &self.columns, &self.gram);
        self.left_out.get_or_init(predicted).as_ref()
    }

    /// Amounts in their own units.
    pub fn amount(&self, column: usize) -> f64 {
        self.amounts[column] * self.gram.scale[column]
    }
}

/// The scene about where known amounts say that the segments are.
pub fn settled<'a>(
    mut scene: Scene<'a>,
    columns: &Columns,
    list: &[usize],
    amounts: &[f64],
) -> Scene<'a> {
    let remembers = remembers(columns);
    let mut last = None;
    for round in 0..2 * ROUNDS {
        let there = shift(&scene, columns, list, amounts);
        if stands(&scene, &there, STANDS) {
            break;
        }
        let next = match &last {
            Some(last) if !remembers => ahead(last, &scene.shift, &there),
            _ if remembers && round >= FREE_ROUNDS => {
                towards(&scene.shift, there.clone(), HALF_WAY)
            }
            _ => there.clone(),
        };
        last = Some((scene.shift.clone(), there));
        scene = scene.moved(scene.baseline.clone(), next);
    }
    scene
}

/// Farthest that a sample is taken beyond the step of the fixed point, and back: of slopes of 0.9 and of -9.
const AHEAD: [f64; 2] = [-9.0, 0.9];

/// Where each sample's last two steps of the fixed point would meet (Anderson 1965, of one step back): `last` is a shift and
/// where it led, `here` led `there`.
fn ahead(
    last: &(LatentDisplacement, LatentDisplacement),
    here: &LatentDisplacement,
    there: &LatentDisplacement,
) -> LatentDisplacement {
    let at = |shift: &LatentDisplacement, s: usize, i: usize| {
        shift.whole_m[s].get(i).copied().unwrap_or(0.0)
    };
    let samples = there.whole_m.iter().map(Vec::len).max().unwrap_or(0);
    let back = |i: usize| {
        let (mut along, mut square) = (0.0, 0.0);
        for s in 0..4 {
            let step = at(there, s, i) - at(here, s, i);
            let change = step - at(&last.1, s, i) + at(&last.0, s, i);
            along += step * change;
            square += change * change;
        }
        if square > 0.0 {
            (along / square).clamp(AHEAD[0], AHEAD[1])
        } else {
            0.0
        }
    };
    let back: Vec<f64> = (0..samples).map(back).collect();
    let towards = |there: &[Vec<f64>; 4], last: &[Vec<f64>; 4]| {
        std::array::from_fn(|s| {
            let pairs = there[s].iter().zip(&last[s]).zip(&back);
            pairs.map(|((t, l), back)| t - back * (t - l)).collect()
        })
    };
    LatentDisplacement {
        whole_m: towards(&there.whole_m, &last.1.whole_m),
        electronic_m: towards(&there.electronic_m, &last.1.electronic_m),
        beside_m: there.beside_m.clone(),
    }
}

/// True if a shift is what the scene is about already.
fn stands(scene: &Scene, next: &LatentDisplacement, near: f64) -> bool {
    let steps = (0..4).filter(|s| scene.scope.segments[*s]).map(|s| {
        let noise = scene.observations.position_noise_m[s].iter().copied();
        let noise = crate::algebra::statistics::rms(noise.filter(|n| n.is_finite()));
        let finite = |v: Option<&f64>| v.copied().filter(|v| v.is_finite()).unwrap_or(0.0);
        let now = &scene.shift.whole_m[s];
        let step = (0..scene.len()).map(|i| finite(next.whole_m[s].get(i)) - finite(now.get(i)));
        crate::algebra::statistics::rms(step) / noise
    });
    let most = steps.fold(0.0, f64::max);
    log(&format!("about itself, moved by {most:.3} of the noise"));
    most < near
}

fn linearised<'a>(
    start: &Scene<'a>,
    about: &LinearizationPoint,
    names: &[String],
    tell: &dyn Fn(&mut BasisInputs),
) -> (Scene<'a>, Columns) {
    let mut scene = start.moved(about.baseline.clone(), about.shift.clone());
    // Here equation (3) is told about the clip itself.
    scene.inputs.beneath = Default::default();
    tell(&mut scene.inputs);
    let mut columns = baseline_columns(&scene);
    let sides = effects::sensor_sides();
    for name in names {
        if let Some(side) = sides.iter().find(|side| side.name() == name) {
            columns.push(name.clone(), side.regressors(&scene.inputs));
        }
    }
    (scene, columns)
}

/// Where amounts lead: a step of the baseline's parameters, and a shift.
fn lead(
    scene: &Scene,
    columns: &Columns,
    gram: &Gram,
    amounts: &[f64],
) -> (Vec<f64>, LatentDisplacement) {
    let first = columns.blocks[0].columns.end;
    let each = amounts.iter().zip(&gram.scale);
    let mut step: Vec<f64> = each.map(|(amount, scale)| amount * scale).collect();
    let effects = step.split_off(first);
    let list: Vec<usize> = (first..first + effects.len()).collect();
    (step, shift(scene, columns, &list, &effects))
}

/// That, or a share of the way there.
fn moved(
    scene: &Scene,
    (step, there): (Vec<f64>, LatentDisplacement),
    share: f64,
) -> LinearizationPoint {
    let step: Vec<f64> = step.iter().map(|s| s * share).collect();
    let mut baseline = scene.baseline.clone();
    baseline.add(scene.scope, &step);
    LinearizationPoint {
        baseline,
        shift: towards(&scene.shift, there, share),
        noise: None,
    }
}

/// A share of the way from one shift to another.
fn towards(here: &LatentDisplacement, there: LatentDisplacement, share: f64) -> LatentDisplacement {
    LatentDisplacement {
        whole_m: part_way(&here.whole_m, there.whole_m, share),
        electronic_m: part_way(&here.electronic_m, there.electronic_m, share),
        beside_m: part_way(&here.beside_m, there.beside_m, share),
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
type ActiveRegressor<'r> = (&'r Regressor, &'r AddReadings, f64, bool);
type AddReadings = Box<dyn Fn(&Covariates, &mut [f64; READINGS]) + Send + Sync>;

/// What some columns with given amounts add to the four readings' places over the teeth, and where one remembers its way, to the
/// channels beside.
pub fn shift(
    scene: &Scene,
    columns: &Columns,
    list: &[usize],
    amounts: &[f64],
) -> LatentDisplacement {
    let acts_on = |acts: Acts, c: usize| {
        let mut blocks = columns.blocks.iter().filter(|b| b.columns.contains(&c));
        blocks.any(|b| effects::has(&b.name, |card| card.acts == acts))
    };
    let acts = list.iter().zip(amounts);
    let acts = acts.filter(|(_, amount)| **amount != 0.0);
    let mut acting: Vec<ActiveRegressor> = Vec::new();
    let mut beside = Vec::new();
    for (c, amount) in acts {
        let regressor = &columns.regressors[*c];
        let moves = scene.inputs.skew_moves || !acts_on(Acts::Teeth, *c);
        match &regressor.action {
            Action::Readings(add) if moves => {
                acting.push((regressor, add, *amount, acts_on(Acts::Electronics, *c)));
            }
            _ => beside.push((regressor, *amount)),
        }
    }
    let mut out = LatentDisplacement::default();
    if acting.is_empty() {
        return out;
    }
    let told = remembers(columns) && !scene.scope.reference;
    let one = |i: usize, covariates: &Covariates, acting: &[&ActiveRegressor]| {
        let (mut whole, mut early) = ([0.0; READINGS], [0.0; READINGS]);
        for (regressor, add, amount, electronic) in acting {
            if !regressor.acts(covariates) {
                continue;
            }
            let mut readings = [0.0; READINGS];
            add(covariates, &mut readings);
            for (reading, value) in readings.iter().enumerate().filter(|r| *r.1 != 0.0) {
                whole[reading] += amount * value;
                if *electronic {
                    early[reading] += amount * value;
                }
            }
        }
        let beside_m = told.then(|| {
            let rows = scene.rows(i);
            let mut sum_m = [0.0; 3];
            for row in 0..rows.count {
                let sum_m = &mut sum_m[rows.channel[row]];
                *sum_m += (4..READINGS)
                    .map(|r| rows.by_reading[row][r] * whole[r])
                    .sum::<f64>();
            }
            for (regressor, amount) in &beside {
                let response = rows.response(regressor, covariates);
                for row in 0..rows.count {
                    sum_m[rows.channel[row]] += amount * response[row];
                }
            }
            sum_m
        });
        (whole, early, beside_m)
    };
    let together = |samples: &[usize]| {
        let moments: Vec<Covariates> = samples.iter().map(|i| scene.covariates(*i)).collect();
        let extent = Extent::of(&moments);
        let acting: Vec<&ActiveRegressor> =
            acting.iter().filter(|a| a.0.may_act(&extent)).collect();
        let each = samples.iter().zip(&moments);
        each.map(|(i, covariates)| one(*i, covariates, &acting))
            .collect::<Vec<_>>()
    };
    let samples: Vec<usize> = (0..scene.len()).collect();
    let parts: Vec<_> = samples.par_chunks(TOGETHER).map(together).collect();
    for (whole, early, beside_m) in parts.into_iter().flatten() {
        for s in (0..4).filter(|s| scene.scope.segments[*s]) {
            out.whole_m[s].push(whole[s]);
            out.electronic_m[s].push(early[s]);
        }
        for (list, beside_m) in out.beside_m.iter_mut().zip(beside_m.into_iter().flatten()) {
            list.push(beside_m);
        }
    }
    out
}

/// True if an effect is among them whose output depends on the way there, and so on other samples than its own.
pub fn remembers(columns: &Columns) -> bool {
    let mut blocks = columns.blocks.iter();
    blocks.any(|b| effects::has(&b.name, |card| card.remembers))
}
