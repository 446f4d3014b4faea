//! Measures how far each effect's form is from what simulators do: what the true effect alone explains of its own recording, and leaves.
//!
//! `cargo run --release -p blind --example inexactness -- SEED COUNT [EFFECT] > effects/inexactness.csv`: so many couriers of each effect, of
//! the project's simulator under the usual conditions and under drawn ones and of the independent one in turn. Cost: some seconds each.

use diagnosis::Options;
use diagnosis::posterior::diagnosed::diagnosed;
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
    let number = |k: usize| words.get(k).and_then(|w| w.parse::<u64>().ok());
    let (Some(seed), Some(count)) = (number(0), number(1)) else {
        return Err(format!(
            "found {words:?}, wanted: inexactness SEED COUNT [EFFECT]"
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

/// Decides on one courier with all other effects taken out of the catalogue: what they would explain counts as left.
fn measure(seed: u64, number: u64, name: &str) {
    let mut dice = Dice(seed ^ (number << 20) ^ hash(name));
    let size_m = SIZES_M[0] * (SIZES_M[1] / SIZES_M[0]).powf(dice.unit());
    let own = (dice.unit() * 4.0e15) as u64;
    let Some((simulator, recording)) = recorded(number, name, size_m, own) else {
        return;
    };
    let all = effects::cards().map(|card| card.name.to_owned());
    let options = Options {
        without: all.filter(|other| other != name).collect(),
    };
    if let Ok(answer) = diagnosed(&recording, &options, false) {
        let (size_um, samples) = (1.0e6 * size_m, recording.samples.len());
        let (explained, left) = (answer.explained, answer.excess);
        println!("{name},{simulator},{number},{size_um:.2},{samples},{explained:.0},{left:.0}");
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
