//! The steps of the search on standard error, for who works on it.

use crate::algebra::statistics::rms;
use crate::data::observations::Observations;
use crate::inference::residuals::Residuals;
use crate::selection::CHANNEL_NAMES;

/// True if COURIER_DIAGNOSIS_TRACE asks for the search's steps on standard error.
pub fn tracing() -> bool {
    std::env::var_os("COURIER_DIAGNOSIS_TRACE").is_some()
}

/// One step of the search, where that was asked for.
pub fn log(text: &str) {
    if tracing() {
        eprintln!("{text}");
    }
}

/// What is left of each run in each channel, over its noise, where that was asked for.
pub fn log_runs(observations: &Observations, left: &Residuals) {
    if !tracing() {
        return;
    }
    for (run, name) in observations.run_names.iter().enumerate() {
        for (channel, channel_name) in CHANNEL_NAMES.iter().enumerate() {
            let of_it = (0..left.sample.len())
                .filter(|&k| left.channel[k] == channel && observations.run[left.sample[k]] == run)
                .map(|k| left.value_m[k] / left.noise_m[k].max(1e-12));
            let list: Vec<f64> = of_it.collect();
            if !list.is_empty() {
                log(&format!(
                    "{name}, {channel_name}: {:.2}",
                    rms(list.iter().copied())
                ));
            }
        }
    }
}
