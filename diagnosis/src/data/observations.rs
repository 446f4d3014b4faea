//! From a recording to what the diagnosis works on: unmodified outputs on one tooth count, deflections, noise.

use crate::Insufficient;
use crate::data::clip::CutFigure;
use crate::data::interpolation::filled;
use crate::data::late_segment::LateSegment;
use recording::{Column, INDEX, Logged, Recording, Samples};
use std::f64::consts::TAU;

/// The recording in columns of f64, NaN where not measured. `N` samples.
#[derive(Clone, Debug, Default)]
pub struct Observations {
    /// Tooth pitch, m.
    pub pitch_m: f64,
    /// Nominal distance between the segments of a pair, m.
    pub span_m: f64,
    /// False if the span is not stated and [`Self::span_m`] is a usual one.
    pub span_is_stated: bool,
    /// Nominal lateral offset, m.
    pub lateral_m: f64,
    /// Nominal `h`, `l_x`, `l_y`, m.
    pub coordination_m: [f64; 3],
    /// tan(psi) at full scale.
    pub tan_full_scale: f64,
    /// Time, s.
    pub t_s: Vec<f64>,
    /// Run of each sample.
    pub run: Vec<usize>,
    /// Unbroken piece of one run.
    pub stretch: Vec<usize>,
    /// Samples that follow each other without a break: a stretch, or a part of one where samples between were let go.
    pub unbroken: Vec<usize>,
    /// Unmodified outputs, m.
    pub position_m: [Vec<f64>; 4],
    /// Segments that come late: [`Self::position_m`] holds what they read a delay later.
    pub late: [Option<LateSegment>; 4],
    /// Stated noise of the unmodified outputs, m.
    pub position_noise_m: [Vec<f64>; 4],
    /// What positions were rounded to, m; zero where counts were logged or all digits.
    pub position_step_m: [f64; 4],
    /// Amplitude of each pair, counts (empty without counts).
    pub amplitude_counts: [Vec<f64>; 4],
    /// Stated amplitude of a pair, counts; NaN where none is stated.
    pub stated_amplitude_counts: f64,
    /// Raw pairs `[sine, cosine]`, counts (empty without counts).
    pub pair_counts: [Vec<[f64; 2]>; 4],
    /// tan(psi_x), tan(psi_y).
    pub tan_psi: [Vec<f64>; 2],
    /// Stated noise of those.
    pub tan_psi_noise: [Vec<f64>; 2],
    /// Board temperature, °C (empty where not recorded).
    pub temperature_c: Vec<f64>,
    /// Commanded x, y, theta (empty where not recorded).
    pub commanded: [Vec<f64>; 3],
    /// Reference x, y, theta (empty where not recorded).
    pub reference: [Vec<f64>; 3],
    /// Quantities that were logged beside the layout's columns.
    pub logged: Vec<Logged>,
    /// Names of the runs.
    pub run_names: Vec<String>,
    /// Noise of a quadrature channel with rounding, counts; zero where positions were logged.
    pub pair_noise_counts: f64,
    /// Noise of an electrode with rounding, counts.
    pub electrode_noise_counts: f64,
    /// Pairs that are cut by hard rails, as [`crate::data::clip::cut_figures`] finds them.
    pub cut_figures: [Option<CutFigure>; 4],
    /// True if the readings show less noise than is stated.
    pub overstated: bool,
    /// Full range of the quadrature converter, counts.
    pub full_range_counts: f64,
}

/// An electrode with less than so many times its noise is dark: the spot is at the diode's edge, and may be beyond it. Derived
/// from the normal tail: noise alone is above once in 3.5 million, so that what is not dark has light.
const EDGE_NOISES: f64 = 5.0;
/// Variance of rounding to whole counts. A derivation: an error that is uniform over one count.
pub(crate) const ROUNDING: f64 = 1.0 / 12.0;

impl Observations {
    /// Reads the columns of a recording.
    ///
    /// # Errors
    /// [`Insufficient`] where no residual can be formed.
    pub fn new(recording: &Recording) -> Result<Self, Insufficient> {
        let samples = &recording.samples;
        let n = samples.len();
        let meta = &recording.meta;
        if n < MINIMUM_SAMPLES {
            return Err(
                Insufficient::new("samples", n as f64, MINIMUM_SAMPLES as f64, "")
                    .lacking(further(samples)),
            );
        }
        let electronics = &meta.electronics;
        let counts_noise =
            (electronics.quadrature_noise_counts.unwrap_or(0.0).powi(2) + ROUNDING).sqrt();
        let full_range = electronics
            .adc_bits
            .map_or(32768.0, |bits| 2f64.powi(bits as i32 - 1));
        let take = |column| samples.column(column).to_vec();
        let coordination = meta.coordination.unwrap_or_default();
        let mut this = Self {
            pitch_m: meta.geometry.pitch_m,
            span_m: meta.geometry.span_m.unwrap_or(10.0 * meta.geometry.pitch_m),
            span_is_stated: meta.geometry.span_m.is_some(),
            lateral_m: meta.geometry.lateral_m.unwrap_or(0.0),
            coordination_m: [
                coordination.height_m,
                coordination.lever_x_m,
                coordination.lever_y_m,
            ],
            tan_full_scale: coordination.tan_full_scale,
            t_s: samples.t_s().to_vec(),
            run: (0..n).map(|i| samples.run_number(i)).collect(),
            stretch: Vec::new(),
            unbroken: Vec::new(),
            position_m: Default::default(),
            late: Default::default(),
            position_noise_m: Default::default(),
            position_step_m: [0.0; 4],
            amplitude_counts: Default::default(),
            stated_amplitude_counts: electronics.amplitude_counts.unwrap_or(f64::NAN),
            pair_counts: Default::default(),
            tan_psi: Default::default(),
            tan_psi_noise: Default::default(),
            temperature_c: filled(samples.t_s(), take(Column::Temperature)),
            commanded: [0, 1, 2].map(|axis| take(Column::Commanded(axis))),
            reference: [0, 1, 2].map(|axis| take(Column::Reference(axis))),
            logged: quantities(samples),
            run_names: samples.run_names().to_vec(),
            pair_noise_counts: counts_noise,
            electrode_noise_counts: (electronics.psd_noise_counts.unwrap_or(0.0).powi(2)
                + ROUNDING)
                .sqrt(),
            cut_figures: [None; 4],
            overstated: false,
            full_range_counts: full_range,
        };
        this.stretch = stretches(&this.t_s, &this.run);
        this.unbroken = this.stretch.clone();
        for segment in 0..4 {
            this.read_segment(recording, segment);
        }
        this.read_deflection(recording);
        Ok(this)
    }

    /// Lets all other samples go.
    pub fn retain(&mut self, stays: &[bool]) {
        let mut breaks = 0;
        self.unbroken = (0..stays.len())
            .map(|i| {
                let broken = i > 0 && (!stays[i - 1] || self.stretch[i] != self.stretch[i - 1]);
                breaks += usize::from(stays[i] && broken);
                breaks
            })
            .collect();
        for list in [&mut self.run, &mut self.stretch, &mut self.unbroken] {
            only(list, stays);
        }
        for list in &mut self.pair_counts {
            only(list, stays);
        }
        let lists = [&mut self.t_s, &mut self.temperature_c].into_iter();
        let lists = lists.chain(&mut self.position_m);
        let lists = lists.chain(&mut self.position_noise_m);
        let late = self.late.iter_mut().flatten();
        let lists = lists.chain(late.map(|late| &mut late.ahead_m));
        let lists = lists.chain(&mut self.amplitude_counts);
        let lists = lists
            .chain(&mut self.tan_psi)
            .chain(&mut self.tan_psi_noise);
        let lists = lists.chain(self.logged.iter_mut().map(|logged| &mut logged.values));
        for list in lists.chain(&mut self.commanded).chain(&mut self.reference) {
            only(list, stays);
        }
    }

    /// Aligns late segments in time: puts what each reads a delay later in the place of its readings. A `sign` of -1 takes that back. Where none tells it a segment is not measured from then on.
    pub fn align_in_time(&mut self, late: &[Option<LateSegment>; 4], sign: f64) {
        for (position_m, late) in self.position_m.iter_mut().zip(late) {
            let ahead_m = late.iter().flat_map(|late| &late.ahead_m);
            let pairs = position_m.iter_mut().zip(ahead_m);
            pairs.for_each(|(position_m, ahead_m)| *position_m += sign * ahead_m);
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// True without a sample.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }

    /// True if the segment was recorded.
    pub fn has_segment(&self, segment: usize) -> bool {
        !self.position_m[segment].is_empty()
    }

    /// True if a beacon was seen at the sample.
    pub fn sees_beacon(&self, i: usize) -> bool {
        self.tan_psi[0].get(i).is_some_and(|u| u.is_finite()) && self.tan_psi[1][i].is_finite()
    }

    /// Nominal position of a segment's output at the commanded pose, m.
    pub fn commanded_m(&self, segment: usize, i: usize) -> f64 {
        nominal_m(&self.commanded, self.span_m, segment, i)
    }

    /// Position of a segment's output at the reference pose, m; the angle is taken as zero where it is not measured.
    pub fn reference_m(&self, segment: usize, i: usize) -> f64 {
        nominal_m(&self.reference, self.span_m, segment, i)
    }

    fn read_segment(&mut self, recording: &Recording, segment: usize) {
        let samples = &recording.samples;
        let n = samples.len();
        let counted = samples.has(Column::Sine(segment)) && samples.has(Column::Cosine(segment));
        if !counted && !samples.has(Column::Position(segment)) {
            return;
        }
        let stated = recording.meta.electronics.position_noise_m;
        let mut position = vec![f64::NAN; n];
        let mut noise = vec![stated.unwrap_or(f64::NAN); n];
        if counted {
            let mut pairs = vec![[f64::NAN; 2]; n];
            let mut amplitudes = vec![f64::NAN; n];
            for i in 0..n {
                let Some(pair) = samples.quadrature_counts(segment, i) else {
                    continue;
                };
                pairs[i] = pair;
                amplitudes[i] = pair[0].hypot(pair[1]);
                let amplitude = if amplitudes[i] > 0.0 {
                    amplitudes[i]
                } else {
                    self.stated_amplitude_counts
                };
                noise[i] = self.pair_noise_counts / amplitude * self.pitch_m / TAU;
                if let Some(teeth) = samples.teeth(segment, i) {
                    position[i] = recording::unmodified_m(teeth, pair, self.pitch_m);
                } else if let Some(logged) = samples.get(Column::Position(segment), i) {
                    position[i] = logged;
                } else {
                    position[i] = self.count_teeth(segment, i, &position, pair);
                }
            }
            self.pair_counts[segment] = pairs;
            self.amplitude_counts[segment] = amplitudes;
        } else {
            position.copy_from_slice(samples.column(Column::Position(segment)));
            self.position_step_m[segment] = crate::algebra::statistics::step(&position);
            let rounding = self.position_step_m[segment].powi(2) * ROUNDING;
            noise
                .iter_mut()
                .for_each(|n| *n = (*n * *n + rounding).sqrt());
        }
        self.position_m[segment] = position;
        self.position_noise_m[segment] = noise;
    }

    /// Without a tooth count: the tooth nearest to the command, else to the sample before.
    fn count_teeth(
        &self,
        segment: usize,
        i: usize,
        before: &[f64],
        [sine, cosine]: [f64; 2],
    ) -> f64 {
        let fraction = sine.atan2(cosine) / TAU * self.pitch_m;
        let near = match self.commanded_m(segment, i) {
            near if near.is_finite() => near,
            _ => before[..i]
                .iter()
                .rev()
                .find(|p| p.is_finite())
                .copied()
                .unwrap_or(0.0),
        };
        fraction + ((near - fraction) / self.pitch_m).round() * self.pitch_m
    }

    fn read_deflection(&mut self, recording: &Recording) {
        let samples = &recording.samples;
        if !(0..4).all(|e| samples.has(Column::Electrode(e))) {
            return;
        }
        let n = samples.len();
        let noise = self.electrode_noise_counts;
        let dim = 0.05 * recording.meta.electronics.psd_sum_counts.unwrap_or(0.0);
        let dark = EDGE_NOISES * noise;
        for axis in 0..2 {
            let mut tan = vec![f64::NAN; n];
            let mut tan_noise = vec![f64::NAN; n];
            for i in 0..n {
                let Some(counts) = samples.electrode_counts(i) else {
                    continue;
                };
                let (plus, minus) = (counts[2 * axis], counts[2 * axis + 1]);
                let sum = plus + minus;
                if sum > dim.max(1.0) && plus.min(minus) > dark {
                    tan[i] = self.tan_full_scale * (plus - minus) / sum;
                    tan_noise[i] =
                        self.tan_full_scale * 2.0 * noise * plus.hypot(minus) / (sum * sum);
                }
            }
            self.tan_psi[axis] = tan;
            self.tan_psi_noise[axis] = tan_noise;
        }
        if !self.tan_psi[0]
            .iter()
            .zip(&self.tan_psi[1])
            .any(|(u, v)| u.is_finite() && v.is_finite())
        {
            self.tan_psi = Default::default();
            self.tan_psi_noise = Default::default();
        }
    }
}

/// Keeps the entries of some samples, and no memory for the others.
fn only<T>(list: &mut Vec<T>, stays: &[bool]) {
    let mut stays = stays.iter();
    list.retain(|_| stays.next().is_some_and(|s| *s));
    list.shrink_to_fit();
}

/// Fewer samples than this answer nothing: the baseline alone has 38 unknowns. Derived from those unknowns: five samples to each.
pub const MINIMUM_SAMPLES: usize = 200;

/// What too few samples lack: more of them, and how long that takes at their rate.
fn further(samples: &Samples) -> Vec<String> {
    let more = MINIMUM_SAMPLES - samples.len();
    let takes = samples.sample_interval_s().map_or(String::new(), |step_s| {
        format!(", {:.3} s at this rate", more as f64 * step_s)
    });
    vec![format!("{more} samples more{takes}")]
}

fn nominal_m(pose: &[Vec<f64>; 3], span_m: f64, segment: usize, i: usize) -> f64 {
    let Some(&along) = pose[segment % 2].get(i) else {
        return f64::NAN;
    };
    let theta = pose[2].get(i).copied().unwrap_or(0.0);
    let half = if segment < 2 { 0.5 } else { -0.5 };
    along + half * span_m * theta
}

/// Number of the stretch of each sample: a new one at a change of run or a gap of over ten of the run's intervals.
fn stretches(t_s: &[f64], run: &[usize]) -> Vec<usize> {
    let runs = run.iter().copied().max().unwrap_or(0) + 1;
    let mut intervals: Vec<Vec<f64>> = vec![Vec::new(); runs];
    for i in 1..t_s.len() {
        if run[i] == run[i - 1] {
            intervals[run[i]].push(t_s[i] - t_s[i - 1]);
        }
    }
    let typical: Vec<f64> = intervals
        .iter_mut()
        .map(|list| crate::algebra::statistics::median(list).unwrap_or(f64::INFINITY))
        .collect();
    let mut stretch = Vec::with_capacity(t_s.len());
    let mut number = 0;
    for i in 0..t_s.len() {
        if i > 0 && (run[i] != run[i - 1] || t_s[i] - t_s[i - 1] > 10.0 * typical[run[i]]) {
            number += 1;
        }
        stretch.push(number);
    }
    stretch
}

/// What was logged beside the columns and may act on a segment: an index acts on nothing.
fn quantities(samples: &Samples) -> Vec<Logged> {
    let logged = samples.logged().iter();
    logged
        .filter(|logged| logged.name != INDEX)
        .cloned()
        .collect()
}
