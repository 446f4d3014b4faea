//! Parts of the platen and of a recording that something acts over: what cannot act at some samples is not asked at each of them.

use crate::covariates::Covariates;

/// What is over a part of the platen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seat {
    /// The sensor's centre: along x and y.
    Centre,
    /// A segment: along its own direction and across it.
    Segment(usize),
    /// Either segment of a pair.
    Pair(usize),
}

/// A rectangle of the platen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Over {
    /// What must be within.
    pub seat: Seat,
    /// One corner, m.
    pub from_m: [f64; 2],
    /// The other, m.
    pub to_m: [f64; 2],
}

impl Over {
    /// So far to either side of a place.
    #[must_use]
    pub fn about(seat: Seat, place_m: [f64; 2], reach_m: [f64; 2]) -> Self {
        let corner = |sign: f64| [0, 1].map(|d| place_m[d] + sign * reach_m[d]);
        Self {
            seat,
            from_m: corner(-1.0),
            to_m: corner(1.0),
        }
    }

    /// True if what must be within is there at a sample.
    #[must_use]
    pub fn holds(&self, covariates: &Covariates) -> bool {
        let within = |place: &[f64; 2]| {
            (0..2).all(|d| place[d] >= self.from_m[d] && place[d] <= self.to_m[d])
        };
        match self.seat {
            Seat::Centre => within(&covariates.centre_m),
            Seat::Segment(s) => within(&covariates.place_m[s]),
            Seat::Pair(direction) => {
                within(&covariates.place_m[direction]) || within(&covariates.place_m[direction + 2])
            }
        }
    }

    /// False if it is there at none of some samples.
    fn touches(&self, extent: &Extent) -> bool {
        let meets = |box_: &Rectangle| {
            (0..2).all(|d| box_[d][1] >= self.from_m[d] && box_[d][0] <= self.to_m[d])
        };
        match self.seat {
            Seat::Centre => meets(&extent.centre_m),
            Seat::Segment(s) => meets(&extent.place_m[s]),
            Seat::Pair(direction) => {
                meets(&extent.place_m[direction]) || meets(&extent.place_m[direction + 2])
            }
        }
    }
}

/// Smallest and largest value along either direction.
type Rectangle = [[f64; 2]; 2];

/// Nothing yet. By definition of a range that the first value makes its own.
const EMPTY: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// How far some samples reach, over the recording and over the platen.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    progress: [f64; 2],
    centre_m: Rectangle,
    place_m: [Rectangle; 4],
}

impl Extent {
    /// Of these samples.
    #[must_use]
    pub fn of<'a>(moments: impl IntoIterator<Item = &'a Covariates>) -> Self {
        let mut out = Self {
            progress: EMPTY,
            centre_m: [EMPTY; 2],
            place_m: [[EMPTY; 2]; 4],
        };
        let reach = |[low, high]: &mut [f64; 2], value: f64| {
            *low = low.min(value);
            *high = high.max(value);
        };
        for covariates in moments {
            reach(&mut out.progress, covariates.progress);
            for d in 0..2 {
                reach(&mut out.centre_m[d], covariates.centre_m[d]);
                for s in 0..4 {
                    reach(&mut out.place_m[s][d], covariates.place_m[s][d]);
                }
            }
        }
        out
    }

    /// False if what acts within some progress of a recording, and over some part of the platen, acts at none of the samples.
    #[must_use]
    pub fn meets(&self, during: [f64; 2], over: Option<&Over>) -> bool {
        let now = self.progress[1] >= during[0] && self.progress[0] <= during[1];
        now && over.is_none_or(|over| over.touches(self))
    }
}
