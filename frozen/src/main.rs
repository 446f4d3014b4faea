//! `frozen`: keeps the diagnosis' answers and compares today's with them.

use anyhow::{Result, ensure};
use clap::{Parser, Subcommand};
use frozen::answer::answer;
use frozen::rounding::{shaken, what_rounding_does};
use frozen::{Answer, Kept, RELATIVE, Specimen, compare, list};
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Keeps the diagnosis' answers to a set of specimens and compares today's with them.
#[derive(Debug, Parser)]
struct Args {
    #[command(subcommand)]
    command: Command,
    /// The file of kept answers.
    #[arg(long, global = true, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/answers.jsonl"))]
    file: PathBuf,
    /// Only specimens whose name contains this.
    #[arg(long, global = true, default_value = "")]
    only: String,
    /// Only so many, from the front.
    #[arg(long, global = true)]
    first: Option<usize>,
    /// Threads: the same number on every machine.
    #[arg(long, global = true, default_value_t = 2)]
    threads: usize,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Answer the whole set and write the file, or with `--only` or `--first` answer those anew and leave the others as they are.
    Write {
        /// Answer only those that the file lacks.
        #[arg(long)]
        missing: bool,
    },
    /// Answer the kept specimens and tell each difference; exit code 1 where there is one.
    Compare {
        /// Tell differences of the last bit too.
        #[arg(long)]
        exact: bool,
    },
    /// How far answers move where each reading is changed in its last bit: what rounding may do.
    Shake,
}

fn main() -> ExitCode {
    match told(&Args::parse()) {
        Ok(differ) => u8::from(differ).into(),
        Err(error) => {
            eprintln!("frozen: {error:#}");
            2.into()
        }
    }
}

/// True if answers differ.
fn told(args: &Args) -> Result<bool> {
    ThreadPoolBuilder::new()
        .num_threads(args.threads)
        .build_global()?;
    match args.command {
        Command::Write { missing } => keep(args, missing),
        Command::Compare { exact } => compared(args, if exact { 0.0 } else { RELATIVE }),
        Command::Shake => shake(args),
    }
}

impl Args {
    fn chosen(&self, specimens: impl Iterator<Item = Specimen>) -> Vec<Specimen> {
        let named = specimens.filter(|s| s.name().contains(&self.only));
        named.take(self.first.unwrap_or(usize::MAX)).collect()
    }

    fn kept(&self) -> Result<Vec<Kept>> {
        let mut kept = frozen::read(&self.file)?;
        kept.retain(|one| one.specimen.name().contains(&self.only));
        kept.truncate(self.first.unwrap_or(usize::MAX));
        ensure!(
            !kept.is_empty(),
            "{}: found no specimen whose name contains '{}', wanted one",
            self.file.display(),
            self.only
        );
        Ok(kept)
    }
}

/// The answer to a specimen; none, and said so, where its recording is absent.
fn answered(specimen: &Specimen) -> Result<Option<Answer>> {
    let Some(first) = specimen.first()? else {
        eprintln!(
            "SKIPPED: {}: its recording is absent; set COURIER_SHARED",
            specimen.name()
        );
        return Ok(None);
    };
    Ok(Some(answer(&first, specimen.second().as_ref())))
}

/// How far a long set is: a line on standard error after every so many.
struct Progress {
    done: AtomicUsize,
    count: usize,
}

impl Progress {
    /// Specimens from line to line: about half a minute.
    const TOLD_EVERY: usize = 50;

    fn of(count: usize) -> Self {
        let done = AtomicUsize::new(0);
        Self { done, count }
    }

    /// The answer to a further specimen.
    fn answered(&self, specimen: &Specimen) -> Result<Option<Answer>> {
        let answer = answered(specimen);
        let done = self.done.fetch_add(1, Relaxed) + 1;
        if done % Self::TOLD_EVERY == 0 || done == self.count {
            eprintln!("{done} of {} answered", self.count);
        }
        answer
    }
}

/// Specimens after which the file is written.
const WRITTEN_EVERY: usize = 20;

fn keep(args: &Args, missing: bool) -> Result<bool> {
    let all = args.only.is_empty() && args.first.is_none() && !missing;
    let mut kept = if all || !args.file.exists() {
        Vec::new()
    } else {
        frozen::read(&args.file)?
    };
    let place = |kept: &[Kept], wanted: &Specimen| kept.iter().position(|k| k.specimen == *wanted);
    let mut chosen = args.chosen(list::list().into_iter());
    if missing {
        chosen.retain(|specimen| place(&kept, specimen).is_none());
    }
    // Written after every few: a long set that is broken off goes on with `--missing`.
    let progress = Progress::of(chosen.len());
    for few in chosen.chunks(WRITTEN_EVERY) {
        let new: Vec<_> = few
            .par_iter()
            .map(|specimen| progress.answered(specimen))
            .collect::<Result<_>>()?;
        for (specimen, answer) in few.iter().zip(new) {
            let Some(answer) = answer else { continue };
            let specimen = specimen.clone();
            match place(&kept, &specimen) {
                Some(k) => kept[k].answer = answer,
                None => kept.push(Kept { specimen, answer }),
            }
        }
        frozen::write(&args.file, &kept)?;
    }
    println!("{} answers kept", kept.len());
    Ok(false)
}

fn compared(args: &Args, relative: f64) -> Result<bool> {
    let kept = args.kept()?;
    let progress = Progress::of(kept.len());
    let differ: Vec<bool> = kept
        .par_iter()
        .map(|one| {
            let Some(now) = progress.answered(&one.specimen)? else {
                return Ok(false);
            };
            let found = compare(&one.answer, &now, relative);
            // Told to the last bit, nothing is put down to rounding.
            let (rounded, other) = if relative > 0.0 && !found.is_empty() {
                what_rounding_does(&one.specimen, &now, found)?
            } else {
                (Vec::new(), found)
            };
            let name = one.specimen.name();
            for difference in &rounded {
                println!("{name}: rounding alone does as much: {difference}");
            }
            for difference in &other {
                println!("{name}: {difference}");
            }
            Ok(!other.is_empty())
        })
        .collect::<Result<_>>()?;
    let count = differ.iter().filter(|differs| **differs).count();
    println!("{count} of {} answers differ", kept.len());
    Ok(count > 0)
}

fn shake(args: &Args) -> Result<bool> {
    let kept = args.kept()?;
    let moved: Vec<f64> = kept
        .par_iter()
        .map(|one| {
            let Some(first) = one.specimen.first()? else {
                return Ok(0.0);
            };
            let now = answer(&shaken(&first, 0), one.specimen.second().as_ref());
            let found = compare(&one.answer, &now, 0.0);
            let Some(most) = found
                .iter()
                .max_by(|a, b| a.relative.total_cmp(&b.relative))
            else {
                return Ok(0.0);
            };
            println!("{:.1e} {}: {most}", most.relative, one.specimen.name());
            Ok(most.relative)
        })
        .collect::<Result<_>>()?;
    println!(
        "most: {:.1e}",
        moved.iter().fold(0.0, |most: f64, x| most.max(*x))
    );
    Ok(false)
}
