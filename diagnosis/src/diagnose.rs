//! The whole answer: clean, calibrate, survey, compare, judge, measure.

use crate::baseline::Baseline;
use crate::calibrate::{baseline_columns, calibrate};
use crate::clean::{Slip, disturbed, repair_slips};
use crate::gram::{Columns, Gram, folds};
use crate::heldout::Residuals;
use crate::lines::{Series, lines_hz};
use crate::observe::Observations;
use crate::places::places;
use crate::scene::Scene;
use crate::simulate::{Floor, floor};
use crate::{Insufficient, clip};
use recording::Recording;

/// What a caller may change.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Effects taken out of the catalogue.
    pub without: Vec<String>,
}

/// A block of the comparison.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A catalogued effect.
    Effect(String),
    /// The shapes of an effect that may not be named: they tell where a gap lies, and nothing else.
    Shape(String),
    /// Free shapes over a coordinate.
    Place(String),
}

/// Everything that the judgement needs.
pub struct Study<'a> {
    /// The linearised recording.
    pub scene: Scene<'a>,
    /// Columns: baseline, effects, places.
    pub columns: Columns,
    /// What each block after the baseline is.
    pub kinds: Vec<Kind>,
    /// Their products.
    pub gram: Gram,
    /// Fold of each sample.
    pub folds: Vec<u8>,
    /// Simulator's scatter.
    pub floor: Floor,
}

impl Study<'_> {
    /// Blocks of the catalogue.
    pub fn effects(&self) -> Vec<usize> {
        (1..self.columns.blocks.len())
            .filter(|b| matches!(self.kinds[b - 1], Kind::Effect(_)))
            .collect()
    }

    /// Blocks of free shapes.
    pub fn places(&self) -> Vec<usize> {
        (1..self.columns.blocks.len())
            .filter(|b| !matches!(self.kinds[b - 1], Kind::Effect(_)))
            .collect()
    }

    /// Columns of the baseline and some blocks.
    pub fn list(&self, blocks: &[usize]) -> Vec<usize> {
        let mut list: Vec<usize> = self.columns.blocks[0].columns.clone().collect();
        for &b in blocks {
            list.extend(self.columns.blocks[b].columns.clone());
        }
        list
    }
}

/// Prepared recording.
pub struct Prepared {
    /// Columns of the recording, slips taken out.
    pub observations: Observations,
    /// Lasting tooth slips.
    pub slips: Vec<Slip>,
    /// Samples in use.
    pub keep: Vec<bool>,
    /// Samples left out because they rest on one place.
    pub resting: Vec<bool>,
    /// Calibrated baseline.
    pub baseline: Baseline,
}

/// Reads, repairs and calibrates.
///
/// # Errors
/// [`Insufficient`] where the recording cannot answer.
pub fn prepare(recording: &Recording) -> Result<Prepared, Insufficient> {
    let mut observations = Observations::new(recording)?;
    crate::adequacy::check(&observations)?;
    let slips = repair_slips(&mut observations);
    let mut keep = vec![true; observations.len()];
    let resting = resting(&observations);
    keep.iter_mut().zip(&resting).for_each(|(k, r)| *k &= !r);
    let mut baseline = calibrate(&observations, &keep);
    for _ in 0..2 {
        let scene = Scene::new(
            &observations,
            baseline.clone(),
            vec![true; observations.len()],
        );
        let marked = disturbed(
            &white_rows(&scene),
            observations.len(),
            &observations.stretch,
        );
        let next: Vec<bool> = marked.iter().zip(&resting).map(|(m, r)| !m && !r).collect();
        if next == keep {
            break;
        }
        keep = next;
        baseline = calibrate(&observations, &keep);
    }
    Ok(Prepared {
        observations,
        slips,
        keep,
        resting,
        baseline,
    })
}

/// Against a reference, samples that rest on one place tell that place only, over and over: they are left out.
pub fn resting(observations: &Observations) -> Vec<bool> {
    let n = observations.len();
    let scene = Scene::new(observations, Baseline::nominal(observations), vec![true; n]);
    let moving = |i: usize| {
        scene
            .motion
            .direction
            .iter()
            .any(|d| d.get(i).is_some_and(|v| *v != 0.0))
    };
    let count = (0..n).filter(|&i| moving(i)).count();
    if !scene.scope.reference || count < crate::observe::MINIMUM_SAMPLES {
        return vec![false; n];
    }
    (0..n)
        .map(|i| scene.motion.smooth[i] && !moving(i))
        .collect()
}

fn white_rows(scene: &Scene) -> Vec<(usize, usize, f64)> {
    let mut list = Vec::new();
    for i in 0..scene.len() {
        let rows = scene.rows(i);
        let white = rows.whitened(&rows.residual_m);
        list.extend((0..rows.count).map(|r| (i, rows.channel[r], white[r])));
    }
    list
}

/// Builds all columns. `residuals` is what the line search looks at: those of the best model so far.
pub fn study<'a>(
    prepared: &'a Prepared,
    options: &Options,
    residuals: Option<&Residuals>,
) -> Study<'a> {
    build(prepared, options, residuals, None)
}

/// The same with a field over the platen; only the blocks named in `keep` stay, for the field has hundreds of unknowns.
pub fn study_with_field<'a>(
    prepared: &'a Prepared,
    options: &Options,
    residuals: &Residuals,
    keep: &[String],
) -> Study<'a> {
    build(prepared, options, Some(residuals), Some(keep))
}

fn build<'a>(
    prepared: &'a Prepared,
    options: &Options,
    residuals: Option<&Residuals>,
    keep: Option<&[String]>,
) -> Study<'a> {
    let mut scene = Scene::new(
        &prepared.observations,
        prepared.baseline.clone(),
        prepared.keep.clone(),
    );
    for segment in 0..4 {
        scene.survey.clip[segment] = clip::find(&scene, segment);
    }
    if let Some(residuals) = residuals {
        find_lines(&mut scene, residuals);
    }
    if keep.is_some() {
        (scene.survey.node_step_m, scene.survey.nodes) = crate::nodes::nodes(&scene);
    }
    let wanted =
        |name: &str| keep.is_none_or(|list| name == FIELD || list.iter().any(|k| k == name));
    let mut columns = baseline_columns(&scene);
    let mut kinds = Vec::new();
    for effect in effects::sensor_sides()
        .into_iter()
        .filter(|e| wanted(e.name()))
    {
        // An effect that is taken out of the catalogue loses its name; the coordinate that it acts on stays to be looked at.
        let taken_out = options.without.iter().any(|w| w == effect.name());
        let kind = if taken_out {
            Kind::Shape(effect.name().into())
        } else {
            Kind::Effect(effect.name().into())
        };
        add(
            &mut columns,
            &mut kinds,
            kind,
            effect.regressors(&scene.survey),
        );
    }
    for place in places(&scene.survey)
        .into_iter()
        .filter(|p| wanted(p.coordinate))
    {
        add(
            &mut columns,
            &mut kinds,
            Kind::Place(place.coordinate.into()),
            place.regressors,
        );
    }
    let folds = folds(&prepared.observations.stretch);
    let gram = Gram::new(&scene, &columns, &folds);
    let floor = floor(&scene, 4);
    Study {
        scene,
        columns,
        kinds,
        gram,
        folds,
        floor,
    }
}

/// The effect that is a field over the platen.
pub const FIELD: &str = "tooth_variation";

fn add(
    columns: &mut Columns,
    kinds: &mut Vec<Kind>,
    kind: Kind,
    regressors: Vec<effects::sensor::Regressor>,
) {
    if !regressors.is_empty() {
        let name = match &kind {
            Kind::Effect(name) | Kind::Place(name) | Kind::Shape(name) => name.clone(),
        };
        columns.push(name, regressors);
        kinds.push(kind);
    }
}

fn find_lines(scene: &mut Scene, residuals: &Residuals) {
    let o = scene.observations;
    let pick = |channel: usize| -> (Vec<f64>, Vec<f64>, Vec<usize>) {
        let mut out = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..residuals.sample.len() {
            if residuals.channel[k] == channel {
                let i = residuals.sample[k];
                out.0.push(o.t_s[i] - o.t_s[0]);
                out.1.push(residuals.white[k]);
                out.2.push(o.stretch[i]);
            }
        }
        out
    };
    let search = |channels: &[usize]| {
        let data: Vec<_> = channels
            .iter()
            .map(|c| pick(*c))
            .filter(|d| d.0.len() > 50)
            .collect();
        let mut series: Vec<Series> = data
            .iter()
            .map(|d| Series {
                t_s: &d.0,
                value: d.1.clone(),
                stretch: &d.2,
            })
            .collect();
        if series.is_empty() {
            Vec::new()
        } else {
            lines_hz(&mut series)
        }
    };
    scene.survey.beacon_lines_hz = search(&[1, 2]);
    scene.survey.segment_lines_hz = search(&[0, 3, 4, 5, 6]);
}

/// A block's handicap when it competes: shapes and flexible fields give way to causes.
pub fn handicap(name: &str) -> f64 {
    match name {
        "extra_harmonics" => 0.10,
        "quadrature_drift" => 0.10,
        FIELD => 0.10,
        "gap_variation" | "thermal_drift" => 0.01,
        _ => 0.0,
    }
}

/// True if COURIER_DIAGNOSIS_TRACE asks for the search's steps on standard error.
pub fn tracing() -> bool {
    std::env::var_os("COURIER_DIAGNOSIS_TRACE").is_some()
}

/// One step of the search, where that was asked for.
pub fn log(text: &str) {
    if tracing() {
        eprintln!("{text}");
    }
}
