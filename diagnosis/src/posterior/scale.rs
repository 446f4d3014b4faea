//! A size that is known by its order of magnitude: how much larger or smaller than stated, with a heavy tail, integrated over a grid.

/// Half-width of the prior of the logarithm of a size over the stated one: one effect in two is within a factor of three of it. A prior:
/// the sizes on the effects' cards are orders of magnitude of published sensors.
const HALF_WIDTH: f64 = 1.098_612_288_668_11;
/// Sizes that are looked at, as logarithms over the stated one. A thousandth is far below any noise. Above, three times: the largest amount
/// that 150 recordings with effects of up to 4 µm rms asked for was 4.3 stated sizes, which is one and a half deviations of that; and
/// amounts far beyond their sizes cancel on the motion at hand, with each other and with the baseline, and build what they are not.
pub(crate) const RANGE: [f64; 2] = [-6.9, HALF_WIDTH];
/// Step of the grid of the logarithm of a variance. Derived from the evidence of few coefficients, which is as wide as two in it:
/// the trapezoid rule of a smooth bump is exact to a thousandth at half its standard deviation.
const STEP: f64 = 0.7;
/// Coefficients from which on the evidence is narrower than the grid, and a finer one is laid about its top. Derived from that
/// width, √(2/p) in the logarithm of a variance: at 16 it is 0.35, half of `STEP`.
const MANY: usize = 16;
/// Steps of the finer grid to either side, and their width in standard deviations. Derived from the normal density, of which the
/// trapezoid rule misses a millionth at that width and which has fallen to two thousandths of its top at the last point.
const FINE: (i32, f64) = (3, 1.2);

/// What an integral over a scale found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Logarithm of the variance over the stated one, where the integrand is largest.
    pub mode: f64,
    /// Logarithm of the integral less that of the likelihood at the mode.
    pub log_width: f64,
}

/// Logarithm of the prior density of the logarithm of a variance over the stated one: Cauchy.
pub fn log_prior(log_variance: f64) -> f64 {
    let half_width = 2.0 * HALF_WIDTH;
    -(std::f64::consts::PI * half_width).ln() - (log_variance / half_width).powi(2).ln_1p()
}

/// The nearest logarithm of a variance over the stated one that is looked at.
pub fn within(log_variance: f64) -> f64 {
    log_variance.clamp(2.0 * RANGE[0], 2.0 * RANGE[1])
}

/// Probability that a variance is beyond so many times the stated one and within what is looked at.
pub fn prior_beyond(times: f64) -> f64 {
    let beyond = |log: f64| 0.5 - (log / (2.0 * HALF_WIDTH)).atan() / std::f64::consts::PI;
    (beyond(times.ln().max(2.0 * RANGE[0])) - beyond(2.0 * RANGE[1])).max(0.0)
}

/// Draws the logarithm of a variance over the stated one from the prior.
#[cfg(test)]
pub(crate) fn draw(rng: &mut effects::random::ChaCha8Rng) -> f64 {
    let share = effects::random::uniform(rng, 0.0, 1.0);
    2.0 * HALF_WIDTH * (std::f64::consts::PI * (share - 0.5)).tan()
}

/// Integrates a likelihood, whose logarithm is a function of the logarithm of a variance, over the prior. `unknowns` coefficients share the
/// variance.
pub fn integrate(unknowns: usize, log_likelihood: impl Fn(f64) -> f64) -> Scale {
    let [low, high] = RANGE.map(|size| 2.0 * size);
    let coarse = if unknowns > MANY { 2.0 * STEP } else { STEP };
    let count = ((high - low) / coarse).floor() as i32;
    let points: Vec<f64> = (0..=count).map(|k| low + coarse * f64::from(k)).collect();
    let all = values(&points, &log_likelihood);
    if unknowns <= MANY {
        return summed(&all, coarse);
    }
    let top = all
        .iter()
        .copied()
        .max_by(|a, b| a.posterior.total_cmp(&b.posterior));
    about(top.map_or(0.0, |top| top.at), unknowns, log_likelihood)
}

/// The same about a variance that is known to be near the top.
pub fn about(near: f64, unknowns: usize, log_likelihood: impl Fn(f64) -> f64) -> Scale {
    let (count, width) = FINE;
    // The logarithm of a variance that n normal numbers tell scatters by the root of 2 over n.
    let step = (width * (2.0 / unknowns.max(1) as f64).sqrt()).min(STEP);
    let [low, high] = RANGE.map(|size| 2.0 * size);
    let mut middle = within(near);
    loop {
        let points: Vec<f64> = (-count..=count)
            .map(|k| middle + step * f64::from(k))
            .filter(|at| (low..=high).contains(at))
            .collect();
        let found = summed(&values(&points, &log_likelihood), step);
        let at_an_end = (found.mode - middle).abs() > (f64::from(count) - 0.5) * step;
        if !at_an_end {
            return found;
        }
        middle = found.mode;
    }
}

/// A point of the grid.
#[derive(Clone, Copy)]
struct Point {
    at: f64,
    likelihood: f64,
    posterior: f64,
}

fn values(points: &[f64], log_likelihood: &impl Fn(f64) -> f64) -> Vec<Point> {
    let value = |at: f64| {
        let likelihood = log_likelihood(at);
        Point {
            at,
            likelihood,
            posterior: likelihood + log_prior(at),
        }
    };
    points.iter().map(|at| value(*at)).collect()
}

fn summed(points: &[Point], step: f64) -> Scale {
    let top = points
        .iter()
        .copied()
        .max_by(|a, b| a.posterior.total_cmp(&b.posterior));
    let Some(top) = top else {
        return Scale {
            mode: 0.0,
            log_width: 0.0,
        };
    };
    let sum: f64 = points
        .iter()
        .map(|p| (p.posterior - top.posterior).exp())
        .sum();
    Scale {
        mode: top.at,
        log_width: top.posterior + (sum * step).ln() - top.likelihood,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The prior is a density, but for the tails beyond what is physical.
    #[test]
    fn the_prior_sums_to_what_lies_within_the_range() {
        let whole = integrate(1, |_| 0.0);
        let wanted = prior_beyond(0.0);
        // The ends of the grid count whole: half a step at the density there.
        assert!(
            (whole.log_width.exp() - wanted).abs() < 0.05,
            "{whole:?} {wanted}"
        );
        assert!((prior_beyond(1.0) - 0.25).abs() < 1e-9);
        assert_eq!(prior_beyond(9.1), 0.0);
    }

    /// A bump as narrow as many coefficients make it is summed as exactly as a wide one.
    #[test]
    fn narrow_bumps_are_integrated() {
        for unknowns in [1, 8, 40, 400] {
            let deviation = (2.0 / unknowns as f64).sqrt();
            let bump = |at: f64| -0.5 * ((at + 3.0) / deviation).powi(2);
            let found = integrate(unknowns, bump);
            let wanted = log_prior(-3.0) + (deviation * std::f64::consts::TAU.sqrt()).ln();
            let told = found.log_width + bump(found.mode);
            assert!((told - wanted).abs() < 0.2, "{unknowns}: {told} {wanted}");
        }
    }
}
