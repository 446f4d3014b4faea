//! The answer out of its parts.

use crate::answer::{Answer, Channels, Harmonic, Turn};
use crate::asked::Question;
use crate::input::Input;
use crate::motion::Motion;
use crate::remarks;
use crate::round::Rounded;
use courier_signal::encoder::ORDERS;

/// All that was learned, with what it cannot tell.
pub(crate) fn answer(
    input: &Input,
    question: &Question,
    round: Option<Rounded>,
    motion: &Motion,
    turn: Option<Turn>,
) -> Answer {
    let pitch_m = input.pitch_m;
    let size = |[a, b]: [f64; 2]| a.hypot(b) * pitch_m;
    let harmonics = (0..ORDERS)
        .map(|n| {
            let ([sine, cosine], deviation) = motion.order(n);
            Harmonic {
                order: n + 1,
                sine_m: sine * pitch_m,
                cosine_m: cosine * pitch_m,
                deviation_m: deviation * pitch_m,
                applied: motion.is_seen(n),
                ripple_m: motion.ripple(n).map(|(pair, _)| size(pair)),
                reversing_m: motion.reverses(n).map(|(pair, _)| size(pair)),
            }
        })
        .collect();
    let mut answer = Answer {
        samples: input.t_s.len(),
        pitch_m,
        unit: input.unit,
        stretches: motion.stretches,
        stretch_periods: motion.periods,
        speeds_hz: motion.speeds,
        ripple_speed_hz: motion.ripple_speed,
        noise_m: motion.noise * pitch_m,
        channels: round.map(|round| channels(&round)),
        harmonics,
        turn,
        remarks: Vec::new(),
    };
    answer.remarks = remarks::remarks(&answer, question, motion);
    answer
}

fn channels(round: &Rounded) -> Channels {
    let scale = round.scale;
    let [sine, cosine, gain, angle] = round.deviations;
    Channels {
        amplitude_counts: round.amplitude * scale,
        offset_counts: round
            .pair
            .offset_counts
            .map(|counts| f64::from(counts) * scale),
        offset_deviation_counts: [sine * scale, cosine * scale],
        gain: f64::from(round.pair.gain),
        gain_deviation: gain,
        angle_rad: f64::from(round.pair.angle_rad),
        angle_deviation_rad: angle,
        radius_orders: round
            .orders
            .map(|([a, b], deviation)| [a.hypot(b), deviation]),
    }
}
