//! What the watch says.

use super::places::Place;
use serde::{Deserialize, Serialize};

/// How the calibration in force stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Standing {
    /// Nothing is watched: there is no calibration in force.
    #[default]
    Unwatched,
    /// The motion so far does not suffice yet to know what the calibration left.
    Learning,
    /// No segment's error has changed by as much as is told.
    Healthy,
    /// A change is told, [`Change`].
    Drifting,
    /// It is above the limit: calibrate again.
    Stale,
    /// Nothing is told, and not all of what is watched shows in this motion: [`Verdict::seen`].
    NotObservable,
}

/// A change of one segment's error at one order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Segment, 0 to 3.
    pub segment: u8,
    /// Order of its own phase: 1, 2, 4 or 6.
    pub order: u8,
    /// The other segment of the pair, where it would explain what is seen nearly as well: this motion turns too little to tell.
    pub or_segment: Option<u8>,
    /// Size, metres rms over a tooth.
    pub size_m: f32,
    /// Its standard deviation, metres.
    pub deviation_m: f32,
    /// When there was last no sign of it, seconds since the board's start.
    pub since_s: u32,
    /// When it was told.
    pub told_s: u32,
    /// Temperature then over that of the reference, kelvin: a coordinate that it may follow.
    pub warmer_k: f32,
    /// Size at which the calibration is stale, metres rms.
    pub limit_m: f32,
    /// Seconds until then, if it goes on as since it was told; none if it does not grow.
    pub limit_in_s: Option<u32>,
}

/// What is known of the calibration in force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// How it stands.
    pub standing: Standing,
    /// What the last window determined: bits 0 to 3 for orders 1, 2, 4 and 6 of segment 1, and so on.
    pub seen: u16,
    /// Windows so far.
    pub windows: u32,
    /// What is left in the parity of one reading beside the last, metres: correlation taken out.
    pub scatter_m: f32,
    /// When the last reading came, seconds since the board's start.
    pub at_s: u32,
    /// What has changed, if that is told.
    pub change: Option<Change>,
}

impl Verdict {
    /// Segment, from 1, and order of everything that the last window did not determine.
    pub fn unseen(&self) -> impl Iterator<Item = (usize, u8)> + '_ {
        Place::all()
            .filter(|place| self.seen & place.bit() == 0)
            .map(|place| (place.segment() + 1, place.order()))
    }
}

/// In words, for people.
impl core::fmt::Display for Verdict {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match (self.standing, &self.change) {
            (Standing::Unwatched, _) => f.write_str("not watched: no calibration is in force"),
            (Standing::Learning, _) => {
                f.write_str("not known yet: too little motion since the calibration came in force")
            }
            (Standing::NotObservable, _) => {
                f.write_str("no change seen; this motion does not show")?;
                let mut before = 0;
                for (segment, order) in self.unseen() {
                    if segment == before {
                        write!(f, ", {order}")?;
                    } else {
                        let between = if before == 0 { "" } else { ";" };
                        write!(f, "{between} segment {segment}'s orders {order}")?;
                    }
                    before = segment;
                }
                Ok(())
            }
            (_, Some(change)) => write!(f, "{change}"),
            (_, None) if self.windows == 0 => {
                f.write_str("as calibrated, as it was found before this start")
            }
            (_, None) => write!(
                f,
                "as calibrated, by {} windows of motion up to {} s",
                self.windows, self.at_s
            ),
        }
    }
}

impl core::fmt::Display for Change {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let um = |metres: f32| 1.0e6 * f64::from(metres);
        write!(
            f,
            "segment {}{}'s order {} has changed by {:.2} ± {:.2} µm rms, after {} s, told at {} s",
            self.segment + 1,
            Or(self.or_segment),
            self.order,
            um(self.size_m),
            um(self.deviation_m),
            self.since_s,
            self.told_s
        )?;
        if self.warmer_k.abs() >= 1.0 {
            write!(f, ", {:+.1} K from the reference", self.warmer_k)?;
        }
        let limit_um = um(self.limit_m);
        match self.limit_in_s {
            _ if self.size_m >= self.limit_m => write!(f, "; stale above {limit_um:.1} µm"),
            Some(seconds) => write!(
                f,
                "; stale at {limit_um:.1} µm, in {:.1} h if it goes on",
                f64::from(seconds) / 3600.0
            ),
            None => write!(f, "; stale at {limit_um:.1} µm"),
        }
    }
}

/// Another segment, in words.
struct Or(Option<u8>);

impl core::fmt::Display for Or {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.0
            .map_or(Ok(()), |segment| write!(f, " or {}", segment + 1))
    }
}
