//! `chip IMAGE [CHECK…]`: runs the image on the modelled chip; without names of checks, all of them.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let Some((image, names)) = words.split_first() else {
        eprintln!("chip: found no image, wanted: chip IMAGE [CHECK…]");
        return ExitCode::from(2);
    };
    match chip::check::run(Path::new(image), names) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("chip: {error:#}");
            ExitCode::FAILURE
        }
    }
}
