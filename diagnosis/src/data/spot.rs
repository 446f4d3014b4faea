//! How fast the spot moves over the coordination sensor, by the platen sensor: its own slopes carry the diode's noise and all that the
//! beacon vibrates, and a column that does is too small by as much (errors in variables).

use nalgebra::{SMatrix, SVector};

/// What turns the courier's motion into the spot's: four segments' speeds, the turn times where the spot is, and the angle times
/// the speeds. Derived from the derivative of equation (11), to first order in the angle.
const TERMS: usize = 8;
/// Fewer samples than so many a term say nothing. Derived from the least squares that follow: with twenty rows a term a fit takes
/// 5 % of the noise for its own.
const FEWEST_STATES: usize = 20;
/// Directions of the terms that the motion shows by less than this share of the largest are left out. Derived from 16 digits: the
/// products, in which this is counted, keep six of a direction as weak as that.
const SHOWN: f64 = 1.0e-9;

type Row = SVector<f64, TERMS>;

/// What is known at one sample: the segments' speeds, m/s, and places, m, and where the spot is, as tan(psi).
#[derive(Clone, Copy, Debug)]
pub struct SpotState {
    /// Speeds along the segments' own axes.
    pub speed_m_s: [f64; 4],
    /// Places along them.
    pub place_m: [f64; 4],
    /// The spot.
    pub tan_psi: [f64; 2],
}

impl SpotState {
    fn row(&self) -> Row {
        let [v1, v2, v3, v4] = self.speed_m_s;
        let turn = v1 - v3;
        let angle = self.place_m[0] - self.place_m[2];
        Row::from([
            v1,
            v2,
            v3,
            v4,
            turn * self.tan_psi[0],
            turn * self.tan_psi[1],
            angle * (v1 + v3),
            angle * (v2 + v4),
        ])
    }

    fn is_known(&self) -> bool {
        let all = self.speed_m_s.iter().chain(&self.place_m);
        all.chain(&self.tan_psi).all(|v| v.is_finite())
    }
}

/// Rates of one axis, 1/s, that the ways foretell: the linear map of them that comes nearest to the spot's `own` rates (not finite
/// where there is none). `None` where too few are known. Zero where a way is not. Linear in samples.
pub fn rates(states: &[SpotState], own: &[f64]) -> Option<Vec<f64>> {
    let known = || {
        let both = states.iter().zip(own);
        both.filter(|(way, own)| way.is_known() && own.is_finite())
    };
    if known().count() < FEWEST_STATES * TERMS {
        return None;
    }
    let mut size = Row::zeros();
    known().for_each(|(way, _)| size += way.row().map(|v| v * v));
    let scale = size.map(|square| {
        if square > 0.0 {
            1.0 / square.sqrt()
        } else {
            0.0
        }
    });
    let mut normal = SMatrix::<f64, TERMS, TERMS>::zeros();
    let mut right = Row::zeros();
    for (way, own) in known() {
        let row = way.row().component_mul(&scale);
        normal += row * row.transpose();
        right += row * *own;
    }
    let map = normal.svd(true, true).solve(&right, SHOWN).ok()?;
    let rate = |way: &SpotState| {
        if way.is_known() {
            way.row().component_mul(&scale).dot(&map)
        } else {
            0.0
        }
    };
    Some(states.iter().map(rate).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal, uniform};

    /// A courier with its beacon above, after equation (11): the spot by the pose, and its rate by a difference of poses.
    #[test]
    fn a_noisy_spot_moves_as_the_platen_sensor_tells() {
        const HEIGHT_M: f64 = 0.5;
        const HALF_SPAN_M: f64 = 0.05;
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let spot = |[x, y, theta]: [f64; 3]| {
            let (s, c) = theta.sin_cos();
            [(c * x + s * y) / HEIGHT_M, (c * y - s * x) / HEIGHT_M]
        };
        let places = |[x, y, theta]: [f64; 3]| {
            let arm = HALF_SPAN_M * theta;
            [x + arm, y + arm, x - arm, y - arm]
        };
        let (mut states, mut own, mut truth) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..2000 {
            let mut draw = |half: f64| uniform(&mut rng, -half, half);
            let pose = [draw(0.05), draw(0.05), draw(0.02)];
            let speed = [draw(0.1), draw(0.1), draw(0.05)];
            let at = |t: f64| std::array::from_fn(|k| pose[k] + t * speed[k]);
            let slope = |a: f64, b: f64| (b - a) / 2.0e-6;
            let (before, after) = (places(at(-1.0e-6)), places(at(1.0e-6)));
            states.push(SpotState {
                speed_m_s: std::array::from_fn(|s| slope(before[s], after[s])),
                place_m: places(pose),
                tan_psi: spot(pose),
            });
            let rate = slope(spot(at(-1.0e-6))[0], spot(at(1.0e-6))[0]);
            truth.push(rate);
            own.push(rate + 0.1 * normal(&mut rng));
        }
        let estimate = rates(&states, &own).unwrap();
        let off: Vec<f64> = estimate.iter().zip(&truth).map(|(a, b)| a - b).collect();
        let [off, all] =
            [&off, &truth].map(|list| crate::algebra::statistics::rms(list.iter().copied()));
        // Eight amounts by 2000 samples of noise 0.1: 0.1 sqrt(8 / 2000).
        assert!(off < 0.015 && all > 0.1, "{off} of {all}");
        assert_eq!(rates(&states[..100], &own[..100]), None);
    }
}
