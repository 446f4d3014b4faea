//! A rest, as one observation of the parity, or under the beacon of g_x and g_y.

use crate::frame::{Coordinate, Frame, Status};
use crate::geometry::Geometry;

/// Faster than this a delay between the sensors is no longer small. A prior: a millisecond of it is a hundredth of a tooth.
pub const FASTEST_M_S: f32 = 0.01;
/// Beyond this share of full scale the diode's bending is no longer small against a tooth. A prior: 17 % of the cube at full scale (Golnabi)
/// are 0.1 mm at half of it, a tenth of a tooth.
pub const MOST_DEFLECTION: f32 = 0.5;
/// Teeth to the unit of a place on the platen. By definition the paper's range of calibration, 10 of them (3.1.2).
const TEETH: f32 = 10.0;
/// Looks that a rest takes. A prior: over 32 ms, at a look each millisecond, vibrations of some tens of hertz average out.
const LOOKS: u16 = 32;

/// What a courier's rests are looked at for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RestKind {
    /// g_x and g_y, under the beacon.
    #[default]
    Beacon,
    /// The parity g_p, wherever the courier is.
    Parity,
}

impl RestKind {
    /// Both, by their numbers.
    pub const ALL: [Self; 2] = [Self::Beacon, Self::Parity];

    /// The number of a channel, of [`RestChange::axis`](super::RestChange::axis).
    pub(super) const fn axis(self, of_two: u8) -> u8 {
        match self {
            Self::Beacon => of_two & 1,
            Self::Parity => 2,
        }
    }
}

/// What is taken of a frame at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glance {
    /// g_x and g_y, metres: the position by the segments less that by the coordination sensor, whole teeth included; or g_p and zero.
    pub g_m: [f32; 2],
    /// Place along x and y: the deflection, of full scale; for g_p by the count of teeth, in tens of them.
    pub place: [f32; 2],
    /// Temperature over the calibration's, kelvin.
    pub temperature_k: f32,
    /// The quarter of a tooth that the courier stands in, along x and y.
    pub cell: [i32; 2],
}

impl Glance {
    /// Of a frame; none where it is in doubt, in motion, or does not show the beacon or too far off. `unusable`: bits of doubtful frames.
    #[must_use]
    #[inline(never)] // or it is compiled as its caller is, for less smallness
    pub fn of(
        kind: RestKind,
        frame: &Frame,
        geometry: &Geometry,
        unusable: Status,
    ) -> Option<Self> {
        // Not a number fails as well.
        let within = |values: &[f32; 2], most: f32| values.iter().all(|value| value.abs() <= most);
        if frame.status.intersects(unusable) || !within(&frame.speed_m_s, FASTEST_M_S) {
            return None;
        }
        let pose = [frame.pose.x, frame.pose.y];
        let (g_m, place, is_of_use) = match kind {
            RestKind::Beacon => {
                let deflection = frame.tan_psi.map(|tan| tan / geometry.tan_full_scale);
                let (platen, sensor) = (&frame.beacon.platen, &frame.beacon.sensor);
                let g_m = [platen.x_m - sensor.x_m, platen.y_m - sensor.y_m];
                let is_near = within(&deflection, MOST_DEFLECTION);
                (g_m, deflection, frame.beacon.seen && is_near)
            }
            RestKind::Parity => {
                let teeth = |place: Coordinate| place.teeth as f32 + place.fraction_turns;
                let place = pose.map(|place| teeth(place) / TEETH);
                ([frame.parity_m, 0.0], place, true)
            }
        };
        let cell = pose.map(|place| {
            // Within a tooth either way: the conversion saturates.
            let quarters = (4.0 * (place.fraction_turns + 8.0)) as i32;
            place.teeth.wrapping_mul(4).wrapping_add(quarters)
        });
        is_of_use.then_some(Self {
            g_m,
            place,
            temperature_k: frame.raw.temperature_delta_k,
            cell,
        })
    }
}

/// One rest: the mean of its glances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// As [`Glance::g_m`].
    pub g_m: [f32; 2],
    /// As [`Glance::place`].
    pub place: [f32; 2],
    /// Temperature over the calibration's, kelvin.
    pub temperature_k: f32,
    /// The quarter of a tooth.
    pub cell: [i32; 2],
}

/// The rest that is under way.
#[derive(Clone, Copy, Debug)]
pub struct Rest {
    first: Glance,
    /// Of what glances have beyond the first.
    sum_m: [f32; 2],
    looks: u16,
}

impl Rest {
    /// None: all zeros.
    pub const NONE: Self = Self {
        first: Glance {
            g_m: [0.0; 2],
            place: [0.0; 2],
            temperature_k: 0.0,
            cell: [0; 2],
        },
        sum_m: [0.0; 2],
        looks: 0,
    };

    /// Takes a glance, or that there was none; the rest, once, when it has lasted long enough in one quarter of a tooth.
    pub fn take(&mut self, glance: Option<&Glance>) -> Option<Visit> {
        let Some(glance) = glance else {
            self.looks = 0;
            return None;
        };
        if self.looks == 0 || self.first.cell != glance.cell {
            (self.first, self.sum_m, self.looks) = (*glance, [0.0; 2], 0);
        }
        if self.looks >= LOOKS {
            return None;
        }
        for (sum_m, (now_m, first_m)) in self
            .sum_m
            .iter_mut()
            .zip(glance.g_m.iter().zip(self.first.g_m))
        {
            *sum_m += now_m - first_m;
        }
        self.looks += 1;
        (self.looks == LOOKS).then(|| Visit {
            g_m: [0, 1].map(|axis| self.first.g_m[axis] + self.sum_m[axis] / f32::from(LOOKS)),
            place: self.first.place,
            temperature_k: self.first.temperature_k,
            cell: self.first.cell,
        })
    }
}
