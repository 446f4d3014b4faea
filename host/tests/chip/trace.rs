//! What a logic analyser sees at the pins of the image as it ships, and whether `courier trace` finds each fault that is put into it.

use crate::common::asked;
use courier::trace::{Line, Lines, Signal, Span, file, judge};
use std::path::Path;
use std::process::Command;

/// 100 MS/s.
const STEP_S: f64 = 1.0e-8;
const US: f64 = 1.0e-6;

/// A millisecond of the image's lines.
fn taken(folder: &Path) -> (Lines, Span) {
    let variable = |name: &str| {
        std::env::var_os(name)
            .unwrap_or_else(|| panic!("{name}: `cargo xtask chip --tests` sets it"))
    };
    let file = folder.join("board.vcd");
    let status = Command::new(variable("COURIER_CHIP_MODEL"))
        .arg("trace")
        .arg(variable("COURIER_CHIP_IMAGE"))
        .args([file.as_os_str(), "0.001".as_ref()])
        .status();
    assert!(status.expect("the model runs").success());
    let trace = file::read(&file, None).expect("a trace");
    let span = trace.span;
    (Lines::of(trace, &[]).expect("lines"), span)
}

/// The same lines, as an instrument sees them that looks every so often.
fn sampled(lines: &Lines, span: Span, step_s: f64) -> (Lines, Span) {
    let mut seen = Lines::default();
    for line in ALL {
        let signal = lines.get(line).expect("the model has it");
        let edges_s = signal
            .edges_s()
            .iter()
            .map(|at_s| (at_s / step_s).ceil() * step_s);
        seen.put(line, Signal::new(signal.first(), edges_s.collect()));
    }
    (seen, Span { step_s, ..span })
}

const ALL: [Line; 9] = [
    Line::Convst,
    Line::Busy,
    Line::Select(0),
    Line::Select(1),
    Line::Clock(0),
    Line::Clock(1),
    Line::Data(0),
    Line::Data(1),
    Line::Reset,
];

fn failed(lines: &Lines, span: Span) -> Vec<&'static str> {
    let steps = judge(lines, span).into_iter();
    steps
        .filter(|step| step.passed == Some(false))
        .map(|step| step.step)
        .collect()
}

/// The lines with two edges of one taken out: a change to a level, the fifth one, and the change back. Where a trace begins is chance.
fn without(lines: &Lines, line: Line, level: bool) -> Lines {
    let first = usize::from(lines.get(line).expect("it is recorded").first() == level);
    let at = first + 8;
    with(lines, line, |edges_s| {
        [&edges_s[..at], &edges_s[at + 2..]].concat()
    })
}

/// One line with other edges.
fn with(lines: &Lines, line: Line, change: impl FnOnce(&[f64]) -> Vec<f64>) -> Lines {
    let signal = lines.get(line).expect("it is recorded");
    let mut changed = lines.clone();
    changed.put(line, Signal::new(signal.first(), change(signal.edges_s())));
    changed
}

#[test]
fn the_image_passes_and_each_fault_that_is_put_into_its_trace_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let (lines, span) = taken(folder.path());
    // CONVST, BUSY and both converters are judged; slopes and the processor's reset a trace of the model does not have.
    let told = judge(&lines, span);
    let open: Vec<&str> = told
        .iter()
        .filter(|step| step.passed.is_none())
        .map(|step| step.step)
        .collect();
    assert_eq!(open, ["CONVST edges", "NRST"]);
    assert_eq!(failed(&lines, span), [""; 0], "{told:?}");
    let (lines, span) = sampled(&lines, span, STEP_S);
    assert_eq!(failed(&lines, span), [""; 0]);

    let short = with(&lines, Line::Convst, |edges_s| {
        let begins = usize::from(lines.get(Line::Convst).expect("it is recorded").first());
        let (before, pulses) = edges_s.split_at(begins);
        let short = pulses
            .chunks(2)
            .flat_map(|pulse| [pulse[0], pulse[0] + 0.1 * US]);
        before.iter().copied().chain(short).collect()
    });
    assert_eq!(failed(&short, span), ["CONVST width"]);
    // A conversion that was not started has no pulse of BUSY and no frames either; here those stay, and are told.
    let missing = without(&lines, Line::Convst, true);
    assert_eq!(
        failed(&missing, span),
        ["CONVST pulses", "BUSY pulses", "CS0 frames", "CS1 frames"]
    );
    let silent = without(&lines, Line::Busy, true);
    assert_eq!(failed(&silent, span), ["BUSY pulses"]);
    let low = without(&lines, Line::Select(0), true);
    let low = failed(&low, span);
    assert!(low.starts_with(&["CS0 frames", "CS0 width"]), "{low:?}");
    let slow = with(&lines, Line::Clock(1), |edges_s| {
        half_clock(&lines, edges_s)
    });
    let slow = failed(&slow, span);
    assert!(
        slow.contains(&"SCLK1 frequency") && !slow.contains(&"SCLK0 frequency"),
        "{slow:?}"
    );
}

/// A clock that takes twice as long, from the begin of each frame on.
fn half_clock(lines: &Lines, edges_s: &[f64]) -> Vec<f64> {
    let begins_s: Vec<f64> = lines
        .get(Line::Select(1))
        .expect("it is recorded")
        .edges_to(false)
        .collect();
    let stretched = edges_s.iter().map(|at_s| {
        let before = begins_s.partition_point(|begin_s| begin_s < at_s);
        let begin_s = before.checked_sub(1).map_or(*at_s, |place| begins_s[place]);
        begin_s + 2.0 * (at_s - begin_s)
    });
    stretched.collect()
}

#[test]
fn the_command_judges_the_models_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    taken(folder);
    let told = asked(folder, "trace board.vcd").quiet();
    assert!(told.ends_with("passed; 2 not measured\n"), "{told}");
    // The third pulse of CONVST does not end before the fourth begins: two changes are taken out of the file.
    let text = std::fs::read_to_string(folder.join("board.vcd")).unwrap();
    let code = text.lines().find_map(|line| {
        line.strip_prefix("$var wire 1 ")?
            .strip_suffix(" CONVST $end")
    });
    let code = code.expect("CONVST's code");
    let mut changes = 0;
    let faulty = text.lines().filter(|line| {
        let is_change =
            line.len() == 1 + code.len() && line.ends_with(code) && line.starts_with(['0', '1']);
        changes += usize::from(is_change);
        !(is_change && (7..9).contains(&changes))
    });
    std::fs::write(
        folder.join("faulty.vcd"),
        faulty.collect::<Vec<_>>().join("\n"),
    )
    .unwrap();
    let ran = asked(folder, "trace faulty.vcd");
    assert_eq!(ran.code, 1, "{}", ran.out);
    for wanted in [
        "CONVST pulses      FAILED: found no pulse",
        "CONVST width       FAILED: found 50.5 µs, 1 of 19",
    ] {
        assert!(ran.out.contains(wanted), "{wanted}: {}", ran.out);
    }
}
