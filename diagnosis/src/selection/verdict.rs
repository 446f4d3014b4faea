//! The verdict: what is seen, what is named, and what is left.

use super::ModelSelection;
use super::bursts::{BURST_SHARE, Bursts, Left};
use super::location::Located;
use super::lost_signals;
use super::named::slips_named;
use super::nameless_correction::NamelessCorrection;
use crate::design::assembly::BlockKind;
use crate::inference::cross_validation::CrossValidation;
use crate::inference::fit_scatter;
use crate::inference::posterior::birge_ratio;
use crate::linearization::relinearized::RelinearizedFit;
use crate::link::state_probabilities;
use crate::selection::limits::{LARGEST_PRIOR_SIZES, MINIMUM_SQUARES};
use crate::selection::limits::{NOISY_RATIO, STAYS_VISIBLE, UNEXPLAINED_SHARE, VISIBLE_GAP_RATIO};
use crate::selection::search::{SearchResult, stands_out};
use crate::selection::worth::unexplained_fraction;
use crate::trace::log;
use crate::verdict::answer::{Diagnosis, Named, Share, Verdict};
use effects::{Card, Detection};

/// All channels this far above the stated noise, and alike: the statement may be what is wrong.
const MISSTATED_RATIO: f64 = 4.0;
/// An effect is named rather than told as an alias if it has this weight among all that would do in its place: odds of 7 to 3. A prior.
const OWN_WEIGHT_OF_A_NAME: f64 = 0.7;
/// A set of causes that leaves more than this is no explanation.
const NO_EXPLANATION_ABOVE: f64 = 0.5;
/// Nor is one that leaves more than this, where that would be a gap by itself.
const PARTIAL_EXPLANATION_ABOVE: f64 = 0.3;
/// A remainder is located if some shape takes this share of it.
const LOCATED_SHARE: f64 = 0.15;
/// Share of a noise that had to be found which shapes may take by chance.
const CHANCE_SHARE_OF_NOISE: f64 = 0.03;
/// Noise is told beside shapes if it is this share of the whole gap: less may be what they lack,
const NOISE_BESIDE_SHAPES: f64 = 0.05;
/// or if it is so many times the stated one, and nothing that is found lacks as much of its own form;
const LOUD_NOISE_RATIO: f64 = 1.5;
/// and beside one that wanders, what is too fast for its course.
const NOISE_BESIDE_A_COURSE: f64 = 0.10;
/// Effects imitate a nameless shape if they leave this share of the gap,
const IMITATION_LEAVES: f64 = 0.01;
/// the shape takes this share of that,
const FOREIGN_SHAPE_SHARE: f64 = 0.5;
/// and leaves no more than this of the whole by itself.
const SHAPE_ALONE_LEAVES: f64 = 0.3;

/// What was measured, before it is weighed.
pub(super) struct Measurements {
    pub(super) white_before: f64,
    pub(super) white_after: f64,
    /// Whitened squares beyond the noise without any effect, as the search sees them.
    pub(super) whole_gap: f64,
    /// The same by the stated noise.
    pub(super) shaped: f64,
    /// That with excess noise and bursts.
    pub(super) total: f64,
    pub(super) bursts: Bursts,
    /// Share of `whole_gap` that is left.
    pub(super) left: f64,
    pub(super) located: Vec<Located>,
    gap: bool,
    pub(super) structured: bool,
    /// What is left is white noise above the stated level.
    noisy: bool,
}

impl ModelSelection<'_> {
    /// The answer, and a correction without a name, where nothing is named.
    pub(super) fn answer(&self, name: &str) -> (Diagnosis, Option<NamelessCorrection>) {
        let mut validation = self.design.cross_validation();
        let seen = self.measure(&mut validation);
        let mut out = Diagnosis {
            schema: 1,
            recording: name.into(),
            notes: self.prepared.notes.clone(),
            ..Diagnosis::default()
        };
        let mut effects = self.effects(&mut validation, &seen);
        out.notes.extend(self.doubt_the_reference(&mut effects));
        let unnamed = self.withheld(&seen);
        let reason = self.objection(&mut validation, &seen);
        let left_over = reason.is_some() || unnamed;
        if let Some(reason) = reason {
            log(&format!("objection: {reason}"));
        }
        let visible = seen.gap || !self.prepared.slips.is_empty() || !effects.is_empty();
        out.verdict = if let Some(limit) = self.too_quiet(seen.white_before, seen.white_after) {
            out.notes.push(limit);
            Verdict::InsufficientData
        } else if !visible {
            Verdict::NoGap
        } else if left_over || effects.is_empty() {
            if effects.is_empty() && !left_over && seen.white_before < NOISY_RATIO {
                Verdict::NoGap
            } else {
                Verdict::Unknown
            }
        } else if effects
            .iter()
            .any(|e| !e.aliases.is_empty() && e.rivals.own_weight() < OWN_WEIGHT_OF_A_NAME)
        {
            Verdict::Alias
        } else {
            Verdict::Named
        };
        if seen.noisy && (seen.white_after > MISSTATED_RATIO || self.misstated()) {
            out.notes.push(format!(
                "stated noise: what is left scatters as noise does, by {:.1} times what is stated, at most {MISSTATED_RATIO} wanted: it may be the statement that is wrong",
                seen.white_after
            ));
        }
        if out.verdict != Verdict::InsufficientData {
            out.notes.extend(self.quiet_channel());
        }
        if !matches!(out.verdict, Verdict::Named | Verdict::Alias) {
            effects.clear();
        }
        effects.sort_by(|a, b| b.share.total_cmp(&a.share));
        out.notes.extend(self.shared_with_the_reference(&effects));
        out.effects = effects;
        let correction = self.fill(&mut out, &mut validation, seen);
        if unnamed && (self.slipped() || out.place.is_empty()) {
            let channel = self.main_channel().into();
            let over_time = Share {
                channel,
                coordinate: "time".into(),
                share: 1.0,
            };
            out.place.insert(0, over_time);
        }
        out.without_signal.clone_from(&self.prepared.without_signal);
        let mut out = lost_signals::located(out, self.design.linearized.scope.reference);
        state_probabilities(&mut out);
        (out, correction)
    }

    /// What speaks against naming what was found.
    fn objection(
        &self,
        validation: &mut CrossValidation,
        seen: &Measurements,
    ) -> Option<&'static str> {
        let located = self.is_located(seen);
        if !self.is_small(&self.after) {
            return Some("what is left is larger than an error of the sensor");
        }
        if seen.structured && self.holds_the_noise() {
            return Some("less than the noise is left");
        }
        if !seen.structured {
            let unexplained = located || self.hides_bursts(seen);
            return (seen.gap && unexplained).then_some("a gap that nothing explains");
        }
        if of_no_size(&self.relinearized) {
            return Some("amounts far beyond any physical size");
        }
        let much = if self.stays_visible(seen) {
            PARTIAL_EXPLANATION_ABOVE
        } else {
            NO_EXPLANATION_ABOVE
        };
        if located && seen.left > UNEXPLAINED_SHARE || seen.left > much {
            Some("much is left")
        } else if self.shapes_do_better(validation, seen) {
            Some("shapes without a name do better")
        } else if self.stays_visible(seen) && self.imitates(validation, seen) {
            Some("a shape without a name takes what is left")
        } else if self.errs_together() {
            Some("readings over different teeth err together")
        } else if self.of_the_reference() || self.at_the_reference(validation) {
            Some("it moves the segments as the reference would")
        } else {
            None
        }
    }

    pub(super) fn measure(&self, validation: &mut CrossValidation) -> Measurements {
        let floor = self.floor.white_square.sqrt();
        let white_before = self.before.white_rms() / floor;
        let white_after = self.ratio();
        let stated = validation.rows() * self.floor.white_square;
        let bursts = self.bursts();
        log(&format!(
            "bursts: {} samples, {:.0} squares",
            bursts.count, bursts.energy
        ));
        // Few samples scatter more: four standard deviations of an rms over these rows.
        let chance = 4.0 / (2.0 * validation.rows()).sqrt();
        let own = self.scatter_of_a_fit(validation, &[]);
        let most = (VISIBLE_GAP_RATIO + chance).powi(2) * stated + own;
        let gap = white_before.powi(2) * stated > most
            || stands_out(validation, self.selected.base + own);
        let structured = gap && !self.selected.found.blocks.is_empty();
        let left = match (gap, structured) {
            (true, true) => self.left(),
            (true, false) => 1.0,
            _ => 0.0,
        };
        let of_found = if structured {
            &self.selected.found.blocks[..]
        } else {
            &[]
        };
        let most =
            (NOISY_RATIO + chance).powi(2) * stated + self.scatter_of_a_fit(validation, of_found);
        let noisy = white_after.powi(2) * stated > most
            && self.rough(&self.after)
            && self.is_noise(&self.after)
            && (self.noise.is_some() || !self.shaped())
            && (bursts.are_few() || self.in_the_middle(&self.after));
        let noise = if noisy {
            (white_after * white_after - 1.0) * stated
        } else {
            0.0
        };
        let shaped = ((white_before * white_before - 1.0) * stated - noise).max(0.0);
        Measurements {
            white_before,
            white_after,
            whole_gap: (validation.score(&[]).squares - self.selected.base).max(0.0),
            shaped,
            total: shaped + noise + bursts.energy,
            bursts,
            left,
            located: self.locate(validation, &self.selected.found.blocks),
            gap,
            structured,
            noisy,
        }
    }

    /// Squares that the uncertainty of a fit, of the baseline with some blocks, may add to those of the noise, to four standard
    /// deviations.
    fn scatter_of_a_fit(&self, validation: &CrossValidation, blocks: &[usize]) -> f64 {
        let expected_squares =
            fit_scatter::expected_squares(validation.gram, &self.design.list(blocks));
        log(&format!(
            "the fit's own scatter: {expected_squares:.0?} squares"
        ));
        self.floor.white_square * (expected_squares.mean + 4.0 * expected_squares.deviation)
    }

    /// True if some shape takes a good part of what is left, beyond chance.
    pub(super) fn is_located(&self, seen: &Measurements) -> bool {
        // Where the noise itself had to be found, what the best shapes took of it by chance is no place.
        let least = if self.noise.is_some() {
            (2.0 * MINIMUM_SQUARES).max(CHANCE_SHARE_OF_NOISE * self.selected.base)
        } else {
            2.0 * MINIMUM_SQUARES
        };
        let enough =
            |l: &Located| l.share > LOCATED_SHARE && l.share * seen.left * seen.whole_gap > least;
        seen.gap && seen.located.first().is_some_and(enough)
    }

    /// Everything that may be named.
    fn effects(&self, validation: &mut CrossValidation, seen: &Measurements) -> Vec<Named> {
        let mut effects = Vec::new();
        let total = seen.total.max(1e-9);
        if self.allowed(effects::name_of(Detection::AsSlips)) {
            let (slips, read) = (&self.prepared.slips, &self.prepared.observations);
            if !slips.is_empty() {
                effects.push(slips_named(slips, read.len(), read.pitch_m));
            }
        }
        if self.burst(seen, BURST_SHARE) && self.allowed(effects::name_of(Detection::AsBursts)) {
            effects.push(
                seen.bursts
                    .named(seen.bursts.energy / total, birge_ratio(self.held_out())),
            );
        }
        if seen.structured {
            effects.extend(self.structured(validation, seen.shaped / total));
        }
        if seen.noisy && self.allowed(effects::name_of(Detection::AsNoise)) {
            let noise = seen.white_after.powi(2) - 1.0;
            let share = noise * validation.rows() * self.floor.white_square / total;
            let least = if self.transfer_residuals.is_some() || self.followed().is_some() {
                NOISE_BESIDE_A_COURSE
            } else {
                NOISE_BESIDE_SHAPES
            };
            let loud = seen.white_after > LOUD_NOISE_RATIO && !self.lacks_much();
            if share > least || loud || !seen.structured {
                effects.push(self.noise(share.clamp(0.0, 1.0)));
            }
        }
        effects
    }

    /// True if a gap that is no noise is larger than the bursts that stand out of it: then they may be its peaks.
    fn hides_bursts(&self, seen: &Measurements) -> bool {
        let left = (seen.white_after.powi(2) - 1.0) * self.after.white.len() as f64;
        !seen.noisy
            && self.stays_visible(seen)
            && seen.bursts.hold(0.0)
            && left > seen.bursts.energy
    }

    /// True if there are bursts, and they are no mere trifle beside what is left unexplained.
    fn burst(&self, seen: &Measurements, share: f64) -> bool {
        let squares = if seen.noisy {
            0.0
        } else {
            (seen.white_after.powi(2) - 1.0).max(0.0) * self.after.white.len() as f64
        };
        let left = Left {
            squares,
            level: seen.white_after.powi(2) * self.floor.white_square,
            shows: self.stays_visible(seen),
        };
        let least = seen.bursts.least_squares(&left, seen.total, share);
        seen.bursts.hold(least)
    }

    /// True if what is found lacks a good part of its own form: something of very many unknowns, or a rail's knee.
    fn lacks_much(&self) -> bool {
        let names = self.names_of(&self.selected.found.blocks);
        let lacks = |name: &&str| {
            effects::has(name, |c| {
                c.is_flexible() || c.detection == Detection::ByRails
            })
        };
        names.iter().any(lacks)
    }

    fn slipped(&self) -> bool {
        !self.prepared.slips.is_empty() && !self.allowed(effects::name_of(Detection::AsSlips))
    }

    /// True if something is seen that may not be named because it was taken out of the catalogue.
    fn withheld(&self, seen: &Measurements) -> bool {
        self.slipped()
            || self.burst(seen, 0.3) && !self.allowed(effects::name_of(Detection::AsBursts))
            || seen.noisy && !self.allowed(effects::name_of(Detection::AsNoise))
    }

    /// True if platen and coordination sensor exceed their stated noise alike: then the statement may be wrong, not a channel.
    fn misstated(&self) -> bool {
        let after = &self.after;
        let ratios: Vec<f64> = after
            .channels()
            .into_iter()
            .map(|c| after.channel_rms_m(c).0 / self.floor.channel_rms_m[c].max(1e-15))
            .collect();
        let (low, high) = ratios
            .iter()
            .fold((f64::INFINITY, 0.0f64), |(l, h), r| (l.min(*r), h.max(*r)));
        low > MISSTATED_RATIO && low > 0.4 * high
    }

    /// True if shapes without a name do far better than the causes, or as well where only what was taken out differs.
    fn shapes_do_better(&self, validation: &mut CrossValidation, seen: &Measurements) -> bool {
        let (found, shaped) = (&self.selected.found, &self.selected.shaped);
        let nameless = |b: &usize| !matches!(self.design.kinds[b - 1], BlockKind::Effect(_));
        let shapes = shaped.blocks.iter().any(nameless);
        // A wander that follows the temperature is none.
        let wanders = |name: &&str| effects::has(name, Card::keeps_its_own_time);
        let drifts = |found: &SearchResult| self.names_of(&found.blocks).iter().any(wanders);
        let simpler = drifts(found)
            && (shapes
                && !drifts(shaped)
                && shaped.unexplained_fraction < self.as_good_as_drift(validation)
                || self.is_no_drift(validation))
            || self.is_no_field(validation)
            || self.is_no_warmth(validation);
        // Where all that is found is needed beside the shapes as well, these are what is left, and no rival.
        let rival = found.blocks.iter().any(|b| !shaped.blocks.contains(b));
        let better =
            rival && found.unexplained_fraction > 2.0 * shaped.unexplained_fraction.max(0.0) + 0.03;
        let visible = self.stays_visible(seen);
        // One shape that does better than several causes together.
        let one = found.blocks.len() > 1
            && self.design.coordinate_blocks().iter().any(|b| {
                unexplained_fraction(validation, &[*b], self.selected.base)
                    < 0.5 * found.unexplained_fraction
            });
        simpler || shapes && better && visible || one && visible || self.shape_ties(validation)
    }

    pub(super) fn names_of(&self, blocks: &[usize]) -> Vec<&str> {
        let name = |b: &usize| self.design.columns.blocks[*b].name.as_str();
        blocks.iter().map(name).collect()
    }

    /// True if what is left would be a gap by itself.
    fn stays_visible(&self, seen: &Measurements) -> bool {
        seen.white_after > STAYS_VISIBLE * self.noise_rms()
    }

    /// True if a shape that no effect owns takes most of what the named effects leave, and by itself most of the whole: then
    /// they only imitate it.
    fn imitates(&self, validation: &mut CrossValidation, seen: &Measurements) -> bool {
        let Some(first) = seen.located.first() else {
            return false;
        };
        let mut coordinate_blocks = self.design.coordinate_blocks().into_iter();
        let shape =
            coordinate_blocks.find(|b| self.design.columns.blocks[*b].name == first.coordinate);
        seen.left > IMITATION_LEAVES
            && first.share > FOREIGN_SHAPE_SHARE
            && shape.is_some_and(|b| {
                unexplained_fraction(validation, &[b], self.selected.base) < SHAPE_ALONE_LEAVES
            })
    }

    /// True if a shape that was taken out of the catalogue does as well as something found.
    fn shape_ties(&self, validation: &mut CrossValidation) -> bool {
        let withheld: Vec<usize> = (1..self.design.columns.blocks.len())
            .filter(|b| matches!(self.design.kinds[b - 1], BlockKind::WithheldEffect(_)))
            .collect();
        let found = &self.selected.found.blocks;
        found.iter().any(|&block| {
            let others: Vec<usize> = found.iter().copied().filter(|b| *b != block).collect();
            self.rivals(validation, block, &others, &withheld)
                .first()
                .is_some_and(|r| r.1 > 0.3)
        })
    }
}

/// True if an amount of a fit is far beyond its prior size: such amounts nearly cancel on this motion, and build what they are not. A
/// field's knots share one size, and what is known of an amount by itself is none.
pub(super) fn of_no_size(relinearized: &RelinearizedFit) -> bool {
    let (gram, columns) = (&relinearized.gram, &relinearized.columns);
    let far = |c: usize| {
        let sizes = (relinearized.coefficients[c] - gram.centre[c]) * gram.shrunk[c];
        let regressor = &columns.regressors[c];
        let of_size = regressor.deviation.is_none() || regressor.course.is_some();
        let far = of_size && sizes.abs() > LARGEST_PRIOR_SIZES;
        if far {
            log(&format!(
                "{}: {sizes:.1} prior sizes, {:.5}",
                columns.regressors[c].name,
                relinearized.coefficient(c)
            ));
        }
        far
    };
    let mut blocks = columns.blocks.iter().skip(1);
    blocks.any(|b| !effects::is(&b.name, Detection::AsField) && b.columns.clone().any(far))
}
