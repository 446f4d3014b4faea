//! How much of its area a recording has gone over, for what shows in no column before it is there: wandering offsets, flat tops, bursts.

use crate::motion::{Area, Move};

/// Share of the area's width that counts as gone over. A prior: what lies beyond is passed by the ends' slow parts alone.
const WIDE: f64 = 0.8;
/// There and back. By definition the two ways along a line.
const WAYS: f64 = 2.0;
/// Times that each way is gone. Derived from what parts the two: what is passed again at another time tells what goes with the
/// place from what goes with the time.
const PASSES: f64 = 2.0;

/// How far the motions made so far go over their area there and back in both dimensions: 1 is all. Along one line, however slanted, x and y stay
/// what they are to each other, so that what goes with the one looks like what goes with the other: what counts is the direction in which
/// the motions have gone least, which is the least eigenvalue of the sum of their outer products.
#[must_use]
pub fn covered(made: &[Move], area: &Area) -> f64 {
    let wanted_m = 2.0 * WIDE * area.half_m;
    let [mut along_x, mut along_y, mut of_both] = [0.0; 3];
    for go in made {
        let by = [go.to.x_m - go.from.x_m, go.to.y_m - go.from.y_m];
        let [x, y] = by.map(|by| (by / wanted_m).clamp(-1.0, 1.0));
        along_x += x * x;
        along_y += y * y;
        of_both += x * y;
    }
    let (mean, half): (f64, f64) = (0.5 * (along_x + along_y), 0.5 * (along_x - along_y));
    let least = mean - half.hypot(of_both);
    (least / (WAYS * PASSES)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::motion::Pose;

    /// Corner to corner, as shares of the area's half.
    fn go(area: &Area, from: [f64; 2], to: [f64; 2]) -> Move {
        let [from, to] = [from, to].map(|[x, y]| Pose {
            x_m: x * area.half_m,
            y_m: y * area.half_m,
            theta_rad: 0.0,
        });
        Move {
            from,
            to,
            speed_m_s: 0.2,
        }
    }

    const SLANTED: [[f64; 2]; 2] = [[-1.0, -1.0], [1.0, 1.0]];
    const ACROSS: [[f64; 2]; 2] = [[-1.0, 1.0], [1.0, -1.0]];

    #[test]
    fn an_area_is_covered_there_and_back_along_two_diagonals() {
        let area = Area::of_survey(Pose::default());
        let there_and_back = |[a, b]: [[f64; 2]; 2]| [go(&area, a, b), go(&area, b, a)];
        let [slanted, across] = [SLANTED, ACROSS].map(there_and_back);
        assert_eq!(covered(&[], &area), 0.0);
        assert_eq!(covered(&[slanted[0], across[0]], &area), 0.5);
        assert_eq!(covered(&[slanted, across].concat(), &area), 1.0);
    }

    #[test]
    fn an_area_is_covered_twice_there_and_back_along_both_axes() {
        let area = Area::of_survey(Pose::default());
        let (a, b, c) = ([-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]);
        let once = [
            go(&area, a, b),
            go(&area, b, a),
            go(&area, a, c),
            go(&area, c, a),
        ];
        assert_eq!(covered(&once, &area), 0.5);
        assert_eq!(covered(&[once, once].concat(), &area), 1.0);
    }

    /// One diagonal, however often, tells nothing of x apart from y.
    #[test]
    fn one_line_covers_no_area() {
        let area = Area::of_survey(Pose::default());
        let [a, b] = SLANTED;
        let often = [go(&area, a, b), go(&area, b, a)].repeat(10);
        assert!(covered(&often, &area) < 1.0e-9);
    }
}
