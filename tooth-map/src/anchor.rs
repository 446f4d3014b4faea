//! Where a map lies on the platen: tooth counts begin anew at each start of a board, the beacon stands where it stood.

use courier_sensor::maps::homing;
use serde::{Deserialize, Serialize};

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
    /// As a board stores it and places the map by it.
    pub fn on_board(&self) -> homing::Anchor {
        let places = self.beacon_m.map(|place_m| {
            let teeth = (place_m / self.pitch_m).round();
            (teeth as i32, (place_m - teeth * self.pitch_m) as f32)
        });
        homing::Anchor {
            beacon_teeth: places.map(|(teeth, _)| teeth),
            beacon_m: places.map(|(_, rest_m)| rest_m),
            height_m: self.height_m as f32,
            lever_m: self.lever_m.map(|length_m| length_m as f32),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::frame::{Coordinate, Pose};
    use courier_sensor::geometry::Geometry;

    const ANCHOR: Anchor = Anchor {
        beacon_m: [22.1e-3, 25.0e-3],
        height_m: 51.0e-3,
        lever_m: [90.7e-3, 4.6e-3],
        pitch_m: 1.016e-3,
        tan_full_scale: 0.1,
    };

    /// Equation (11) without residual: the platen sensor's place.
    fn place_m(theta: f64, tan_psi: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = theta.sin_cos();
        let [lx, ly] = ANCHOR.lever_m;
        let x = ANCHOR.height_m * tan_psi[0] + lx;
        let y = ANCHOR.height_m * tan_psi[1] + ly;
        [
            ANCHOR.beacon_m[0] - lx + cosine * x - sine * y,
            ANCHOR.beacon_m[1] - ly + sine * x + cosine * y,
        ]
    }

    /// The board's f32 against f64, to 0.1 um.
    #[test]
    fn a_board_counts_ahead_of_the_map_what_it_is() {
        for (theta, tan_psi) in [
            (0.0, [0.0, 0.0]),
            (0.02, [0.03, -0.04]),
            (-0.03, [-0.02, 0.01]),
        ] {
            let place = place_m(theta, tan_psi);
            let wanted = [-22.1, 7.4];
            let [x, y] = [0, 1].map(|axis| {
                let turns = place[axis] / ANCHOR.pitch_m + wanted[axis];
                Coordinate {
                    teeth: turns.round() as i32,
                    fraction_turns: (turns - turns.round()) as f32,
                }
            });
            let pose = Pose {
                x,
                y,
                theta_rad: theta as f32,
                ..Pose::default()
            };
            let tan_psi = tan_psi.map(|t| t as f32);
            let ahead = ANCHOR.on_board().ahead(&Geometry::PAPER, &pose, tan_psi);
            for (ahead, wanted) in ahead.into_iter().zip(wanted) {
                let found = f64::from(ahead.teeth) + f64::from(ahead.fraction_turns);
                assert!((found - wanted).abs() < 1.0e-4, "{found} for {wanted}");
                assert!(ahead.fraction_turns.abs() <= 0.5);
            }
        }
    }

    #[test]
    fn the_beacon_has_its_place_in_the_boards_count() {
        let (teeth, left_m) = ANCHOR.on_board().origin([-22, 7], &Geometry::PAPER);
        // (22.1 - 90) / 1.016 - 22 and (25 - 5) / 1.016 + 7 teeth.
        assert_eq!(teeth, [-89, 27]);
        assert!((left_m[0] - 0.172e-3).abs() < 1e-7 && (left_m[1] + 0.32e-3).abs() < 1e-7);
    }
}
