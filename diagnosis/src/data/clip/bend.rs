//! Rails that are soft: no reading piles up at them, but they bend the figure that a pair draws.
//!
//! A displacement turns the pair along its ellipse and leaves the ellipse whole. What saturates pulls each channel in by that
//! channel's own value, and so bends the ellipse towards a square: amplitude and phase together. The bend alone tells rails and
//! knee; whether the phase errors that follow from them are there is for the comparison to say.

use super::rails::cutting;
use crate::algebra::statistics::median_and_deviation;
use effects::rails::saturated;
use effects::sensor::Clip;
use nalgebra::{SMatrix, SVector};
use std::f64::consts::TAU;

/// Logarithm of the amplitude, the pair's four flaws, reciprocals of the four rails (zero: open), knee. A definition: one, four,
/// four and one.
const FIGURE_PARAMETERS: usize = 10;
type FigureParameters = SVector<f64, FIGURE_PARAMETERS>;
/// Where the rails begin among them. A definition: behind the amplitude and the four flaws.
const RAILS: usize = 5;
/// The knee among them. A definition: behind the four rails.
const KNEE: usize = 9;

/// Parts of the turn that the figure is told by. Derived from the narrowest knee that is soft, 0.02 of the amplitude: at a rail
/// of 0.75 to 0.9 it bends the figure over 0.1 rad, three parts.
const PARTS: usize = 180;
/// Fewer readings tell no mean of a part. Derived from the line that is taken off: it has two unknowns, and with five readings
/// the scatter about it is known to 40 %.
const FEWEST_IN_A_PART: usize = 5;
/// Fewer parts tell no figure. Derived from the ten parameters of the figure: six parts to each, a third of the turn.
const LEAST_PARTS: usize = 60;
/// Readings this many deviations off their part's median are disturbed. Derived from the normal tail: by chance one reading in
/// 1.7 million.
const OUTLIER_DEVIATIONS: f64 = 5.0;
/// No figure is told better than this: 0.03 µm of a phase at a pitch of a millimetre. Derived from the noise floor of 0.3 µm: a
/// tenth of it.
const EXACT: f64 = 2e-4;
/// Points of a figure's curve. Derived from the curve's bends: four points to a part, between which a circle's chord is off by
/// 1e-5 of the radius, a twentieth of `EXACT`.
const POINTS: usize = 720;
/// Squares over the noise that bent rails must take off what a whole ellipse, or one that is cut hard, leaves. A bend has five
/// unknowns more than a whole ellipse. Derived from their chi-square distribution: by chance so much comes less than once in
/// 10^19.
const CLIP_SQUARES: f64 = 100.0;
/// And the share of what that leaves beyond chance.
const FIGURE_SHARE: f64 = 0.7;
/// Highest reciprocal of a rail, and of a knee: tanh is half, and nothing amplifies that gives way sooner than 1/v. A prior: a
/// converter that cut at a third of the amplitude would be refused before (`channels::AT_TOP`).
const LARGEST_RAIL_AND_KNEE: (f64, f64) = (3.0, 0.7);
/// Offsets, gain and angle of a pair are some hundredths. A prior: 0.3 to 0.5 % of offset, 1.7 to 5.3 % of gain (ESS resolver), 6
/// % of offset in one axis (lib_sincos_enc).
const FLAW: f64 = 0.05;
/// A bound on the work: what has not settled by then is told as it is, and must still take `CLIP_SQUARES` off.
const FIT_ROUNDS: usize = 40;

/// Rails (reciprocals) and knees that the search starts from: near the top and well above it. A prior: a wave that is a tenth to
/// a third too large for its converter, hard and soft; the best of the fits counts, so that more starts cost time alone.
const STARTS: [(f64, f64); 3] = [(1.3, 0.1), (1.1, 0.3), (1.4, 0.5)];

/// The figure as it was seen: mean angle, logarithm of the mean radius, and its weight, by part of the turn.
pub(super) struct MeasuredFigure(Vec<[f64; 3]>);

impl MeasuredFigure {
    /// Of the readings of a pair, if they go round.
    pub fn of(pairs: &[[f64; 2]]) -> Option<Self> {
        let mut parts: Vec<Vec<[f64; 2]>> = vec![Vec::new(); PARTS];
        for [sine, cosine] in pairs {
            let turns = sine.atan2(*cosine) / TAU + 0.5;
            let part = ((turns * PARTS as f64) as usize).min(PARTS - 1);
            parts[part].push([sine.atan2(*cosine), sine.hypot(*cosine).ln()]);
        }
        let seen: Vec<[f64; 3]> = parts.iter().filter_map(|part| mean(part)).collect();
        (seen.len() >= LEAST_PARTS).then_some(Self(seen))
    }

    /// Weighed distances of the figure that was seen from that of some parameters.
    fn distances(&self, p: &FigureParameters) -> Vec<f64> {
        let curve = curve(p);
        let mut at = 0;
        let one = |[angle, radius, weight]: &[f64; 3]| {
            while at + 2 < curve.len() && curve[at + 1][0] < *angle {
                at += 1;
            }
            let ([a, low], [b, high]) = (curve[at], curve[at + 1]);
            let part = if b > a { (angle - a) / (b - a) } else { 0.5 };
            weight * (radius - low - part * (high - low))
        };
        self.0.iter().map(one).collect()
    }

    /// Sum of the squares that some parameters leave.
    fn squares(&self, p: &FigureParameters) -> f64 {
        self.distances(p).iter().map(|d| d * d).sum::<f64>() + held(p).norm_squared()
    }

    /// The best parameters of those that are free, and the squares that they leave: Levenberg's and Marquardt's steps.
    fn fitted(&self, start: FigureParameters, free: &[usize]) -> (FigureParameters, f64) {
        let mut p = start;
        let (mut now, mut damping) = (self.squares(&p), 1e-3);
        for _ in 0..FIT_ROUNDS {
            let Some(step) = self.step(&p, free, damping) else {
                break;
            };
            let next = within(p + step);
            let then = self.squares(&next);
            if then < now {
                let small = now - then < 1e-4 * now.min(self.0.len() as f64);
                (p, now, damping) = (next, then, damping * 0.2);
                if small {
                    break;
                }
            } else {
                damping *= 6.0;
                if damping > 1e6 {
                    break;
                }
            }
        }
        (p, now)
    }

    fn step(&self, p: &FigureParameters, free: &[usize], damping: f64) -> Option<FigureParameters> {
        /// Step of a derivative. Derived from 16 digits: rounding makes 1e-11 of it, the curve's bend 1e-5.
        const DIFFERENCE_STEP: f64 = 1e-5;
        let here = self.distances(p);
        let mut normal = SMatrix::<f64, FIGURE_PARAMETERS, FIGURE_PARAMETERS>::identity() * 1e-9;
        let mut right = FigureParameters::zeros();
        let slopes: Vec<Vec<f64>> = free
            .iter()
            .map(|&j| {
                let mut more = *p;
                more[j] += DIFFERENCE_STEP;
                let there = self.distances(&more);
                there
                    .iter()
                    .zip(&here)
                    .map(|(t, h)| (t - h) / DIFFERENCE_STEP)
                    .collect()
            })
            .collect();
        for (a, &j) in free.iter().enumerate() {
            right[j] -= slopes[a].iter().zip(&here).map(|(s, h)| s * h).sum::<f64>();
            for (b, &k) in free.iter().enumerate() {
                normal[(j, k)] += slopes[a]
                    .iter()
                    .zip(&slopes[b])
                    .map(|(s, t)| s * t)
                    .sum::<f64>();
            }
        }
        let held = held(p);
        for j in 1..RAILS {
            normal[(j, j)] += FLAW.powi(-2);
            right[j] -= held[j] / FLAW;
        }
        for &j in free {
            normal[(j, j)] *= 1.0 + damping;
        }
        normal.cholesky().map(|c| c.solve(&right))
    }
}

/// What the flaws' physical size holds them by.
fn held(p: &FigureParameters) -> FigureParameters {
    FigureParameters::from_fn(|j, _| {
        if (1..RAILS).contains(&j) {
            p[j] / FLAW
        } else {
            0.0
        }
    })
}

/// The same within what rails and a knee can be.
fn within(mut p: FigureParameters) -> FigureParameters {
    for j in RAILS..KNEE {
        p[j] = p[j].clamp(0.0, LARGEST_RAIL_AND_KNEE.0);
    }
    p[KNEE] = p[KNEE].clamp(0.0, LARGEST_RAIL_AND_KNEE.1);
    p
}

/// Mean angle and logarithm of the radius of a part of the turn, disturbed readings left out, and one over its deviation.
fn mean(part: &[[f64; 2]]) -> Option<[f64; 3]> {
    let mut radii: Vec<f64> = part.iter().map(|r| r[1]).collect();
    let (centre, scatter) = median_and_deviation(&mut radii)?;
    let near = |r: &&[f64; 2]| (r[1] - centre).abs() <= OUTLIER_DEVIATIONS * scatter;
    let used: Vec<&[f64; 2]> = part.iter().filter(near).collect();
    if used.len() < FEWEST_IN_A_PART {
        return None;
    }
    let count = used.len() as f64;
    let mean = [0, 1].map(|k| used.iter().map(|r| r[k]).sum::<f64>() / count);
    // About a straight line: an ellipse that is bent falls by a percent over a part.
    let covariates = |j: usize, k: usize| -> f64 {
        used.iter()
            .map(|r| (r[j] - mean[j]) * (r[k] - mean[k]))
            .sum()
    };
    let slope = covariates(0, 1) / covariates(0, 0).max(1e-18);
    let variance = (covariates(1, 1) - slope * covariates(0, 1)) / (count - 2.0);
    Some([
        mean[0],
        mean[1],
        1.0 / (variance / count + EXACT * EXACT).sqrt(),
    ])
}

/// Rails, signed, of an amplitude of 1.
fn rails(p: &FigureParameters) -> [[f64; 2]; 2] {
    let rail = |j: usize| (1.0 / p[RAILS + j].max(1e-9)).min(Clip::OPEN);
    [[-rail(0), rail(1)], [-rail(2), rail(3)]]
}

/// Angle and logarithm of the radius once round, by angle.
fn curve(p: &FigureParameters) -> Vec<[f64; 2]> {
    let [sine_rails, cosine_rails] = rails(p);
    let mut curve: Vec<[f64; 2]> = (0..POINTS)
        .map(|i| {
            let phase = TAU * i as f64 / POINTS as f64;
            let sine = saturated(
                (1.0 + p[3]) * (phase + p[4]).sin() + p[1],
                sine_rails,
                p[KNEE],
            );
            let cosine = saturated(phase.cos() + p[2], cosine_rails, p[KNEE]);
            [sine.atan2(cosine), sine.hypot(cosine).ln() + p[0]]
        })
        .collect();
    curve.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let (first, last) = (curve[0], curve[POINTS - 1]);
    curve.insert(0, [last[0] - TAU, last[1]]);
    curve.push([first[0] + TAU, first[1]]);
    curve
}

/// What the figure of a pair leaves, in squares over the readings' scatter.
pub(super) struct Bend {
    /// Parts of the turn that were seen.
    parts: f64,
    /// Squares that a whole ellipse leaves, or one that is cut hard.
    whole: f64,
    /// Squares that the best soft rails leave, and the clip that they are.
    soft: Option<(f64, Clip)>,
}

impl Bend {
    /// Squares that soft rails take off.
    fn gain(&self) -> f64 {
        self.soft
            .as_ref()
            .map_or(0.0, |(left, _)| self.whole - left)
    }

    /// Squares that are left, by soft rails where there may be some.
    fn left(&self) -> f64 {
        self.soft.as_ref().map_or(self.whole, |(left, _)| *left)
    }
}

/// The clips of those pairs whose figures are bent as by nothing else. Other causes bend figures as well, a gap that varies with the place most
/// of all, and those of all pairs alike: what the figures leave in the mean is the scatter that a clip is seen by, where that is more than the
/// readings' own.
pub(super) fn clips(bends: &[Option<Bend>]) -> Vec<Option<Clip>> {
    let seen = || bends.iter().flatten();
    let parts: f64 = seen().map(|bend| bend.parts).sum();
    let left: f64 = seen().map(Bend::left).sum();
    let scatter = (left / parts.max(1.0)).max(1.0);
    let stands_out = |bend: &&Bend| bend.gain() > CLIP_SQUARES * scatter;
    let clip = |bend: &Option<Bend>| bend.as_ref().filter(stands_out)?.soft.as_ref().map(|s| s.1);
    bends.iter().map(clip).collect()
}

/// What the figure of a pair leaves, beside the hard rails that were found, or as a whole ellipse.
pub(super) fn bend(pairs: &[[f64; 2]], hard: Option<(&Clip, f64)>) -> Option<Bend> {
    let seen = MeasuredFigure::of(pairs)?;
    let radius = seen.0.iter().map(|s| s[1]).sum::<f64>() / seen.0.len() as f64;
    let mut whole = FigureParameters::zeros();
    whole[0] = radius;
    let all: Vec<usize> = (0..FIGURE_PARAMETERS).collect();
    let mut starts: Vec<FigureParameters> = STARTS
        .iter()
        .map(|(rail, knee)| {
            let mut p = whole;
            p[0] += 0.1;
            (RAILS..KNEE).for_each(|j| p[j] = *rail);
            p[KNEE] = *knee;
            p
        })
        .collect();
    let before = match hard {
        Some((clip, amplitude)) => {
            let mut p = whole;
            p[0] = amplitude.ln();
            for (j, rail) in clip.rails.as_flattened().iter().enumerate() {
                p[RAILS + j] = if rail.abs() < Clip::OPEN {
                    1.0 / rail.abs()
                } else {
                    0.0
                };
            }
            (0..4).for_each(|j| p[1 + j] = clip.pair[j]);
            let squares = seen.fitted(p, &all[..KNEE]).1;
            p[KNEE] = 0.1;
            starts.push(p);
            squares
        }
        None => seen.fitted(whole, &all[..RAILS]).1,
    };
    let chance = seen.0.len() as f64;
    let mut bend = Bend {
        parts: chance,
        whole: before,
        soft: None,
    };
    if before - chance < CLIP_SQUARES {
        return Some(bend);
    }
    let fits = starts.into_iter().map(|start| seen.fitted(start, &all));
    let (p, after) = fits.min_by(|a, b| a.1.total_cmp(&b.1))?;
    crate::trace::log(&format!(
        "figure over chance: {:.1} {}, {:.1} bent: {:.3?}",
        before / chance,
        if hard.is_some() { "cut" } else { "whole" },
        after / chance,
        p.as_slice()
    ));
    if before - after > FIGURE_SHARE * (before - chance) && p[KNEE] >= Clip::HARD {
        bend.soft = clip(&p).map(|clip| (after, clip));
    }
    Some(bend)
}

/// The clip that some parameters are, if its rails cut anything off.
fn clip(p: &FigureParameters) -> Option<Clip> {
    let pair = [p[1], p[2], p[3], p[4]];
    let levels = rails(p).map(|ends| ends.map(Some));
    Some(Clip {
        rails: cutting(levels, &pair, p[KNEE])?,
        pair,
        knee: p[KNEE],
        zero_and_delay: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::rails::{parts, phase_error};
    use effects::random::{ChaCha8Rng, SeedableRng, normal, uniform};

    const AMPLITUDE: f64 = 20_000.0;

    /// Pairs all round, each channel through `channel`, with noise and a gap that breathes.
    fn pairs(seed: u64, amplitude_modulation: f64, channel: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let one = |_| {
            let (sine, cosine) = uniform(&mut rng, 0.0, TAU).sin_cos();
            let size = AMPLITUDE * (1.0 + amplitude_modulation * uniform(&mut rng, -1.0, 1.0));
            [sine, cosine].map(|v| size * channel(v) + 60.0 * normal(&mut rng))
        };
        (0..8000).map(one).collect()
    }

    /// Rms over the phase, rad, of a clip's phase error, or of the difference of two, that equation (3) has no orders for.
    fn beyond(clips: &[&Clip]) -> f64 {
        let steps = 720;
        let phase = |i: usize| TAU * i as f64 / steps as f64;
        let error = |i: usize| {
            let one = |clip: &&Clip| phase_error(phase(i), &parts(clip));
            clips.iter().map(one).reduce(|a, b| a - b).unwrap_or(0.0)
        };
        let mean = |of: &dyn Fn(usize) -> f64| (0..steps).map(of).sum::<f64>() / steps as f64;
        let known = [1.0, 2.0, 4.0, 6.0].iter().map(|n| {
            let wave = |i: usize| (n * phase(i)).sin_cos();
            let (a, b) = (
                mean(&|i| error(i) * wave(i).0),
                mean(&|i| error(i) * wave(i).1),
            );
            2.0 * (a * a + b * b)
        });
        let level = mean(&error).powi(2);
        (mean(&|i| error(i).powi(2)) - level - known.sum::<f64>()).sqrt()
    }

    /// The clip of a pair beside which no other is.
    fn find(pairs: &[[f64; 2]]) -> Option<Clip> {
        clips(&[bend(pairs, None)])[0]
    }

    #[test]
    fn rails_and_knee_are_told_by_the_figure() {
        for (rail, knee) in [(0.75, 0.06), (0.8, 0.1)] {
            let soft = |v| saturated(v, [-rail, rail], knee);
            let found = find(&pairs(3, 0.0, soft)).expect("a bent figure");
            let drawn = Clip {
                rails: [[-rail, rail]; 2],
                knee,
                ..Clip::default()
            };
            let (whole, wrong) = (beyond(&[&drawn]), beyond(&[&drawn, &found]));
            assert!(wrong < 0.1 * whole, "{wrong} of {whole}: {found:?}");
        }
    }

    /// A wide knee is seen to be one. How wide, a figure alone does not tell: at this noise a larger amplitude with a wider knee draws it
    /// as well (squares of 178 and 175 over 180 parts for knees of 0.20 and 0.30).
    #[test]
    fn a_wide_knee_is_seen() {
        for knee in [0.2, 0.4, 0.5] {
            let soft = |v| saturated(v, [-0.7, 0.7], knee);
            let found = find(&pairs(3, 0.0, soft)).expect("a bent figure");
            assert!(found.knee > 0.15, "{found:?}");
        }
    }

    #[test]
    fn neither_an_ellipse_nor_one_that_breathes_is_bent() {
        assert_eq!(find(&pairs(5, 0.0, |v| v)), None);
        assert_eq!(find(&pairs(6, 0.1, |v| v)), None);
        let offset = pairs(7, 0.0, |v| 0.03 + v);
        assert_eq!(find(&offset), None);
        // An amplifier that expands bends outwards: no rail does that.
        assert_eq!(find(&pairs(8, 0.0, |v| v + 0.05 * v * v * v)), None);
    }

    /// Figures that something else warps, by seven waves to the turn, which no rail makes: beside them a slight bend is none, and a great one is.
    #[test]
    fn what_warps_all_figures_hides_a_slight_bend() {
        let warped = |seed| {
            let mut all = pairs(seed, 0.0, |v| v);
            for pair in &mut all {
                let size = 1.0 + 0.05 * (7.0 * pair[0].atan2(pair[1])).cos();
                *pair = pair.map(|v| size * v);
            }
            bend(&all, None)
        };
        let soft = |rail: f64, knee: f64| {
            bend(&pairs(3, 0.0, |v| saturated(v, [-rail, rail], knee)), None)
        };
        let found = |bend: Option<Bend>, others: &[u64]| {
            let others = others.iter().map(|seed| warped(*seed));
            let bends: Vec<_> = std::iter::once(bend).chain(others).collect();
            let clips = clips(&bends);
            assert_eq!(clips[1..], vec![None; clips.len() - 1]);
            clips[0].is_some()
        };
        assert!(found(soft(1.1, 0.1), &[]));
        assert!(!found(soft(1.1, 0.1), &[4, 5, 6]));
        assert!(found(soft(0.7, 0.1), &[4, 5, 6]));
    }
}
