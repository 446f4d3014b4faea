//! What a recording of one pair cannot tell, in words, and which motion would tell it.

use crate::answer::{Answer, Harmonic, Remark};
use crate::asked::Question;
use crate::motion::Motion;

/// Deviations from which on order 1 or 2 is told as a harmonic of the signals. Derived from an F ratio of 8: by chance one
/// recording in 3,000.
const CLEAR: f64 = 4.0;

fn remark(what: impl Into<String>, tell: impl Into<String>) -> Remark {
    Remark {
        what: what.into(),
        tell: tell.into(),
    }
}

fn orders<'a>(of: impl Iterator<Item = &'a Harmonic>) -> String {
    let numbers: Vec<String> = of.map(|harmonic| harmonic.order.to_string()).collect();
    match numbers.len() {
        1 => format!("order {}", numbers[0]),
        _ => format!("orders {}", numbers.join(", ")),
    }
}

/// All that applies.
pub(crate) fn remarks(answer: &Answer, question: &Question, motion: &Motion) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let applied = || answer.harmonics.iter().filter(|harmonic| harmonic.applied);
    if !motion.speeds_tell && applied().next().is_some() {
        let [slow, fast] = answer.speeds_hz;
        remarks.push(remark(
            format!(
                "a ripple of the true speed that is locked to the phase is not told from an error of the sensor at one speed ({slow:.3} to {fast:.3} periods/s): taken to be the sensor's, {}",
                orders(applied())
            ),
            "the same motion at half or twice the speed as well, or coasting with the drive off",
        ));
    }
    let ripples: Vec<&Harmonic> = answer
        .harmonics
        .iter()
        .filter(|harmonic| harmonic.ripple_m.is_some())
        .collect();
    if !ripples.is_empty() {
        let sizes: Vec<String> = ripples
            .iter()
            .filter_map(|harmonic| {
                Some(format!(
                    "{:.2} µm in order {}",
                    1.0e6 * harmonic.ripple_m?,
                    harmonic.order
                ))
            })
            .collect();
        remarks.push(remark(
            format!("the true motion ripples with the phase as an inertia does: {} at {:.3} periods/s; this is not applied", sizes.join(", "), answer.ripple_speed_hz),
            "coasting with the drive off shows whether the drive makes it",
        ));
    }
    if !motion.directions_tell {
        remarks.push(remark(
            "what reverses with the direction (friction, hysteresis, a delay) is not told from an error: the motion goes one way",
            "the same motion the other way as well",
        ));
    }
    let reversing: Vec<&Harmonic> = answer
        .harmonics
        .iter()
        .filter(|harmonic| harmonic.reversing_m.is_some())
        .collect();
    if !reversing.is_empty() {
        remarks.push(remark(
            format!("what differs by direction: {}; the mean of both is applied", orders(reversing.into_iter())),
            "slower and faster motion: what grows with speed is a delay, what does not is hysteresis or the drive",
        ));
    }
    match &answer.channels {
        Some(_) => beyond_the_circle(answer, &mut remarks),
        None => remarks.push(remark(
            "only a position was logged: the amplitude tells nothing, and orders 1 and 2 rest on the motion alone",
            "a log of sine and cosine before any correction",
        )),
    }
    let lost: Vec<&Harmonic> = answer
        .harmonics
        .iter()
        .filter(|harmonic| !harmonic.applied)
        .collect();
    if let Some(worst) = lost
        .iter()
        .map(|harmonic| harmonic.deviation_m)
        .reduce(f64::max)
    {
        remarks.push(remark(
            format!(
                "no more than chance, and not applied: {}, each known to {:.3} µm or better",
                orders(lost.into_iter()),
                1.0e6 * worst
            ),
            "a longer motion, or a steadier one",
        ));
    }
    match (&answer.turn, question.periods_per_turn) {
        (Some(turn), _) => match &turn.index {
            None => remarks.push(remark(
                format!("the {} orders of the turn are counted from the place zero of this recording's count", turn.orders.len()),
                "an index (--column index=COLUMN), or a count that is the same after each start",
            )),
            // Passes are as far apart as that within one recording already.
            Some(index) if index.after_periods.abs() + index.spread_periods >= 0.5 => remarks.push(remark(
                format!(
                    "the index is {:.2} ± {:.2} periods from the phase zero that turns are counted from: another start may take the next one",
                    index.after_periods.abs(),
                    index.spread_periods
                ),
                "an index that is moved by a quarter of a period, or samples closer to each other",
            )),
            Some(_) => {}
        },
        (None, Some(_)) => remarks.push(remark(
            "no order of the turn foretells a stretch that it was not fitted to: single poles and eccentricity are not told",
            "two turns or more, better five, without a stop",
        )),
        (None, None) => remarks.push(remark(
            "what differs from period to period (single poles, eccentricity) is not looked for",
            "--periods-per-turn N, and two turns or more",
        )),
    }
    remarks
}

/// Orders 1 and 2 that the radius cannot see.
fn beyond_the_circle(answer: &Answer, remarks: &mut Vec<Remark>) {
    for (harmonic, number) in answer.harmonics.iter().zip(["second", "third"]) {
        let size = harmonic.sine_m.hypot(harmonic.cosine_m);
        if harmonic.applied && size > CLEAR * harmonic.deviation_m {
            remarks.push(remark(
                format!(
                    "order {} of the angle, {:.2} µm, is left after the circle is round: a {number} harmonic of the signals, or a ripple of the motion",
                    harmonic.order,
                    1.0e6 * size
                ),
                "another speed: an error stays, a ripple does not",
            ));
        }
    }
}
