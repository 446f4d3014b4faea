//! What a reader may see for himself: held-out residuals before and after, beside every coordinate of the sample.

use crate::algebra::statistics::median;
use crate::data::channel_names::CHANNEL_NAMES;
use crate::inference::residuals::Residuals;
use crate::linearization::recording::LinearizedRecording;
use effects::sensor::{LoggedColumn, MOST_LOGGED};
use std::f64::consts::TAU;

/// Most samples that are kept for a reader; more are thinned by whole blocks, so that spectra stay what they are. A bound on the
/// work: a drawing has fewer points across than that, and all figures are of all samples.
const MOST_DRAWN_SAMPLES: usize = 24_000;
/// Samples in such a block. Derived from spectra: at a millisecond a sample a block of 0.4 s resolves 2.5 Hz, below the slowest
/// line (3 Hz).
const BLOCK_SAMPLES: usize = 400;

/// Coordinates of one sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampleCoordinates {
    /// Since the first sample, s.
    pub t_s: f64,
    /// Unbroken piece of a run.
    pub stretch: usize,
    /// Own tooth phase of each segment, turns, not wrapped.
    pub own_turns: [f64; 4],
    /// Tooth phase across each segment, turns within 0 to 1.
    pub lateral_turns: [f64; 4],
    /// Angle of the courier, rad.
    pub theta_rad: f64,
    /// Centre of the sensor, m.
    pub centre_m: [f64; 2],
    /// Speed of each segment along its own direction, m/s.
    pub speed_m_s: [f64; 4],
    /// Direction of travel, or of the last approach: -1, 0 or 1.
    pub direction: [f64; 4],
    /// Temperature less its mean, K.
    pub warmth_k: f64,
    /// Deflection of the coordination sensor over its full scale.
    pub deflection: [f64; 2],
    /// Logarithm of each segment's amplitude less what repeats with the tooth.
    pub ln_amplitude: [f64; 4],
    /// Logged columns ([`Evidence::logged`]), each in its own unit.
    pub logged: [f64; MOST_LOGGED],
}

/// One residual.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// Index into [`Evidence::places`].
    pub place: usize,
    /// With the baseline alone, m.
    pub before_m: f64,
    /// With what is named, m, or with shapes without a name ([`WITHOUT_A_NAME`]); the same as before where there is neither.
    pub after_m: f64,
    /// Standard deviation that the stated noise gives it, m: the simulator's own scatter.
    pub floor_m: f64,
}

/// One channel's residuals in time order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// `g_p`, `g_x`, `g_y`, `segment_1` to `segment_4`.
    pub channel: String,
    /// Segment, where the channel is one against a reference.
    pub segment: Option<usize>,
    /// Residuals.
    pub points: Vec<Point>,
}

impl Trace {
    /// Standard deviation that the stated noise gives to the middle one of its residuals, m: single ones in the dark are far noisier.
    pub fn floor_m(&self) -> f64 {
        let mut list: Vec<f64> = self.points.iter().map(|p| p.floor_m).collect();
        median(&mut list).unwrap_or(0.0)
    }
}

/// What was recorded and how: what an advice for the next recording depends on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setting {
    /// Segments that were recorded.
    pub segments: [bool; 4],
    /// A beacon was seen.
    pub beacon: bool,
    /// There is an independent reference.
    pub reference: bool,
    /// Length of the recording, s.
    pub duration_s: f64,
    /// Mean of the commanded pose in the motion controller's frame, m, m, rad; none where no commands were recorded.
    pub commanded: Option<[f64; 3]>,
}

impl Setting {
    fn new(linearized: &LinearizedRecording) -> Self {
        let o = linearized.observations;
        let mean = |list: &Vec<f64>| {
            let known: Vec<f64> = list.iter().copied().filter(|v| v.is_finite()).collect();
            (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
        };
        let [x, y, theta] = [0, 1, 2].map(|axis| mean(&o.commanded[axis]));
        Self {
            segments: linearized.inputs.segments,
            beacon: linearized.inputs.beacon,
            reference: linearized.inputs.reference,
            duration_s: linearized.inputs.duration_s,
            commanded: x.zip(y).map(|(x, y)| [x, y, theta.unwrap_or(0.0)]),
        }
    }

    /// True where all four segments of a courier were recorded.
    pub fn is_courier(&self) -> bool {
        self.segments.iter().all(|s| *s)
    }
}

/// The step of a correction without a name.
pub const WITHOUT_A_NAME: &str = "shapes without a name";

/// The gap after one more effect.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Step {
    /// Effect that was added, or [`WITHOUT_A_NAME`]; empty for the baseline.
    pub effect: String,
    /// Held-out rms over the simulator's own scatter.
    pub whitened: f64,
}

/// Everything behind the figures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Tooth pitch, m.
    pub pitch_m: f64,
    /// Samples of the recording.
    pub samples: usize,
    /// Samples that were set aside as disturbed or resting.
    pub set_aside: usize,
    /// What was recorded.
    pub setting: Setting,
    /// Logged columns that change, at most as many as a sample has.
    pub logged: Vec<LoggedColumn>,
    /// Coordinates.
    pub places: Vec<SampleCoordinates>,
    /// Residuals by channel.
    pub traces: Vec<Trace>,
    /// The gap from the baseline on, one effect at a time in the order of the answer.
    pub steps: Vec<Step>,
}

impl Evidence {
    /// Of a linearized recording and two models' residuals over the same samples. Linear in samples.
    pub fn new(
        linearized: &LinearizedRecording,
        before: &Residuals,
        after: &Residuals,
        steps: Vec<Step>,
    ) -> Self {
        let chosen = thinned(linearized.len());
        let mut index = vec![usize::MAX; linearized.len()];
        let mut places = Vec::new();
        for i in (0..linearized.len()).filter(|&i| linearized.mask[i] && chosen(i)) {
            index[i] = places.len();
            places.push(place(linearized, i));
        }
        let mut traces: Vec<Trace> = before
            .channels()
            .into_iter()
            .map(|c| Trace {
                channel: CHANNEL_NAMES[c].into(),
                segment: c.checked_sub(3),
                points: Vec::new(),
            })
            .collect();
        let same = after.value_m.len() == before.value_m.len();
        for k in 0..before.value_m.len() {
            let at = index[before.sample[k]];
            let name = CHANNEL_NAMES[before.channel[k]];
            if let Some(trace) = traces
                .iter_mut()
                .find(|t| t.channel == name)
                .filter(|_| at != usize::MAX)
            {
                let before_m = before.value_m[k];
                let after_m = if same { after.value_m[k] } else { before_m };
                trace.points.push(Point {
                    place: at,
                    before_m,
                    after_m,
                    floor_m: before.noise_m[k],
                });
            }
        }
        let kept = linearized.mask.iter().filter(|k| **k).count();
        let pitch_m = linearized.observations.pitch_m;
        Self {
            pitch_m,
            samples: linearized.len(),
            set_aside: linearized.len() - kept,
            setting: Setting::new(linearized),
            logged: linearized.inputs.logged.clone(),
            places,
            traces,
            steps,
        }
    }
}

/// Which samples are kept: all of them, or evenly spread blocks.
fn thinned(samples: usize) -> impl Fn(usize) -> bool {
    let blocks = samples.div_ceil(BLOCK_SAMPLES);
    let every = blocks.div_ceil(MOST_DRAWN_SAMPLES / BLOCK_SAMPLES).max(1);
    move |i| samples <= MOST_DRAWN_SAMPLES || (i / BLOCK_SAMPLES) % every == 0
}

fn place(linearized: &LinearizedRecording, i: usize) -> SampleCoordinates {
    let m = linearized.covariates(i);
    let turns = |(sine, cosine): (f64, f64)| (sine.atan2(cosine) / TAU).rem_euclid(1.0);
    SampleCoordinates {
        t_s: m.t_s,
        stretch: m.stretch,
        own_turns: m.place_m.map(|p| p[0] / linearized.observations.pitch_m),
        lateral_turns: m.lateral.map(|orders| turns(orders[1])),
        theta_rad: m.theta_rad,
        centre_m: m.centre_m,
        speed_m_s: m.speed_m_s,
        direction: std::array::from_fn(|s| {
            if m.direction[s] != 0.0 {
                m.direction[s]
            } else {
                m.approach[s]
            }
        }),
        warmth_k: m.warmth_k,
        deflection: m.deflection,
        ln_amplitude: m.ln_amplitude,
        logged: std::array::from_fn(|k| {
            let column = linearized.inputs.logged.get(k);
            column.map_or(0.0, |c| c.mean + c.deviation * m.logged[k])
        }),
    }
}
