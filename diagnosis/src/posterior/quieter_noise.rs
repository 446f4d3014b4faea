//! Noise that is stated too loud: how loud it can be at most, by what is left.

use super::noise_scale::quietest_rms;
use crate::design::assembly::Design;
use crate::inference::residuals::Residuals;
use effects::sensor::READINGS;

/// Noise of each reading over the stated one, no louder than what is left of a design by the stated noise allows; none unless that is less than
/// stated noise may be for some of them. What is left may hold patterns besides, so that the noise may be quieter still.
pub(super) fn quieter_noise(design: &Design, left: &Residuals) -> Option<[f64; READINGS]> {
    let scope = design.linearized.scope;
    let over = |channel: usize| {
        let (rms_m, count) = left.channel_rms_m(channel);
        let over = rms_m / design.floor.channel_rms_m[channel].max(f64::MIN_POSITIVE);
        if count > 0 { over.min(1.0) } else { 1.0 }
    };
    let mut noise = [1.0; READINGS];
    if scope.reference {
        for segment in (0..4).filter(|s| scope.segments[*s]) {
            noise[segment] = over(3 + segment);
        }
    } else {
        noise[..4].copy_from_slice(&[over(0); 4]);
        noise[4..].copy_from_slice(&[of_the_diode(design, left, over(0)); 2]);
    }
    let most = quietest_rms();
    noise.iter().any(|n| *n < most).then_some(noise)
}

/// Noise of the diode over the stated one, no louder than what is left of g_x and g_y allows beside segments that are so many times as loud
/// as stated: 1 at most, and no quieter than the segments. 1 without a beacon.
fn of_the_diode(design: &Design, residuals: &Residuals, segments: f64) -> f64 {
    let linearized = &design.linearized;
    let (mut left, mut by_segments, mut by_diode) = (0.0, 0.0, 0.0);
    let places = residuals.sample.iter().zip(&residuals.channel);
    for ((i, channel), value_m) in places.zip(&residuals.value_m) {
        if !(1..=2).contains(channel) {
            continue;
        }
        let (rows, variance) = (linearized.rows(*i), linearized.stated_variance(*i));
        let Some(row) = (0..rows.count).find(|row| rows.channel[*row] == *channel) else {
            continue;
        };
        let share = |reading: usize| rows.by_reading[row][reading].powi(2) * variance[reading];
        left += value_m * value_m;
        by_segments += (0..4).map(share).sum::<f64>();
        by_diode += (4..READINGS).map(share).sum::<f64>();
    }
    if by_diode == 0.0 {
        return 1.0;
    }
    let square = (left - segments * segments * by_segments) / by_diode;
    square.max(segments * segments).sqrt().min(1.0)
}
