//! The sensor's side of an effect: regressors over what a sensor knows at a sample, with priors of physical size.
//!
//! Nothing here knows the plant. A regressor is a unit amount of the effect, written as what must be *added* to the
//! readings (segments 1 to 4 in metres, then tan(psi_x), tan(psi_y)) for the constraints to close, the convention of
//! equation (3). The diagnosis turns it into channels, weighs it by the noise, and fits its amount.

pub use crate::covariates::{
    Covariates, GRADUAL, Harmonics, LAGS_S, LATERAL_ORDERS, MOST_LOGGED, ORDERS, TURNOVERS,
};
use crate::identity::{Factor, Identity, Part, Wave};
pub use crate::nested_forms::{Channel, NestedForms, SingleTeeth};
use crate::over::{Extent, Over};
pub use crate::rails::Clip;
use serde::{Deserialize, Serialize};

/// Readings of a sample: four segments (m), then tan(psi_x), tan(psi_y). A definition: 4 and 2.
pub const READINGS: usize = 6;
/// Residual channels: g_p, g_x, g_y, then segment 1 to 4 against a reference. A definition: 3 and 4.
pub const CHANNELS: usize = 7;
/// A mount that swings more slowly than this hangs by 28 mm under its own weight: what is slower is a drift or follows the
/// motion, and no line of a vibration. Derived from a spring's sag under its load, g/(2 pi f)².
pub const SLOWEST_LINE_HZ: f64 = 3.0;

/// A quantity that was logged beside the layout's columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LoggedColumn {
    /// Name of the column.
    pub name: String,
    /// Its mean, in its own unit.
    pub mean: f64,
    /// Its standard deviation, in its own unit.
    pub deviation: f64,
    /// It only rises or only falls: then it is a clock.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub one_way: bool,
}

/// True if it holds of no segment.
fn is_none(of_segments: &[bool; 4]) -> bool {
    *of_segments == [false; 4]
}

/// True if it is zero of all segments.
fn is_zero(of_segments: &[f64; 4]) -> bool {
    *of_segments == [0.0; 4]
}

/// What a recording offers: an effect without the data that it needs is not judged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BasisInputs {
    /// Segments that were recorded.
    pub segments: [bool; 4],
    /// A beacon was seen.
    pub beacon: bool,
    /// Counts were recorded, so amplitudes are known.
    pub counts: bool,
    /// The temperature was recorded and changed.
    pub temperature: bool,
    /// The courier turned (largest less smallest angle over 0.5 mrad).
    pub turning: bool,
    /// There are samples in motion.
    pub moving: bool,
    /// Lateral phases are known (both axes were recorded).
    pub lateral: bool,
    /// Delay of a segment that comes so late that it shows before anything is fitted, s; zero of others.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub late_s: [f64; 4],
    /// Highest speed of each segment (99th percentile), m/s.
    pub top_speed_m_s: [f64; 4],
    /// Distance over which each segment moved, m.
    pub travel_m: [f64; 4],
    /// Mean of the sensor's centre, m: places are told from there.
    #[serde(default)]
    pub middle_m: [f64; 2],
    /// Tooth pitch, m.
    pub pitch_m: f64,
    /// tan(psi) at full scale.
    pub tan_full_scale: f64,
    /// Length of the recording, s.
    pub duration_s: f64,
    /// Lowest and highest board temperature less its mean, K: beyond them nothing was measured.
    #[serde(default)]
    pub warmths_k: [f64; 2],
    /// Frequencies at which g_x and g_y oscillate beyond chance, Hz, strongest first.
    pub beacon_lines_hz: Vec<f64>,
    /// Frequencies at which the segments oscillate beyond chance, Hz, strongest first.
    pub segment_lines_hz: Vec<f64>,
    /// Frequencies that hum in each segment's pair, as its amplitude shows, Hz, strongest first.
    #[serde(default)]
    pub pair_lines_hz: [Vec<f64>; 4],
    /// Frequencies at which the coordination sensor's gain flickers, Hz, strongest first.
    #[serde(default)]
    pub flicker_hz: Vec<f64>,
    /// Waves over the coordination sensor's deflection that stand out of what nothing explains, strongest first: turns over a full
    /// scale along either axis.
    #[serde(default)]
    pub deflection_waves: Vec<[f64; 2]>,
    /// Stretches in which a beacon was seen.
    pub beacon_stretches: Vec<usize>,
    /// Mesh width of a field over the platen, m; zero where none is judged.
    #[serde(rename = "node_step_m")]
    pub knot_step_m: f64,
    /// Knots that are passed often enough: of each segment along and across, or, where that would be too many, of the sensor's
    /// centre along x and y for g_p, g_x and g_y.
    #[serde(rename = "nodes")]
    pub knots: [Vec<[i32; 2]>; 4],
    /// Residuals are those of single segments against a reference.
    #[serde(default)]
    pub reference: bool,
    /// Each segment has a field of its own, at its own place, though there is no reference.
    #[serde(default)]
    pub field_by_segment: bool,
    /// Knots are not teeth, but corners (the first and the last) of a rectangle on which each segment's field is told by its values.
    #[serde(default)]
    pub field_by_value: bool,
    /// The place explains a good part of how each segment's amplitude changes.
    #[serde(default)]
    pub amplitude_by_place: [bool; 4],
    /// Each pair's amplitude shows that its offsets, gain or angle wander.
    #[serde(default)]
    pub pair_wanders: [bool; 4],
    /// Logged columns `aux_…` that change.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub logged: Vec<LoggedColumn>,
    /// Each pair's amplitude shows that the offsets of its channels change with the place.
    #[serde(default, skip_serializing_if = "is_none")]
    pub offsets_by_place: [bool; 4],
    /// Free harmonics run over the phase of the unmodified output, as equation (3) does, and not over the calibrated one's.
    #[serde(default)]
    pub unmodified: bool,
    /// Teeth that a field over the platen is told by, where they are few enough.
    #[serde(default)]
    pub teeth: Option<tooth_field::Teeth>,
    /// Beside skewed rulings, what is periodic goes with the place over the platen and not with the teeth.
    #[serde(default)]
    pub skew_moves: bool,
    /// Skewed rulings wind as well: they leave a gap without.
    #[serde(default)]
    pub lines_wind: bool,
    /// Growth with temperature is known: what it makes of the scale at the mean temperature is told with it.
    #[serde(default)]
    pub growth_told: bool,
    /// Smallest and largest angle of nearly all samples, rad.
    #[serde(default)]
    pub thetas_rad: [f64; 2],
    /// What is told of effects whose simplest form leaves a gap.
    #[serde(default, rename = "fuller")]
    pub forms: NestedForms,
    /// A drift's bend over the measured temperatures goes on beyond them.
    #[serde(default)]
    pub bend_goes_on: bool,
    /// A gap is known to change: what its error holds at the normal amplitude, and equation (3) lacks, is told with it.
    #[serde(default)]
    pub gap_told: bool,
    /// The clip of each segment's pair, where the counts or a reference show one.
    pub clip: [Option<Clip>; 4],
    /// Sine and cosine of equation (3)'s orders 1, 2, 4 and 6 in each segment, m, as they are beneath its clip. Where they are told, the
    /// clip's shapes hold what it bends of them: residuals are then taken about an equation (3) that knows no clip.
    #[serde(skip)]
    pub beneath: [Option<[f64; 8]>; 4],
}

/// What a unit amount is at a sample.
pub type Value = dyn Fn(&Covariates) -> f64 + Send + Sync;

/// A unit amount added to the readings or, for shapes that no reading owns, to the channels.
pub enum Action {
    /// Adds to the one reading of this number.
    Reading(usize, Box<Value>),
    /// Adds to the one channel of this number.
    Channel(usize, Box<Value>),
    /// Adds to the readings.
    Readings(Box<dyn Fn(&Covariates, &mut [f64; READINGS]) + Send + Sync>),
    /// Adds to the channels.
    Channels(Box<dyn Fn(&Covariates, &mut [f64; CHANNELS]) + Send + Sync>),
}

impl Action {
    /// True if it adds to readings, and not to channels.
    #[must_use]
    pub fn is_on_readings(&self) -> bool {
        matches!(self, Self::Reading(..) | Self::Readings(_))
    }

    /// What it adds to the readings; zeros if it adds to channels.
    #[must_use]
    #[inline]
    pub fn on_readings(&self, covariates: &Covariates) -> [f64; READINGS] {
        let mut out = [0.0; READINGS];
        match self {
            Self::Reading(reading, value) => out[*reading] = value(covariates),
            Self::Readings(add) => add(covariates, &mut out),
            Self::Channel(..) | Self::Channels(_) => (),
        }
        out
    }

    /// What it adds to the channels; zeros if it adds to readings.
    #[must_use]
    #[inline]
    pub fn on_channels(&self, covariates: &Covariates) -> [f64; CHANNELS] {
        let mut out = [0.0; CHANNELS];
        match self {
            Self::Channel(channel, value) => out[*channel] = value(covariates),
            Self::Channels(add) => add(covariates, &mut out),
            Self::Reading(..) | Self::Readings(_) => (),
        }
        out
    }
}

/// A regressor that acts throughout. By definition of a range without ends.
pub const ALWAYS: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// One unknown amount of an effect.
pub struct Regressor {
    /// What it is, for the report.
    pub name: String,
    /// Unit of the amount.
    pub unit: &'static str,
    /// Physical size: prior standard deviation of what it does to the readings, rms over the recording, m.
    pub size_m: f64,
    /// Prior standard deviation of the amount itself, where that is what is known; else it is what gives [`Self::size_m`].
    pub deviation: Option<f64>,
    /// Prior mean of the amount: zero, unless something else than the residuals tells it.
    pub mean: f64,
    /// So much of the amount is in the readings' places already: late segments are aligned in time with the others before the fit.
    pub aligned_by: f64,
    /// It adds nothing outside this progress of the recording; asked before it is evaluated.
    pub during: [f64; 2],
    /// Nor outside this part of the platen.
    pub over: Option<Over>,
    /// Number, within its effect, of the course that it is a knot of: what is known of their size is known of all its knots.
    pub course: Option<usize>,
    /// What the amount stands for, where code needs to know it.
    pub identity: Option<Identity>,
    /// What a unit amount adds.
    pub action: Action,
}

impl Regressor {
    /// Of an action: throughout, of its physical size alone.
    fn of(name: impl Into<String>, unit: &'static str, size_m: f64, action: Action) -> Self {
        Self {
            name: name.into(),
            unit,
            size_m,
            deviation: None,
            mean: 0.0,
            aligned_by: 0.0,
            during: ALWAYS,
            over: None,
            course: None,
            identity: None,
            action,
        }
    }

    /// Adds to several readings at once.
    pub fn readings(
        name: impl Into<String>,
        unit: &'static str,
        size_m: f64,
        add: impl Fn(&Covariates, &mut [f64; READINGS]) + Send + Sync + 'static,
    ) -> Self {
        Self::of(name, unit, size_m, Action::Readings(Box::new(add)))
    }

    /// Adds to one reading.
    pub fn reading(
        name: impl Into<String>,
        unit: &'static str,
        size_m: f64,
        reading: usize,
        value: impl Fn(&Covariates) -> f64 + Send + Sync + 'static,
    ) -> Self {
        Self::of(
            name,
            unit,
            size_m,
            Action::Reading(reading, Box::new(value)),
        )
    }

    /// Adds to one channel.
    pub fn channel(
        name: impl Into<String>,
        unit: &'static str,
        size_m: f64,
        channel: usize,
        value: impl Fn(&Covariates) -> f64 + Send + Sync + 'static,
    ) -> Self {
        Self::of(
            name,
            unit,
            size_m,
            Action::Channel(channel, Box::new(value)),
        )
    }

    /// Adds to several channels at once.
    pub fn channels(
        name: impl Into<String>,
        unit: &'static str,
        size_m: f64,
        add: impl Fn(&Covariates, &mut [f64; CHANNELS]) + Send + Sync + 'static,
    ) -> Self {
        Self::of(name, unit, size_m, Action::Channels(Box::new(add)))
    }

    /// The same, which adds nothing outside some progress of the recording.
    #[must_use]
    pub fn within(mut self, during: [f64; 2]) -> Self {
        self.during = during;
        self
    }

    /// The same, which adds nothing outside some part of the platen.
    #[must_use]
    pub fn only_over(mut self, over: Over) -> Self {
        self.over = Some(over);
        self
    }

    /// The same, a knot of a course.
    #[must_use]
    pub fn knot_of(mut self, course: usize) -> Self {
        self.course = Some(course);
        self
    }

    /// The same, which stands for something that code asks for.
    #[must_use]
    pub fn identified(mut self, identity: Identity) -> Self {
        self.identity = Some(identity);
        self
    }

    /// The same with a prior on the amount itself.
    #[must_use]
    pub fn of_deviation(mut self, deviation: f64) -> Self {
        self.deviation = Some(deviation);
        self
    }

    /// The same with a prior mean by which the readings are aligned in time already. Its size is the prior deviation about that mean.
    #[must_use]
    pub fn aligned_by(self, amount: f64) -> Self {
        Self {
            mean: amount,
            aligned_by: amount,
            ..self
        }
    }

    /// The same with an amount that something else than the residuals tells.
    #[must_use]
    pub fn expected(self, mean: f64, deviation: f64) -> Self {
        Self {
            mean,
            ..self.of_deviation(deviation)
        }
    }

    /// True if it may add something at a sample.
    #[inline]
    pub fn acts(&self, covariates: &Covariates) -> bool {
        let now = (self.during[0]..=self.during[1]).contains(&covariates.progress);
        now && self.over.as_ref().is_none_or(|over| over.holds(covariates))
    }

    /// False if it acts at none of some samples.
    pub fn may_act(&self, extent: &Extent) -> bool {
        extent.meets(self.during, self.over.as_ref())
    }

    /// Sine and cosine of order `order` of a segment's own phase times a factor.
    pub fn harmonic<'a>(
        list: &mut Vec<Self>,
        segment: usize,
        order: usize,
        label: impl Into<Label<'a>>,
        factor: impl Fn(&Covariates) -> f64 + Send + Sync + Clone + 'static,
    ) {
        Self::harmonic_of(|m| &m.own, list, (segment, order), label.into(), factor);
    }

    /// The same of the own phase that the basis inputs name, the calibrated output's or the unmodified one's.
    pub fn free_harmonic<'a>(
        inputs: &BasisInputs,
        list: &mut Vec<Self>,
        place: (usize, usize),
        label: impl Into<Label<'a>>,
        factor: impl Fn(&Covariates) -> f64 + Send + Sync + Clone + 'static,
    ) {
        if inputs.unmodified {
            Self::harmonic_of(|m| &m.raw, list, place, label.into(), factor);
        } else {
            Self::harmonic_of(|m| &m.own, list, place, label.into(), factor);
        }
    }

    fn harmonic_of(
        table: fn(&Covariates) -> &Harmonics,
        list: &mut Vec<Self>,
        (segment, own_order): (usize, usize),
        label: Label,
        factor: impl Fn(&Covariates) -> f64 + Send + Sync + Clone + 'static,
    ) {
        for part in Part::BOTH {
            let Label {
                text, unit, size_m, ..
            } = label;
            let name = format!(
                "{text}order {own_order} {}, segment {}",
                part.name(),
                segment + 1
            );
            let factor = factor.clone();
            let value = move |m: &Covariates| factor(m) * part.of(table(m)[segment][own_order]);
            let wave = Wave {
                segment,
                own_order,
                lateral_order: 0,
                part,
                factor: label.factor,
            };
            let one = Self::reading(name, unit, size_m, segment, value);
            list.push(one.identified(Identity::Wave(wave)));
        }
    }
}

/// What sines and cosines have in common: what stands before their order, unit and size of their amounts, and what they are
/// multiplied by.
#[derive(Clone, Copy, Debug)]
pub struct Label<'a> {
    text: &'a str,
    unit: &'static str,
    size_m: f64,
    factor: Factor,
}

impl<'a> From<(&'a str, &'static str, f64)> for Label<'a> {
    fn from((text, unit, size_m): (&'a str, &'static str, f64)) -> Self {
        (text, unit, size_m, Factor::Other).into()
    }
}

impl<'a> From<(&'a str, &'static str, f64, Factor)> for Label<'a> {
    fn from((text, unit, size_m, factor): (&'a str, &'static str, f64, Factor)) -> Self {
        Self {
            text,
            unit,
            size_m,
            factor,
        }
    }
}
