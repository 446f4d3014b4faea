//! A segment that gives no signal somewhere: a gap that no effect of the catalogue makes.

use crate::data::channel_names::CHANNEL_NAMES;
use crate::data::faint::WithoutSignal;
use crate::verdict::answer::{Diagnosis, Share, Unexplained, Verdict};

/// The answer with the lost signals located, though no other sample shows a gap. `by_segment`: each segment is a channel of its own.
pub(super) fn located(answer: Diagnosis, by_segment: bool) -> Diagnosis {
    if answer.verdict != Verdict::NoGap || answer.without_signal.is_empty() {
        return answer;
    }
    let samples: usize = answer.without_signal.iter().map(|lost| lost.samples).sum();
    let share = |lost: &WithoutSignal| Share {
        channel: if by_segment {
            format!("segment_{}", lost.segment)
        } else {
            CHANNEL_NAMES[0].into()
        },
        coordinate: format!("signal amplitude, segment {}", lost.segment),
        share: lost.samples as f64 / samples as f64,
    };
    let place: Vec<Share> = answer.without_signal.iter().map(share).collect();
    Diagnosis {
        verdict: Verdict::Unknown,
        unexplained: Unexplained {
            share: 1.0,
            place: place.clone(),
            ..Unexplained::default()
        },
        place,
        ..answer
    }
}
