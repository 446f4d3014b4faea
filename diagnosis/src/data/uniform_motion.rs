//! Whether a motion goes with the clock: what follows the place then has lines in the spectrum, as what follows the time has.

use std::f64::consts::TAU;

/// True if most samples are in stretches that pass a pitch or more at one speed. A wave over the pitch and the line in the spectrum that it is at
/// that speed are then within a radian of each other: off the straight line of place over time a stretch is by less than a pitch over `2π`, rms.
/// `stretch` numbers each sample's, in order of time; places that are not finite are not there.
pub fn is_uniform(stretch: &[usize], t_s: &[f64], place_m: &[f64], pitch_m: f64) -> bool {
    let known: Vec<usize> = (0..stretch.len())
        .filter(|i| place_m[*i].is_finite())
        .collect();
    let each = known.chunk_by(|a, b| stretch[*a] == stretch[*b]);
    let uniform = each.filter(|of| goes_with_the_clock(of, t_s, place_m, pitch_m));
    let samples: usize = uniform.map(<[usize]>::len).sum();
    2 * samples > known.len()
}

/// True of one stretch.
fn goes_with_the_clock(samples: &[usize], t_s: &[f64], place_m: &[f64], pitch_m: f64) -> bool {
    let count = samples.len() as f64;
    let mean = |of: &[f64]| samples.iter().map(|i| of[*i]).sum::<f64>() / count;
    let (middle_s, middle_m) = (mean(t_s), mean(place_m));
    let (mut squares_s, mut product, mut squares_m) = (0.0, 0.0, 0.0);
    for i in samples {
        let (t, x) = (t_s[*i] - middle_s, place_m[*i] - middle_m);
        squares_s += t * t;
        product += t * x;
        squares_m += x * x;
    }
    let speed_m_s = product / squares_s.max(f64::MIN_POSITIVE);
    let off_m = ((squares_m - speed_m_s * product).max(0.0) / count).sqrt();
    // A straight line of a length has a deviation of that over √12.
    let travel_m = 12.0_f64.sqrt() * (squares_m / count).sqrt();
    travel_m > pitch_m && off_m < pitch_m / TAU
}

#[cfg(test)]
mod tests {
    use super::is_uniform;

    /// Two stretches of a hundred samples, with the place by the number of the sample in pitches.
    fn told(place: impl Fn(f64) -> f64) -> bool {
        let number = || (0..200).map(f64::from);
        let stretch: Vec<usize> = (0..200).map(|i| i / 100).collect();
        let t_s: Vec<f64> = number().map(|i| 1.0e-3 * i).collect();
        let place_m: Vec<f64> = number().map(|i| 1.0e-3 * place(i)).collect();
        is_uniform(&stretch, &t_s, &place_m, 1.0e-3)
    }

    #[test]
    fn one_speed_is_told_from_others() {
        assert!(told(|i| 0.1 * i));
        // A shaft whose place begins anew with each turn, and an angle that is off by a twentieth of a pitch.
        assert!(told(|i| 0.1 * (i % 100.0) + 0.05 * (0.1 * i).sin()));
        assert!(!told(|_| 3.0), "at rest");
        assert!(!told(|i| 5.0 * (0.05 * i).sin()), "to and fro");
        assert!(!told(|i| 0.001 * i * i), "ever faster");
        assert!(!told(|_| f64::NAN), "nothing is known");
    }
}
