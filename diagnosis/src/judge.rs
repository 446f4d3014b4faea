//! From scores to a verdict.

use crate::clean::Slip;
use crate::diagnose::{
    FIELD, Kind, Options, Prepared, Study, handicap, prepare, study, study_with_field,
};
use crate::evidence::{Evidence, Step};
use crate::gram::solve;
use crate::heldout::Residuals;
use crate::model::{EffectAmounts, Model, OF_THEIR_TIME};
use crate::report::{
    Diagnosis, Gap, HeldOutChannel, Magnitude, Named, Share, Unexplained, Verdict,
};
use crate::search::{Arena, Found, MINIMUM_SQUARES, rest, search};
use recording::Recording;

/// Names of the channels.
pub const CHANNEL_NAMES: [&str; 7] = [
    "g_p",
    "g_x",
    "g_y",
    "segment_1",
    "segment_2",
    "segment_3",
    "segment_4",
];
/// A gap shows if the whitened rms exceeds the simulator's own by this factor, or if shapes stand out beyond chance.
const VISIBLE: f64 = 1.05;
/// White noise is named from this factor on.
const NOISY: f64 = 1.10;
/// More of the gap than this left over, and located, is a gap that nothing named explains.
const LEFT_OVER: f64 = 0.10;
/// Effects with so many unknowns that a simpler shape which does nearly as well is to be believed instead.
pub const FLEXIBLE: [&str; 2] = [FIELD, "quadrature_drift"];
/// All channels this far above the stated noise, and alike: the statement is not believed.
const MISSTATED: f64 = 4.0;
/// Neighbours on smooth paths that are needed to tell noise from a pattern.
const ROUGH_PAIRS: usize = 300;
/// Half the mean squared step over the mean square is 1 for white noise; a pattern stays below this.
const ROUGH: f64 = 0.6;
/// A set of causes that leaves more than this is no explanation.
const HALF_DONE: f64 = 0.5;
/// A remainder is located if some shape takes this share of it.
const LOCATED: f64 = 0.15;
/// The stated noise is not believed below this whitened rms.
const TOO_QUIET: f64 = 0.7;
/// Samples in a piece of the bootstrap.
pub const PIECE: usize = 50;
/// Probability below which a runner-up is not worth a mention.
const ALIAS: f64 = 0.05;

/// The diagnosis with what a report and a model need besides.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// What is told.
    pub diagnosis: Diagnosis,
    /// The model, where there is one.
    pub model: Option<Model>,
    /// Held-out residuals with the baseline alone.
    pub before: Residuals,
    /// Held-out residuals with what is named.
    pub after: Residuals,
    /// What a reader may see for himself.
    pub evidence: Evidence,
}

/// Diagnoses a recording; `name` is what the answer calls it.
pub fn diagnose(recording: &Recording, name: &str, options: &Options) -> Diagnosis {
    diagnose_fully(recording, name, options).diagnosis
}

/// The same with the model and the residuals.
pub fn diagnose_fully(recording: &Recording, name: &str, options: &Options) -> Answer {
    match prepare(recording) {
        Ok(prepared) => {
            let judge = Judge::new(&prepared, options);
            let diagnosis = judge.answer(name);
            let model =
                (diagnosis.verdict != Verdict::InsufficientData).then(|| judge.model(&diagnosis));
            let evidence = judge.evidence(&diagnosis);
            Answer {
                diagnosis,
                model,
                before: judge.before,
                after: judge.after,
                evidence,
            }
        }
        Err(limit) => Answer {
            diagnosis: Diagnosis {
                schema: 1,
                recording: name.into(),
                verdict: Verdict::InsufficientData,
                notes: vec![limit.to_string()],
                ..Diagnosis::default()
            },
            ..Answer::default()
        },
    }
}

struct Judge<'a> {
    prepared: &'a Prepared,
    options: &'a Options,
    study: Study<'a>,
    found: Found,
    /// What explains the gap best if shapes without a name may enter.
    shaped: Found,
    /// Whitened squares of the floor.
    base: f64,
    before: Residuals,
    after: Residuals,
}

impl<'a> Judge<'a> {
    fn new(prepared: &'a Prepared, options: &'a Options) -> Self {
        let mut study_now = study(prepared, options, None);
        let (mut found, mut shaped) = explain(&study_now);
        let mut after = residuals(&study_now, &found.blocks);
        let ratio = after.white_rms() / study_now.floor.white_square.sqrt();
        if ratio > VISIBLE {
            // What is left may be a line in the spectrum; looked for only now, when motion no longer makes lines of its own.
            let again = study(prepared, options, Some(&after));
            let survey = &again.scene.survey;
            if !survey.beacon_lines_hz.is_empty() || !survey.segment_lines_hz.is_empty() {
                study_now = again;
                (found, shaped) = explain(&study_now);
                after = residuals(&study_now, &found.blocks);
            }
        }
        if found.rest > LEFT_OVER
            && after.white_rms() / study_now.floor.white_square.sqrt() > VISIBLE
        {
            let keep = leading(&study_now, &found, &shaped);
            let fielded = study_with_field(prepared, options, &after, &keep);
            if fielded.columns.blocks.iter().any(|b| b.name == FIELD) {
                let (f, s) = explain(&fielded);
                if f.rest < 0.7 * found.rest {
                    after = residuals(&fielded, &f.blocks);
                    (study_now, found, shaped) = (fielded, f, s);
                }
            }
        }
        let before = residuals(&study_now, &[]);
        let base = study_now.gram.total_rows() as f64 * study_now.floor.white_square;
        Self {
            prepared,
            options,
            study: study_now,
            found,
            shaped,
            base,
            before,
            after,
        }
    }

    /// Residuals beside their coordinates, and the gap after each effect in the order of the answer.
    fn evidence(&self, diagnosis: &Diagnosis) -> Evidence {
        let columns = &self.study.columns;
        let floor = self.study.floor.white_square.sqrt();
        let step = |effect: &str, of: &Residuals| Step {
            effect: effect.into(),
            whitened: of.white_rms() / floor,
        };
        let mut steps = vec![step("", &self.before)];
        let mut blocks = Vec::new();
        for effect in &diagnosis.effects {
            if let Some(&block) = self
                .found
                .blocks
                .iter()
                .find(|&&b| columns.blocks[b].name == effect.name)
            {
                blocks.push(block);
                let whole = blocks.len() == self.found.blocks.len();
                steps.push(if whole {
                    step(&effect.name, &self.after)
                } else {
                    step(&effect.name, &residuals(&self.study, &blocks))
                });
            }
        }
        let after = if blocks.is_empty() {
            &self.before
        } else {
            &self.after
        };
        Evidence::new(&self.study.scene, &self.before, after, steps)
    }

    fn allowed(&self, name: &str) -> bool {
        !self.options.without.iter().any(|w| w == name)
    }

    fn answer(&self, name: &str) -> Diagnosis {
        let mut arena = Arena::new(&self.study.gram, &self.study.columns);
        let floor = self.study.floor.white_square.sqrt();
        let white_before = self.before.white_rms() / floor;
        let white_after = self.after.white_rms() / floor;
        let whole = arena.score(&[]).squares - self.base;
        let bursts = self.bursts();
        let total = whole.max(0.0) + bursts.energy;
        let located_after = self.locate(&mut arena, &self.found.blocks);
        // Few samples scatter more: four standard deviations of an rms over these rows.
        let chance = 4.0 / (2.0 * arena.rows()).sqrt();
        let gap = white_before > VISIBLE + chance || self.stands_out(&mut arena);
        let left = if gap {
            rest(&mut arena, &self.found.blocks, self.base)
        } else {
            0.0
        };
        let located = gap
            && located_after
                .first()
                .is_some_and(|l| l.1 > LOCATED && l.1 * left * whole > 2.0 * MINIMUM_SQUARES);
        let beaten = gap && self.beaten(&mut arena, left);
        let mut out = Diagnosis {
            schema: 1,
            recording: name.into(),
            ..Diagnosis::default()
        };
        let structured = gap && !self.found.blocks.is_empty();
        let mut effects: Vec<Named> = Vec::new();
        if white_before < TOO_QUIET {
            out.notes.push(format!(
                "stated noise: the recording scatters by {white_before:.2} of what is stated, at least {TOO_QUIET} wanted"
            ));
            out.verdict = Verdict::InsufficientData;
        }
        for slip in self
            .prepared
            .slips
            .iter()
            .filter(|_| self.allowed("cycle_slip"))
            .take(1)
        {
            effects.push(slip_named(slip, &self.prepared.slips));
        }
        if bursts.count >= 3
            && bursts.energy > 0.05 * total
            && bursts.energy > 300.0
            && self.allowed("outlier_bursts")
        {
            effects.push(bursts.named(bursts.energy / total.max(1e-9)));
        }
        if structured {
            effects.extend(self.structured(&mut arena, whole / total.max(1e-9)));
        }
        let noisy = white_after > NOISY + chance && !located && self.rough();
        if noisy && self.allowed("excess_noise") && (left > 0.05 || !structured) {
            effects.push(self.noise(
                white_after,
                (left * whole / total.max(1e-9)).clamp(0.0, 1.0),
            ));
        }
        if noisy && !structured && self.misstated() {
            out.notes.push(format!(
                "stated noise: every channel scatters by the same factor above it, {white_after:.1}, at most {MISSTATED} wanted"
            ));
            out.verdict = Verdict::InsufficientData;
        }
        let slipped_unnamed = !self.prepared.slips.is_empty() && !self.allowed("cycle_slip");
        let burst_unnamed = bursts.count >= 3
            && bursts.energy > 300.0
            && bursts.energy > 0.3 * total
            && !self.allowed("outlier_bursts");
        let noise_unnamed = noisy && !self.allowed("excess_noise");
        let left_over = (located && left > LEFT_OVER)
            || (structured && left > HALF_DONE && !noisy)
            || beaten
            || slipped_unnamed
            || burst_unnamed
            || noise_unnamed;
        let visible = gap || !self.prepared.slips.is_empty() || !effects.is_empty();
        out.verdict = if out.verdict == Verdict::InsufficientData && !out.notes.is_empty() {
            Verdict::InsufficientData
        } else if !visible {
            Verdict::NoGap
        } else if left_over || effects.is_empty() {
            if visible && effects.is_empty() && !left_over && white_before < NOISY && !located {
                Verdict::NoGap
            } else {
                Verdict::Unknown
            }
        } else if effects
            .iter()
            .any(|e| e.aliases.iter().any(|_| e.probability < 0.7))
        {
            Verdict::Alias
        } else {
            Verdict::Named
        };
        if !matches!(out.verdict, Verdict::Named | Verdict::Alias) {
            effects.clear();
        }
        effects.sort_by(|a, b| b.share.total_cmp(&a.share));
        let effects_have_noise = effects.iter().any(|e| e.name == "excess_noise");
        out.effects = effects;
        self.fill(
            &mut out,
            &mut arena,
            if effects_have_noise {
                0.0
            } else {
                left * whole / total.max(1e-9)
            },
            located_after,
        );
        if slipped_unnamed || burst_unnamed {
            out.place.insert(
                0,
                Share {
                    channel: "g_p".into(),
                    coordinate: "time".into(),
                    share: 1.0,
                },
            );
        }
        out
    }

    /// True if platen and coordination sensor exceed their stated noise alike: then the statement is wrong, not a channel.
    fn misstated(&self) -> bool {
        let ratios: Vec<f64> = self
            .after
            .channels()
            .into_iter()
            .map(|c| self.after.channel_rms_m(c).0 / self.study.floor.channel_rms_m[c].max(1e-15))
            .collect();
        let (low, high) = ratios
            .iter()
            .fold((f64::INFINITY, 0.0f64), |(l, h), r| (l.min(*r), h.max(*r)));
        ratios.len() > 1 && low > MISSTATED && low > 0.4 * high
    }

    /// True if what is left changes from sample to sample as white noise does: where the path is smooth, a pattern would not.
    fn rough(&self) -> bool {
        let scene = &self.study.scene;
        let r = &self.after;
        let (mut step, mut level, mut pairs) = (0.0, 0.0, 0);
        for channel in r.channels() {
            let list: Vec<usize> = (0..r.sample.len())
                .filter(|k| r.channel[*k] == channel)
                .collect();
            for pair in list.windows(2) {
                let (i, j) = (r.sample[pair[0]], r.sample[pair[1]]);
                let near =
                    j == i + 1 && scene.observations.stretch[i] == scene.observations.stretch[j];
                if near && scene.motion.smooth[i] && scene.motion.smooth[j] {
                    let (a, b) = (r.white[pair[0]], r.white[pair[1]]);
                    step += 0.5 * (a - b) * (a - b);
                    level += 0.5 * (a * a + b * b);
                    pairs += 1;
                }
            }
        }
        pairs < ROUGH_PAIRS || step > ROUGH * level
    }

    /// True if shapes without a name do far better than the causes, or as well where only what was taken out differs.
    fn beaten(&self, arena: &mut Arena, left: f64) -> bool {
        let shapes = self
            .shaped
            .blocks
            .iter()
            .any(|b| !matches!(self.study.kinds[b - 1], Kind::Effect(_)));
        // A field that a few long waves describe as well is no matter of single teeth, nor is a wander that follows the
        // temperature.
        let flexible = |found: &Found| {
            found
                .blocks
                .iter()
                .any(|b| FLEXIBLE.contains(&self.study.columns.blocks[*b].name.as_str()))
        };
        let simpler = shapes
            && flexible(&self.found)
            && !flexible(&self.shaped)
            && self.shaped.rest < left + 0.1;
        let better = simpler || shapes && left > 2.0 * self.shaped.rest.max(0.0) + 0.03;
        let withheld: Vec<usize> = (1..self.study.columns.blocks.len())
            .filter(|b| matches!(self.study.kinds[b - 1], Kind::Shape(_)))
            .collect();
        let tied = self.found.blocks.iter().any(|&block| {
            let others: Vec<usize> = self
                .found
                .blocks
                .iter()
                .copied()
                .filter(|b| *b != block)
                .collect();
            self.rivals(arena, block, &others, &withheld)
                .first()
                .is_some_and(|r| r.1 > 0.3)
        });
        better || tied
    }

    fn fill(
        &self,
        out: &mut Diagnosis,
        arena: &mut Arena,
        left: f64,
        after: Vec<(String, f64, Vec<usize>)>,
    ) {
        let named = matches!(out.verdict, Verdict::Named | Verdict::Alias);
        let model = if named { &self.after } else { &self.before };
        for c in self.before.channels() {
            let (real, samples) = self.before.channel_rms_m(c);
            let simulated = self.study.floor.channel_rms_m[c];
            let signed = |v: f64| {
                (v * v - simulated * simulated).signum()
                    * (v * v - simulated * simulated).abs().sqrt()
            };
            let interval = self.before.interval_m(c, PIECE);
            out.gap.push(Gap {
                channel: CHANNEL_NAMES[c].into(),
                samples,
                real_rms_m: real,
                simulated_rms_m: simulated,
                excess_rms_m: signed(real),
                excess_ci95_m: interval.map(signed),
            });
            out.held_out.channels.push(HeldOutChannel {
                channel: CHANNEL_NAMES[c].into(),
                before_rms_m: real,
                after_rms_m: model.channel_rms_m(c).0,
                after_ci95_m: model.interval_m(c, PIECE),
                floor_rms_m: simulated,
            });
        }
        let floor = self.study.floor.white_square.sqrt();
        out.held_out.whitened_before = self.before.white_rms() / floor;
        out.held_out.whitened_after = model.white_rms() / floor;
        if out.verdict != Verdict::NoGap {
            out.place = self.shares(self.locate(arena, &[]));
            let share = if named { left } else { 1.0 };
            let list = if named {
                self.shares(after)
            } else {
                out.place.clone()
            };
            out.unexplained = Unexplained {
                share: share.clamp(0.0, 1.0),
                place: list,
            };
        }
    }

    /// True if some shape stands out beyond chance although the sum of squares does not.
    fn stands_out(&self, arena: &mut Arena) -> bool {
        let alone = arena.score(&[]).squares;
        let all: Vec<usize> = (1..self.study.columns.blocks.len()).collect();
        let gain = all
            .into_iter()
            .map(|b| alone - arena.score(&[b]).squares)
            .fold(0.0, f64::max);
        gain > 2.0 * MINIMUM_SQUARES && gain > 0.01 * self.base
    }

    /// Shares of the excess that is left after `blocks`, by coordinate, largest first.
    fn locate(&self, arena: &mut Arena, blocks: &[usize]) -> Vec<(String, f64, Vec<usize>)> {
        let with = rest(arena, blocks, self.base);
        let whole = arena.score(&[]).squares - self.base;
        if with <= 0.0 || whole <= 0.0 {
            return Vec::new();
        }
        let base_list = self.study.list(blocks);
        let mut out: Vec<(String, f64, Vec<usize>)> = Vec::new();
        for (label, columns) in self.coordinates(blocks) {
            let mut list = base_list.clone();
            list.extend(columns.iter().copied().filter(|c| !base_list.contains(c)));
            let after = (arena.score_columns(&list).squares - self.base) / whole;
            out.push((label, (with - after) / with, columns));
        }
        out.sort_by(|a, b| b.1.total_cmp(&a.1));
        out
    }

    /// Columns by coordinate.
    fn coordinates(&self, without: &[usize]) -> Vec<(String, Vec<usize>)> {
        let mut list: Vec<(String, Vec<usize>)> = Vec::new();
        for (b, block) in self.study.columns.blocks.iter().enumerate().skip(1) {
            if without.contains(&b) {
                continue;
            }
            for c in block.columns.clone() {
                let label = coordinate(
                    &self.study.kinds[b - 1],
                    &self.study.columns.regressors[c].name,
                );
                match list.iter_mut().find(|l| l.0 == label) {
                    Some(entry) => entry.1.push(c),
                    None => list.push((label, vec![c])),
                }
            }
        }
        list
    }

    fn shares(&self, list: Vec<(String, f64, Vec<usize>)>) -> Vec<Share> {
        let channel = self.main_channel();
        list.into_iter()
            .filter(|(_, share, _)| *share > 0.03)
            .take(8)
            .map(|(coordinate, share, _)| Share {
                channel: channel.into(),
                coordinate,
                share: share.min(1.0),
            })
            .collect()
    }

    /// The channel with the largest excess over its own floor.
    fn main_channel(&self) -> &'static str {
        let excess = |c: &usize| {
            self.before.channel_rms_m(*c).0 / self.study.floor.channel_rms_m[*c].max(1e-12)
        };
        let best = self
            .before
            .channels()
            .into_iter()
            .max_by(|a, b| excess(a).total_cmp(&excess(b)));
        CHANNEL_NAMES[best.unwrap_or(0)]
    }

    fn structured(&self, arena: &mut Arena, part: f64) -> Vec<Named> {
        let all = rest(arena, &self.found.blocks, self.base);
        let candidates = self.study.effects();
        self.found
            .blocks
            .iter()
            .map(|&block| {
                let others: Vec<usize> = self
                    .found
                    .blocks
                    .iter()
                    .copied()
                    .filter(|b| *b != block)
                    .collect();
                let without = rest(arena, &others, self.base);
                let name = self.study.columns.blocks[block].name.clone();
                let rivals = self.rivals(arena, block, &others, &candidates);
                let sum: f64 = 1.0 + rivals.iter().map(|r| r.1).sum::<f64>();
                let aliases: Vec<String> = rivals
                    .iter()
                    .filter(|r| r.1 / sum > ALIAS)
                    .map(|r| r.0.clone())
                    .collect();
                let motion = effects::sensor_sides()
                    .iter()
                    .find(|e| e.name() == name)
                    .map(|e| e.telling_motion().to_string());
                let alone = residuals(&self.study, &[block]);
                let gap_after_alone_m = alone
                    .channels()
                    .iter()
                    .map(|c| alone.channel_rms_m(*c).0)
                    .fold(0.0, f64::max);
                Named {
                    magnitude: self.magnitudes(block),
                    name,
                    probability: (1.0 / sum).min(0.999),
                    break_alias: if aliases.is_empty() { None } else { motion },
                    aliases,
                    share: ((without - all) * part).clamp(0.0, 1.0),
                    gap_after_alone_m,
                }
            })
            .collect()
    }

    /// Effects that would do in the place of `block`, with their odds against it.
    fn rivals(
        &self,
        arena: &mut Arena,
        block: usize,
        others: &[usize],
        candidates: &[usize],
    ) -> Vec<(String, f64)> {
        let mut with = others.to_vec();
        with.push(block);
        let mine = rest(arena, &with, self.base);
        let without = rest(arena, others, self.base);
        let evidence = arena.score(&with).log_evidence;
        let mut list = Vec::new();
        for &c in candidates.iter().filter(|c| !with.contains(c)) {
            let mut set = others.to_vec();
            set.push(c);
            let theirs = rest(arena, &set, self.base);
            // The model is never exact: what differs by less than a few percent of the effect is not told apart by fit.
            let behind = (theirs - mine) / (without - mine).max(1e-9);
            let fit = (-behind.max(0.0) / 0.01).exp();
            let occam = (arena.score(&set).log_evidence - evidence)
                .clamp(-5.0, 0.0)
                .exp();
            list.push((
                self.study.columns.blocks[c].name.clone(),
                fit * occam.max(fit * 0.2),
            ));
        }
        list.sort_by(|a, b| b.1.total_cmp(&a.1));
        list
    }

    /// The largest amounts of an effect, with their units: what is added to the readings.
    fn magnitudes(&self, block: usize) -> Vec<Magnitude> {
        let list = self.study.list(&self.found.blocks);
        let training = self.study.gram.training(None);
        let Some(fit) = crate::gram::solve(&training, &list, &self.study.gram.centre, 1.0) else {
            return Vec::new();
        };
        let columns = &self.study.columns;
        let mut out: Vec<(f64, Magnitude)> = list
            .iter()
            .zip(fit.amount.iter())
            .filter(|(c, _)| columns.blocks[block].columns.contains(c))
            .map(|(&c, amount)| {
                let regressor = &columns.regressors[c];
                let value = amount * self.study.gram.scale[c];
                (
                    (amount * regressor.size_m).abs(),
                    Magnitude {
                        name: regressor.name.clone(),
                        value,
                        unit: regressor.unit.into(),
                    },
                )
            })
            .collect();
        out.sort_by(|a, b| b.0.total_cmp(&a.0));
        out.into_iter().take(12).map(|m| m.1).collect()
    }

    /// The model of what is named, fitted on all samples in use.
    fn model(&self, diagnosis: &Diagnosis) -> Model {
        let columns = &self.study.columns;
        let named = matches!(diagnosis.verdict, Verdict::Named | Verdict::Alias);
        let blocks: &[usize] = if named { &self.found.blocks } else { &[] };
        let fitted = |blocks: &[usize]| {
            let list = self.study.list(blocks);
            let fit = solve(
                &self.study.gram.training(None),
                &list,
                &self.study.gram.centre,
                1.0,
            );
            let amounts: Vec<f64> = fit.map_or(vec![0.0; list.len()], |f| {
                f.amount.iter().copied().collect()
            });
            list.into_iter()
                .zip(amounts)
                .map(|(c, a)| (c, a * self.study.gram.scale[c]))
                .collect::<Vec<_>>()
        };
        let scene = &self.study.scene;
        let with = |amounts: &[(usize, f64)]| {
            let count = columns.blocks[0].columns.len();
            let step: Vec<f64> = amounts.iter().take(count).map(|a| a.1).collect();
            let mut baseline = scene.baseline.clone();
            baseline.add(scene.scope, &step);
            baseline
        };
        let (alone, joint) = (fitted(&[]), fitted(blocks));
        let effects = blocks
            .iter()
            .map(|&b| EffectAmounts {
                name: columns.blocks[b].name.clone(),
                carries_over: !OF_THEIR_TIME.contains(&columns.blocks[b].name.as_str()),
                amounts: joint
                    .iter()
                    .filter(|(c, _)| columns.blocks[b].columns.contains(c))
                    .map(|&(c, value)| Magnitude {
                        name: columns.regressors[c].name.clone(),
                        value,
                        unit: columns.regressors[c].unit.into(),
                    })
                    .collect(),
            })
            .collect();
        Model {
            schema: 1,
            recording: diagnosis.recording.clone(),
            baseline: with(&alone),
            baseline_with_effects: with(&joint),
            effects,
            normal: scene.normal.clone(),
            survey: scene.survey.clone(),
            claimed: diagnosis.held_out.clone(),
        }
    }

    fn noise(&self, white: f64, share: f64) -> Named {
        let magnitude = self
            .after
            .channels()
            .into_iter()
            .map(|c| {
                let (rms, floor) = (
                    self.after.channel_rms_m(c).0,
                    self.study.floor.channel_rms_m[c],
                );
                Magnitude {
                    name: format!("beyond the stated noise, {}", CHANNEL_NAMES[c]),
                    value: (rms * rms - floor * floor).max(0.0).sqrt(),
                    unit: "m".into(),
                }
            })
            .collect();
        Named {
            name: "excess_noise".into(),
            probability: if white > 1.2 { 0.97 } else { 0.8 },
            magnitude,
            share,
            ..Named::default()
        }
    }

    fn bursts(&self) -> Bursts {
        let scene = &self.study.scene;
        let mut out = Bursts::default();
        let list = self.study.list(&self.found.blocks);
        let training = self.study.gram.training(None);
        let Some(fit) = crate::gram::solve(&training, &list, &self.study.gram.centre, 1.0) else {
            return out;
        };
        let amounts: Vec<f64> = fit.amount.iter().copied().collect();
        if scene.keep.iter().all(|k| *k) {
            return out;
        }
        let all = Residuals::predicted(
            scene,
            &self.study.columns,
            &self.study.gram,
            &list,
            |_| &amounts,
            true,
        );
        let mut last = usize::MAX;
        for k in 0..all.sample.len() {
            let i = all.sample[k];
            if !scene.keep[i] && !self.prepared.resting[i] {
                out.energy += (all.white[k].powi(2) - 1.0).max(0.0);
                out.largest_m = out.largest_m.max(all.value_m[k].abs());
                if i != last {
                    out.count += 1;
                    last = i;
                }
            }
        }
        out
    }
}

/// Disturbed samples.
#[derive(Default)]
struct Bursts {
    count: usize,
    energy: f64,
    largest_m: f64,
}

impl Bursts {
    fn named(&self, share: f64) -> Named {
        Named {
            name: "outlier_bursts".into(),
            probability: 0.97,
            magnitude: vec![
                Magnitude {
                    name: "disturbed samples".into(),
                    value: self.count as f64,
                    unit: "samples".into(),
                },
                Magnitude {
                    name: "largest".into(),
                    value: self.largest_m,
                    unit: "m".into(),
                },
            ],
            share: share.clamp(0.0, 1.0),
            ..Named::default()
        }
    }
}

fn slip_named(first: &Slip, all: &[Slip]) -> Named {
    let magnitude = all
        .iter()
        .map(|s| Magnitude {
            name: format!("segment {} from sample {}", s.segment + 1, s.sample),
            value: f64::from(s.teeth),
            unit: "teeth".into(),
        })
        .collect();
    Named {
        name: "cycle_slip".into(),
        probability: if first.sure { 0.99 } else { 0.95 },
        magnitude,
        share: 1.0,
        ..Named::default()
    }
}

/// The coordinate of a column in the words of diagnosis.md.
fn coordinate(kind: &Kind, column: &str) -> String {
    let order = |text: &str| {
        column
            .split("order ")
            .nth(1)
            .map(|t| format!("{text}, order {}", t.split(' ').next().unwrap_or("")))
            .unwrap_or(text.into())
    };
    match kind {
        Kind::Place(name) => name.clone(),
        Kind::Effect(name) | Kind::Shape(name) => match name.as_str() {
            "extra_harmonics" => order("own tooth phase"),
            "lateral_dependence" if column.starts_with("own") => {
                "own and lateral tooth phase".into()
            }
            "lateral_dependence" => order("lateral tooth phase"),
            "adc_clipping" => "own tooth phase, orders 4, 8, 12, 16".into(),
            "angle_dependence" => "theta and own tooth phase".into(),
            "psd_nonlinearity" | "psd_misalignment" => {
                "deflection of the coordination sensor".into()
            }
            "thermal_drift" => "temperature".into(),
            "velocity_lag" | "psd_latency" => "speed".into(),
            "hysteresis" => "direction".into(),
            "gap_variation" => "signal amplitude".into(),
            "beacon_vibration" => "frequency".into(),
            "axis_skew" | "tooth_variation" => "place on the platen".into(),
            "quadrature_drift" => "time and own tooth phase".into(),
            "span_error" => "theta".into(),
            other => other.into(),
        },
    }
}

/// Blocks that stay in competition beside a field: what was found, and the best by themselves.
fn leading(study: &Study, found: &Found, shaped: &Found) -> Vec<String> {
    let mut arena = Arena::new(&study.gram, &study.columns);
    let mut alone: Vec<(f64, usize)> = (1..study.columns.blocks.len())
        .map(|b| (arena.score(&[b]).squares, b))
        .collect();
    alone.sort_by(|a, b| a.0.total_cmp(&b.0));
    let place = (1..study.columns.blocks.len())
        .filter(|b| study.columns.blocks[*b].name == "place on the platen");
    let best = alone.iter().take(5).map(|a| a.1);
    let mut list: Vec<usize> = found
        .blocks
        .iter()
        .chain(&shaped.blocks)
        .copied()
        .chain(best)
        .chain(place)
        .collect();
    list.dedup();
    list.into_iter()
        .map(|b| study.columns.blocks[b].name.clone())
        .collect()
}

/// The best set of effects, and the best set if free shapes compete with them.
fn explain(study: &Study) -> (Found, Found) {
    let mut arena = Arena::new(&study.gram, &study.columns);
    let base = arena.rows() * study.floor.white_square;
    let names: Vec<String> = study
        .columns
        .blocks
        .iter()
        .map(|b| b.name.clone())
        .collect();
    let places = study.places();
    let effects = study.effects();
    let weight = |b: usize| {
        handicap(&names[b])
            + if places.contains(&b) {
                SHAPE_HANDICAP
            } else {
                0.0
            }
    };
    let found = search(&mut arena, &effects, &weight, base);
    let all: Vec<usize> = effects.iter().chain(&places).copied().collect();
    let shaped = search(&mut arena, &all, &weight, base);
    if crate::diagnose::tracing() {
        let mut alone: Vec<(f64, &str)> = all
            .iter()
            .map(|&b| (rest(&mut arena, &[b], base), names[b].as_str()))
            .collect();
        alone.sort_by(|a, b| a.0.total_cmp(&b.0));
        crate::diagnose::log(&format!(
            "{} columns; alone {:?}",
            study.gram.width(),
            &alone[..alone.len().min(6)]
        ));
        crate::diagnose::log(&format!("{:?}", alone.iter().find(|a| a.1 == FIELD)));
    }
    crate::diagnose::log(&format!(
        "found {:?} {:.4}; with shapes {:?} {:.4}",
        found.blocks.iter().map(|b| &names[*b]).collect::<Vec<_>>(),
        found.rest,
        shaped.blocks.iter().map(|b| &names[*b]).collect::<Vec<_>>(),
        shaped.rest
    ));
    (found, shaped)
}

/// A shape without a name must do this much better than a cause, as a share of the gap.
const SHAPE_HANDICAP: f64 = 0.02;

fn residuals(study: &Study, blocks: &[usize]) -> Residuals {
    Residuals::new(
        &study.scene,
        &study.columns,
        &study.gram,
        &study.folds,
        &study.list(blocks),
    )
}
