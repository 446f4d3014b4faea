//! Teeth of the platen as the segments of a pair read them: each the mean of those under its aperture, both of the same teeth.

use serde::{Deserialize, Serialize};

/// Teeth along and across a segment that its reading averages: the fewest that are built (the more there are, the smoother).
const APERTURE_PITCHES: f64 = 4.0;

/// Knots to either side that an aperture reaches at most, the knots this many pitches apart.
#[must_use]
pub fn reach(step_pitches: f64) -> i32 {
    ((0.5 * APERTURE_PITCHES + 0.5) / step_pitches)
        .ceil()
        .max(1.0) as i32
}

/// Share of a knot in a reading so many knots away, the knots this many pitches apart: overlap with the aperture at the
/// knots, linear between them.
#[must_use]
pub fn share(knots_away: f64, step_pitches: f64) -> f64 {
    let at = |k: f64| (0.5 * APERTURE_PITCHES + 0.5 - k * step_pitches).clamp(0.0, 1.0);
    let away = knots_away.abs();
    let (first, part) = (away.floor(), away.fract());
    let first_share = if first == 0.0 { 1.0 } else { at(first) };
    (1.0 - part) * first_share + part * at(first + 1.0)
}

/// What a segment's reading averages over: flat to its edges, which fall smoothly (a cubic, level at both ends).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ApertureKernel {
    /// Half of it along and across the segment's direction, pitches.
    pub half_pitches: [f64; 2],
    /// Share of each half that is its edge: 1 is a bell, near 0 a box.
    pub edge: f64,
}

impl ApertureKernel {
    /// Share of a tooth so many pitches away along (0) or across (1) the segment, of all that the aperture holds.
    #[must_use]
    pub fn weight(&self, direction: usize, away_pitches: f64) -> f64 {
        let (half, away) = (self.half_pitches[direction], away_pitches.abs());
        if away >= half {
            return 0.0;
        }
        let flat = half * (1.0 - self.edge);
        let fall = ((away - flat) / (half - flat)).max(0.0);
        (1.0 - fall * fall * (3.0 - 2.0 * fall)) / (half * (2.0 - self.edge))
    }

    /// Sum of the squared shares along or across, teeth being a pitch apart.
    #[must_use]
    pub fn squares(&self, direction: usize) -> f64 {
        const STEPS: i32 = 40;
        let step = self.half_pitches[direction] / f64::from(STEPS);
        let at = |k: i32| self.weight(direction, (f64::from(k) + 0.5) * step).powi(2);
        2.0 * step * (0..STEPS).map(at).sum::<f64>()
    }
}

/// Teeth that a recording passed, and how its segments read them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Teeth {
    /// What a reading averages over.
    #[serde(rename = "footprint")]
    pub aperture: ApertureKernel,
    /// Pitches from one amount to the next along and across a segment: 1, or more under an aperture that blurs single teeth.
    pub step_pitches: [f64; 2],
    /// Prior deviation of a tooth's displacement and of a whole line's, m.
    pub deviation_m: [f64; 2],
    /// Teeth along and across in such steps, displaced along x (seen by segments 1 and 3) and along y (2 and 4).
    pub posts: [Vec<[i32; 2]>; 2],
    /// Whole lines of them.
    pub lines: [Vec<i32>; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_footprint_holds_the_whole_of_what_it_averages() {
        for edge in [0.1, 0.5, 1.0] {
            let aperture = ApertureKernel {
                half_pitches: [3.2, 4.7],
                edge,
            };
            for direction in 0..2 {
                let shares =
                    (-600..600).map(|k| 0.01 * aperture.weight(direction, f64::from(k) * 0.01));
                assert!(
                    (shares.sum::<f64>() - 1.0).abs() < 1e-3,
                    "{edge} {direction}"
                );
                let squares = (-600..600)
                    .map(|k| 0.01 * aperture.weight(direction, f64::from(k) * 0.01).powi(2));
                assert!((squares.sum::<f64>() - aperture.squares(direction)).abs() < 1e-3);
            }
        }
    }
}
