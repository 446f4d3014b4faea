//! What a user asks of a conversion beside the log itself.

use crate::runs::Runs;
use crate::source::Asked;

/// A conversion's options. What is not stated is taken from the log, measured from it, or assumed and told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Order {
    /// Columns of the recording and where each comes from.
    pub columns: Vec<Asked>,
    /// Rows a second, where the log has no time.
    pub rate_hz: Option<f64>,
    /// What separates runs, where no column names them.
    pub runs: Runs,
    /// Length of one signal period, m.
    pub pitch_m: Option<f64>,
    /// Signal periods of one turn of a shaft.
    pub periods_per_turn: Option<f64>,
    /// What recording.toml is to say.
    pub stated: Stated,
}

/// Values of recording.toml.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stated {
    /// The device, free text.
    pub device: Option<String>,
    /// Where the log comes from, free text.
    pub source: Option<String>,
    /// Number or name of the courier.
    pub courier_id: Option<String>,
    /// Number or name of the platen.
    pub platen_id: Option<String>,
    /// `[geometry] span_m`.
    pub span_m: Option<f64>,
    /// `[geometry] lateral_m`.
    pub lateral_m: Option<f64>,
    /// `[electronics] adc_bits`.
    pub adc_bits: Option<u32>,
    /// Input at the converter's full scale, in the log's unit: only where the log has no counts.
    pub full_scale: Option<f64>,
    /// `[electronics] amplitude_counts`.
    pub amplitude_counts: Option<f64>,
    /// `[electronics] quadrature_noise_counts`.
    pub noise_counts: Option<f64>,
    /// `[electronics] position_noise_m`.
    pub position_noise_m: Option<f64>,
    /// `[electronics] psd_sum_counts`.
    pub psd_sum_counts: Option<f64>,
    /// `[electronics] psd_noise_counts`.
    pub psd_noise_counts: Option<f64>,
    /// `[coordination] height_m`.
    pub height_m: Option<f64>,
    /// `[coordination] lever_x_m`, `lever_y_m`.
    pub lever_m: [Option<f64>; 2],
    /// `[coordination] tan_full_scale`.
    pub tan_full_scale: Option<f64>,
}
