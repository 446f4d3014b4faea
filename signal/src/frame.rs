//! What passes between the interrupt and the background: the raw frame in, the corrected frame out.
//!
//! Order of segments everywhere: index 0..=3 is the paper's 1..=4; 1 and 3 measure x, 2 and 4 measure y.

/// Number of magnetic quadrature-pair segments, by definition of the sensor (paper, section 1).
pub const SEGMENTS: usize = 4;

/// One instant's conversion of all channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RawFrame {
    /// `[segment][sine, cosine]`, signed converter counts.
    pub quadrature_counts: [[i16; 2]; SEGMENTS],
    /// Coordination sensor's electrodes `x+, x-, y+, y-`, signed converter counts.
    pub electrode_counts: [i16; 4],
    /// Board temperature minus the reference temperature of the calibration, kelvin (slow input, last known).
    pub temperature_delta_k: f32,
    /// What the sampler already knows to be wrong with this instant.
    pub fault: Status,
}

bitflags::bitflags! {
    /// Everything that can be wrong with a frame. Stable bit numbers: `docs/faults.md` has a line for each.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
    pub struct Status: u32 {
        /// Segment 1's amplitude is below its lower limit (a dead channel reads so); bits 1 to 3: segments 2 to 4.
        const AMPLITUDE_LOW_1 = 1 << 0;
        #[allow(missing_docs)]
        const AMPLITUDE_LOW_2 = 1 << 1;
        #[allow(missing_docs)]
        const AMPLITUDE_LOW_3 = 1 << 2;
        #[allow(missing_docs)]
        const AMPLITUDE_LOW_4 = 1 << 3;
        /// Segment 1's amplitude is above its upper limit; bits 5 to 7: segments 2 to 4.
        const AMPLITUDE_HIGH_1 = 1 << 4;
        #[allow(missing_docs)]
        const AMPLITUDE_HIGH_2 = 1 << 5;
        #[allow(missing_docs)]
        const AMPLITUDE_HIGH_3 = 1 << 6;
        #[allow(missing_docs)]
        const AMPLITUDE_HIGH_4 = 1 << 7;
        /// A channel of segment 1 sits at the converter's end; bits 9 to 11: segments 2 to 4.
        const CLIPPED_1 = 1 << 8;
        #[allow(missing_docs)]
        const CLIPPED_2 = 1 << 9;
        #[allow(missing_docs)]
        const CLIPPED_3 = 1 << 10;
        #[allow(missing_docs)]
        const CLIPPED_4 = 1 << 11;
        /// Segment 1's phase moved too far in one sample for its tooth count to be sure; bits 13 to 15: segments 2 to 4.
        /// Latched until the counter is set again.
        const SLIP_1 = 1 << 12;
        #[allow(missing_docs)]
        const SLIP_2 = 1 << 13;
        #[allow(missing_docs)]
        const SLIP_3 = 1 << 14;
        #[allow(missing_docs)]
        const SLIP_4 = 1 << 15;
        /// No beacon: the electrodes' sums are below their limit; tan psi is zero.
        const BEACON_MISSING = 1 << 16;
        /// An electrode sits at the converter's end.
        const BEACON_SATURATED = 1 << 17;
        /// The converter's CRC did not match: the previous frame's counts stand in.
        const CONVERTER_CRC = 1 << 18;
        /// The converter's busy line never fell: the previous frame's counts stand in.
        const CONVERTER_TIMEOUT = 1 << 19;
        /// At least one sampling instant was missed before this frame; `sequence` counts them. Latched, with the slip bits, if so
        /// many were missed that a tooth may have gone by unseen.
        const OVERRUN = 1 << 20;
        /// No calibration is in force: the pose is the unmodified outputs'.
        const UNCALIBRATED = 1 << 21;
        /// A result was not finite or outside its range and was replaced by zero.
        const NUMERIC = 1 << 22;
        /// The counts have not changed for longer than noise allows: the converter is frozen.
        const FROZEN = 1 << 23;
        /// The two angles disagree by more than any error of the segments: some segment's tooth count is off.
        const PARITY = 1 << 24;
        /// A tooth map is in force and a segment is outside its trusted area: its field is taken as zero there.
        const OUTSIDE_MAP = 1 << 25;
        /// One channel of segment 1 does not change, away from zero, while the other of its pair does: its amplifier cuts it off below
        /// the converter's end, or it is stuck; bits 27 to 29: segments 2 to 4.
        const RAIL_1 = 1 << 26;
        #[allow(missing_docs)]
        const RAIL_2 = 1 << 27;
        #[allow(missing_docs)]
        const RAIL_3 = 1 << 28;
        #[allow(missing_docs)]
        const RAIL_4 = 1 << 29;
        /// A segment's error, or what the beacon shows, has changed since the calibration in force was made: the status says which, and by how much.
        const CALIBRATION_DRIFT = 1 << 30;
    }
}

/// What the bits of a segment mean, by the first bit of the four.
const OF_SEGMENTS: [(u32, &str); 5] = [
    (0, "amplitude too low"),
    (4, "amplitude too high"),
    (8, "clipped at the converter's end"),
    (12, "tooth count not sure"),
    (
        26,
        "clipped or stuck: one channel stands while the other of its pair changes",
    ),
];
/// What the other bits mean.
const OF_ALL: [(Status, &str); 11] = [
    (Status::BEACON_MISSING, "no beacon seen"),
    (
        Status::BEACON_SATURATED,
        "light on the coordination sensor at the converter's end",
    ),
    (
        Status::CONVERTER_CRC,
        "checksum of the converter's data wrong",
    ),
    (Status::CONVERTER_TIMEOUT, "converter does not answer"),
    (Status::OVERRUN, "samples missed"),
    (Status::UNCALIBRATED, "no calibration in force"),
    (Status::NUMERIC, "a result out of range, replaced by zero"),
    (Status::FROZEN, "converter frozen: counts do not change"),
    (
        Status::PARITY,
        "the two angles disagree by a wrong tooth count",
    ),
    (Status::OUTSIDE_MAP, "outside the tooth map"),
    (Status::CALIBRATION_DRIFT, "the calibration has drifted"),
];

/// In words, for people: `segment 2 clipped at the converter's end, samples missed`; `ok` without any bit.
impl core::fmt::Display for Status {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let mut between = "";
        for (first, words) in OF_SEGMENTS {
            for segment in (0..SEGMENTS).filter(|i| self.bits() & (1 << (first + *i as u32)) != 0) {
                write!(formatter, "{between}segment {} {words}", segment + 1)?;
                between = ", ";
            }
        }
        for (_, words) in OF_ALL.iter().filter(|(bit, _)| self.contains(*bit)) {
            write!(formatter, "{between}{words}")?;
            between = ", ";
        }
        if self.is_empty() {
            formatter.write_str("ok")?;
        }
        Ok(())
    }
}

/// A length as whole teeth and a fraction of one: f32 metres over a metre of platen resolve only 60 nm.
///
/// Value: `(teeth + fraction_turns) * pitch`. The fraction may leave ±0.5 by the size of a correction.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Coordinate {
    /// Whole teeth.
    pub teeth: i32,
    /// Rest, in pitches.
    pub fraction_turns: f32,
}

impl Coordinate {
    /// This minus another, in pitches; exact to f32 while they are within some teeth of each other.
    #[inline(always)]
    pub fn minus_turns(self, other: Self) -> f32 {
        self.teeth.wrapping_sub(other.teeth) as f32 + (self.fraction_turns - other.fraction_turns)
    }

    /// Middle of two coordinates; half a tooth goes to the fraction.
    #[inline(always)]
    pub fn mean(self, other: Self) -> Self {
        let teeth = self.teeth.wrapping_add(other.teeth);
        let fraction_turns =
            0.5 * (self.fraction_turns + other.fraction_turns + (teeth & 1) as f32);
        Self {
            teeth: teeth >> 1,
            fraction_turns,
        }
    }

    /// As one number of metres, f64: for the host and for slow work.
    pub fn metres(self, pitch_m: f32) -> f64 {
        (f64::from(self.teeth) + f64::from(self.fraction_turns)) * f64::from(pitch_m)
    }
}

/// One segment's part of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Segment {
    /// Unmodified output: tooth count and phase in (-0.5, 0.5] turns.
    pub unmodified: Coordinate,
    /// Calibrated output p-hat = p-bar + e, same tooth count.
    pub calibrated: Coordinate,
    /// Signal amplitude after offset and gain correction, counts.
    pub amplitude_counts: f32,
}

/// Planar pose of the platen sensor's centre.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Pose {
    /// Mean of segments 1 and 3.
    pub x: Coordinate,
    /// Mean of segments 2 and 4.
    pub y: Coordinate,
    /// Angle by segments 1 and 3, equation (4).
    pub theta_x_rad: f32,
    /// Angle by segments 2 and 4, equation (4).
    pub theta_y_rad: f32,
    /// Mean of the two.
    pub theta_rad: f32,
}

/// Position of the platen sensor's centre relative to the beacon, in the platen's axes, and the angle that goes with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RelativePose {
    /// Along x, metres.
    pub x_m: f32,
    /// Along y, metres.
    pub y_m: f32,
    /// Angle, rad.
    pub theta_rad: f32,
}

/// Pose relative to the beacon; all zero and `seen` false without one, or without a calibrated coordination sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BeaconPose {
    /// Whether the rest means anything.
    pub seen: bool,
    /// By the coordination sensor and the platen's angle, equations (10) and (11).
    pub sensor: RelativePose,
    /// By the platen sensor alone.
    pub platen: RelativePose,
    /// Both, weighted by their covariance.
    pub fused: RelativePose,
}

/// One sample's result.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// Counts sampling instants since start, modulo 2^32; a gap is missed instants or lost frames.
    pub sequence: u32,
    /// What is wrong with it.
    pub status: Status,
    /// The counts it was computed from.
    pub raw: RawFrame,
    /// Per segment.
    pub segments: [Segment; SEGMENTS],
    /// Calibrated pose.
    pub pose: Pose,
    /// Parity of the two angles, g_p of equation (5), metres.
    pub parity_m: f32,
    /// Filtered speeds of segments 1 and 3 (along x) and 2 and 4 (along y), m/s.
    pub speed_m_s: [f32; 2],
    /// Last directions of travel outside the dead band along x and y: -1, 0 (none yet) or 1; kept if the model or the
    /// settings ask for it, else 0.
    pub direction: [f32; 2],
    /// Coordination sensor: tan psi_x, tan psi_y; zero without a beacon.
    pub tan_psi: [f32; 2],
    /// Pose relative to the beacon.
    pub beacon: BeaconPose,
}

impl Frame {
    /// All zeros.
    pub const ZERO: Self = {
        const AT_ZERO: Coordinate = Coordinate {
            teeth: 0,
            fraction_turns: 0.0,
        };
        const RELATIVE: RelativePose = RelativePose {
            x_m: 0.0,
            y_m: 0.0,
            theta_rad: 0.0,
        };
        Self {
            sequence: 0,
            status: Status::empty(),
            raw: RawFrame {
                quadrature_counts: [[0; 2]; SEGMENTS],
                electrode_counts: [0; 4],
                temperature_delta_k: 0.0,
                fault: Status::empty(),
            },
            segments: [Segment {
                unmodified: AT_ZERO,
                calibrated: AT_ZERO,
                amplitude_counts: 0.0,
            }; SEGMENTS],
            pose: Pose {
                x: AT_ZERO,
                y: AT_ZERO,
                theta_x_rad: 0.0,
                theta_y_rad: 0.0,
                theta_rad: 0.0,
            },
            parity_m: 0.0,
            speed_m_s: [0.0; 2],
            direction: [0.0; 2],
            tan_psi: [0.0; 2],
            beacon: BeaconPose {
                seen: false,
                sensor: RELATIVE,
                platen: RELATIVE,
                fused: RELATIVE,
            },
        }
    };
}
