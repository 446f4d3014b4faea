//! Late segments aligned in time with the others, and the residual that is left then.

use crate::data::observations::Observations;
use courier_signal::equations::{OWN_ORDERS, PARITY_SIGN};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::ops::Range;

/// Samples that are looked at, about. A bound on the work: of longer recordings every so many are taken, which tell a mean size
/// to 2 % all the same.
const SAMPLES: usize = 1500;
/// Half the time over which a segment's speed is told, s. A prior: short against what a motion changes in (tens of hertz), and
/// one sampling interval or more of what is recorded.
const SPEED_S: f64 = 1.0e-3;
/// Sines and cosines of equation (3)'s orders.
const PERIODIC: usize = 2 * OWN_ORDERS.len();
/// Size of the periodic errors, m: of the paper's uncalibrated segments (figure 5 and section 3.1.2), some micrometres an order.
const PERIODIC_M: f64 = 5.0e-6;
/// Residual beside the periodic errors, m. A prior: three noise floors of 0.3 µm.
const NOISE_M: f64 = 1.0e-6;

/// Segments, each with its delay.
#[derive(Clone, Copy)]
pub struct Alignment<'a> {
    /// The recording.
    pub observations: &'a Observations,
    /// How late each segment is, s.
    pub delays_s: [f64; 4],
    /// Where each segment is, m: what it reads, or that without equation (3).
    pub place_m: &'a [Vec<f64>; 4],
}

/// What all but one segment adds to its residual: the same whatever its delay.
pub struct Beside<'a> {
    alignment: Alignment<'a>,
    segment: usize,
    /// Sign of its own reading.
    sign: f64,
    others_m: Residuals,
}

impl Beside<'_> {
    /// The segment's residual with another delay of its own.
    pub fn residuals(&self, delay_s: f64) -> Residuals {
        let own = self.alignment.with(self.segment, delay_s);
        let whole_m = |(i, others_m): &(usize, f64)| {
            (*i, self.sign * own.later_m(self.segment, *i).0 + others_m)
        };
        let all = self.others_m.iter().map(whole_m);
        all.filter(|(_, value)| value.is_finite()).collect()
    }

    /// Stretch of a sample.
    pub fn stretch(&self, sample: usize) -> usize {
        self.alignment.observations.stretch[sample]
    }
}

/// A fit of equation (3), and of a longer delay, to the residual.
pub struct Fitted {
    /// By how much longer the delay is, s.
    pub more_s: f64,
    /// What is left, mean size, m.
    pub left_m: f64,
}

/// Number of a sample, its residual, and its row of the design matrix.
type Told = (usize, f64, Vec<f64>);

/// Numbers of samples, and the residual of each, m.
pub type Residuals = Vec<(usize, f64)>;

impl<'a> Alignment<'a> {
    /// All in time.
    pub fn new(observations: &'a Observations) -> Self {
        Self {
            observations,
            delays_s: [0.0; 4],
            place_m: &observations.position_m,
        }
    }

    /// The same with another delay of one segment.
    pub fn with(mut self, segment: usize, delay_s: f64) -> Self {
        self.delays_s[segment] = delay_s;
        self
    }

    /// Samples that are looked at.
    pub fn sample_numbers(&self) -> impl Iterator<Item = usize> + use<> {
        let n = self.observations.len();
        (0..n).step_by((n / SAMPLES).max(1))
    }

    /// What a segment reads its delay later than a sample, m, and how unsure that is.
    pub fn later_m(&self, segment: usize, i: usize) -> (f64, f64) {
        let o = self.observations;
        later_m(o, &self.place_m[segment], i, self.delays_s[segment])
    }

    /// Segments that a segment's residual is formed of, with their signs: itself alone against a reference, else all four.
    fn parts(&self, segment: usize) -> Vec<(usize, f64)> {
        if self.observations.reference.iter().any(|r| !r.is_empty()) {
            vec![(segment, 1.0)]
        } else {
            PARITY_SIGN.map(f64::from).into_iter().enumerate().collect()
        }
    }

    /// A segment's position less the reference's, or the parity; empty where there is neither.
    pub fn residuals(&self, segment: usize) -> Residuals {
        self.beside(segment).residuals(self.delays_s[segment])
    }

    /// What all but a segment's own reading adds to its residual.
    pub fn beside(&self, segment: usize) -> Beside<'a> {
        let o = self.observations;
        let parts = self.parts(segment);
        let others_m = |i: usize| -> f64 {
            match parts.len() {
                1 => -o.reference_m(segment, i),
                _ => {
                    let others = parts.iter().filter(|(s, _)| *s != segment);
                    others.map(|(s, sign)| sign * self.later_m(*s, i).0).sum()
                }
            }
        };
        let whole = parts.iter().all(|(s, _)| o.has_segment(*s));
        let numbers = self.sample_numbers().filter(|_| whole);
        let own = parts.iter().find(|(s, _)| *s == segment);
        Beside {
            alignment: *self,
            segment,
            sign: own.map_or(0.0, |(_, sign)| *sign),
            others_m: numbers.map(|i| (i, others_m(i))).collect(),
        }
    }

    /// Fits equation (3)'s orders, and by how much a segment is later still, to its residual within each stretch. `None` where there
    /// are too few samples.
    pub fn fit(&self, segment: usize, later: bool) -> Option<Fitted> {
        let parts = self.parts(segment);
        let row = |i: usize| {
            let of_one = |(s, sign): &(usize, f64)| {
                let shapes = shapes(self.observations.pitch_m, self.later_m(*s, i).0);
                shapes.map(|shape| sign * shape)
            };
            let mut row: Vec<f64> = parts.iter().flat_map(of_one).collect();
            let own = parts.iter().find(|(s, _)| later && *s == segment);
            row.extend(own.map(|(s, sign)| -sign * self.speed_m_s(*s, i)));
            row
        };
        let told = self.residuals(segment).into_iter();
        let told: Vec<Told> = told
            .map(|(i, value)| (i, value, row(i)))
            .filter(|t| t.2.iter().all(|v| v.is_finite()))
            .collect();
        let (amounts, left_m) = self.solved(&told)?;
        let more_s = if later {
            amounts[amounts.len() - 1]
        } else {
            0.0
        };
        Some(Fitted { more_s, left_m })
    }

    /// Amounts by least squares within each stretch, and the mean size of what they leave, m.
    fn solved(&self, told: &[Told]) -> Option<(DVector<f64>, f64)> {
        let width = told.first()?.2.len();
        if told.len() <= width {
            return None;
        }
        let mut design = DMatrix::from_fn(told.len(), width, |k, c| told[k].2[c]);
        let mut target = DVector::from_fn(told.len(), |k, _| told[k].1);
        let stretch = |of: &Told| self.observations.stretch[of.0];
        let mut from = 0;
        for part in told.chunk_by(|a, b| stretch(a) == stretch(b)) {
            for mut column in design.column_iter_mut().chain([target.column_mut(0)]) {
                let mut column = column.rows_mut(from, part.len());
                let mean = column.mean();
                column.add_scalar_mut(-mean);
            }
            from += part.len();
        }
        let mut normal = design.tr_mul(&design);
        for k in 0..width / PERIODIC * PERIODIC {
            normal[(k, k)] += (NOISE_M / PERIODIC_M).powi(2);
        }
        let amounts = normal.cholesky()?.solve(&design.tr_mul(&target));
        let left_m = (target - design * &amounts).abs().mean();
        Some((amounts, left_m))
    }

    fn speed_m_s(&self, segment: usize, i: usize) -> f64 {
        let at = |delay_s: f64| later_m(self.observations, &self.place_m[segment], i, delay_s).0;
        let delay_s = self.delays_s[segment];
        let before_s = SPEED_S.min(delay_s);
        (at(delay_s + SPEED_S) - at(delay_s - before_s)) / (SPEED_S + before_s)
    }
}

/// What a segment reads, or any list of its places, so much later than a sample, m; and how unsure that is: the parabola through two of
/// them and the one before against that with the one after. Not finite where the stretch has ended by then.
pub fn later_m(o: &Observations, place_m: &[f64], i: usize, delay_s: f64) -> (f64, f64) {
    if delay_s == 0.0 {
        return (place_m[i], 0.0);
    }
    let time_s = o.t_s[i] + delay_s;
    let first = i - usize::from(i > 0 && o.stretch[i - 1] == o.stretch[i]);
    let until = i + o.stretch[i..].partition_point(|s| *s == o.stretch[i]);
    let next = first + o.t_s[first..until].partition_point(|t| *t < time_s);
    if next >= until || next == first {
        return (f64::NAN, f64::NAN);
    }
    let parabola = |[a, b, c]: [usize; 3]| {
        let slope = |a: usize, b: usize| (place_m[b] - place_m[a]) / (o.t_s[b] - o.t_s[a]);
        let bend = (slope(b, c) - slope(a, b)) / (o.t_s[c] - o.t_s[a]);
        let [from_a, from_b] = [a, b].map(|k| time_s - o.t_s[k]);
        place_m[a] + slope(a, b) * from_a + bend * from_a * from_b
    };
    let before = (next >= first + 2).then(|| parabola([next - 2, next - 1, next]));
    let after = (next + 1 < until).then(|| parabola([next - 1, next, next + 1]));
    match (before, after) {
        (Some(before), Some(after)) => (0.5 * (before + after), 0.5 * (before - after).abs()),
        (Some(one), None) | (None, Some(one)) => (one, 0.0),
        (None, None) => (f64::NAN, f64::NAN),
    }
}

/// Sines and cosines of equation (3)'s orders at a place.
fn shapes(pitch_m: f64, place_m: f64) -> [f64; PERIODIC] {
    let phase = TAU * place_m / pitch_m;
    std::array::from_fn(|k| {
        let (sine, cosine) = (f64::from(OWN_ORDERS[k / 2]) * phase).sin_cos();
        if k % 2 == 0 { sine } else { cosine }
    })
}

/// Samples of each stretch.
pub fn stretches(o: &Observations) -> Vec<Range<usize>> {
    let mut from = 0;
    let each = o.stretch.chunk_by(|a, b| a == b);
    each.map(|part| {
        from += part.len();
        from - part.len()..from
    })
    .collect()
}
