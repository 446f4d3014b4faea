//! Numbers that a log wrote with few digits behind the point, as whole numbers of the last digit.

/// Most digits behind the point, and digits in all that Parquet is told of: a number of 64 bits has 18.
const MOST_DIGITS: i32 = 15;
pub(crate) const PRECISION: i32 = 18;
/// Whole numbers below it have a 64-bit floating-point number each.
const EXACT: u64 = 1 << f64::MANTISSA_DIGITS;

/// The numbers times `10^scale`, if each is its whole number over `10^scale` bit for bit: both of these are exact in 64 bits, so that the
/// quotient is the nearest there is to what was written with as many digits.
pub(crate) fn decimals(numbers: &[f64]) -> Option<(Vec<i64>, i32)> {
    let mut scale = 0;
    for number in numbers {
        while whole(*number, scale).is_none() {
            scale += 1;
            if scale > MOST_DIGITS {
                return None;
            }
        }
    }
    let whole = numbers.iter().map(|number| whole(*number, scale));
    Some((whole.collect::<Option<_>>()?, scale))
}

/// A number times `10^scale`, if it is that whole number over it.
fn whole(number: f64, scale: i32) -> Option<i64> {
    let power = 10f64.powi(scale);
    let whole = (number * power).round() as i64;
    let same = (whole as f64 / power).to_bits() == number.to_bits();
    (whole.unsigned_abs() < EXACT && same).then_some(whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_that_were_written_are_found_and_others_are_not_made_up() {
        let written = [0.1, -2.345, 1e-9, 7.0, 0.3];
        let (whole, scale) = decimals(&written).unwrap();
        assert_eq!(scale, 9);
        assert_eq!(
            whole,
            [100_000_000, -2_345_000_000, 1, 7_000_000_000, 300_000_000]
        );
        for other in [0.1 + 0.2, -0.0, 1e-16, 1e300, f64::INFINITY, 1.0 / 3.0] {
            assert_eq!(decimals(&[0.5, other]), None, "{other}");
        }
        // With as many digits as the smallest has, the largest is above what is exact.
        assert_eq!(decimals(&[1e3, 1e-14]), None);
    }
}
