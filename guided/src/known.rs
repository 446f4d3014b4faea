//! What is determined by what was recorded, with its predicted deviation, and what is not.
//!
//! An amount has a prior deviation and the recording has noise, so what a recording will tell of it follows from the products of columns
//! alone, before the readings are asked. An effect is answered where, beside the baseline and beside any one rival in the catalogue, its
//! amounts would be known to a small part of their prior deviations, and its gap would not be explained by the rival. Both limits are the
//! diagnosis' own.

use crate::given::Given;
use crate::products::Totals;
use crate::question::Question;
use diagnosis::design::excitation::Excitation;
use diagnosis::figures::limits::{MINIMUM_SQUARES, UNEXPLAINED_SHARE};
use effects::effect::{Card, Nature};
use effects::sensor::SLOWEST_LINE_HZ;
use effects::{Detection, card};
use serde::Serialize;
use std::ops::Range;

/// A group of unknowns that is asked for.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// Its name.
    pub name: String,
    /// Its columns.
    pub columns: Vec<usize>,
    /// Of an effect: what is known of it.
    pub card: Option<&'static Card>,
    /// Deviation that is wanted of calibration terms, m.
    pub wanted_m: f64,
    /// How it is told.
    pub told_by: ToldBy,
    /// Rivals that no motion parts it from.
    pub inseparable: Vec<String>,
}

/// How a group is told.
#[derive(Clone, Debug)]
pub(crate) enum ToldBy {
    /// By its columns, beside the baseline, and beside each rival as well.
    Columns(Vec<Beside>),
    /// By going over the whole area: nothing shows it before it is there.
    Cover,
    /// By time with the beacon in sight: its frequencies are not known before.
    Sight,
    /// By nothing within reach.
    Nothing,
}

/// Columns that are to be told beside others.
#[derive(Clone, Debug)]
pub(crate) struct Beside {
    /// The rival; none: the baseline alone.
    pub rival: Option<String>,
    /// Columns that can be told there by enough motion.
    pub own: Vec<usize>,
    /// The baseline's columns and the rival's.
    pub others: Vec<usize>,
    /// Share of its squares that the forms of both may lack: no more than that left tells the two apart.
    pub lacking: f64,
}

/// How well one group is known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Known {
    /// The effect, or the calibration's part.
    pub name: String,
    /// Predicted deviation of an amount, rms over the group, beside the baseline and the closest rival, m; none where the motions cannot
    /// show it in columns, and their cover counts.
    pub deviation_m: Option<f64>,
    /// What such an amount of an effect is expected to be, rms, m.
    pub expected_m: Option<f64>,
    /// What the closest rival would leave of its gap, as a share of the square; 1 without a rival.
    pub told_apart: f64,
    /// That rival.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rival: Option<String>,
    /// Rivals that no motion of this courier parts it from.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inseparable: Vec<String>,
    /// True where nothing within reach shows it.
    pub is_beyond_reach: bool,
    /// How far it is: 1 is determined.
    pub progress: f64,
}

impl Known {
    /// True where nothing more is wanted.
    #[must_use]
    pub fn is_determined(&self) -> bool {
        self.progress >= 1.0
    }
}

/// What was made of the area and the beacon, where that is what counts: 1 is all.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    /// See [`crate::cover::covered`].
    pub cover: f64,
    /// Time with the beacon in sight over [`SIGHT_S`].
    pub sight: f64,
}

/// Time with the beacon in sight by which lines of its vibration are told, s. Derived from ten periods of the slowest that the
/// catalogue knows.
pub(crate) const SIGHT_S: f64 = 10.0 / SLOWEST_LINE_HZ;
/// A column that all motions together, made many times, leave with more than this share of its prior variance is told by none.
const TOLD_BY_NONE: f64 = 0.5;

/// Resolution that calibration terms are wanted to, m: one part in five thousand of a pitch (the paper, section 1).
const RESOLUTION_M: f64 = 0.2e-6;
/// Deviation that the coordination sensor's lengths are wanted to, m (the paper, section 3.2.1).
const LENGTHS_M: f64 = 20.0e-6;

/// What is asked, as groups of columns: those of which the recording or a path shows something, and those that have no columns.
pub(crate) fn groups(question: Question, excitation: &Excitation) -> Vec<Group> {
    let effect = |card: &'static Card| {
        let columns = block(excitation, card.name).map_or(Vec::new(), Iterator::collect);
        Group {
            name: card.name.into(),
            columns,
            card: Some(card),
            wanted_m: 0.0,
            told_by: ToldBy::Nothing,
            inseparable: Vec::new(),
        }
    };
    match question {
        Question::Effect(name) => card(name).map(effect).into_iter().collect(),
        Question::All => effects::cards().map(effect).collect(),
        Question::Platen => segments(excitation),
        Question::Joint => {
            let mut list = segments(excitation);
            list.push(lateral(excitation));
            list.push(lengths(excitation));
            list
        }
    }
}

/// Columns of a block.
pub(crate) fn block(excitation: &Excitation, name: &str) -> Option<Range<usize>> {
    let found = excitation.blocks.iter().find(|block| block.name == name);
    found.map(|block| block.columns.clone())
}

/// Equation (3) of each segment, but for its constant.
fn segments(excitation: &Excitation) -> Vec<Group> {
    let own = |segment: usize| {
        let ends = format!(", segment {segment}");
        baseline(excitation, |name| {
            name.starts_with("order ") && name.ends_with(&ends)
        })
    };
    let group = |segment: usize| Group {
        name: format!("segment {segment}, equation (3)"),
        columns: own(segment),
        card: None,
        wanted_m: RESOLUTION_M,
        told_by: ToldBy::Nothing,
        inseparable: Vec::new(),
    };
    (1..=4).map(group).collect()
}

/// Equation (9)'s terms: those of the catalogue that follow the phase across a segment.
fn lateral(excitation: &Excitation) -> Group {
    let followers =
        effects::cards().filter(|card| card.follows == effects::effect::Quantity::AcrossPhase);
    let columns = followers
        .filter_map(|card| block(excitation, card.name))
        .flatten();
    Group {
        name: "terms across a segment, equation (9)".into(),
        columns: columns.collect(),
        card: None,
        wanted_m: RESOLUTION_M,
        told_by: ToldBy::Nothing,
        inseparable: Vec::new(),
    }
}

/// Height and lever arms.
fn lengths(excitation: &Excitation) -> Group {
    Group {
        name: "coordination sensor's height and lever arm".into(),
        columns: baseline(excitation, |name| {
            name.starts_with("height") || name.starts_with("lever")
        }),
        card: None,
        wanted_m: LENGTHS_M,
        told_by: ToldBy::Nothing,
        inseparable: Vec::new(),
    }
}

fn baseline(excitation: &Excitation, wanted: impl Fn(&str) -> bool) -> Vec<usize> {
    let all = excitation
        .blocks
        .first()
        .map_or(0..0, |block| block.columns.clone());
    all.filter(|c| wanted(&excitation.names[*c])).collect()
}

/// Groups that may be named in the place of an effect: those that a diagnosis would not rather leave out.
pub(crate) fn rivals(excitation: &Excitation, card: &Card) -> Vec<(String, Vec<usize>)> {
    let rank = |nature: Nature| match nature {
        Nature::Cause => 0,
        Nature::Flexible => 1,
        Nature::Shape => 2,
    };
    let others = excitation.blocks.iter().skip(1).filter(|block| {
        let other = effects::card(&block.name);
        block.name != card.name
            && other.is_some_and(|other| rank(other.nature) <= rank(card.nature))
    });
    others
        .map(|block| (block.name.clone(), block.columns.clone().collect()))
        .collect()
}

/// Share of its squares that an effect's form may lack.
fn lacking_share(card: &Card) -> f64 {
    effects::inexactness(card.name).powi(2)
}

impl Group {
    /// Finds out how it is told, by what all motions together would show. `all` are their products.
    /// Calibration terms are told beside all others that are `asked` for.
    pub fn look(&mut self, excitation: &Excitation, all: &Totals, asked: &[usize]) {
        let baseline: Vec<usize> = excitation.blocks[0].columns.clone().collect();
        let Some(card) = self.card else {
            let more = asked.iter().filter(|c| !baseline.contains(c));
            let others = baseline.iter().chain(more).copied();
            let others = others.filter(|c| !self.columns.contains(c));
            let beside = Beside {
                rival: None,
                own: self.columns.clone(),
                others: others.collect(),
                lacking: 0.0,
            };
            if !self.columns.is_empty() {
                self.told_by = ToldBy::Columns(vec![beside]);
            }
            return;
        };
        self.told_by = match card.detection {
            _ if !card.is_answerable(&excitation.inputs) => ToldBy::Nothing,
            Detection::ByLines => ToldBy::Sight,
            Detection::ByFit if !card.by_amplitude && !self.columns.is_empty() => {
                self.beside_rivals(excitation, all, card, &baseline)
            }
            _ => ToldBy::Cover,
        };
    }

    fn beside_rivals(
        &mut self,
        excitation: &Excitation,
        all: &Totals,
        card: &Card,
        baseline: &[usize],
    ) -> ToldBy {
        let beside = |rival: Option<String>, columns: &[usize]| {
            let others = [baseline, columns].concat();
            let variances = all.given(&self.columns, &others).variances();
            let own = self.columns.iter().zip(variances);
            let own = own.filter(|(_, v)| *v < TOLD_BY_NONE).map(|(c, _)| *c);
            let forms = rival.as_deref().and_then(effects::card).into_iter();
            let lacks = forms.map(|rival| lacking_share(rival) + lacking_share(card));
            Beside {
                rival,
                own: own.collect(),
                others,
                lacking: lacks.sum(),
            }
        };
        let alone = beside(None, &[]);
        if alone.own.is_empty() {
            // Where not even many motions show it, what is recorded must show it by itself: a pair that wanders, a column that is logged.
            return ToldBy::Cover;
        }
        let mut list = vec![alone];
        for (name, columns) in rivals(excitation, card) {
            let pair = beside(Some(name.clone()), &columns);
            let together = all.given(&pair.own, &pair.others).squares();
            let alone = all.given(&pair.own, baseline).squares();
            if pair.own.is_empty() || together < pair.lacking * alone {
                self.inseparable.push(name);
            } else {
                list.push(pair);
            }
        }
        ToldBy::Columns(list)
    }

    /// What is not told by columns, by what was made.
    pub fn made(&self, seen: Seen) -> Option<f64> {
        match self.told_by {
            ToldBy::Columns(_) => None,
            ToldBy::Cover => Some(seen.cover.min(1.0)),
            ToldBy::Sight => Some(seen.sight.min(1.0)),
            ToldBy::Nothing => Some(0.0),
        }
    }

    /// True where no motion tells anything of it.
    pub fn is_beyond_reach(&self) -> bool {
        matches!(self.told_by, ToldBy::Nothing)
    }
}

/// How well a group is known by products, and by what was made.
pub(crate) fn known(group: &Group, excitation: &Excitation, totals: &Totals, seen: Seen) -> Known {
    let plain = Known {
        name: group.name.clone(),
        deviation_m: None,
        expected_m: None,
        told_apart: 1.0,
        rival: None,
        inseparable: group.inseparable.clone(),
        is_beyond_reach: group.is_beyond_reach(),
        progress: group.made(seen).unwrap_or_default(),
    };
    match &group.told_by {
        ToldBy::Columns(list) if group.card.is_some() => effect(plain, list, excitation, totals),
        ToldBy::Columns(list) => list.iter().fold(plain, |plain, beside| {
            terms(plain, group.wanted_m, beside, excitation, totals)
        }),
        _ => plain,
    }
}

fn terms(
    plain: Known,
    wanted_m: f64,
    beside: &Beside,
    excitation: &Excitation,
    totals: &Totals,
) -> Known {
    let variances = totals.given(&beside.own, &beside.others).variances();
    let own = beside.own.iter().map(|c| excitation.deviations[*c]);
    let deviations = own.zip(variances).map(|(prior, v)| v.sqrt() * prior);
    let worst_m = deviations.fold(0.0, f64::max);
    Known {
        deviation_m: Some(worst_m),
        progress: (wanted_m / worst_m.max(1.0e-12)).min(1.0),
        ..plain
    }
}

fn effect(plain: Known, list: &[Beside], excitation: &Excitation, totals: &Totals) -> Known {
    let baseline = &list[0].others;
    let judge = |beside: &Beside| {
        let alone = totals.given(&beside.own, baseline).squares();
        let together = totals.given(&beside.own, &beside.others);
        judged(&together, alone, beside.lacking)
    };
    let all = list.iter().map(|beside| (judge(beside), beside));
    let Some((worst, beside)) = all.min_by(|a, b| a.0.progress.total_cmp(&b.0.progress)) else {
        return plain;
    };
    let sizes = beside.own.iter().map(|c| excitation.sizes_m[*c].powi(2));
    let expected_m = (sizes.sum::<f64>() / beside.own.len() as f64).sqrt();
    Known {
        deviation_m: Some(worst.unknown.sqrt() * expected_m),
        expected_m: Some(expected_m),
        told_apart: worst.left,
        rival: beside.rival.clone(),
        progress: worst.progress,
        ..plain
    }
}

/// One rival's judgement.
struct Judged {
    /// Mean posterior variance over the prior's.
    unknown: f64,
    /// Share of the squares that is left.
    left: f64,
    progress: f64,
}

fn judged(beside: &Given, alone: f64, lacking: f64) -> Judged {
    let variances = beside.variances();
    let n = variances.len().max(1) as f64;
    let unknown = variances.iter().sum::<f64>() / n;
    let left_squares = beside.squares();
    let left = left_squares / alone.max(f64::MIN_POSITIVE);
    // Less than a tenth unexplained; squares beyond those that chance gives so many columns and those that the two forms may lack, which
    // is the diagnosis' rule for an alias.
    let wanted = MINIMUM_SQUARES + n + lacking * alone;
    let parts = [
        UNEXPLAINED_SHARE / unknown.max(1.0e-12),
        left_squares / wanted,
    ];
    Judged {
        unknown,
        left,
        progress: parts.into_iter().fold(1.0, f64::min),
    }
}
