//! The row of one recording: what it is, what was answered, or why it could not be.

use super::cell::{Cell, Row};
use diagnosis::verdict::answer::{Diagnosis, Named};
use effects::CATALOGUE;
use recording::Recording;
use report::headline::headline;

/// What a row says of a recording besides its readings.
#[derive(Clone, Debug)]
pub struct Identity<'a> {
    /// Its path, as it was given.
    pub path: &'a str,
    /// SHA-256 of its files.
    pub content: &'a str,
    /// Effects that were taken out of the catalogue, separated by commas.
    pub without: &'a str,
    /// Resolution that the gap is held against, m.
    pub resolution_m: f64,
}

/// The row of an answer.
///
/// # Errors
/// The answer has no form in JSON.
pub fn of_answer(
    identity: &Identity,
    recording: &Recording,
    answer: &Diagnosis,
) -> serde_json::Result<Row> {
    let headline = headline(answer, identity.resolution_m);
    let channels = &answer.held_out.channels;
    let floor_m = channels
        .iter()
        .find(|held| held.channel == headline.channel);
    let verdict = serde_json::to_value(answer.verdict)?;
    let names: Vec<&str> = answer
        .effects
        .iter()
        .map(|effect| effect.name.as_str())
        .collect();
    let has_gap = !channels.is_empty();
    let of_gap = |value: f64| {
        if has_gap {
            Cell::real(value)
        } else {
            Cell::Real(None)
        }
    };
    let mut row = of_recording(identity, Some(recording));
    row.extend([
        named("verdict", Cell::text(verdict.as_str().unwrap_or_default())),
        named("error", Cell::Text(None)),
        named("effects", Cell::text(names.join(","))),
        named("channel", Cell::text(headline.channel.clone())),
        named("gap_m", of_gap(headline.gap_m)),
        named("left_m", of_gap(headline.left_m)),
        named("floor_m", Cell::Real(floor_m.map(|held| held.floor_rms_m))),
        named("floors_before", of_gap(answer.held_out.whitened_before)),
        named("floors_after", of_gap(answer.held_out.whitened_after)),
        named("explained", of_gap(headline.explained)),
        named("headline", Cell::text(headline.text.clone())),
    ]);
    for entry in CATALOGUE {
        let found = answer
            .effects
            .iter()
            .find(|effect| effect.name == entry.name);
        row.extend(of_effect(entry.name, found));
    }
    row.push(named("answer", Cell::text(serde_json::to_string(answer)?)));
    Ok(row)
}

/// The row of a recording that could not be read or diagnosed, with the one line that says why.
#[must_use]
pub fn of_failure(identity: &Identity, recording: Option<&Recording>, error: &str) -> Row {
    let mut row = of_recording(identity, recording);
    row.push(named("verdict", Cell::text(FAILED)));
    row.push(named("error", Cell::text(error)));
    row.extend(["effects", "channel"].map(|name| named(name, Cell::Text(None))));
    let reals = [
        "gap_m",
        "left_m",
        "floor_m",
        "floors_before",
        "floors_after",
        "explained",
    ];
    row.extend(reals.map(|name| named(name, Cell::Real(None))));
    row.push(named("headline", Cell::Text(None)));
    CATALOGUE
        .iter()
        .for_each(|entry| row.extend(of_effect(entry.name, None)));
    row.push(named("answer", Cell::Text(None)));
    row
}

/// What stands in the column `verdict` of a recording that could not be read or diagnosed.
pub const FAILED: &str = "failed";

fn named(name: &str, cell: Cell) -> (String, Cell) {
    (name.to_owned(), cell)
}

fn of_recording(identity: &Identity, recording: Option<&Recording>) -> Row {
    let meta = recording
        .map(|recording| recording.meta.clone())
        .unwrap_or_default();
    let samples = recording.map(|recording| &recording.samples);
    let seconds = samples.and_then(|samples| Some(samples.t_s().last()? - samples.t_s().first()?));
    vec![
        named("recording", Cell::text(identity.path)),
        named("content", Cell::text(identity.content)),
        named("courier_version", Cell::text(env!("CARGO_PKG_VERSION"))),
        named("without", Cell::text(identity.without)),
        named("device", Cell::text(meta.device)),
        named("platen_id", Cell::text(meta.names.platen_id)),
        named("beacon_id", Cell::text(meta.names.beacon_id)),
        named("firmware", Cell::text(meta.names.firmware)),
        named("source", Cell::text(meta.source)),
        named(
            "samples",
            samples.map_or(Cell::Whole(None), |samples| Cell::count(samples.len())),
        ),
        named("seconds", Cell::Real(seconds)),
    ]
}

/// What an effect does altogether, its standard deviation, and how sure it is; none where it is not named.
fn of_effect(name: &str, found: Option<&Named>) -> [(String, Cell); 3] {
    let real = |value: Option<f64>| Cell::Real(value.filter(|value| value.is_finite()));
    [
        (
            format!("{name}_rms_m"),
            real(found.and_then(|effect| effect.total_rms_m)),
        ),
        (
            format!("{name}_deviation_m"),
            real(found.and_then(|effect| effect.total_deviation_m)),
        ),
        (
            format!("{name}_probability"),
            real(found.map(|effect| effect.probability)),
        ),
    ]
}
