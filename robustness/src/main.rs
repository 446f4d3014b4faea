//! `cargo xtask robustness`: as many random recordings and cut surveys as a night has room for.

use anyhow::{Result, ensure};
use clap::{Parser, Subcommand, ValueEnum};
use recording::Existing;
use robustness::through::through;
use robustness::{cuts, draw};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

/// Random recordings against every command that reads one.
#[derive(Parser)]
#[command(name = "robustness", version)]
struct Cli {
    #[command(subcommand)]
    what: What,
}

/// What a cut survey is of.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum WithEffect {
    /// A courier without any effect.
    None,
    /// One with an effect.
    One,
}

#[derive(Subcommand)]
enum What {
    /// Recordings drawn at random through `diagnose`, `check`, `replay` and `map`; none may end in an error of the program.
    Crashes {
        /// How many.
        count: u64,
        /// Number of the first.
        #[arg(long, default_value_t = 0)]
        first: u64,
    },
    /// Surveys that were cut at random, without any effect: at most one in 200 may have an effect named. With an effect: how often
    /// it is found.
    Cuts {
        /// How many.
        count: u64,
        /// Number of the first.
        #[arg(long, default_value_t = 0)]
        first: u64,
        /// Give each courier one effect.
        #[arg(long)]
        effect: bool,
    },
    /// Writes one recording, to look at it with `courier`.
    Write {
        /// Its number.
        number: u64,
        /// A cut survey in place of a random recording: without an effect, or with one.
        #[arg(long)]
        cut: Option<WithEffect>,
        /// Folder to make.
        folder: PathBuf,
    },
}

fn main() -> ExitCode {
    command_line::run(|cli: Cli| {
        match cli.what {
            What::Crashes { count, first } => crashes(count, first)?,
            What::Cuts {
                count,
                first,
                effect,
            } if effect => found(count, first),
            What::Cuts { count, first, .. } => cut(count, first)?,
            What::Write {
                number,
                cut,
                folder,
            } => {
                let drawn = match cut {
                    Some(with) => cuts::draw(number, with == WithEffect::One).recording,
                    None => draw::recording(number),
                };
                drawn.write(folder, Existing::Refuse)?;
            }
        }
        Ok(ExitCode::SUCCESS)
    })
}

/// Steps after which a line tells how far it is.
const TOLD_EVERY: u64 = 100;

fn crashes(count: u64, first: u64) -> Result<()> {
    let mut crashed = 0;
    let mut answers = BTreeMap::new();
    let mut other = draw::recording(first + count);
    for number in first..first + count {
        let drawn = draw::recording(number);
        let outcome = through(&drawn, &other);
        other = drawn;
        for crash in &outcome.crashes {
            println!(
                "number {number}: {} panicked at {}",
                crash.command, crash.panic
            );
        }
        crashed += u64::from(!outcome.crashes.is_empty());
        for command in outcome.answered {
            *answers.entry(command).or_insert(0) += 1;
        }
        let done = number + 1 - first;
        if done % TOLD_EVERY == 0 || done == count {
            let told = answers
                .iter()
                .map(|(command, n)| format!("{n} by {command}"));
            let told: Vec<String> = told.collect();
            println!(
                "{crashed} of {done} recordings crashed; answers: {}",
                told.join(", ")
            );
        }
    }
    ensure!(
        crashed == 0,
        "{crashed} of {count} recordings ended in an error of the program, wanted none"
    );
    Ok(())
}

/// Cuts without any effect in which one may be named: one in so many.
const ONE_NAMED_OF: u64 = 200;
/// Cuts after which a line tells how far it is: one takes some seconds.
const CUTS_TOLD_EVERY: u64 = 20;

fn cut(count: u64, first: u64) -> Result<()> {
    let mut named = 0;
    for number in first..first + count {
        if let Some(wrong) = cuts::answer(&cuts::draw(number, false)).wrong {
            named += 1;
            println!("number {number}: {wrong}");
        }
        let done = number + 1 - first;
        if done % CUTS_TOLD_EVERY == 0 || done == count {
            println!("effects named in {named} of {done} cut surveys without any");
        }
    }
    let most = count.div_ceil(ONE_NAMED_OF);
    ensure!(
        named <= most,
        "effects named in {named} of {count} cut surveys without any, wanted at most {most}"
    );
    Ok(())
}

fn found(count: u64, first: u64) {
    let (mut right, mut wrong) = (0, 0);
    for number in first..first + count {
        let drawn = cuts::draw(number, true);
        let answer = cuts::answer(&drawn);
        right += u64::from(answer.found);
        wrong += u64::from(answer.wrong.is_some());
        let told = answer.wrong.unwrap_or_default();
        println!(
            "number {number}: {:?} {:?}, found {}; {told} ({right} of {} so far)",
            drawn.kind,
            drawn.effect,
            answer.found,
            number + 1 - first
        );
    }
    println!("of {count} cut surveys with one effect {right} named it, {wrong} named another");
}
