//! Measures how far each effect's form is from what simulators do: what the true effect alone explains of its own recording, and leaves.
//!
//! `cargo run --release -p blind --example inexactness -- SEED COUNT [EFFECT] > effects/inexactness.csv`: so many couriers of each effect, of
//! the project's simulator under the usual conditions and under drawn ones and of the independent one in turn. Cost: some seconds each.
//! `... -- of RECORDING EFFECT` prints the same of a recording in which that effect acts alone. To standard error go the lines of
//! `effects/form_errors.csv`, what each other effect, and lines in the spectrum, take of what is left: effect, simulator, number, squares left, other, its
//! columns, those of them that the data tell, squares taken.

use diagnosis::posterior::form_error::form_error;
use effects::has;
use rayon::prelude::*;
use recording::Recording;
use specimens::rig::{self, Dice};
use specimens::{Case, Conditions, Drawn, Kind};

/// Sizes, rms m: up to twice the largest of a blind check.
const SIZES_M: [f64; 2] = [0.7e-6, 8.0e-6];
/// Samples of the independent simulator's runs, as its judges have them.
const SAMPLES: usize = 3000;

fn main() -> Result<(), String> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let [first, path, name] = &words[..]
        && first == "of"
    {
        let recording = Recording::read(path).map_err(|e| e.to_string())?;
        tell([name, "real", "0", ""], &recording);
        return Ok(());
    }
    let number = |k: usize| words.get(k).and_then(|w| w.parse::<u64>().ok());
    let (Some(seed), Some(count)) = (number(0), number(1)) else {
        return Err(format!(
            "found {words:?}, wanted: inexactness SEED COUNT [EFFECT], or: inexactness of RECORDING EFFECT"
        ));
    };
    let only = words.get(2).map_or("", String::as_str);
    let names: Vec<&str> = effects::cards()
        .map(|card| card.name)
        .filter(|name| name.contains(only) && has(name, |card| card.detection.is_fitted()))
        .collect();
    println!("effect,simulator,number,size_um,samples,explained,left");
    let all: Vec<(u64, &str)> = (0..count)
        .flat_map(|k| names.iter().map(move |name| (k, *name)))
        .collect();
    all.par_iter().for_each(|(k, name)| measure(seed, *k, name));
    Ok(())
}

/// Fits one courier with all other effects taken out of the catalogue: what they would explain counts as left.
fn measure(seed: u64, number: u64, name: &str) {
    let mut dice = Dice(seed ^ (number << 20) ^ hash(name));
    let size_m = SIZES_M[0] * (SIZES_M[1] / SIZES_M[0]).powf(dice.unit());
    let own = (dice.unit() * 4.0e15) as u64;
    if let Some((simulator, recording)) = recorded(number, name, size_m, own) {
        let (number, size) = (number.to_string(), format!("{:.2}", 1.0e6 * size_m));
        tell([name, simulator, &number, &size], &recording);
    }
}

/// Whitened squares that must be left for it to be asked what other effects take of them, and what lines in the spectrum do. Derived from chi-square:
/// a tenth of 1,500 is 12 deviations of the noise in one column, and a tenth of 500 is 7. Of lines less will do, since all couriers are taken together.
const ASKED_FROM: [f64; 2] = [1_500.0, 500.0];
/// Shapes of lines in the spectrum.
const LINES: &str = "frequency";

/// Prints what an effect explains of a recording in which it acts alone, and leaves; to standard error, what others take of that. `of` is the effect, the
/// simulator, the courier's number and the size.
fn tell(of: [&str; 4], recording: &Recording) {
    let [name, simulator, number, _] = of;
    let Ok(Some(found)) = form_error(recording, name) else {
        return;
    };
    let samples = recording.samples.len();
    let (what, explained, left) = (of.join(","), found.explained, found.left);
    println!("{what},{samples},{explained:.0},{left:.0}");
    let Some(beside) = &found.beside else {
        return;
    };
    let [effects_from, lines_from] = ASKED_FROM;
    let asked = |block: &str| {
        let lines = block == LINES && beside.squares >= lines_from;
        lines || effects::card(block).is_some() && beside.squares >= effects_from
    };
    for taken in beside.taken.iter().filter(|taken| asked(&taken.block)) {
        eprintln!(
            "{name},{simulator},{number},{:.0},{},{},{:.1},{:.0}",
            beside.squares, taken.block, taken.columns, taken.told, taken.squares
        );
    }
}

/// A courier with the effect; none where the simulator in turn does not know it.
fn recorded(number: u64, name: &str, size_m: f64, seed: u64) -> Option<(&'static str, Recording)> {
    let case = |conditions| Case {
        number: number as usize,
        seed,
        kind: Kind::Single,
        effects: vec![Drawn {
            name: name.into(),
            size_m,
        }],
        conditions,
    };
    match number % 3 {
        0 => Some(("usual", case(Conditions::Usual).recorded(0))),
        1 => Some(("drawn", case(Conditions::Drawn).recorded(0))),
        _ => {
            let known = rig::CATALOGUE.contains(&name) || rig::LATER.contains(&name);
            let options = rig::Options {
                samples: SAMPLES,
                ..rig::Options::default()
            };
            // The independent simulator multiplies its seed.
            known.then(|| {
                (
                    "independent",
                    rig::record(seed >> 12, &[(name, size_m)], &options).0,
                )
            })
        }
    }
}

/// A number for a name (FNV-1a).
fn hash(name: &str) -> u64 {
    name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    })
}
