//! How much of its area a recording has gone over, for what shows in no column before it is there: wandering offsets, flat tops, bursts.

use crate::motion::{Area, Move};

/// Share of the area's width that counts as gone over. A prior: what lies beyond is passed by the ends' slow parts alone.
const WIDE: f64 = 0.8;
/// Both ways along both axes. By definition two by two.
const WAYS: usize = 4;
/// Times that each way is gone. Derived from what parts the two: what is passed again at another time tells what goes with the
/// place from what goes with the time.
const PASSES: usize = 2;

/// How far the motions made so far go over their area in both directions of both axes: 1 is all.
#[must_use]
pub fn covered(made: &[Move], area: &Area) -> f64 {
    let mut ways: [Vec<f64>; WAYS] = Default::default();
    for go in made {
        let by = [go.to.x_m - go.from.x_m, go.to.y_m - go.from.y_m];
        for (axis, by) in by.into_iter().enumerate() {
            ways[2 * axis + usize::from(by < 0.0)].push(by.abs());
        }
    }
    let wanted_m = 2.0 * WIDE * area.half_m;
    let gone = |mut way: Vec<f64>| {
        way.sort_by(|a, b| b.total_cmp(a));
        let longest = way.iter().take(PASSES);
        longest.map(|by| (by / wanted_m).min(1.0)).sum::<f64>()
    };
    ways.into_iter().map(gone).sum::<f64>() / (WAYS * PASSES) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::motion::Pose;

    #[test]
    fn an_area_is_covered_twice_there_and_back_along_both_axes() {
        let area = Area::of_survey(Pose::default());
        let [a, b] = [-1.0, 1.0].map(|side| Pose {
            x_m: side * area.half_m,
            y_m: side * area.half_m,
            theta_rad: 0.0,
        });
        let go = |from, to| Move {
            from,
            to,
            speed_m_s: 0.2,
        };
        assert_eq!(covered(&[], &area), 0.0);
        let once = [go(a, b), go(b, a)];
        assert_eq!(covered(&once[..1], &area), 0.25);
        assert_eq!(covered(&once, &area), 0.5);
        assert_eq!(covered(&[once, once].concat(), &area), 1.0);
    }
}
