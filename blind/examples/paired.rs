//! Answers the same simulated couriers by the rules of the selection and by the posterior, and counts which are right.
//!
//! `cargo run --release -p blind --example paired -- SEED FIRST LAST [--drawn] [--explain]`: cases FIRST to LAST of a campaign; with `--drawn` under
//! conditions that are drawn as well. `--explain` tells the likeliest sets of each.

use blind::paired::{Counts, Pair, paired};
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
    let wanted = "wanted: paired SEED FIRST LAST [--drawn] [--explain]";
    let numbers: Option<Vec<u64>> = words.iter().map(|w| w.parse().ok()).collect();
    let Some([seed, first, last]) = numbers.as_deref() else {
        return Err(format!("found {words:?}, {wanted}"));
    };
    let cases = *first as usize..*last as usize + 1;
    let pairs = paired(cases, *seed, conditions, explain, |pair| {
        tell(pair, explain)
    });
    for kind in [
        Kind::None,
        Kind::Single,
        Kind::Pair,
        Kind::Triple,
        Kind::Unlisted,
    ] {
        let of_it = pairs.iter().filter(|p| p.rules.case.kind == kind);
        println!("{kind:?}: {}", Counts::of(of_it));
    }
    println!("all: {}", Counts::of(pairs.iter()));
    Ok(())
}

fn tell(pair: &Pair, explain: bool) {
    let truth = pair.rules.case.effects.iter();
    let truth: Vec<String> = truth
        .map(|e| format!("{} {:.2} µm", e.name, 1e6 * e.size_m))
        .collect();
    let [rules, posterior] = pair
        .right()
        .map(|right| if right { "right" } else { "WRONG" });
    let mut out = format!(
        "{:3} {truth:?}, seen with {:.2}{}: rules {rules} {}, posterior {posterior} {}, bound {} {}, {:.1} and {:.1} s",
        pair.rules.case.number,
        pair.ideal.seen,
        if pair.ideal.worth_a_name {
            ""
        } else {
            ", not worth a name"
        },
        words(&pair.rules),
        words(&pair.posterior),
        if pair.can_be_told() { "right" } else { "WRONG" },
        words(&pair.bound),
        pair.took_s[0],
        pair.took_s[1],
    );
    if let Some(answer) = &pair.answer {
        let masses = answer.masses;
        out += &format!(
            "; {} rounds, no gap {:.3}, named {:.3}, unknown {:.3}, left {:.3}",
            answer.rounds, masses.no_gap, masses.named, masses.unknown, answer.left_share
        );
        if explain {
            answer
                .reasons
                .iter()
                .for_each(|r| out += &format!("\n      {r}"));
            answer
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
