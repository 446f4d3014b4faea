//! What the sensor knows at one sample.

/// Lengths over which a direction of travel turns over. A definition: the lengths of the diagnosis' play operator, `GRADUAL_M`
/// and `EVEN_M`.
pub const TURNOVERS: usize = 10;
/// Those of them that turn over gradually; the others do evenly, and stop. A definition: as many as `GRADUAL_M` has.
pub const GRADUAL: usize = 4;
/// Highest order of the own tooth phase that is tabulated, calibrated or unmodified.
pub const ORDERS: usize = courier_signal::model::MAX_OWN_ORDER as usize;
/// Highest order of the lateral tooth phase that is tabulated.
pub const LATERAL_ORDERS: usize = courier_signal::model::MAX_LATERAL_ORDER as usize;

/// Most logged columns that are asked for. A bound on the work: of a recording with more, the first four are coordinates.
pub const MOST_LOGGED: usize = 4;

/// Times after which a mount has followed the board's temperature to 1/e, s: of a coil, of what holds it, and of a courier that is
/// warmed through slowly.
/// A prior: each is four times the one before, so that two of them make any between.
pub const LAGS_S: [f64; 3] = [5.0, 20.0, 80.0];

/// `[segment][n]` = (sin, cos) of n times a phase.
pub type Harmonics = [[(f64, f64); ORDERS + 1]; 4];

/// What the sensor knows at one sample, from calibrated readings. Lengths in metres, angles in radians, SI throughout.
/// What is not measured is zero, and [`BasisInputs`](crate::sensor::BasisInputs) says so.
#[derive(Clone, Debug)]
pub struct Covariates {
    /// Since the first sample, divided by the recording's length: 0 to 1.
    pub progress: f64,
    /// Time, s.
    pub t_s: f64,
    /// Number of the stretch (an unbroken piece of one run).
    pub stretch: usize,
    /// Tooth phase of the unmodified output, rad.
    pub raw_phase: [f64; 4],
    /// Tooth phase of the reference at the segment, rad; zero without one.
    pub reference_phase: [f64; 4],
    /// What equation (3) makes of a small displacement of the unmodified output: 1 and its slope there.
    pub calibration_gain: [f64; 4],
    /// `raw[segment][n]` = (sin, cos) of n times the unmodified output's phase: what equation (3) is written in.
    pub raw: Harmonics,
    /// `own[segment][n] = (sin, cos)` of n times the own tooth phase.
    pub own: Harmonics,
    /// `lateral[segment][m] = (sin, cos)` of m times the tooth phase across the segment.
    pub lateral: [[(f64, f64); LATERAL_ORDERS + 1]; 4],
    /// Where each segment is on the platen: along its own direction and across it, m.
    pub place_m: [[f64; 2]; 4],
    /// Centre of the sensor, m.
    pub centre_m: [f64; 2],
    /// The same less its mean over the recording, m.
    pub from_middle_m: [f64; 2],
    /// Angle of the courier, rad.
    pub theta_rad: f64,
    /// The same as the neighbours on a smooth path tell it, without the sample's own noise; zero without a beacon.
    pub steady_theta_rad: f64,
    /// tan(psi) as those neighbours tell it.
    pub steady_tan_psi: [f64; 2],
    /// Commanded angle, rad.
    pub commanded_theta_rad: f64,
    /// Speed of each segment along its own direction, m/s.
    pub speed_m_s: [f64; 4],
    /// The same; of a segment that comes late (`BasisInputs::late_s`) the mean speed over its delay, from the sample on, m/s.
    pub speed_ahead_m_s: [f64; 4],
    /// Derivative of the speed, m/s².
    pub acceleration_m_s2: [f64; 4],
    /// Direction of travel while moving: -1, 0 or 1.
    pub direction: [f64; 4],
    /// Direction from which a still pose was approached: -1, 0 or 1.
    pub approach: [f64; 4],
    /// Direction of travel that turns over with it: gradually within 4, 12, 40 and 120 um, then evenly over 3 to 96 um; -1 to 1.
    pub memory: [[f64; TURNOVERS]; 4],
    /// What a segment still remembers of its way before the stretch: 1 at its first sample, 0 once it has gone far.
    pub before: [f64; 4],
    /// The courier is on its way, and no separate pose or rest.
    pub underway: bool,
    /// tan(psi) of the coordination sensor.
    pub tan_psi: [f64; 2],
    /// Its rate, 1/s.
    pub tan_psi_rate: [f64; 2],
    /// tan(psi) over its full scale.
    pub deflection: [f64; 2],
    /// Board temperature less its mean, K.
    pub warmth_k: f64,
    /// How much warmer than the board a mount is that follows it after each of [`LAGS_S`], K.
    pub behind_k: [f64; LAGS_S.len()],
    /// What the place explains of the logarithm of each segment's amplitude, less its mean: the air gap's part.
    pub ln_amplitude: [f64; 4],
    /// All of that logarithm less its mean and what repeats with the own phase, whatever may be the cause.
    pub amplitude_excess: [f64; 4],
    /// Each logged column of [`BasisInputs::logged`](crate::sensor::BasisInputs::logged), less its mean and over its deviation.
    pub logged: [f64; MOST_LOGGED],
    /// Angle, rad, by which each pair's flaws, as far as they differ from their means at this time, turn the vector that it gives: as
    /// its amplitude shows them, the quadrature angle half in either channel.
    pub pair_turn_rad: [f64; 4],
    /// That half of the quadrature angle, rad.
    pub half_quadrature_angle_rad: [f64; 4],
}

impl Covariates {
    /// Tooth phase of a segment's unmodified output as its pair would give it without what is known of its wander, rad.
    #[must_use]
    pub fn phase_without_wander_rad(&self, segment: usize) -> f64 {
        self.raw_phase[segment] - self.pair_turn_rad[segment]
    }
}
