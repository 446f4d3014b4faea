//! What an effect is to the rest of the project: both of its sides, and what is known of it as data.
//!
//! The simulator asks for the plant's side, the diagnosis for the sensor's side, and both for the [`Card`]. No code outside an
//! effect's own file compares names: it asks the card for a property. `xtask test` refuses names elsewhere.

use crate::plant::{PlantEffect, Scene};
use crate::random::ChaCha8Rng;
use crate::sensor::{BasisInputs, NestedForms, Regressor};

/// Everything about an effect. Its file holds one type that implements this.
pub trait Effect: Send + Sync {
    /// What is known of it.
    fn card(&self) -> &'static Card;

    /// Draws a realisation of the plant's side: `size_rms_m` is the rms of the main channel, m, over the motion that the file states.
    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect>;

    /// The same, but following a quantity that the machine logs ([`PlantEffect::logged`]); none of an effect that follows no such one.
    fn draw_logged(
        &self,
        _scene: &Scene,
        _rng: &mut ChaCha8Rng,
        _size_rms_m: f64,
    ) -> Option<Box<dyn PlantEffect>> {
        None
    }

    /// The sensor's side: what it could add to the readings of a recording that offers what [`Card::needs`] lists. Nothing for what
    /// is judged directly ([`Detection::is_fitted`]).
    fn shapes(&self, _survey: &BasisInputs) -> Vec<Regressor> {
        Vec::new()
    }

    /// What it could add to the readings of a recording; empty where the data cannot show it.
    fn regressors(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        if self.card().is_answerable(inputs) {
            self.shapes(inputs)
        } else {
            Vec::new()
        }
    }

    /// Its name.
    fn name(&self) -> &'static str {
        self.card().name
    }

    /// The coordinate that an amount acts over, in the words of the answer's `where`.
    fn coordinate(&self, _amount: &Regressor) -> String {
        self.card().coordinate.into()
    }

    /// What a segment brought along to a stretch from a way that is not recorded: another recording has another, so `check` fits it.
    fn brought_along(&self, _segment: usize, _stretch: usize) -> Option<Regressor> {
        None
    }
}

/// What is known of an effect, as data.
#[derive(Debug)]
pub struct Card {
    /// Name, as in the answers; also that of its file.
    pub name: &'static str,
    /// What it is, in one sentence without a full stop.
    pub summary: &'static str,
    /// Where the prior sizes of its amounts come from.
    pub sizes: &'static str,
    /// The motion that tells it from others; empty where none is needed, since it is seen in the samples themselves.
    pub telling_motion: &'static str,
    /// Which recordings that motion takes.
    pub recordings: Recordings,
    /// What a recording must offer.
    pub needs: &'static [Need],
    /// How it is found.
    pub detection: Detection,
    /// Where its unknowns stand among those of the others.
    pub order: ColumnOrder,
    /// The quantity that it follows.
    pub follows: Quantity,
    /// That quantity in the words of the answer's `where`.
    pub coordinate: &'static str,
    /// Where it acts along the chain from platen to counts.
    pub acts: Acts,
    /// What of it carries over to another recording of the same courier.
    pub transfer: Transfer,
    /// What of it carries over and what does not, in words.
    pub carries_over: &'static str,
    /// A cause, or a shape that may stand in for one.
    pub nature: Nature,
    /// Its harmonics may run over the phase of the unmodified output instead of the calibrated one.
    pub either_phase: bool,
    /// It may move all segments as one rigid body, as an error of the reference does.
    pub rigid: bool,
    /// Its output depends on the way there, and so on other samples than its own.
    pub remembers: bool,
    /// It is a pair's amplitude that shows it: what is beyond the amplitudes that were seen is not known.
    pub by_amplitude: bool,
    /// Forms that tell more of it, simplest first; asked for where the form before leaves a gap.
    pub forms: &'static [Form],
    /// Its form where it does more than amounts of its usual sizes could.
    pub far: Option<fn(&mut NestedForms)>,
    /// A fuller form that is also looked for where the simple one is not found.
    pub searched: Option<fn(&mut BasisInputs)>,
    /// What another effect is found for but is this one's own once this one is known.
    pub subsumes: &'static [Subsumption],
    /// What it is confused with, and what parts the two.
    pub confusable: &'static [Confusable],
    /// What a board takes over of it; empty: nothing.
    pub on_board: &'static str,
    /// What of it belongs to its own recording's time, in words; empty: nothing.
    pub its_own: &'static str,
    /// What must be told of it where another recording's counts tell it anew; empty: nothing.
    pub remark: &'static str,
}

impl Card {
    /// A plain cause: what a card says unless it says otherwise.
    pub const PLAIN: Self = Self {
        name: "",
        summary: "",
        sizes: "",
        telling_motion: "",
        recordings: Recordings::Usual,
        needs: &[],
        detection: Detection::ByFit,
        order: ColumnOrder::Usual,
        follows: Quantity::OwnPhase,
        coordinate: "",
        acts: Acts::Segment,
        transfer: Transfer::Whole,
        carries_over: "its amounts",
        nature: Nature::Cause,
        either_phase: false,
        rigid: false,
        remembers: false,
        by_amplitude: false,
        forms: &[],
        far: None,
        searched: None,
        subsumes: &[],
        confusable: &[],
        on_board: "",
        its_own: "",
        remark: "",
    };

    /// True if a recording offers what the effect needs.
    #[must_use]
    pub fn is_answerable(&self, inputs: &BasisInputs) -> bool {
        self.needs.iter().all(|need| need.is_met(inputs))
    }

    /// True for a shape without a cause.
    #[must_use]
    pub fn is_shape(&self) -> bool {
        self.nature == Nature::Shape
    }

    /// True if another recording has another course of it.
    #[must_use]
    pub fn keeps_its_own_time(&self) -> bool {
        self.transfer == Transfer::ItsOwnTime
    }

    /// True if it follows the board's temperature.
    #[must_use]
    pub fn follows_temperature(&self) -> bool {
        self.follows == Quantity::Temperature
    }
}

/// Which recordings tell an effect from others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recordings {
    /// The usual survey.
    Usual,
    /// One cold, one warm.
    ColdAndWarm,
    /// One now, one an hour later.
    NowAndLater,
    /// At places of the platen that lie apart.
    Apart,
    /// Turned to either side.
    Turned,
    /// Standing still at the full rate.
    Still,
}

/// What a recording must offer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A beacon in sight of the coordination sensor.
    Beacon,
    /// A temperature that changes.
    Temperature,
    /// Angles that change.
    Turning,
    /// Samples in motion.
    Moving,
    /// Places across a segment.
    Across,
    /// Pairs whose counts show it, or a logged column that changes.
    CountsOrLogged,
}

impl Need {
    /// True if a recording offers it.
    #[must_use]
    pub fn is_met(self, inputs: &BasisInputs) -> bool {
        match self {
            Self::Beacon => inputs.beacon,
            Self::Temperature => inputs.temperature,
            Self::Turning => inputs.turning,
            Self::Moving => inputs.moving,
            Self::Across => inputs.lateral,
            Self::CountsOrLogged => inputs.counts || !inputs.logged.is_empty(),
        }
    }

    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Beacon => "a beacon in sight",
            Self::Temperature => "a temperature that changes",
            Self::Turning => "angles that change",
            Self::Moving => "samples in motion",
            Self::Across => "segments along both axes, or a reference",
            Self::CountsOrLogged => "raw counts, or a logged column `aux_…` that changes",
        }
    }
}

/// How an effect is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detection {
    /// By a fit of its regressors among those of others.
    ByFit,
    /// The same; it is a field over the platen, of very many unknowns, and looked for where the teeth are passed often enough.
    AsField,
    /// The same, at the lines that stand in a spectrum.
    ByLines,
    /// By the figure that a pair's counts draw, before anything is fitted: a forward model of a saturating pair.
    ByRails,
    /// Directly: steps of whole teeth, which are repaired.
    AsSlips,
    /// Directly: samples that stand out far, which are left out.
    AsBursts,
    /// Directly: white noise.
    AsNoise,
}

impl Detection {
    /// True for what adds something to the readings that a fit can follow.
    #[must_use]
    pub fn is_fitted(self) -> bool {
        !matches!(self, Self::AsSlips | Self::AsBursts | Self::AsNoise)
    }

    /// True for what is taken out of the samples and leaves nothing to fit.
    #[must_use]
    pub fn is_taken_out(self) -> bool {
        matches!(self, Self::AsSlips | Self::AsBursts)
    }
}

/// Where an effect's unknowns stand among those of the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ColumnOrder {
    /// Before all: the others are told about it.
    First,
    /// In the order of the catalogue.
    Usual,
    /// Behind all: it has the most.
    Last,
}

/// A quantity that an effect follows. Fuller forms are tried in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Speed.
    Speed,
    /// The way there: direction of travel and what is remembered of it.
    Way,
    /// The board's temperature.
    Temperature,
    /// The courier's angle.
    Angle,
    /// Tooth phase across a segment.
    AcrossPhase,
    /// The own tooth phase.
    OwnPhase,
    /// Place on the platen.
    PlaceOnPlaten,
    /// Deflection of the coordination sensor.
    Deflection,
    /// A pair's amplitude.
    Amplitude,
    /// Time.
    Time,
    /// Nothing: each sample by itself.
    Nothing,
}

/// Where an effect acts along the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// It moves what a segment reads.
    Segment,
    /// It moves the teeth and not the segments: over its teeth a segment is where its reading says.
    Teeth,
    /// On the pair, before equation (3).
    Electronics,
}

/// What carries over to another recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// All amounts.
    Whole,
    /// Frequencies and levels; the phases are fitted anew.
    Rephased,
    /// Nothing but what the other recording's own counts show: its course is another one.
    ItsOwnTime,
    /// Nothing: it is found anew in each recording.
    Anew,
}

/// A cause, or a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nature {
    /// A cause.
    Cause,
    /// A cause with so many unknowns that a simpler shape which does nearly as well is to be believed instead.
    Flexible,
    /// A shape, named only where no cause explains the gap better.
    Shape,
}

/// A fuller form of an effect.
#[derive(Debug)]
pub struct Form {
    /// What is told more.
    pub tells: &'static str,
    /// Asks for it.
    pub tell: fn(&mut NestedForms),
    /// What the effect is found as while no more is told of it; none: as itself.
    pub found_as: Option<&'static str>,
    /// What stands in beside the effect for what the form tells.
    pub completed_by: Option<&'static str>,
    /// The simple form may leave most of the gap.
    pub far_from_it: bool,
    /// How much less it must leave.
    pub cost: Cost,
}

impl Form {
    /// A form of an effect that is found as itself, and leaves little.
    #[must_use]
    pub const fn new(tells: &'static str, tell: fn(&mut NestedForms)) -> Self {
        Self {
            tells,
            tell,
            found_as: None,
            completed_by: None,
            far_from_it: false,
            cost: Cost::Many,
        }
    }
}

/// How much less a fuller form must leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// It has many unknowns: much less.
    Many,
    /// It has a few: less.
    Few,
    /// It stands in the place of two effects: no more than these.
    OneForTwo,
}

/// Another effect is found for what is this one's own.
#[derive(Debug)]
pub struct Subsumption {
    /// The other one.
    pub other: &'static str,
    /// What this one holds besides; of several, the one that leaves least.
    pub tell: &'static [fn(&mut BasisInputs)],
    /// How the other is known to be that.
    pub known_by: KnownBy,
}

/// How another effect is known to be what this one holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KnownBy {
    /// This one leaves no more without it.
    Fit,
    /// A ruling's pitch is what its growth makes of another temperature, by which it is right.
    Growth {
        /// How far off the mean temperature a ruling may be right, K.
        within_k: f64,
    },
    /// Harmonics are what an offset that changes with the amplitude makes of equation (3)'s.
    MixedHarmonics,
}

/// Another effect that looks alike.
#[derive(Debug)]
pub struct Confusable {
    /// The other one.
    pub with: &'static str,
    /// What both do alike, and the motion that parts them.
    pub parted_by: &'static str,
}
