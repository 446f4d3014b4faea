//! A command whose work panics, for the test of how that ends. It goes the way that `courier` goes, and is installed by nobody.

use clap::Parser;
use std::process::ExitCode;

/// A command that panics.
#[derive(Parser)]
#[command(name = "courier", version)]
struct Options {
    /// Where: `here`, or in a `thread` that is waited for.
    place: String,
}

fn main() -> ExitCode {
    command_line::run(|options: Options| {
        if options.place == "thread" {
            std::thread::scope(|scope| scope.spawn(|| panic!("in a thread")).join())
                .unwrap_or_else(|_| panic!("a thread has ended"));
        }
        let list: Vec<u8> = Vec::new();
        // An index out of bounds, two lines long in the report.
        assert!(
            list.len() > options.place.len(),
            "wanted more\nthan nothing"
        );
        Ok(ExitCode::SUCCESS)
    })
}
