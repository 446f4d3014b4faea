//! The blocks of commands that the test does not run, each with its reason.

use crate::page::Page;
use crate::run::{holds_commands, is_left_out, is_run};

/// Page, first line of the block, why it is not run. Each stands for one block after ```` ```console not-run ```` or
/// ```` ```sh not-run ````.
const NOT_RUN: &[(&str, &str, &str)] = &[
    ("README.md", "cargo xtask test", "it is what runs this test"),
    (
        "README.md",
        "cargo install --path host",
        "builds everything anew, for minutes",
    ),
    (
        "CONTRIBUTING.md",
        "cargo demo          # the main job on a simulated board",
        "the first is run by README.md, the second runs this test",
    ),
    (
        "docs/your-sensor.md",
        "courier convert LOG.csv OUT --column t_s=t:s --column q1s=sin --column q1c=cos \\",
        "a form to fill in: no such log is here",
    ),
    (
        "docs/your-sensor.md",
        "courier convert LOG.csv OUT --column t_s=t:ms \\",
        "a form to fill in: no such log is here",
    ),
    (
        "docs/formats.md",
        "courier convert examples/survey-lateral survey.parquet",
        "needs a feature that the tests do not build: `cargo xtask parquet` does",
    ),
    (
        "docs/formats.md",
        "courier convert examples/survey-lateral survey.mcap",
        "needs a feature that the tests do not build: `cargo xtask mcap` does",
    ),
    (
        "docs/other-logs.md",
        "courier convert my-bag.mcap my-joint --column p1_m=position[elbow]:rad --column ref_x_m=/stage.data:deg",
        "needs a feature that the tests do not build: `cargo xtask mcap` does",
    ),
    (
        "docs/many-recordings.md",
        "ls -d recordings/* | parallel -j 2 courier diagnose {} --out answers --jobs 1",
        "needs GNU parallel and Slurm",
    ),
    (
        "docs/python.md",
        "pip install ./python                    # builds it; a few minutes the first time",
        "installs; `cargo xtask test python` builds a wheel, installs and tests it",
    ),
    (
        "docs/python.md",
        "cargo build --profile checked --package courier",
        "tells how long things take on the machine at hand",
    ),
    (
        "docs/many-recordings.md",
        "python examples/diagnose-on-ray/diagnose.py answers recordings/*",
        "needs Ray; `cargo xtask ray` runs the script",
    ),
    (
        "docs/fleet.md",
        "courier fleet c1 --part c1.part                              # each recording by itself",
        "half a minute; `fleet/tests/suite/sums.rs` holds that parts lead to the same",
    ),
    (
        "docs/bring-up.md",
        "courier trace board.vcd",
        "needs a recording of a logic analyser",
    ),
    (
        "docs/your-board.md",
        "cargo install --path host --features probe",
        "builds everything anew, for minutes",
    ),
    (
        "docs/your-board.md",
        "cargo xtask option-bytes",
        "needs a board on a probe",
    ),
    (
        "docs/update.md",
        "cargo xtask image firmware.img",
        "builds the image anew, for minutes",
    ),
    (
        "docs/your-board.md",
        "cargo flash",
        "needs a board on a probe",
    ),
    (
        "docs/bring-up.md",
        "cargo xtask option-bytes",
        "needs a board on a probe",
    ),
    (
        "docs/bring-up.md",
        "cargo xtask image firmware.img",
        "needs a board on a probe",
    ),
    (
        "docs/diagnosis-inside.md",
        "cargo run --release -p frozen -- compare           # what differs today; --exact tells the last bit too",
        "builds everything anew, for minutes, and answers every kept recording",
    ),
    (
        "docs/bring-up.md",
        "cargo flash",
        "needs a board on a probe",
    ),
    (
        "docs/bring-up.md",
        "STM32_Programmer_CLI -c port=SWD -ob RDP=0xBB",
        "needs a board on a probe, and ST's tool",
    ),
];

/// Blocks of commands that are neither run nor listed, and lines of the list that name no block.
pub fn unlisted(pages: &[Page]) -> Vec<String> {
    let mut listed = NOT_RUN.to_vec();
    let mut wrong = vec![];
    for page in pages {
        for block in page
            .blocks
            .iter()
            .filter(|block| holds_commands(page, block))
        {
            let first = page.lines(block).lines().next().unwrap_or_default();
            let at = format!("{}: `{first}`", page.name);
            let place = listed
                .iter()
                .position(|(name, line, _)| (*name, *line) == (&page.name, first));
            match (is_left_out(block), place) {
                (true, Some(place)) => {
                    listed.remove(place);
                }
                (true, None) => wrong.push(format!("{at} is not run, and no reason is listed")),
                (false, Some(_)) => wrong.push(format!("{at} is listed as not run, and is")),
                (false, None) if !is_run(block) => {
                    wrong.push(format!("{at}: commands in a block that is not run"));
                }
                (false, None) => {}
            }
        }
    }
    let unused = listed
        .iter()
        .map(|(page, line, _)| format!("listed as not run, but not there: {page}: `{line}`"));
    wrong.extend(unused);
    wrong
}
