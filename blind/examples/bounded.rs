//! Diagnoses simulated couriers, beside a diagnosis that is told which effects act and an ideal observer, and counts which are right.
//!
//! `cargo run --release -p blind --example bounded -- SEED FIRST LAST [--drawn] [--explain]`: cases FIRST to LAST of a campaign; with `--drawn` under
//! conditions that are drawn as well. `--explain` tells the likeliest sets of each.

use blind::bounded::{Bounded, Counts, bounded};
use blind::{Conditions, Judged, Kind};

fn main() -> Result<(), String> {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let mut asked = |flag: &str| {
        let count = words.len();
        words.retain(|w| w != flag);
        words.len() < count
    };
    let explain = asked("--explain");
    let conditions = if asked("--drawn") {
        Conditions::Drawn
    } else {
        Conditions::Usual
    };
    let wanted = "wanted: bounded SEED FIRST LAST [--drawn] [--explain]";
    let numbers: Option<Vec<u64>> = words.iter().map(|w| w.parse().ok()).collect();
    let Some([seed, first, last]) = numbers.as_deref() else {
        return Err(format!("found {words:?}, {wanted}"));
    };
    let cases = *first as usize..*last as usize + 1;
    let all = bounded(cases, *seed, conditions, explain, tell);
    for kind in [
        Kind::None,
        Kind::Single,
        Kind::Pair,
        Kind::Triple,
        Kind::Unlisted,
    ] {
        let of_it = all.iter().filter(|case| case.judged.case.kind == kind);
        println!("{kind:?}: {}", Counts::of(of_it));
    }
    println!("all: {}", Counts::of(all.iter()));
    Ok(())
}

fn tell(case: &Bounded) {
    let truth = case.judged.case.effects.iter();
    let truth: Vec<String> = truth
        .map(|e| format!("{} {:.2} µm", e.name, 1e6 * e.size_m))
        .collect();
    let right = |right: bool| if right { "right" } else { "WRONG" };
    let mut out = format!(
        "{:3} {truth:?}, seen with {:.2}{}: {} {}, told {} {}, {:.1} s",
        case.judged.case.number,
        case.ideal.seen,
        if case.ideal.worth_a_name {
            ""
        } else {
            ", not worth a name"
        },
        right(case.is_right()),
        words(&case.judged),
        right(case.can_be_told()),
        words(&case.told),
        case.took_s,
    );
    if let Some(decision) = &case.decision {
        let masses = decision.masses;
        out += &format!(
            "; {} rounds, no gap {:.3}, named {:.3}, unknown {:.3}, left {:.3}",
            decision.rounds, masses.no_gap, masses.named, masses.unknown, decision.left_share
        );
        if !decision.sets.is_empty() {
            decision
                .reasons
                .iter()
                .for_each(|r| out += &format!("\n      {r}"));
            decision
                .sets
                .iter()
                .for_each(|s| out += &format!("\n    {}", s.cells().join("  ")));
        }
    }
    println!("{out}");
}

fn words(judged: &Judged) -> String {
    let claim = judged.claim.as_ref();
    let claim =
        claim.and_then(|c| Some(format!(" claimed {:.2}, is {:.2}", c.claimed, c.confirmed?)));
    format!(
        "{:?} {:?} {:?}{}",
        judged.verdict,
        judged.named,
        judged.places.first(),
        claim.unwrap_or_default()
    )
}
