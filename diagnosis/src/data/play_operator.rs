//! Which way a segment last travelled, and how far since it turned: what a remanence remembers.
//!
//! A turn is told only once the way back is clear of the noise, and is then set back to where the way back began: a segment that
//! gathers speed evenly, or with even jerk, has spent a good part of its time on that.

use crate::data::local_fit::local;
use crate::data::observations::Observations;
use effects::sensor::{GRADUAL, TURNOVERS};

/// Travel after which a segment's own memory of its direction has turned over to 1/e, m. A prior: reported stages lag by 4 to 7
/// µm (ESS), which is the shortest travel; in steps of a factor of three two neighbours build what lies between to 6 %.
pub const GRADUAL_M: [f64; GRADUAL] = [4.0e-6, 12.0e-6, 40.0e-6, 120.0e-6];
/// Half the travel after which it has turned over evenly and stands: what has play. A prior: play of 3 to 96 µm, in steps of two;
/// what is between is a sum of two of them (Prandtl and Ishlinskii).
pub const EVEN_M: [f64; TURNOVERS - GRADUAL] = [1.5e-6, 3.0e-6, 6.0e-6, 12.0e-6, 24.0e-6, 48.0e-6];
/// Reach within which what was before a stretch is forgotten to 1/e, m. Derived from the travels above: within 40 µm all of the
/// gradual ones but the longest, and play of up to 80 µm, have turned over by 1 - 1/e at least.
const FORGOTTEN_M: f64 = 40.0e-6;
/// Of a memory this share is none. A derivation: a hundredth of an effect of some micrometres is a tenth of the noise floor of
/// 0.3 µm.
const NOTHING: f64 = 0.01;
/// Travel that counts, in rms misfits of the local path (some 0.75 of the noise): less may be noise. Derived from two places that
/// are compared, each known by its neighbours to 0.4 of a reading's noise: 8 misfits are 5.5 of the noise, and ten deviations of
/// their difference.
const DEAD: f64 = 8.0;
/// Within this many misfits of the farthest place, a sample is at it: a quarter of what is clear. Derived from the same noise: 2
/// misfits are 1.4 of a reading's noise, and 3.4 deviations of a place that six neighbours tell.
const AT_TURN: f64 = 0.25 * DEAD;
/// Time from the beginning of the way back to its first quarter, over that from there to where it is clear. Derived from 1 at
/// even acceleration and 1.7 at even jerk: the middle of both.
const BEFORE: f64 = 1.35;
/// Neighbours follow a path that they miss by less than this many misfits, rms: by chance one in a thousand misses it by more.
/// Derived from the tail of chi-square with four degrees of freedom: 2.4 misfits are 1.66 of the noise, beyond which lies 0.0007.
const FOLLOWED: f64 = 2.4;
/// Neighbours on either side that stand for a sample's place: its own noise must be in no memory. Derived from six neighbours'
/// mean, which is known to 0.4 of a reading's noise; as [`crate::data::motion`]'s.
const PATH_HALF_WINDOW: usize = 3;

/// The last way of a segment, one value a sample.
#[derive(Clone, Debug, Default)]
pub struct PlayOperator {
    /// Direction of the last travel: -1 or 1, 0 where none was yet.
    pub direction: Vec<f64>,
    /// The same that turns over with travel: the states of Dahl 1968's friction model, then the stops whose sums are Prandtl's and
    /// Ishlinskii's hysteresis (Brokate and Sprekels 1996, chapter 2).
    pub memory: Vec<[f64; TURNOVERS]>,
    /// What is left of the memory that it began its stretch with.
    pub before: Vec<f64>,
    /// True about a turn, until the way back is clear: which way it goes there is told to a few samples only.
    pub turning: Vec<bool>,
}

/// A way without a turn.
struct MonotonicLeg {
    direction: f64,
    /// Place that it began at, and the memory there.
    from_m: f64,
    memory: [f64; TURNOVERS],
    /// Farthest place, and the sample there.
    farthest: (f64, usize),
    /// First sample of the smooth piece that it belongs to.
    piece: usize,
}

impl MonotonicLeg {
    /// Memory at a place farther on.
    fn memory_at(&self, here_m: f64) -> [f64; TURNOVERS] {
        let way_m = (self.direction * (here_m - self.from_m)).max(0.0);
        std::array::from_fn(|k| match k.checked_sub(GRADUAL) {
            None => {
                let left = self.memory[k] - self.direction;
                self.direction + left * (-way_m / GRADUAL_M[k]).exp()
            }
            Some(even) => {
                let turned = self.memory[k] + self.direction * way_m / EVEN_M[even];
                turned.clamp(-1.0, 1.0)
            }
        })
    }

    fn turned(&self, at: usize, from_m: f64, memory: [f64; TURNOVERS]) -> Self {
        Self {
            direction: -self.direction,
            from_m,
            memory,
            farthest: (from_m, at),
            piece: self.piece,
        }
    }
}

impl PlayOperator {
    /// From a segment's positions, those of them that follow a smooth path, and the path's rms misfit. Between separate poses and
    /// between stretches the way is taken to be straight. Linear in samples.
    pub fn new(position_m: &[f64], smooth: &[bool], misfit_m: f64, o: &Observations) -> Self {
        let apart = |i: usize| i == 0 || !smooth[i] || o.unbroken[i] != o.unbroken[i - 1];
        let place_m = without_own_noise(&o.t_s, position_m, misfit_m, &apart);
        let mut this = Self::default();
        let mut leg = MonotonicLeg {
            direction: 0.0,
            from_m: f64::NAN,
            memory: [0.0; TURNOVERS],
            farthest: (f64::NAN, 0),
            piece: 0,
        };
        let mut range_m = [f64::INFINITY, f64::NEG_INFINITY];
        for (i, &here_m) in place_m.iter().enumerate() {
            if i > 0 && o.stretch[i] != o.stretch[i - 1] {
                range_m = [f64::INFINITY, f64::NEG_INFINITY];
            }
            range_m = [range_m[0].min(here_m), range_m[1].max(here_m)];
            let left = (-(range_m[1] - range_m[0]) / FORGOTTEN_M).exp();
            this.before.push(if left > NOTHING { left } else { 0.0 });
            if apart(i) {
                leg = arrived(&leg, here_m, i, DEAD * misfit_m);
            }
            let beyond = leg.direction * (here_m - leg.farthest.0);
            if leg.direction == 0.0 {
                let step = here_m - leg.from_m;
                if step.abs() > DEAD * misfit_m {
                    leg.direction = step.signum();
                    leg.farthest = (here_m, i);
                }
            } else if beyond > 0.0 {
                leg.farthest = (here_m, i);
            } else if -beyond > DEAD * misfit_m {
                let turn = turn(&leg, &place_m[..i], AT_TURN * misfit_m);
                let memory = leg.memory_at(leg.farthest.0);
                leg = leg.turned(turn, leg.farthest.0, memory);
                let point = turn.saturating_sub(i - turn).max(leg.piece);
                this.turning[point..i].fill(true);
                for (j, &place) in place_m.iter().enumerate().take(i).skip(turn) {
                    this.direction[j] = leg.direction;
                    this.memory[j] = leg.memory_at(place);
                }
                leg.farthest = (here_m, i);
            }
            this.direction.push(leg.direction);
            this.memory.push(leg.memory_at(here_m));
            this.turning.push(false);
        }
        this
    }
}

/// The leg that leads to a separate pose, or to the first sample of a path: on, or turned, if the way there is far enough to tell.
fn arrived(leg: &MonotonicLeg, here_m: f64, i: usize, clear_m: f64) -> MonotonicLeg {
    let step = here_m - leg.farthest.0;
    let (direction, memory) = if step.abs() > clear_m {
        let there = leg.memory_at(leg.farthest.0);
        let straight = MonotonicLeg {
            direction: step.signum(),
            from_m: leg.farthest.0,
            memory: there,
            farthest: leg.farthest,
            piece: i,
        };
        (step.signum(), straight.memory_at(here_m))
    } else if leg.from_m.is_nan() {
        (0.0, [0.0; TURNOVERS])
    } else {
        (leg.direction, leg.memory_at(leg.farthest.0))
    };
    MonotonicLeg {
        direction,
        from_m: here_m,
        memory,
        farthest: (here_m, i),
        piece: i,
    }
}

/// Sample at which the way back began that is clear at the end of these places; a rest before it belongs to the way there.
fn turn(leg: &MonotonicLeg, place_m: &[f64], near_m: f64) -> usize {
    let near = |j: &usize| leg.direction * (leg.farthest.0 - place_m[*j]) < near_m;
    let far = leg.farthest.1;
    let first = (leg.piece..=far).rev().take_while(near).last();
    let last = (far..place_m.len()).rev().find(near).unwrap_or(far);
    let before = BEFORE * (place_m.len() - 1 - last) as f64;
    last.saturating_sub(before as usize)
        .max(first.unwrap_or(far))
}

/// Each place by the straight path through the same number of neighbours on either side within its smooth piece, the sample itself
/// left out, or by the parabola where they follow none; as it is where they do not follow that either: a courier that is shaken
/// goes farther between two samples than its noise. Linear in samples.
fn without_own_noise(
    t_s: &[f64],
    position_m: &[f64],
    misfit_m: f64,
    apart: &dyn Fn(usize) -> bool,
) -> Vec<f64> {
    let n = position_m.len();
    let estimate = |i: usize| {
        let reach =
            |ends: &dyn Fn(usize) -> bool| (0..PATH_HALF_WINDOW).take_while(|k| !ends(*k)).count();
        let back = reach(&|k| apart(i - k));
        let half = back.min(reach(&|k| i + k + 1 >= n || apart(i + k + 1)));
        let window = i - half..i + half + 1;
        let neighbours = || window.clone().filter(|j| *j != i);
        let followed = |rms_m: f64| rms_m < FOLLOWED * misfit_m;
        let (place_m, rms_m) = straight(neighbours().map(|j| (t_s[j] - t_s[i], position_m[j])));
        if followed(rms_m) {
            return Some(place_m);
        }
        let mut others = position_m[window.clone()].to_vec();
        others[half] = f64::NAN;
        let path = local(&t_s[window.clone()], &others, half, 0..others.len());
        followed(path.residual).then_some(path.value)
    };
    (0..n)
        .map(|i| estimate(i).unwrap_or(position_m[i]))
        .collect()
}

/// Value at time zero of the line through some points, and the rms of what it leaves; not a number of less than two.
fn straight(points: impl Iterator<Item = (f64, f64)> + Clone) -> (f64, f64) {
    let count = points.clone().count() as f64;
    let sum = |of: &dyn Fn(f64, f64) -> f64| points.clone().map(|(t, y)| of(t, y)).sum::<f64>();
    let (t, y) = (sum(&|t, _| t) / count, sum(&|_, y| y) / count);
    let slope = sum(&|a, b| (a - t) * (b - y)) / sum(&|a, _| (a - t).powi(2));
    let left = sum(&|a, b| (b - y - slope * (a - t)).powi(2));
    (y - slope * t, (left / count).sqrt())
}
