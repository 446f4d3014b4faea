//! What a recording states of its electronics.

use recording::noise::at_rest::Noise;
use recording::{Electronics, Row};

/// Bits of the board's converters.
pub(super) const ADC_BITS: u32 = 16;

/// Amplitudes of what has been recorded.
#[derive(Default)]
pub(super) struct Measured {
    quadrature: Mean,
    electrodes: Mean,
}

/// A mean under way.
#[derive(Default)]
struct Mean {
    count: u32,
    sum: f64,
}

impl Measured {
    pub(super) fn add(&mut self, row: &Row) {
        for [sine, cosine] in row.quadrature_counts.into_iter().flatten() {
            self.quadrature.add(sine.hypot(cosine));
        }
        if let Some([xp, xn, yp, yn]) = row.electrode_counts {
            self.electrodes.add(xp + xn);
            self.electrodes.add(yp + yn);
        }
    }

    pub(super) fn electronics(&self, noise: &Noise) -> Electronics {
        let hundredths = |counts: f64| (counts * 100.0).round() / 100.0;
        let psd_sum_counts = self.electrodes.rounded();
        Electronics {
            adc_bits: Some(ADC_BITS),
            amplitude_counts: self.quadrature.rounded(),
            quadrature_noise_counts: Some(hundredths(noise.quadrature_counts)),
            psd_sum_counts,
            psd_noise_counts: psd_sum_counts.map(|_| hundredths(noise.electrode_counts)),
            position_noise_m: None,
        }
    }
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    /// To whole counts; none of nothing.
    fn rounded(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.sum / f64::from(self.count)).round())
    }
}
