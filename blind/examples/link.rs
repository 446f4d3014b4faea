//! Makes the link from what speaks for a named effect to the probability that it acts (`diagnosis/src/link/`), and judges it.
//!
//! `cargo run --release -p blind --example link -- cases SIMULATOR SEED FIRST LAST` diagnoses couriers FIRST to LAST of a campaign of SIMULATOR
//! (`usual`, `drawn`, `independent`) and prints a line for each cause that is named: what speaks for it, and whether it is true. Cost: some
//! three seconds each.
//! `… -- fit DATE FILE …` fits a link to such tables and prints it, for `diagnosis/link.csv`; the tables are kept as `diagnosis/link-cases.csv`.
//! `… -- judge FILE …` compares the link in force, and what was stated in the tables, with what is true in them.

use blind::{Case, Conditions, Drawn, Judged, Kind, Reliability};
use diagnosis::link::{Fitted, Link, Support};
use diagnosis::{Options, diagnose};
use rayon::prelude::*;
use recording::Recording;
use specimens::SIZES_M;
use specimens::rig::{self, Dice};
use std::collections::{BTreeMap, BTreeSet};

/// Samples of the independent simulator's runs, as its judges have them.
const SAMPLES: usize = 3000;
/// What is told of each cause before what speaks for it.
const TOLD: &str = "simulator,seed,number,truth,verdict,name,stated";
/// Begins the line of a courier on which nothing is named.
const NOTHING_NAMED: &str = "# nothing named: ";
/// What is wrong with couriers of the independent simulator, as shares: those of the drawn campaigns.
const KINDS: [(f64, Kind); 5] = [
    (0.15, Kind::None),
    (0.55, Kind::Single),
    (0.75, Kind::Pair),
    (0.83, Kind::Triple),
    (1.0, Kind::Unlisted),
];

fn main() -> Result<(), String> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let number = |k: usize| words.get(k).and_then(|w| w.parse::<u64>().ok());
    match (&words[..], number(2), number(3), number(4)) {
        (["cases", simulator, ..], Some(seed), Some(first), Some(last)) => {
            println!("{TOLD},{}", Support::header());
            let all = (first..=last).into_par_iter();
            all.map(|number| tell(simulator, seed, number)).collect()
        }
        (["fit", date, files @ ..], ..) if !files.is_empty() => fit(date, &read(files)?),
        (["judge", files @ ..], ..) if !files.is_empty() => judge(&read(files)?),
        _ => Err(format!(
            "found {words:?}, wanted: link cases SIMULATOR SEED FIRST LAST, link fit DATE FILE …, link judge FILE …"
        )),
    }
}

/// Tables one after the other.
fn read(files: &[&str]) -> Result<String, String> {
    let text = |file: &&str| std::fs::read_to_string(file).map_err(|e| format!("{file}: {e}"));
    files.iter().map(text).collect()
}

/// Couriers of a table, by simulator and seed: each named cause and each comment for one without names has both and the courier's number.
fn couriers(table: &str) -> BTreeMap<String, BTreeSet<String>> {
    let mut out: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for line in table.lines().filter(|line| !line.starts_with(TOLD)) {
        let mut cells = line.trim_start_matches(NOTHING_NAMED).split(',');
        if let (Some(simulator), Some(seed), Some(number)) =
            (cells.next(), cells.next(), cells.next())
        {
            let campaign = format!("{simulator} {seed}");
            out.entry(campaign).or_default().insert(number.into());
        }
    }
    out
}

/// Prints the link that a table gives, with its source.
fn fit(date: &str, table: &str) -> Result<(), String> {
    let cases = Support::cases(table)?;
    let acts = cases.iter().filter(|case| case.1).count();
    println!(
        "# Written by the example 'link' of the crate blind, {date}: {} causes, of which {acts} act, named on",
        cases.len()
    );
    for (campaign, numbers) in couriers(table) {
        println!(
            "# {} couriers of simulator and seed {campaign}",
            numbers.len()
        );
    }
    println!("term,coefficient,deviation");
    let fitted = Fitted::of(&cases);
    let header = Support::header();
    let names = std::iter::once("always").chain(header.split(','));
    for ((name, coefficient), deviation) in
        names.zip(fitted.link.coefficients).zip(fitted.deviations)
    {
        println!("{name},{coefficient:.4},{deviation:.4}");
    }
    Ok(())
}

/// Prints how far what is stated is from what is true: by the tables themselves, and by the link in force.
fn judge(table: &str) -> Result<(), String> {
    let cases = Support::cases(table)?;
    let place = TOLD.split(',').position(|title| title == "stated");
    let rows = table
        .lines()
        .filter(|line| !line.starts_with('#') && !line.starts_with(TOLD));
    let stated: Option<Vec<f64>> = rows
        .map(|row| row.split(',').nth(place?)?.parse().ok())
        .collect();
    let stated = stated.ok_or("a row without what was stated")?;
    let link = Link::in_force();
    let by_table = stated
        .iter()
        .zip(&cases)
        .map(|(stated, case)| (*stated, case.1));
    let by_link = cases
        .iter()
        .map(|(support, acts)| (link.probability(support), *acts));
    tell_reliability("as stated in the table", &by_table.collect::<Vec<_>>());
    tell_reliability("by the link in force", &by_link.collect::<Vec<_>>());
    Ok(())
}

fn tell_reliability(what: &str, causes: &[(f64, bool)]) {
    let of = Reliability::of_causes(causes);
    println!(
        "{what}: {:?}; {} of {} act; mean log score {:.3}, of that share {:.3}",
        of.outcome, of.right, of.named, of.log_score, of.base_log_score
    );
    for tenth in &of.tenths {
        let [low, high] = tenth.interval;
        println!(
            "  {:.1} to {:.1}: {} causes, {} act, mean stated {:.3}, deviation {:+.3} ({low:+.3} to {high:+.3})",
            tenth.from, tenth.to, tenth.named, tenth.right, tenth.stated, tenth.deviation
        );
    }
}

/// Diagnoses one courier and prints what is named.
fn tell(simulator: &str, seed: u64, number: u64) -> Result<(), String> {
    let (case, recording) = recorded(simulator, seed, number)?;
    let answer = diagnose(&recording, "link", &Options::default());
    let judged = Judged::new(&case, &answer, None, None);
    let (truth, verdict) = (judged.truth().join(" "), judged.verdict);
    let mut lines = String::new();
    for (effect, stated) in answer.effects.iter().zip(&judged.stated) {
        let cells = Support::of(effect, &answer).cells(stated.is_true(|name| judged.acts(name)));
        let (name, probability) = (&stated.name, stated.probability);
        lines += &format!(
            "{simulator},{seed},{number},{truth},{verdict:?},{name},{probability:.3},{cells}\n"
        );
    }
    if lines.is_empty() {
        lines = format!("{NOTHING_NAMED}{simulator},{seed},{number},{truth},{verdict:?}\n");
    }
    print!("{lines}");
    Ok(())
}

/// A courier of a campaign, and its recording.
fn recorded(simulator: &str, seed: u64, number: u64) -> Result<(Case, Recording), String> {
    let drawn = |conditions| {
        let case = Case::draw(number as usize, seed, conditions);
        let recording = case.recorded(0);
        (case, recording)
    };
    match simulator {
        "usual" => Ok(drawn(Conditions::Usual)),
        "drawn" => Ok(drawn(Conditions::Drawn)),
        "independent" => Ok(independent(seed, number)),
        _ => Err(format!(
            "found simulator {simulator:?}, wanted usual, drawn or independent"
        )),
    }
}

/// A courier of the independent simulator.
fn independent(seed: u64, number: u64) -> (Case, Recording) {
    let mut dice = Dice((seed << 20) ^ number);
    let share = dice.unit();
    let kind = KINDS
        .iter()
        .find(|(below, _)| share < *below)
        .map_or(Kind::Unlisted, |k| k.1);
    let listed: Vec<&str> = rig::CATALOGUE.iter().chain(&rig::LATER).copied().collect();
    let (count, names) = match kind {
        Kind::None => (0, &listed[..]),
        Kind::Single => (1, &listed[..]),
        Kind::Pair => (2, &listed[..]),
        Kind::Triple => (3, &listed[..]),
        Kind::Unlisted => (1, &rig::UNLISTED[..]),
    };
    let mut effects: Vec<(&str, f64)> = Vec::new();
    while effects.len() < count {
        let name = names[((dice.unit() * names.len() as f64) as usize).min(names.len() - 1)];
        if effects.iter().all(|e| e.0 != name) {
            effects.push((
                name,
                SIZES_M[0] * (SIZES_M[1] / SIZES_M[0]).powf(dice.unit()),
            ));
        }
    }
    // The independent simulator multiplies its seed.
    let own = (dice.unit() * 1.0e12) as u64;
    let options = rig::Options {
        samples: SAMPLES,
        ..rig::Options::default()
    };
    let recording = rig::record(own, &effects, &options).0;
    let case = Case {
        number: number as usize,
        seed: own,
        kind,
        effects: effects
            .iter()
            .map(|(name, size_m)| Drawn {
                name: (*name).into(),
                size_m: *size_m,
            })
            .collect(),
        conditions: Conditions::Usual,
    };
    (case, recording)
}
