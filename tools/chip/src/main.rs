//! `chip IMAGE [CHECK…]`: runs the image on the modelled chip; without names of checks, all of them. `chip serve IMAGE`: the chip is a
//! board for the program that started this one. `chip trace IMAGE FILE.vcd [SECONDS]`: what a logic analyser sees at its pins. `chip rules`:
//! the rules, by name. `chip control IMAGE IMAGE`: two images of somebody else's drivers, the second at the fastest clock.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let done = match &words[..] {
        [] => {
            eprintln!("chip: found no image, wanted: chip IMAGE [CHECK…] or chip serve IMAGE");
            return ExitCode::from(2);
        }
        [rules] if rules == "rules" => {
            for rule in chip::rule::Rule::ALL {
                println!("{} {}", rule.name(), rule.text().trim());
            }
            Ok(())
        }
        [serve, image] if serve == "serve" => chip::serve::run(Path::new(image)),
        [trace, image, file, seconds @ ..] if trace == "trace" && seconds.len() < 2 => {
            chip::trace::run(Path::new(image), Path::new(file), seconds.first())
        }
        [control, normal, boosted] if control == "control" => {
            chip::check::control::run(Path::new(normal), Path::new(boosted))
        }
        [image, name, json] if json == "--json" => {
            chip::check::print_figures(Path::new(image), name)
        }
        [image, names @ ..] => chip::check::run(Path::new(image), names),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("chip: {error:#}");
            ExitCode::FAILURE
        }
    }
}
