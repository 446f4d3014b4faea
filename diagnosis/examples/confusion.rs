//! The confusion matrix of the diagnosis on the independent rig: `cargo run --release -p diagnosis --example confusion`.
//! Environment: CASES, FIRST (seed), KINDS (none,single,unlisted,pair,without), PAIRS.
#[path = "../tests/rig/mod.rs"]
mod rig;
use diagnosis::{Options, Verdict, diagnose};
use std::collections::BTreeMap;

fn var(name: &str, default: f64) -> f64 {
    std::env::var(name)
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or(default)
}

fn run(seed: u64, list: &[(&str, f64)], without: &[&str]) -> (String, diagnosis::Diagnosis) {
    let (rec, _) = rig::record(seed, list, &rig::Options::default());
    let d = diagnose(
        &rec,
        "rig",
        &Options {
            without: without.iter().map(|s| s.to_string()).collect(),
        },
    );
    let names: Vec<String> = d.effects.iter().map(|e| e.name.clone()).collect();
    (format!("{:?} {}", d.verdict, names.join("+")), d)
}

fn show(d: &diagnosis::Diagnosis) -> String {
    let place: Vec<String> = d
        .place
        .iter()
        .take(3)
        .map(|w| format!("{} {:.2}", w.coordinate, w.share))
        .collect();
    let effects: Vec<String> = d
        .effects
        .iter()
        .map(|e| {
            format!(
                "{} p{:.2} s{:.2} {:?}",
                e.name, e.probability, e.share, e.aliases
            )
        })
        .collect();
    format!(
        "white {:.2}->{:.2} left {:.3} [{}] where [{}]",
        d.held_out.whitened_before,
        d.held_out.whitened_after,
        d.unexplained.share,
        effects.join("; "),
        place.join("; ")
    )
}

fn main() {
    let cases = var("CASES", 1.0) as u64;
    let first = var("FIRST", 1.0) as u64;
    let kinds = std::env::var("KINDS").unwrap_or("none,single,unlisted,pair,without".into());
    let mut tally: BTreeMap<String, (u64, u64)> = BTreeMap::new();
    let mut note = |kind: &str, good: bool, text: String| {
        let entry = tally.entry(kind.into()).or_default();
        entry.1 += 1;
        if good {
            entry.0 += 1
        } else {
            println!("BAD {kind}: {text}")
        }
    };
    for seed in first..first + cases {
        let mut dice = rig::Dice(seed * 1009);
        if kinds.contains("none") {
            let (text, d) = run(seed, &[], &[]);
            note(
                "none",
                d.verdict == Verdict::NoGap,
                format!("seed {seed} {text} {}", show(&d)),
            );
        }
        let only = std::env::var("ONLY").unwrap_or_default();
        for name in rig::CATALOGUE
            .into_iter()
            .filter(|n| only.is_empty() || only.contains(n))
        {
            let size = 0.7e-6 * (4.0f64 / 0.7).powf(dice.unit());
            if kinds.contains("single") {
                let (text, d) = run(seed, &[(name, size)], &[]);
                let good = d.effects.first().is_some_and(|e| e.name == name);
                note(
                    "single",
                    good,
                    format!(
                        "seed {seed} {name} {:.2} -> {text} {}",
                        size * 1e6,
                        show(&d)
                    ),
                );
                note(
                    "single, nothing else",
                    good && d.effects.len() == 1,
                    name.to_string(),
                );
            }
            if kinds.contains("without") {
                let (text, d) = run(seed, &[(name, size)], &[name]);
                let good = d.effects.iter().all(|e| e.name == "extra_harmonics");
                note(
                    "without",
                    good,
                    format!(
                        "seed {seed} {name} {:.2} -> {text} {}",
                        size * 1e6,
                        show(&d)
                    ),
                );
            }
        }
        for name in rig::UNLISTED
            .into_iter()
            .filter(|n| only.is_empty() || only.contains(n))
        {
            let size = 0.7e-6 * (4.0f64 / 0.7).powf(dice.unit());
            if kinds.contains("unlisted") {
                let (text, d) = run(seed, &[(name, size)], &[]);
                note(
                    "unlisted",
                    d.verdict == Verdict::Unknown,
                    format!(
                        "seed {seed} {name} {:.2} -> {text} {}",
                        size * 1e6,
                        show(&d)
                    ),
                );
            }
        }
        for _ in 0..var("PAIRS", 6.0) as u64 {
            let (a, b) = (dice.pick(19), dice.pick(19));
            let (sa, sb) = (
                0.7e-6 * (4.0f64 / 0.7).powf(dice.unit()),
                0.7e-6 * (4.0f64 / 0.7).powf(dice.unit()),
            );
            if a != b && kinds.contains("pair") {
                let (a, b) = (rig::CATALOGUE[a], rig::CATALOGUE[b]);
                let (text, d) = run(seed, &[(a, sa), (b, sb)], &[]);
                let good =
                    d.effects.len() == 2 && d.effects.iter().all(|e| e.name == a || e.name == b);
                note(
                    "pair",
                    good,
                    format!(
                        "seed {seed} {a} {:.2} + {b} {:.2} -> {text} {}",
                        sa * 1e6,
                        sb * 1e6,
                        show(&d)
                    ),
                );
            }
        }
    }
    for (kind, (good, all)) in tally {
        println!("{kind}: {good} of {all}");
    }
}
