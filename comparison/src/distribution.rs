//! Tail probabilities and quantiles, for degrees of freedom that may be infinite.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal, StudentsT};

/// Degrees of freedom from which on a scale counts as known. Derived from Student's distribution, whose quantiles differ from the
/// normal ones by 1 over the degrees of freedom.
pub const MANY: f64 = 1.0e5;

/// Probability that chance alone gives a mean square of `statistic` or more over `directions` unit directions, where the scale is known
/// with `freedom` degrees of freedom: Fisher's F, chi-square where that is infinite. One where there is no direction.
#[must_use]
pub fn chance_of_mean_square(statistic: f64, directions: usize, freedom: f64) -> f64 {
    let count = directions as f64;
    if directions == 0 || statistic.is_nan() || statistic <= 0.0 {
        return 1.0;
    }
    let chance = if freedom >= MANY {
        ChiSquared::new(count)
            .map(|of| of.sf(count * statistic))
            .ok()
    } else {
        FisherSnedecor::new(count, freedom.max(1.0))
            .map(|of| of.sf(statistic))
            .ok()
    };
    chance.unwrap_or(1.0)
}

/// Standard deviations on either side of a two-sided interval of this coverage: Student's t.
#[must_use]
pub fn coverage_factor(coverage: f64, freedom: f64) -> f64 {
    let share = 0.5 * (1.0 + coverage);
    let factor = if freedom >= MANY {
        Normal::new(0.0, 1.0).map(|of| of.inverse_cdf(share)).ok()
    } else {
        StudentsT::new(0.0, 1.0, freedom.max(1.0))
            .map(|of| of.inverse_cdf(share))
            .ok()
    };
    factor.unwrap_or(f64::INFINITY)
}

/// Effective degrees of freedom of a sum of squares: `(sum u^2)^2 / sum (u^4 / freedom)` over `(u^2, freedom)` (Welch 1947;
/// JCGM 100:2008, G.4.1). Infinite where all are, or where nothing is summed.
#[must_use]
pub fn effective_freedom(parts: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let (mut sum, mut spread) = (0.0, 0.0);
    for (square, freedom) in parts {
        sum += square;
        spread += square * square / freedom;
    }
    if spread > 0.0 {
        sum * sum / spread
    } else {
        f64::INFINITY
    }
}

/// Variance of a mean square over so many directions where its scale is known with `freedom` degrees of freedom, more than four, over the square of its
/// mean: Fisher's F, chi-square where that is infinite.
#[must_use]
pub fn relative_variance(directions: f64, freedom: f64) -> f64 {
    if freedom >= MANY {
        2.0 / directions
    } else {
        2.0 * (directions + freedom - 2.0) / (directions * (freedom - 4.0))
    }
}

/// Degrees of freedom by [`relative_variance`]; infinite where that is no more than directions alone have.
#[must_use]
pub fn freedom_by_variance(directions: f64, variance: f64) -> f64 {
    let beyond = directions * variance - 2.0;
    if beyond > 0.0 {
        (2.0 * directions - 4.0 + 4.0 * directions * variance) / beyond
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// JCGM 100:2008, table G.2: 95 %; and of the chi-square distribution 95 % points (NIST handbook, 1.3.6.7.4).
    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (freedom, wanted) in [
            (1.0, 12.71),
            (5.0, 2.57),
            (20.0, 2.09),
            (f64::INFINITY, 1.96),
        ] {
            let found = coverage_factor(0.95, freedom);
            assert!((found - wanted).abs() < 0.006, "{freedom}: {found}");
        }
        for (directions, point) in [(1, 3.841), (10, 18.307), (33, 47.400)] {
            let chance =
                chance_of_mean_square(point / directions as f64, directions, f64::INFINITY);
            assert!((chance - 0.05).abs() < 1.0e-4, "{directions}: {chance}");
        }
        // F of 10 and 20: 2.348.
        assert!((chance_of_mean_square(2.348, 10, 20.0) - 0.05).abs() < 1.0e-4);
        assert_eq!(chance_of_mean_square(1.0, 0, 20.0), 1.0);
    }

    /// Two equal parts of 10 degrees have 20; the worked example of JCGM 100:2008, H.1.6, has 16.
    #[test]
    fn freedoms_are_joined_as_the_guide_does() {
        let equal = effective_freedom([(1.0, 10.0), (1.0, 10.0)]);
        assert!((equal - 20.0).abs() < 1.0e-12);
        assert_eq!(effective_freedom([(1.0, f64::INFINITY)]), f64::INFINITY);
        // Nanometres and degrees of freedom of its table H.1.
        let gauge = [(25.0, 18.0), (9.7, 25.6), (2.9, 50.0), (16.6, 2.0)];
        let freedom = effective_freedom(gauge.map(|(u, freedom): (f64, f64)| (u * u, freedom)));
        assert!((16.0..17.0).contains(&freedom), "{freedom}");
    }

    #[test]
    fn degrees_of_freedom_are_those_of_their_variance() {
        for freedom in [10.0, 300.0] {
            let found = freedom_by_variance(32.0, relative_variance(32.0, freedom));
            assert!((found / freedom - 1.0).abs() < 1.0e-9, "{found}");
        }
        let known = relative_variance(32.0, f64::INFINITY);
        assert_eq!(freedom_by_variance(32.0, known), f64::INFINITY);
    }
}
