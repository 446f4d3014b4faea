//! The answer in a sentence or two: how large the gap is, how much of it is explained, and whether it matters beside the resolution.

use crate::advice::{alias_sets, joined, located};
use crate::units::micrometres;
use diagnosis::WithoutSignal;
use diagnosis::verdict::answer::{Diagnosis, Gap, HeldOutChannel, Verdict};

/// Resolution that a gap is held against where nobody states another, m: that of the sensor in the paper, 0.2 µm.
pub const RESOLUTION_M: f64 = 0.2e-6;
/// What is left would be a gap by itself from so many times the simulator's own scatter on, rms.
const STAYS_VISIBLE: f64 = diagnosis::figures::limits::STAYS_VISIBLE;

/// What a reader is to take from it at a glance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// No gap, one that is smaller than the resolution, or one that is explained.
    Good,
    /// Explained in part, by one of several effects, or not answered.
    Doubtful,
    /// A gap larger than the resolution that nothing explains, or of which far too much is left.
    Bad,
}

/// The headline and what it says as data.
#[derive(Clone, Debug, PartialEq)]
pub struct Headline {
    /// The gap of the channel with the largest one, m rms beyond the simulator's own scatter.
    pub gap_m: f64,
    /// That channel; empty where there is none.
    pub channel: String,
    /// What is left of the gap in the channel where most is left, m rms.
    pub left_m: f64,
    /// All that is left over the simulator's own scatter, rms: 1 is all noise.
    pub floors_left: f64,
    /// Share of the gap's square that is explained, 0 to 1, whitened over all channels; zero where nothing is named.
    pub explained: f64,
    /// Resolution that both are held against, m.
    pub resolution_m: f64,
    /// Whether the gap is as large as the resolution.
    pub matters: bool,
    /// What it means.
    pub tone: Tone,
    /// The sentences.
    pub text: String,
}

/// The headline of an answer beside a resolution, m.
#[must_use]
pub fn headline(diagnosis: &Diagnosis, resolution_m: f64) -> Headline {
    let channels = &diagnosis.held_out.channels;
    let largest = |of: fn(&HeldOutChannel) -> f64| {
        let sizes = channels.iter().map(|c| (beyond(of(c), c.floor_rms_m), c));
        sizes.max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let gap = largest(|c| c.before_rms_m);
    let (gap_m, channel) = gap.map_or((0.0, String::new()), |(m, c)| (m, c.channel.clone()));
    let aside_m = set_aside_m(diagnosis);
    let gap_m = gap_m.hypot(aside_m);
    let left_m = largest(|c| c.after_rms_m).map_or(0.0, |(m, _)| m);
    let square = |floors: f64| (floors * floors - 1.0).max(0.0);
    let held = &diagnosis.held_out;
    let explains = matches!(diagnosis.verdict, Verdict::Named | Verdict::Alias);
    let [before, after] = [held.whitened_before, held.whitened_after].map(square);
    let explained = if explains && aside_m > 0.0 {
        1.0 - (left_m / gap_m).powi(2).min(1.0)
    } else if explains && before > 0.0 {
        (1.0 - after / before).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let mut out = Headline {
        gap_m,
        channel,
        left_m,
        floors_left: held.whitened_after,
        explained,
        resolution_m,
        matters: gap_m >= resolution_m,
        tone: Tone::Good,
        text: String::new(),
    };
    out.tone = if only_signals_are_lost(diagnosis) {
        Tone::Bad
    } else {
        out.tone_of(diagnosis.verdict)
    };
    out.text = out.words(diagnosis);
    out
}

/// True if a segment gives no signal somewhere, and nothing else is amiss.
fn only_signals_are_lost(diagnosis: &Diagnosis) -> bool {
    let within_the_noise = |gap: &Gap| gap.excess_ci95_m[0] <= 0.0;
    diagnosis.verdict == Verdict::Unknown
        && !diagnosis.without_signal.is_empty()
        && diagnosis.gap.iter().all(within_the_noise)
}

/// Where the signals are lost, and what that means.
fn lost_signals(diagnosis: &Diagnosis) -> String {
    let one = |lost: &WithoutSignal| {
        let [from, to] = lost.place_m.map(|place_m| 1e3 * place_m);
        format!(
            "Segment {} gives no signal from {from:.2} to {to:.2} mm, so that its place is not known there.",
            lost.segment
        )
    };
    let lost: Vec<String> = diagnosis.without_signal.iter().map(one).collect();
    format!(
        "{} No effect of the catalogue does that. Elsewhere the recording and its simulation agree within the noise. Next: look for the platen's edge, dirt or a loose wire there.",
        lost.join(" ")
    )
}

/// What those do, m rms, that are taken out of the readings before residuals are formed, and so are not in their figures.
fn set_aside_m(diagnosis: &Diagnosis) -> f64 {
    let out = diagnosis
        .effects
        .iter()
        .filter(|e| effects::has(&e.name, |card| card.detection.is_taken_out()));
    let squares = out
        .filter_map(|e| e.total_rms_m)
        .map(|total_m| total_m * total_m);
    squares.sum::<f64>().sqrt()
}

/// What a length has beyond another, both rms.
fn beyond(rms_m: f64, floor_m: f64) -> f64 {
    (rms_m * rms_m - floor_m * floor_m).max(0.0).sqrt()
}

impl Headline {
    /// True if what is left shows over the noise and is as large as the resolution.
    fn leaves_much(&self) -> bool {
        self.floors_left > STAYS_VISIBLE && self.left_m >= self.resolution_m
    }

    fn tone_of(&self, verdict: Verdict) -> Tone {
        match verdict {
            Verdict::InsufficientData => Tone::Doubtful,
            _ if !self.matters => Tone::Good,
            Verdict::NoGap => Tone::Good,
            Verdict::Unknown => Tone::Bad,
            Verdict::Named | Verdict::Alias if self.leaves_much() => Tone::Bad,
            Verdict::Alias => Tone::Doubtful,
            Verdict::Named => Tone::Good,
        }
    }

    fn words(&self, diagnosis: &Diagnosis) -> String {
        let names: Vec<&str> = diagnosis.effects.iter().map(|e| e.name.as_str()).collect();
        match diagnosis.verdict {
            Verdict::InsufficientData => match diagnosis.notes.first() {
                Some(note) if note.ends_with('?') => format!("The recording cannot answer: {note}"),
                Some(note) => format!("The recording cannot answer: {note}."),
                None => "The recording cannot answer.".into(),
            },
            Verdict::NoGap => self.no_gap(diagnosis),
            Verdict::Named => format!(
                "{} {} {}",
                self.size(),
                joined(&names),
                self.explain(names.len())
            ),
            Verdict::Alias => format!(
                "{} {} {} This motion does not tell which.",
                self.size(),
                alias_sets(diagnosis),
                self.explain(names.len())
            ),
            Verdict::Unknown if only_signals_are_lost(diagnosis) => lost_signals(diagnosis),
            Verdict::Unknown => format!(
                "{} No effect of the catalogue explains it{}",
                self.size(),
                located(diagnosis)
            ),
        }
    }

    fn no_gap(&self, diagnosis: &Diagnosis) -> String {
        let most_m = diagnosis
            .gap
            .iter()
            .map(|gap| gap.excess_ci95_m[1])
            .fold(0.0, f64::max);
        let limit = if most_m > 0.0 {
            format!(
                "; a gap of more than {} would have shown",
                micrometres(most_m)
            )
        } else {
            String::new()
        };
        format!("No gap: the recording and its simulation agree within the noise{limit}.")
    }

    /// How large the gap is, and whether that matters.
    fn size(&self) -> String {
        let resolution = micrometres(self.resolution_m);
        let times = self.gap_m / self.resolution_m;
        let beside = if times >= 1.95 {
            format!("{times:.0} times the resolution of {resolution}")
        } else if self.matters {
            format!("about the resolution of {resolution}")
        } else {
            format!("below the resolution of {resolution}: it hardly matters")
        };
        format!(
            "A gap of {} rms in {}, {beside}.",
            micrometres(self.gap_m),
            self.channel
        )
    }

    /// How much of it what is named explains, and what that leaves.
    fn explain(&self, causes: usize) -> String {
        let verb = if causes == 1 { "explains" } else { "explain" };
        let share = if self.explained > 0.999 {
            "all of it".to_owned()
        } else {
            // Never rounded up to all of it.
            format!("{:.0} % of it", (100.0 * self.explained).floor())
        };
        let left = micrometres(self.left_m);
        if self.leaves_much() {
            return format!(
                "{verb} {share}, but {left} rms is left, {:.1} times the noise: this is not solved.",
                self.floors_left
            );
        }
        if self.floors_left > STAYS_VISIBLE {
            return format!("{verb} {share}; {left} rms is left, below the resolution.");
        }
        format!("{verb} {share}; what is left is noise.")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use diagnosis::verdict::answer::{HeldOut, Named, Share};

    const FLOOR_M: f64 = 0.3e-6;

    /// An answer with a gap and a rest, m rms beyond the floor.
    fn answer(verdict: Verdict, gap_m: f64, left_m: f64, floor_m: f64) -> Diagnosis {
        let with = |m: f64| m.hypot(floor_m);
        let effect = Named {
            name: "velocity_lag".into(),
            ..Named::default()
        };
        Diagnosis {
            verdict,
            effects: vec![effect],
            held_out: HeldOut {
                whitened_before: with(gap_m) / floor_m,
                whitened_after: with(left_m) / floor_m,
                channels: vec![HeldOutChannel {
                    channel: "g_p".into(),
                    before_rms_m: with(gap_m),
                    after_rms_m: with(left_m),
                    floor_rms_m: floor_m,
                    ..HeldOutChannel::default()
                }],
            },
            ..Diagnosis::default()
        }
    }

    /// All sizes of gap and rest from half a nanometre to a millimetre, over several floors: what is said follows from the numbers.
    #[test]
    fn what_is_said_follows_from_the_sizes() {
        let sizes: Vec<f64> = (0..14).map(|k| 0.5e-9 * 3.0_f64.powi(k)).collect();
        let verdicts = [
            Verdict::Named,
            Verdict::Alias,
            Verdict::Unknown,
            Verdict::NoGap,
        ];
        for floor_m in [1.0e-10, FLOOR_M, 1.0e-4] {
            for gap_m in &sizes {
                for left_m in sizes.iter().filter(|left| *left <= gap_m) {
                    for verdict in verdicts {
                        let told =
                            headline(&answer(verdict, *gap_m, *left_m, floor_m), RESOLUTION_M);
                        let case = format!(
                            "{verdict:?} {gap_m:e} {left_m:e} {floor_m:e}: {}",
                            told.text
                        );
                        assert_eq!(told.matters, *gap_m >= RESOLUTION_M, "{case}");
                        if !told.matters {
                            assert_ne!(told.tone, Tone::Bad, "{case}");
                        }
                        let unsolved = *left_m >= RESOLUTION_M && told.floors_left > STAYS_VISIBLE;
                        if verdict == Verdict::Named {
                            assert_eq!(told.text.contains("not solved"), unsolved, "{case}");
                            assert_eq!(told.tone == Tone::Bad, unsolved, "{case}");
                        }
                        if verdict == Verdict::Unknown && told.matters {
                            assert_eq!(told.tone, Tone::Bad, "{case}");
                        }
                        assert!(!told.text.contains("100 %"), "{case}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_sentences() {
        let told = |verdict, gap_m, left_m| {
            headline(&answer(verdict, gap_m, left_m, FLOOR_M), RESOLUTION_M).text
        };
        assert_eq!(
            told(Verdict::Named, 3.0e-6, 0.05e-6),
            "A gap of 3 µm rms in g_p, 15 times the resolution of 0.2 µm. velocity_lag explains all of it; what is left is noise."
        );
        assert_eq!(
            told(Verdict::Named, 90.0e-6, 20.7e-6),
            "A gap of 90 µm rms in g_p, 450 times the resolution of 0.2 µm. velocity_lag explains 94 % of it, but 20.7 µm rms is left, 69.0 times the noise: this is not solved."
        );
        assert_eq!(
            told(Verdict::Unknown, 0.5e-9, 0.5e-9),
            "A gap of 0.0005 µm rms in g_p, below the resolution of 0.2 µm: it hardly matters. No effect of the catalogue explains it; it lies over no coordinate. Next: rule out a wrong unit, pitch or span, and exchanged wires."
        );
        let mut lies = answer(Verdict::Unknown, 3.0e-6, 3.0e-6, FLOOR_M);
        let place = |coordinate: &str, share| Share {
            channel: "g_p".into(),
            coordinate: coordinate.into(),
            share,
        };
        lies.unexplained.place = vec![place("place on the platen", 0.78)];
        assert_eq!(
            headline(&lies, RESOLUTION_M).text,
            "A gap of 3 µm rms in g_p, 15 times the resolution of 0.2 µm. No effect of the catalogue explains it; 78 % of it lies over place on the platen (g_p). Next: record at two places, 30 mm apart, over other teeth."
        );
        lies.unexplained.place = vec![place("theta", 0.07)];
        let told = headline(&lies, RESOLUTION_M).text;
        assert!(
            told.contains("no coordinate holds most of it: theta holds 7 % (g_p)"),
            "{told}"
        );
        let mut lost = answer(Verdict::Unknown, 0.0, 0.0, FLOOR_M);
        lost.without_signal = vec![WithoutSignal {
            segment: 2,
            samples: 216,
            place_m: [19.23e-3, 20.58e-3],
        }];
        let told = headline(&lost, RESOLUTION_M);
        assert!(
            told.text
                .starts_with("Segment 2 gives no signal from 19.23 to 20.58 mm"),
            "{}",
            told.text
        );
        assert_eq!(told.tone, Tone::Bad);
        let nothing = headline(&Diagnosis::default(), RESOLUTION_M);
        assert_eq!(nothing.text, "The recording cannot answer.");
        assert_eq!(nothing.tone, Tone::Doubtful);
    }
}
