//! Flat tops in the counts: each channel may be cut at either end.
//!
//! A rail shows twice. Readings pile up at it and none lies beyond; and the pair's figure, which the readings below the rail draw whole
//! (`super::figure`), goes on beyond it.

use super::bend::{self, Bend};
use super::figure::{CutFigure, Figure};
use super::rails::{Rails, cutting};
use crate::algebra::statistics::{median, median_and_deviation};
use crate::data::observations::Observations;
use effects::sensor::Clip;
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4, PI, TAU};

/// The pairs that are cut by rails which their readings pile up at.
pub(super) fn cut_figures(o: &Observations) -> [Option<CutFigure>; 4] {
    let of_segment = |segment: usize| cut_figure(o, segment, &known_pairs(o, segment));
    let each: Vec<_> = (0..4).into_par_iter().map(of_segment).collect();
    std::array::from_fn(|segment| each[segment])
}

/// The clips of the segments' pairs that their counts show.
pub(super) fn find(o: &Observations) -> [Option<Clip>; 4] {
    let each: Vec<_> = (0..4).into_par_iter().map(|s| figures(o, s)).collect();
    let (hard, bends): (Vec<_>, Vec<_>) = each.into_iter().unzip();
    let soft = bend::clips(&bends);
    std::array::from_fn(|segment| soft[segment].or(hard[segment]))
}

/// The clip of a segment's pair by tops that are flat, and what its figure leaves.
fn figures(o: &Observations, segment: usize) -> (Option<Clip>, Option<Bend>) {
    let pairs = known_pairs(o, segment);
    if pairs.len() < FEWEST_AT_A_TOP {
        return (None, None);
    }
    let hard = hard(o, segment);
    let bend = bend::bend(
        &pairs,
        hard.as_ref().map(|(clip, amplitude)| (clip, *amplitude)),
    );
    (hard.map(|(clip, _)| clip), bend)
}

fn known_pairs(o: &Observations, segment: usize) -> Vec<[f64; 2]> {
    let known = |p: &&[f64; 2]| p[0].is_finite() && p[1].is_finite();
    let all = o.pair_counts[segment].iter();
    all.filter(known).copied().collect()
}

/// Rails that the readings of a pair pile up at, and the figure of those below.
fn cut_figure(o: &Observations, segment: usize, pairs: &[[f64; 2]]) -> Option<CutFigure> {
    if pairs.len() < FEWEST_AT_A_TOP {
        return None;
    }
    // Over separate poses neighbours show no noise: what is stated is tried before what they show.
    let noises = [o.pair_noise_counts, shown_noise(&o.pair_counts[segment])];
    let shares = shares(pairs);
    let tops = Tops {
        pairs,
        shares: &shares,
    };
    let rail = |channel, sign| noises.iter().find_map(|n| tops.flat(channel, sign, *n));
    let rails_counts: Rails = [0, 1].map(|channel| [-1.0, 1.0].map(|sign| rail(channel, sign)));
    if rails_counts.as_flattened().iter().all(Option::is_none) {
        return None;
    }
    let amplitude = || likely_amplitude(pairs, &rails_counts, usual_amplitude(o, segment));
    let figure = Figure::of_whole(pairs, &rails_counts, amplitude)?;
    Some(CutFigure {
        rails_counts,
        figure,
    })
}

/// The clip by tops that are flat, and the amplitude of the whole wave, counts.
fn hard(o: &Observations, segment: usize) -> Option<(Clip, f64)> {
    let CutFigure {
        rails_counts,
        figure,
    } = o.cut_figures[segment]?;
    let levels = rails_counts.map(|ends| ends.map(|rail| Some(rail? / figure.amplitude)));
    let clip = Clip {
        rails: cutting(levels, &figure.pair, 0.0)?,
        pair: figure.pair,
        ..Clip::default()
    };
    Some((clip, figure.amplitude))
}

/// Whether sine and cosine stand at a rail; `noise` is a channel's, counts.
pub(super) fn stand_at(rails: &Rails, pair: [f64; 2], noise: f64) -> [bool; 2] {
    [0, 1].map(|channel| {
        let value = pair[channel];
        let rail = rails[channel][usize::from(value > 0.0)];
        rail.is_some_and(|r| value.abs() > r.abs() - width(r.abs(), noise))
    })
}

/// Width of the band below a top in which readings stand at it, counts.
fn width(top: f64, noise: f64) -> f64 {
    (NOISES_AT_RAIL * noise)
        .max(AT_RAIL * top)
        .min(WIDEST * top)
}

/// Noise within which a reading is at a rail, in standard deviations. Derived from the normal tail: one reading in 16,000 that stands there is
/// beyond.
const NOISES_AT_RAIL: f64 = 4.0;

/// This near to a rail, of it, a channel stands at it. A derivation: 0.2 % of an amplitude are 0.3 µm of a place at the paper's
/// pitch (ρ/2π = 162 µm), the noise floor.
const AT_RAIL: f64 = 0.002;

/// Amplitude of a pair that is nowhere whole: the usual one, where its waves would be whole nowhere. Else by the corners: the higher
/// the waves go beyond the rails, the longer the pair stands at two of them at once.
fn likely_amplitude(pairs: &[[f64; 2]], rails: &Rails, usual: Option<f64>) -> Option<f64> {
    let level = |[a, b]: [Option<f64>; 2]| Some(0.5 * (b? - a?));
    let (Some(sine), Some(cosine)) = (level(rails[0]), level(rails[1])) else {
        return usual;
    };
    let level = 0.5 * (sine + cosine);
    let at_rail = |channel: usize, value: f64| {
        let rail = rails[channel][usize::from(value > 0.0)];
        rail.is_some_and(|r| value / r > 1.0 - AT_RAIL)
    };
    let stands = |p: &&[f64; 2]| at_rail(0, p[0]) && at_rail(1, p[1]);
    let share = pairs.iter().filter(stands).count() as f64 / pairs.len() as f64;
    let by_corners = level / (FRAC_PI_4 * (1.0 - share)).sin();
    usual
        .filter(|usual| level < FRAC_1_SQRT_2 * usual)
        .or(Some(by_corners))
}

/// Amplitude of a pair that shows none of its own: what is stated, else what the others have.
fn usual_amplitude(o: &Observations, segment: usize) -> Option<f64> {
    let stated = o.stated_amplitude_counts;
    let others = (0..4).filter(|s| *s != segment).filter_map(|s| {
        let mut list = o.amplitude_counts[s].clone();
        list.retain(|a| a.is_finite());
        median(&mut list)
    });
    if stated.is_finite() {
        Some(stated)
    } else {
        others.max_by(f64::total_cmp)
    }
}

/// Noise of a channel, counts, as the bends of the amplitude between neighbours show it.
fn shown_noise(pairs: &[[f64; 2]]) -> f64 {
    let radius: Vec<f64> = pairs.iter().map(|p| p[0].hypot(p[1])).collect();
    let mut bends: Vec<f64> = radius
        .windows(3)
        .map(|r| (r[0] - 2.0 * r[1] + r[2]) / 6f64.sqrt())
        .filter(|b| b.is_finite())
        .collect();
    median_and_deviation(&mut bends).map_or(0.0, |b| b.1)
}

/// Parts of the turn that count alike: a courier that dwells at a top is not cut there. Derived from the least cut that is told:
/// it stands 0.045 of the turn at a top ([`LONGER`]), three parts.
const TURN_PARTS: usize = 64;
/// Fewer samples tell no top. Derived from the binomial distribution: of thirty samples a share of a half is known to 0.09.
const FEWEST_AT_A_TOP: usize = 30;

/// Share of the turn that each sample stands for. Sums to one.
fn shares(pairs: &[[f64; 2]]) -> Vec<f64> {
    let part = |p: &[f64; 2]| {
        let turns = p[0].atan2(p[1]) / TAU + 0.5;
        ((turns * TURN_PARTS as f64) as usize).min(TURN_PARTS - 1)
    };
    let mut count = [0usize; TURN_PARTS];
    pairs.iter().for_each(|p| count[part(p)] += 1);
    let visited = count.iter().filter(|c| **c > 0).count();
    let share = |p| 1.0 / (count[part(p)] * visited) as f64;
    pairs.iter().map(share).collect()
}

/// A channel is cut if it stays at its top this much longer than a sine does, and longer by this share of the turn. Derived from
/// the least cut that could be told, at 0.99 of the amplitude (`WHOLE`): it stands at its top over `acos(0.99) / π` = 0.045 of
/// the turn, 2.2 times as long as a sine is in the narrowest band (0.002 of the top) and 0.025 longer; the limits lie between
/// both.
const LONGER: f64 = 1.8;
/// See [`LONGER`].
const FLAT_SHARE: f64 = 0.015;
/// Widest band below the top that is looked at, of the top. Derived from a sine: within 6 % of its top it stands over 0.11 of the
/// turn for each top, so that even without a cut two in nine samples are there; a wider band tells tops from flanks no more.
const WIDEST: f64 = 0.06;
/// A channel's top is what this share of the turn exceeds. Derived from the least cut that is told, which stands at its top over
/// 0.045 of the turn ([`LONGER`]): a ninth of that may be disturbed.
const BEYOND_RAIL: f64 = 1.0 / 200.0;

struct Tops<'a> {
    pairs: &'a [[f64; 2]],
    shares: &'a [f64],
}

impl Tops<'_> {
    /// Counts that a channel's flat tops of a sign stand at, signed, if it has any.
    fn flat(&self, channel: usize, sign: f64, noise: f64) -> Option<f64> {
        let mut values: Vec<(f64, f64)> = self
            .pairs
            .iter()
            .zip(self.shares)
            .map(|(p, share)| (sign * p[channel], *share))
            .filter(|v| v.0 > 0.0)
            .collect();
        values.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        let mut beyond = 0.0;
        let top = values.iter().find(|v| {
            beyond += v.1;
            beyond > BEYOND_RAIL
        })?;
        let top = top.0;
        let width = width(top, noise);
        let held: Vec<&(f64, f64)> = values.iter().take_while(|v| v.0 > top - width).collect();
        let share: f64 = held.iter().map(|v| v.1).sum();
        // A sine's own share of the turn within `width` below one of its tops.
        let own = (1.0 - width / top).acos() / PI;
        let mut held: Vec<f64> = held.iter().map(|v| v.0).collect();
        (share > LONGER * own && share > own + FLAT_SHARE)
            .then(|| median(&mut held))
            .flatten()
            .map(|top| sign * top)
    }
}
