//! Where a map lies on the platen: tooth counts begin anew at each start of a board, the beacon stands where it stood.
//!
//! A pose under the same beacon has the same place on the platen, by equation (11) of the map's own fit; what the board counts there
//! now, less that, is a whole number of teeth either way.

use anyhow::{Result, ensure};
use courier_sensor::frame::Pose;
use serde::{Deserialize, Serialize};

/// Largest part of a tooth left over: the diode's bending and the platen's errors are some hundredths.
const LEFT_TEETH: f64 = 0.25;
/// Beyond this deflection the diode's bending is no longer small against a tooth.
const MOST_DEFLECTION: f64 = 0.5;

/// The beacon as the map's fit found it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Anchor {
    /// Place of the platen sensor with the coordination sensor under the beacon at angle zero, metres from the tooth count zero of
    /// the map's recording.
    pub beacon_m: [f64; 2],
    /// Height h, metres.
    pub height_m: f64,
    /// l_x, l_y, metres.
    pub lever_m: [f64; 2],
    /// Tooth pitch, metres.
    pub pitch_m: f64,
    /// tan psi at a deflection of 1.
    pub tan_full_scale: f64,
}

impl Anchor {
    /// Teeth by which a board's count is ahead of the map's, along x and y.
    ///
    /// # Errors
    /// The beacon is too far from the diode's middle, or the counts do not differ by whole teeth: another beacon, or another
    /// calibration than the map's.
    pub fn teeth_ahead(&self, pose: &Pose, tan_psi: [f32; 2]) -> Result<[i32; 2]> {
        let deflection = tan_psi.map(|t| f64::from(t) / self.tan_full_scale);
        let farthest = deflection[0].abs().max(deflection[1].abs());
        ensure!(
            farthest <= MOST_DEFLECTION,
            "the board: found the beacon at {farthest:.2} of the diode's range, wanted {MOST_DEFLECTION} or less: stand under it"
        );
        let place_m = self.place_m(f64::from(pose.theta_rad), tan_psi.map(f64::from));
        let mut teeth = [0; 2];
        for (axis, counted) in [pose.x, pose.y].into_iter().enumerate() {
            let counted = f64::from(counted.teeth) + f64::from(counted.fraction_turns);
            let ahead = counted - place_m[axis] / self.pitch_m;
            let left = ahead - ahead.round();
            ensure!(
                left.abs() <= LEFT_TEETH,
                "the board: found its count {ahead:.2} teeth ahead of the map's along {}, wanted a whole number within {LEFT_TEETH}: is this the map's beacon, unmoved?",
                ["x", "y"][axis]
            );
            teeth[axis] = ahead.round() as i32;
        }
        Ok(teeth)
    }

    /// The beacon's place o' in the counts of a board that is so many teeth ahead, for its own lever arm: whole teeth, and the rest
    /// in metres.
    pub fn origin(&self, teeth_ahead: [i32; 2], lever_m: [f32; 2]) -> ([i32; 2], [f32; 2]) {
        let places = [0, 1].map(|axis| {
            let here = (self.beacon_m[axis] - f64::from(lever_m[axis])) / self.pitch_m;
            here + f64::from(teeth_ahead[axis])
        });
        let left = places.map(|place| ((place - place.round()) * self.pitch_m) as f32);
        (places.map(|place| place.round() as i32), left)
    }

    /// Equation (11) without residual: the platen sensor's place.
    fn place_m(&self, theta: f64, tan_psi: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = theta.sin_cos();
        let [lx, ly] = self.lever_m;
        let [x, y] = [
            self.height_m * tan_psi[0] + lx,
            self.height_m * tan_psi[1] + ly,
        ];
        [
            self.beacon_m[0] - lx + cosine * x - sine * y,
            self.beacon_m[1] - ly + sine * x + cosine * y,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::frame::Coordinate;

    const ANCHOR: Anchor = Anchor {
        beacon_m: [22.1e-3, 25.0e-3],
        height_m: 51.0e-3,
        lever_m: [90.7e-3, 4.6e-3],
        pitch_m: 1.016e-3,
        tan_full_scale: 0.1,
    };

    /// What a board counts `ahead` of the map at a place under the beacon.
    fn pose(theta: f64, tan_psi: [f64; 2], ahead: [f64; 2]) -> Pose {
        let place = ANCHOR.place_m(theta, tan_psi);
        let [x, y] = [0, 1].map(|axis| {
            let turns = place[axis] / ANCHOR.pitch_m + ahead[axis];
            Coordinate {
                teeth: turns.round() as i32,
                fraction_turns: (turns - turns.round()) as f32,
            }
        });
        Pose {
            x,
            y,
            theta_rad: theta as f32,
            ..Pose::default()
        }
    }

    #[test]
    fn whole_teeth_are_found_and_nothing_else() {
        for (theta, tan_psi) in [
            (0.0, [0.0, 0.0]),
            (0.02, [0.03, -0.04]),
            (-0.03, [-0.02, 0.01]),
        ] {
            let here = pose(theta, tan_psi, [-22.1, 7.05]);
            let found = ANCHOR
                .teeth_ahead(&here, tan_psi.map(|t| t as f32))
                .unwrap();
            assert_eq!(found, [-22, 7]);
            let moved = pose(theta, tan_psi, [3.0, 0.4]);
            let error = ANCHOR
                .teeth_ahead(&moved, tan_psi.map(|t| t as f32))
                .unwrap_err();
            assert!(
                error
                    .to_string()
                    .contains("0.40 teeth ahead of the map's along y"),
                "{error}"
            );
        }
        let (teeth, left_m) = ANCHOR.origin([-22, 7], [90.0e-3, 5.0e-3]);
        // (22.1 - 90) / 1.016 - 22 and (25 - 5) / 1.016 + 7 teeth.
        assert_eq!(teeth, [-89, 27]);
        assert!((left_m[0] - 0.172e-3).abs() < 1e-7 && (left_m[1] + 0.32e-3).abs() < 1e-7);
        let far = ANCHOR
            .teeth_ahead(&Pose::default(), [0.08, 0.0])
            .unwrap_err();
        assert!(
            far.to_string().contains("0.80 of the diode's range"),
            "{far}"
        );
    }
}
