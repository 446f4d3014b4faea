//! The answers in words: what an effect is, and what to do next.

use crate::motions::{self, Records};
use diagnosis::verdict::answer::{Diagnosis, Named, Share, Verdict};
use diagnosis::verdict::evidence::Setting;

/// What an effect is, in one sentence.
#[must_use]
pub fn sentence(effect: &str) -> &'static str {
    effects::entry(effect).map_or("", |entry| entry.summary)
}

/// A coordinate that holds this share of what nothing explains is the one to look at: it holds more than all others together.
const MOST: f64 = 0.5;

/// Where a gap lies that nothing explains, as the end of a sentence, and what to do about it, as another.
pub(crate) fn located(diagnosis: &Diagnosis) -> String {
    let place = diagnosis
        .unexplained
        .place
        .first()
        .or(diagnosis.place.first());
    let rule_out = "Next: rule out a wrong unit, pitch or span, and exchanged wires.";
    let Some(Share {
        channel,
        coordinate,
        share,
    }) = place
    else {
        return format!("; it lies over no coordinate. {rule_out}");
    };
    let share_told = percent(*share);
    if *share < MOST {
        return format!(
            "; no coordinate holds most of it: {coordinate} holds {share_told} ({channel}). {rule_out}"
        );
    }
    let (next, _) = motions::over(coordinate);
    let (next, _) = next.split_once(". ").unwrap_or((next, ""));
    format!(
        "; {share_told} of it lies over {coordinate} ({channel}). Next: {}.",
        uncapital(next)
    )
}

fn uncapital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_lowercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

/// Each alias set, likeliest first.
pub(crate) fn alias_sets(diagnosis: &Diagnosis) -> String {
    let sets = diagnosis.effects.iter().map(|effect| {
        let all: Vec<&str> = std::iter::once(&effect.name)
            .chain(&effect.aliases)
            .map(String::as_str)
            .collect();
        all.join(" or ")
    });
    sets.collect::<Vec<_>>().join("; ")
}

/// Names in a row.
pub(crate) fn joined(names: &[&str]) -> String {
    match names {
        [] => "Nothing".into(),
        [one] => (*one).into(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}

/// One thing to do next.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Advice {
    /// What to do and what it tells, in whole sentences.
    pub what: String,
    /// How long its motions take, in words; empty where nothing moves.
    pub takes: String,
    /// The commands, in order; empty where no command does it.
    pub commands: Vec<String>,
}

impl Advice {
    fn of(what: impl Into<String>, takes: impl Into<String>, commands: Vec<String>) -> Self {
        Self {
            what: what.into(),
            takes: takes.into(),
            commands,
        }
    }

    /// Recordings that are then compared by a model of this one.
    fn recorded(what: String, records: Records, asked: &Asked) -> Self {
        if !asked.setting.is_courier() {
            return Self::of(format!("{what} {WORDS}"), "", of_log(asked.setting));
        }
        let mut commands = motions::commands(records, asked.setting);
        commands.extend(
            records
                .iter()
                .map(|(folder, _)| format!("courier diagnose {folder}")),
        );
        Self::of(what, motions::takes(records), commands)
    }
}

/// What the words in capitals of [`of_log`] are.
const WORDS: &str = "Words in capitals stand for the log's own names, units and pitch; courier convert LOG.csv alone lists its columns and suggests the options.";

/// From the log of another sensor to its diagnosis.
fn of_log(setting: &Setting) -> Vec<String> {
    let mut segments = setting.segments;
    // Where nothing was recorded, one encoder is.
    segments[0] |= segments == [false; 4];
    let numbers = (1..).zip(segments).filter(|(_, recorded)| *recorded);
    let numbers: Vec<usize> = numbers.map(|(number, _)| number).collect();
    let mut columns = vec!["t_s=TIME:UNIT".to_owned()];
    for number in &numbers {
        columns.extend([format!("q{number}s=SINE"), format!("q{number}c=COSINE")]);
    }
    // Segments 1 and 3 measure x, 2 and 4 measure y.
    for (axis, remainder) in [("x", 1), ("y", 0)] {
        if numbers.iter().any(|number| number % 2 == remainder) {
            columns.push(format!("ref_{axis}_m=REFERENCE:UNIT"));
        }
    }
    let columns: String = columns
        .iter()
        .map(|column| format!(" --column {column}"))
        .collect();
    vec![
        format!("courier convert LOG.csv next{columns} --pitch PITCH"),
        "courier diagnose next".into(),
    ]
}

/// What an advice is about: the answer, the recording's setting, and the file of its model.
struct Asked<'a> {
    diagnosis: &'a Diagnosis,
    setting: &'a Setting,
    model: Option<&'a str>,
}

/// What to record or do next, most useful first. Never empty. `model` is the file that the answer's model was written to, if it was.
#[must_use]
pub fn next_measurements(
    diagnosis: &Diagnosis,
    setting: &Setting,
    model: Option<&str>,
) -> Vec<Advice> {
    let asked = Asked {
        diagnosis,
        setting,
        model,
    };
    let parted = diagnosis
        .effects
        .iter()
        .filter_map(|e| part_aliases(e, &asked));
    let mut list: Vec<Advice> = parted.collect();
    list.extend(match diagnosis.verdict {
        Verdict::NoGap => vec![again(&asked)],
        Verdict::Named | Verdict::Alias => named(&asked),
        Verdict::Unknown => unknown(&asked),
        Verdict::InsufficientData => usual(&asked),
    });
    list
}

fn part_aliases(effect: &Named, asked: &Asked) -> Option<Advice> {
    if effect.aliases.is_empty() {
        return None;
    }
    let others: Vec<&str> = effect.aliases.iter().map(String::as_str).collect();
    let motion = effect
        .break_alias
        .as_deref()
        .or(effects::telling_motion(&effect.name))?;
    let what = format!("Tell {} from {}: {motion}.", effect.name, joined(&others));
    Some(Advice::recorded(
        what,
        motions::of_effect(&effect.name),
        asked,
    ))
}

fn again(asked: &Asked) -> Advice {
    let what = "Nothing is missing. Record and diagnose again after a change of platen, mount or temperature.";
    Advice::recorded(what.into(), motions::USUAL, asked)
}

fn named(asked: &Asked) -> Vec<Advice> {
    let mut list = vec![confirm(asked)];
    if asked.setting.is_courier() {
        let model = asked.model.unwrap_or(MODEL);
        list.push(Advice::of(
            "Once it is confirmed, make it a part of the board's error model and calibrate again. Effects that the board has no terms for are named and left out.",
            "",
            vec![format!("courier load {}", word(model)), "courier calibrate".into()],
        ));
    }
    let unsure = |effect: &&Named| effect.aliases.is_empty() && effect.probability < SURE;
    for effect in asked.diagnosis.effects.iter().filter(unsure) {
        if let Some(motion) = effects::telling_motion(&effect.name) {
            let what = format!("Be surer of {}: {motion}.", effect.name);
            list.push(Advice::recorded(
                what,
                motions::of_effect(&effect.name),
                asked,
            ));
        }
    }
    list
}

/// Where no file of the model is known, it is called so.
const MODEL: &str = "model.json";
/// A cause that is less probable than this is worth a motion of its own.
const SURE: f64 = 0.9;

fn confirm(asked: &Asked) -> Advice {
    let mut commands = Vec::new();
    if asked.model.is_none() {
        let recording = word(&asked.diagnosis.recording);
        commands.push(format!("courier diagnose {recording} --model {MODEL}"));
    }
    let model = word(asked.model.unwrap_or(MODEL));
    let check = format!("courier check {model} second");
    if !asked.setting.is_courier() {
        commands.push(check);
        let what = "Confirm it: record the same sensor a second time, convert its log to a recording named second, and see whether the gap shrinks there as claimed here. Nothing is fitted to the second recording.";
        return Advice::of(what, "", commands);
    }
    commands.extend(motions::commands(SECOND, asked.setting));
    commands.push(check);
    let what = "Confirm it: record the same courier a second time and see whether the gap shrinks there as claimed here. Nothing is fitted to the second recording.";
    Advice::of(what, motions::takes(SECOND), commands)
}

/// The recording that confirms.
const SECOND: Records = &[("second", motions::HERE)];

fn unknown(asked: &Asked) -> Vec<Advice> {
    let mut list = Vec::new();
    if let Some(place) = asked.diagnosis.unexplained.place.first() {
        let (what, records) = motions::over(&place.coordinate);
        let what = format!(
            "{what}. {} of what is left lies over {}.",
            percent(place.share),
            place.coordinate
        );
        list.push(Advice::recorded(what, records, asked));
    }
    if !asked.setting.reference {
        list.push(Advice::of(
            "Record against an independent reference, such as a laser interferometer (columns ref_x_m and ref_y_m). It tells each segment's error by itself; without it only their differences are seen.",
            "",
            Vec::new(),
        ));
    } else if !asked.setting.is_courier() {
        list.push(Advice::of(
            "Look at the reference itself: move to and fro over at least ten pitches at two speeds. What stays the same when the reference is mounted anew is the sensor's.",
            "",
            Vec::new(),
        ));
    }
    list
}

fn usual(asked: &Asked) -> Vec<Advice> {
    let own = "A single encoder with a reference: move to and fro over at least ten pitches at two speeds, and log readings and reference together.";
    let courier = Advice::of(
        "A courier: record the motions that a diagnosis wants. They go there and back at three speeds, turned, turning and still. Stand under the beacon if there is one.",
        motions::takes(motions::USUAL),
        motions::commands(motions::USUAL, asked.setting),
    );
    let log = Advice::of(
        format!("{own} {WORDS}"),
        "takes 30 s",
        of_log(asked.setting),
    );
    let any = asked.setting.segments.iter().any(|s| *s);
    match (asked.setting.is_courier(), any) {
        (true, _) => vec![courier],
        (false, true) => vec![log],
        (false, false) => vec![courier, log],
    }
}

/// A word of a command line, quoted where a shell would take it apart.
#[must_use]
pub fn word(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "_-./,:=+@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.into()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

/// A share as a percentage.
#[must_use]
pub fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use diagnosis::verdict::answer::Unexplained;

    fn courier() -> Setting {
        Setting {
            segments: [true; 4],
            commanded: Some([0.1, 0.2, 0.0]),
            ..Setting::default()
        }
    }

    fn of(verdict: Verdict) -> Diagnosis {
        let place = Share {
            coordinate: "time".into(),
            share: 0.8,
            ..Share::default()
        };
        Diagnosis {
            recording: "first one".into(),
            verdict,
            unexplained: Unexplained {
                share: 1.0,
                place: vec![place],
                ..Unexplained::default()
            },
            ..Diagnosis::default()
        }
    }

    #[test]
    fn every_verdict_leads_to_something_to_do() {
        for verdict in [
            Verdict::NoGap,
            Verdict::Named,
            Verdict::Alias,
            Verdict::Unknown,
            Verdict::InsufficientData,
        ] {
            for setting in [courier(), Setting::default()] {
                let list = next_measurements(&of(verdict), &setting, None);
                assert!(list.iter().all(|a| a.what.ends_with('.')), "{list:?}");
                let commands = list.iter().flat_map(|a| &a.commands).count();
                assert!(
                    !list.is_empty() && (commands > 0 || !setting.is_courier()),
                    "{list:?}"
                );
            }
        }
    }

    #[test]
    fn a_claim_is_confirmed_by_the_model_that_was_written_or_one_that_is() {
        let told = |model| {
            next_measurements(&of(Verdict::Named), &courier(), model)[0]
                .commands
                .clone()
        };
        let record = "courier record second --survey 100.0,200.0,0.0";
        assert_eq!(
            told(Some("m.json")),
            [record, "courier check m.json second"]
        );
        assert_eq!(
            told(None),
            [
                "courier diagnose 'first one' --model model.json",
                record,
                "courier check model.json second"
            ]
        );
    }

    #[test]
    fn a_gap_without_a_name_is_looked_for_where_it_lies() {
        let list = next_measurements(&of(Verdict::Unknown), &courier(), None);
        assert!(
            list[0].what.contains("in ten minutes") && list[0].what.contains("80 %"),
            "{list:?}"
        );
        assert_eq!(list[0].takes, "2 recordings, 25 s and 25 s");
        assert!(list[1].what.contains("ref_x_m"), "{list:?}");
    }

    #[test]
    fn a_log_is_converted_by_the_columns_of_what_was_recorded() {
        let told = |segments| {
            of_log(&Setting {
                segments,
                ..Setting::default()
            })[0]
                .clone()
        };
        assert_eq!(
            told([false, true, false, false]),
            "courier convert LOG.csv next --column t_s=TIME:UNIT --column q2s=SINE --column q2c=COSINE --column ref_y_m=REFERENCE:UNIT --pitch PITCH"
        );
        assert!(told([false; 4]).contains("q1s=SINE"));
    }

    #[test]
    fn a_word_that_a_shell_would_take_apart_is_quoted() {
        assert_eq!(word("a/b-1.json"), "a/b-1.json");
        assert_eq!(word("it's"), "'it'\\''s'");
        assert_eq!(word(""), "''");
    }
}
