//! The sets of a design, weighed, with their names.

use super::alias::limit;
use super::decision::{Decision, Inclusion, decide};
use super::discrepancy::excess;
use super::explained::{Row, rows};
use super::held_out::refuted;
use super::hypotheses::LOG_WEIGHT_THAT_COUNTS;
use super::least_size::least_squares;
use super::noise_scale::{Left, log_sum};
use super::prior::{
    is_in_the_counts, is_of_lines, is_of_own_course, is_recurring, log_odds, prior,
};
use super::problem::{Prior, Problem};
use super::reduced::Reduced;
use super::sets::weigh;
use super::weighed::Weighed;
use crate::data::uniform_motion::is_uniform;
use crate::design::assembly::{BlockKind, Design};
use crate::design::unlisted::is_unlisted;
use crate::linearization::recording::LinearizedRecording;
use crate::trace::log;
use effects::Detection;
use std::collections::{BTreeSet, HashMap};

/// An effect of the answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Its name.
    pub name: String,
    /// Probability that it acts, or one of those that would do in its place, in a set that explains the gap.
    pub probability: f64,
    /// Whitened squares over the noise that it does; none where it is not fitted.
    pub power: Option<f64>,
    /// What would do in its place.
    pub aliases: Vec<String>,
    /// What parts it from those.
    pub break_alias: Option<String>,
}

impl Effect {
    /// What is found directly: samples that a repair, or a comparison with their neighbours, shows.
    pub fn directly(name: &str) -> Self {
        Self {
            name: name.into(),
            probability: 1.0,
            power: None,
            aliases: Vec::new(),
            break_alias: None,
        }
    }
}

/// Sets that held-out pieces may veto, one after the other. A bound on the work: where so many were vetoed, nothing is told but
/// what needs no effect.
const VETOES: usize = 40;
/// Sets in which held-out pieces refute an effect from which on no set holds it. A bound on the work: beside so many others it is
/// not seen, and each further set costs as much.
const REFUTED: usize = 8;
/// Sets that are told. A bound on the work: of what is printed alone; all sets are weighed.
const TOLD: usize = 20;

/// The sets of a design.
pub struct Weighing {
    reduced: Reduced,
    stated: f64,
    names: Vec<String>,
    effects: Vec<Prior>,
    coordinates: Vec<usize>,
    of_lines: Vec<usize>,
    of_own_course: Vec<usize>,
    recurring: Vec<usize>,
    in_the_counts: Vec<usize>,
    weighed: Vec<Weighed>,
    /// Single effects, the one that leaves least by the stated noise first.
    alone: Vec<usize>,
}

impl Weighing {
    /// Weighs the sets of a design.
    pub fn of(design: &Design) -> Self {
        let mut out = Self::before(design);
        out.weighed = weigh(&out.problem());
        out.alone = alone(&out.weighed);
        out.put_first_what_is_told(design);
        out
    }

    /// What is asked of a design, before any set is weighed.
    pub(super) fn before(design: &Design) -> Self {
        let blocks: Vec<usize> = (1..design.columns.blocks.len()).collect();
        let reduced = Reduced::new(
            &design.gram,
            &design.errors_in_variables,
            &design.columns,
            &blocks,
        )
        .in_own_axes();
        // A cause that is in no catalogue competes as one that is: it is fitted about itself, and what it explains is not told of others.
        let unlisted = |k: &usize| is_unlisted(&design.columns.blocks[blocks[*k]].name);
        let effect = |k: &usize| matches!(design.kinds[*k], BlockKind::Effect(_)) || unlisted(k);
        let (effects, coordinates): (Vec<usize>, _) = (0..blocks.len()).partition(effect);
        let names: Vec<String> = blocks
            .iter()
            .map(|b| design.columns.blocks[*b].name.clone())
            .collect();
        Self {
            stated: floor(design),
            reduced,
            effects: effects
                .into_iter()
                .map(|b| prior(&names[b], b, &design.linearized))
                .collect(),
            coordinates,
            of_lines: of_lines(&names, &design.linearized),
            of_own_course: (0..names.len())
                .filter(|b| is_of_own_course(&names[*b], &design.linearized))
                .collect(),
            recurring: (0..names.len())
                .filter(|b| is_recurring(&names[*b], &design.linearized.inputs))
                .collect(),
            in_the_counts: (0..names.len())
                .filter(|b| is_in_the_counts(&names[*b], &design.linearized))
                .collect(),
            names,
            weighed: Vec::new(),
            alone: Vec::new(),
        }
    }

    /// The set that is told comes first: nameless shapes that are likelier give way to causes that predict the same, and a set that
    /// held-out pieces do not confirm is none.
    fn put_first_what_is_told(&mut self, design: &Design) {
        let mut validation = design.cross_validation();
        let mut refutations: HashMap<usize, usize> = HashMap::new();
        for _ in 0..VETOES {
            let told = self.decide(true).first;
            let set = &self.weighed[told];
            let noise = self.stated * set.left.log_noise.exp();
            let Some(effect) = refuted(&mut validation, set, noise) else {
                self.weighed[..=told].rotate_right(1);
                return;
            };
            let names: Vec<&String> = set.set().iter().map(|b| &self.names[*b]).collect();
            log(&format!(
                "held-out pieces refute {} in {names:?}",
                self.names[effect]
            ));
            self.weighed.remove(told);
            let times = refutations.entry(effect).or_default();
            *times += 1;
            if *times == REFUTED {
                self.weighed.retain(|w| !w.set().contains(&effect));
            }
        }
        // None of so many was confirmed: nothing is told but what needs no effect.
        self.weighed.retain(|w| w.set().is_empty());
    }

    /// Names of its blocks.
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    pub(super) fn problem(&self) -> Problem<'_> {
        Problem {
            reduced: &self.reduced,
            stated: self.stated,
            noise: self.stated,
            effects: &self.effects,
            coordinates: &self.coordinates,
            of_lines: &self.of_lines,
            of_own_course: &self.of_own_course,
            recurring: &self.recurring,
            in_the_counts: &self.in_the_counts,
            along: &self.names,
            log_odds: log_odds(),
        }
    }

    /// Decides.
    pub fn decide(&self, noise_is_white: bool) -> Decision {
        decide(&self.problem(), &self.weighed, noise_is_white)
    }

    /// Names of the effects of the likeliest set.
    pub fn found(&self) -> Vec<String> {
        let best = self.weighed.first().map_or(&[][..], Weighed::set);
        best.iter().map(|b| self.names[*b].clone()).collect()
    }

    /// Names of the blocks of all sets that count beside the likeliest, and of the shapes beside them.
    pub fn counting(&self) -> BTreeSet<String> {
        let weight = |w: &Weighed| w.log_weight(log_odds());
        let weights = self.weighed.iter().map(weight);
        let least = weights.fold(f64::NEG_INFINITY, f64::max) + LOG_WEIGHT_THAT_COUNTS;
        let counting = self.weighed.iter().filter(|w| weight(w) > least);
        let blocks = counting.flat_map(|w| {
            let shapes = w
                .nameless
                .iter()
                .flat_map(|(shapes, _)| &shapes.coordinates);
            let shapes = shapes.map(|c| self.coordinates[*c]);
            w.set().iter().copied().chain(shapes)
        });
        let told = self.found();
        blocks.map(|b| self.names[b].clone()).chain(told).collect()
    }

    /// Names of so many effects of which each alone leaves least to first order.
    pub fn largest_alone(&self, count: usize) -> impl Iterator<Item = &str> {
        self.alone
            .iter()
            .take(count)
            .map(|b| self.names[*b].as_str())
    }

    /// Names of those effects of the likeliest set that do more than the forms of the others may lack, the one that does most first; of all
    /// where none does.
    pub fn leading(&self) -> Vec<String> {
        let Some(best) = self.weighed.first() else {
            return Vec::new();
        };
        let mut each: Vec<(f64, usize)> = best
            .powers
            .iter()
            .copied()
            .zip(best.set().iter().copied())
            .collect();
        let leads = |k: usize| {
            best.shares
                .get(k)
                .is_none_or(|s| s.power > s.may_be_lacking)
        };
        if (0..each.len()).any(leads) {
            let mut place = 0..;
            each.retain(|_| place.next().is_some_and(leads));
        }
        each.sort_by(|a, b| b.0.total_cmp(&a.0));
        each.into_iter()
            .map(|(_, b)| self.names[b].clone())
            .collect()
    }

    /// True where the likeliest set is one effect, beside which there is nothing but noise near the stated one.
    pub fn one_explains_all(&self) -> bool {
        self.weighed.first().is_some_and(|best| {
            let closed = best.closed(log_odds());
            let open = best.open(log_odds());
            best.set().len() == 1 && closed[0] > closed[1].max(open[0]).max(open[1])
        })
    }

    /// Logarithm of the evidence of the whole comparison if the forms of all effects lack nothing.
    pub fn log_evidence_of_forms(&self) -> f64 {
        let each = self.weighed.iter();
        log_sum(each.map(|w| w.log_weight_of_forms(log_odds())))
    }

    /// True where the likeliest set has fewer effects than another comparison's, by the same noise, and leaves no more than chance makes of what
    /// either predicts (9): then it is the same with fewer causes.
    pub fn does_with_fewer(&self, other: &Self) -> bool {
        let (Some(own), Some(of)) = (self.weighed.first(), other.weighed.first()) else {
            return false;
        };
        let fewer = !own.set().is_empty() && own.set().len() < of.set().len();
        fewer && own.listed && self.leaves_as_little(other, &of.left, 0.0)
    }

    /// True where the likeliest set is another comparison's, and does without the nameless shapes that are likely beside it there: shapes are no
    /// cause, and give way where it leaves no more than chance and what its effects' forms may lack make of what they predict (9).
    pub fn does_without_shapes(&self, other: &Self) -> bool {
        let (Some(own), Some(of)) = (self.weighed.first(), other.weighed.first()) else {
            return false;
        };
        let [closed, open] = [of.closed(log_odds()), of.open(log_odds())].map(|w| w[0].max(w[1]));
        let shapes = of.nameless.as_ref().filter(|_| open > closed);
        let same = !own.set().is_empty() && own.listed && self.found() == other.found();
        same && shapes.is_some_and(|(shapes, _)| {
            self.leaves_as_little(other, &shapes.left, own.lacking)
                && !other.leaves_as_little(other, &shapes.left, of.lacking)
        })
    }

    /// True where the likeliest set leaves no more squares than something else leaves in another comparison, by the same noise, but for what
    /// chance and forms that may lack so much make of what either predicts (9).
    fn leaves_as_little(&self, other: &Self, left: &Left, lacking: f64) -> bool {
        let own = &self.weighed[0].left;
        let same_noise = own.log_noise == left.log_noise && self.stated == other.stated;
        let more = (own.squares - left.squares) * (-own.log_noise).exp();
        let told =
            |of: &Self, left: &Left| of.reduced.rows - of.reduced.baseline as f64 - left.degrees;
        same_noise && more <= limit(told(self, own) + told(other, left)) + lacking
    }

    /// Names of the effects of the best set without each of them in turn, then of so many other sets, the likeliest first. None twice.
    pub fn rivals(&self, count: usize) -> Vec<Vec<String>> {
        let best = self.weighed.first().map_or(&[][..], Weighed::set);
        let without = |k: usize| [&best[..k], &best[k + 1..]].concat();
        let parts = (0..best.len()).map(without).filter(|part| !part.is_empty());
        let mut out: Vec<Vec<usize>> = parts.collect();
        let others = self.weighed.iter().filter(|w| w.listed).map(|w| w.set());
        let others = others.filter(|set| !set.is_empty() && *set != best);
        let more = out.len() + count;
        for set in others {
            if out.len() == more {
                break;
            }
            if !out.iter().any(|one| one == set) {
                out.push(set.to_vec());
            }
        }
        let names = |set: Vec<usize>| set.iter().map(|b| self.names[*b].clone()).collect();
        out.into_iter().map(names).collect()
    }

    /// True where the likeliest set leaves no more beyond the noise than is worth a name: no form of its effects lacks anything.
    fn leaves_nothing(&self) -> bool {
        let least = least_squares(self.reduced.rows);
        let best = self.weighed.first();
        best.is_some_and(|best| excess(&best.left) < least)
    }

    /// True where one effect explains all and leaves nothing but noise: of that no more is asked.
    pub fn one_leaves_nothing(&self) -> bool {
        self.one_explains_all() && self.leaves_nothing()
    }

    /// The likeliest sets, with what each explains of data that it has not seen. Cost: twenty cross-validations.
    pub fn explained(&self, design: &Design) -> Vec<Row> {
        let mut validation = design.cross_validation();
        // The baseline is block 0 of the design and none here.
        let held_out = |set: &[usize]| {
            let blocks: Vec<usize> = set.iter().map(|b| b + 1).collect();
            validation.score(&blocks).squares
        };
        let told = &self.weighed[..self.weighed.len().min(TOLD)];
        rows(&self.problem(), told, &self.names, held_out)
    }

    /// Coordinates that hold what the best set leaves.
    pub fn places(&self, decision: &Decision) -> Vec<(String, f64)> {
        let each = decision.places.iter();
        each.map(|(b, share)| (self.names[*b].clone(), *share))
            .collect()
    }

    /// An effect of a decision, by name.
    pub fn effect(&self, inclusion: &Inclusion) -> Effect {
        let name = |b: usize| self.names[b].clone();
        let own = inclusion
            .block
            .map_or_else(|| effects::name_of(Detection::AsNoise).into(), name);
        let aliases: Vec<String> = inclusion.aliases.iter().map(|b| name(*b)).collect();
        Effect {
            break_alias: parting(&own, &aliases),
            probability: inclusion.probability,
            power: Some(inclusion.power),
            name: own,
            aliases,
        }
    }
}

/// Blocks of lines in the spectrum. Where every segment goes with the clock, what follows the motion has lines as well, and none is told from
/// what the form of an effect lacks.
fn of_lines(names: &[String], linearized: &LinearizedRecording) -> Vec<usize> {
    let o = linearized.observations;
    let mut segments = (0..4).filter(|s| linearized.scope.segments[*s]);
    let of_lines = (0..names.len()).filter(|b| is_of_lines(&names[*b]));
    let of_lines: Vec<usize> = of_lines.collect();
    let as_a_clock =
        |s: usize| is_uniform(&o.stretch, &o.t_s, &linearized.calibrated_m[s], o.pitch_m);
    if !of_lines.is_empty() && segments.all(as_a_clock) {
        return Vec::new();
    }
    of_lines
}

/// Variance of the whitened residuals by the noise that the design is whitened by: as it is simulated where that is the stated one. Noise
/// that was measured is white, and rounding is next to nothing beside it.
pub fn floor(design: &Design) -> f64 {
    if design.linearized.is_by_stated_noise() {
        design.floor.white_square
    } else {
        1.0
    }
}

/// Blocks of the effects that were weighed alone by the stated noise, the one that leaves least first.
fn alone(weighed: &[Weighed]) -> Vec<usize> {
    let one = |w: &&Weighed| w.set().len() == 1 && w.left.log_noise == 0.0;
    let mut each: Vec<(f64, usize)> = weighed
        .iter()
        .filter(one)
        .map(|w| (w.left.squares, w.set()[0]))
        .collect();
    each.sort_by(|a, b| a.0.total_cmp(&b.0));
    each.into_iter().map(|(_, b)| b).collect()
}

/// The motion that parts an effect from those that would do in its place: what the cards say of the pair, or else the motion that tells
/// the effect.
fn parting(name: &str, aliases: &[String]) -> Option<String> {
    let first = aliases.first()?;
    let of = |one: &str, other: &str| {
        let all = effects::card(one)?.confusable.iter();
        let pair = all.clone().find(|pair| pair.with == other);
        pair.map(|pair| pair.parted_by.to_owned())
    };
    of(name, first)
        .or_else(|| of(first, name))
        .or_else(|| effects::telling_motion(name).map(Into::into))
}
