//! A recording made ready: read, repaired, thinned, cleaned, calibrated.

use crate::Insufficient;
use crate::data::faint::WithoutSignal;
use crate::data::observations::Observations;
use crate::data::outliers::{astray, disturbed};
use crate::data::slips::{Slip, repair_slips};
use crate::data::thinning;
use crate::data::tooth_counts::align_pairs;
use crate::linearization::baseline::Baseline;
use crate::linearization::calibrate::calibrate;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::recording::{Amplitudes, LinearizedRecording};
use effects::sensor::Clip;
use recording::Recording;
use std::sync::Arc;

/// Prepared recording.
pub struct Prepared {
    /// Columns of the recording, slips taken out; of a very long one, those of the samples that the answer is made of.
    pub observations: Observations,
    /// Samples of the recording.
    pub samples: usize,
    /// Lasting tooth slips.
    pub slips: Vec<Slip>,
    /// Samples in use.
    pub mask: Vec<bool>,
    /// Samples left out because they rest on one place.
    pub resting: Vec<bool>,
    /// Samples that are there for the sake of their neighbours only, where a very long recording was thinned.
    pub thinned: Vec<bool>,
    /// Samples left out because both channels of a pair stand at their rails.
    pub stuck: Vec<bool>,
    /// Calibrated baseline.
    pub baseline: Baseline,
    /// What explains the pairs' amplitudes.
    pub amplitudes: Arc<Amplitudes>,
    /// Clips of the pairs that the counts show.
    pub clips: [Option<Clip>; 4],
    /// Equation (3)'s orders beneath them.
    pub beneath: [Option<[f64; 8]>; 4],
    /// The stated noise, where the readings show less.
    pub overstated: Option<Insufficient>,
    /// Where segments gave no signal: left out.
    pub without_signal: Vec<WithoutSignal>,
    /// What must be said of the recording.
    pub notes: Vec<String>,
}

impl Prepared {
    /// The same with other samples in use, calibrated on them.
    pub fn use_only(&mut self, mask: Vec<bool>) {
        self.baseline = calibrate(&self.observations, &mask);
        self.mask = mask;
    }

    /// True for a sample that may be in use, if nothing disturbs it.
    pub fn usable(&self, i: usize) -> bool {
        !self.resting[i] && !self.thinned[i] && !self.stuck[i]
    }

    /// The linearisation about the baseline alone.
    pub fn point(&self) -> LinearizationPoint {
        LinearizationPoint {
            baseline: self.baseline.clone(),
            ..LinearizationPoint::default()
        }
    }
}

/// Reads, repairs and calibrates.
///
/// # Errors
/// [`Insufficient`] where the recording cannot answer.
pub fn prepare(recording: &Recording) -> Result<Prepared, Insufficient> {
    let mut observations = Observations::new(recording)?;
    crate::data::adequacy::check(&observations)?;
    crate::data::channels::electrodes(recording)?;
    let late = crate::data::late::late(&observations);
    observations.align_in_time(&late, 1.0);
    let mut notes = crate::data::commanded::repair(&mut observations);
    notes.extend(crate::data::held_reference::leave_aside(&mut observations));
    notes.extend(crate::data::restarts::join(&mut observations, recording));
    let slips = repair_slips(&mut observations);
    align_pairs(&mut observations);
    let (without_signal, told): (Vec<WithoutSignal>, Vec<String>) =
        crate::data::faint::leave_aside(&mut observations)
            .into_iter()
            .unzip();
    notes.extend(told);
    notes.extend(crate::data::adequacy::remarks(&observations));
    let samples = observations.len();
    observations.late = late;
    let (thinned, note) = thinning::thin(&mut observations);
    notes.extend(note);
    observations.cut_figures = crate::data::clip::cut_figures(&observations);
    let mut mask = vec![true; observations.len()];
    let resting = resting(&observations);
    let usable: Vec<bool> = resting
        .iter()
        .zip(&thinned)
        .map(|(r, t)| !r && !t)
        .collect();
    mask.copy_from_slice(&usable);
    let mut baseline = calibrate(&observations, &mask);
    for _ in 0..2 {
        let mut linearized = LinearizedRecording::new(
            &observations,
            baseline.clone(),
            vec![true; observations.len()],
        );
        linearized.aligned_in_time = true;
        let mut rows = white_rows(&linearized);
        rows.extend(linearized.amplitude_rows());
        let marked = disturbed(&rows, observations.len(), &observations.stretch);
        let astray = astray(&rows, &observations);
        let next: Vec<bool> = (0..observations.len())
            .map(|i| usable[i] && !marked[i] && !astray[i])
            .collect();
        if next == mask {
            break;
        }
        mask = next;
        baseline = calibrate(&observations, &mask);
    }
    if observations.late.iter().any(Option::is_some) {
        crate::data::late::realign(&mut observations, &baseline);
        baseline = calibrate(&observations, &mask);
    }
    let linearized = LinearizedRecording::new(&observations, baseline.clone(), mask.clone());
    crate::data::adequacy::check_residuals(&linearized, &mask)?;
    crate::data::adequacy::check_turning(&linearized)?;
    let overstated = crate::data::adequacy::overstated(&linearized);
    let amplitudes = Arc::new(linearized.amplitudes_explained());
    drop(linearized);
    let clips = crate::data::clip::in_counts(&observations);
    let stuck = crate::data::clip::stuck(&observations, &clips);
    let count = stuck.iter().filter(|s| **s).count();
    if count > 0 {
        notes.push(format!(
            "{}: at {count} of {samples} samples both channels of a pair stand at their rails and tell no place between them: left out",
            effects::name_of(effects::Detection::ByRails)
        ));
        mask.iter_mut().zip(&stuck).for_each(|(k, s)| *k &= !s);
        baseline = calibrate(&observations, &mask);
    }
    let beneath = crate::data::clip::beneath(&observations, &baseline, &mask, &clips);
    observations.overstated = overstated.is_some();
    Ok(Prepared {
        observations,
        samples,
        slips,
        mask,
        resting,
        thinned,
        stuck,
        baseline,
        amplitudes,
        clips,
        beneath,
        overstated,
        without_signal,
        notes,
    })
}

/// Against a reference, samples that rest on one place tell that place only, over and over: they are left out.
pub fn resting(observations: &Observations) -> Vec<bool> {
    let n = observations.len();
    let linearized =
        LinearizedRecording::new(observations, Baseline::nominal(observations), vec![true; n]);
    let moving = |i: usize| {
        linearized
            .motion
            .direction
            .iter()
            .any(|d| d.get(i).is_some_and(|v| *v != 0.0))
    };
    let count = (0..n).filter(|&i| moving(i)).count();
    if !linearized.scope.reference || count < crate::data::observations::MINIMUM_SAMPLES {
        return vec![false; n];
    }
    (0..n)
        .map(|i| linearized.motion.smooth[i] && !moving(i))
        .collect()
}

fn white_rows(linearized: &LinearizedRecording) -> Vec<(usize, usize, f64)> {
    let mut list = Vec::new();
    for i in 0..linearized.len() {
        let rows = linearized.rows(i);
        let white = rows.whitened(&rows.residual_m);
        list.extend((0..rows.count).map(|r| (i, rows.channel[r], white[r])));
    }
    list
}
