//! `courier trace`: recordings of the pins, good ones, one with a fault, and files that are none.

use crate::common::{asked, json_in};
use std::fmt::Write;
use std::path::Path;

/// CONVST high for so long every 50 µs, BUSY after it, in a table of changes.
fn table(folder: &Path, name: &str, width_us: f64) {
    let mut text = String::from("Time [us],CONVST,D1\n0,0,0\n");
    for number in 0..4 {
        let at_us = 10.0 + 50.0 * f64::from(number);
        let changes = [(0.0, "1,0"), (0.01, "1,1"), (width_us, "0,1"), (0.9, "0,0")];
        for (after_us, levels) in changes {
            writeln!(text, "{:.2},{levels}", at_us + after_us).unwrap();
        }
    }
    text += "210,0,0\n";
    std::fs::write(folder.join(name), text).unwrap();
}

#[test]
fn a_good_trace_passes_and_what_is_not_in_it_is_said() {
    let folder = tempfile::tempdir().unwrap();
    table(folder.path(), "good.csv", 0.5);
    let ran = asked(
        folder.path(),
        "trace good.csv --channel BUSY=D1 --json=told.json",
    );
    assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{}", ran.out);
    for line in [
        "trace              0.210 ms at 100 MS/s",
        "CONVST pulses      passed: 4 pulses",
        "CONVST width       passed: 0.5 µs",
        "BUSY after CONVST  passed: 10 ns",
        "CS0 frames         not measured: no channel CS0 (--channel CS0=NAME names one)",
        "passed; 18 not measured",
    ] {
        assert!(ran.out.contains(line), "{line}: {}", ran.out);
    }
    let told = json_in(folder.path().join("told.json"));
    assert_eq!(told["passed"], true);
    assert_eq!(told["trace"]["lines"][1][0], "BUSY");
    // With fewer looks a second less can be told.
    let ran = asked(
        folder.path(),
        "trace good.csv --channel BUSY=D1 --rate-msps 10",
    );
    assert!(
        ran.out
            .contains("BUSY after CONVST  not measured: 10 MS/s are too few, 40 tell it"),
        "{}",
        ran.out
    );
}

#[test]
fn a_fault_is_told_with_its_number_and_its_place_and_ends_with_1() {
    let folder = tempfile::tempdir().unwrap();
    table(folder.path(), "short.csv", 0.25);
    let ran = asked(folder.path(), "trace short.csv");
    assert_eq!((ran.code, ran.err.as_str()), (1, ""), "{}", ran.out);
    let line = "CONVST width       FAILED: found 0.25 µs, 4 of 4 at 0.010000 ms, wanted 0.5 µs ± 2 % and 25 ns for its edges";
    assert!(ran.out.contains(line), "{}", ran.out);
    assert!(ran.out.contains("failed: 1 step"), "{}", ran.out);
    // Nothing can be told of it: that is no pass.
    let ran = asked(folder.path(), "trace short.csv --rate-msps 0.5");
    assert_eq!(ran.code, 1, "{}", ran.out);
    assert!(
        ran.out.contains("not passed: nothing could be measured"),
        "{}",
        ran.out
    );
}

#[test]
fn what_is_no_trace_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    table(folder.path(), "good.csv", 0.5);
    std::fs::write(
        folder.path().join("broken.vcd"),
        "$timescale 1 ns $end $enddefinitions $end #5 %",
    )
    .unwrap();
    let trace = |words: &str| asked(folder.path(), &format!("trace {words}"));
    trace("none.vcd").refused(&["none.vcd: wanted a readable file"]);
    trace("broken.vcd").refused(&["broken.vcd", "VCD"]);
    trace("good.csv --channel CONVST=D7")
        .refused(&["good.csv", "--channel D7: found the channels CONVST, D1"]);
    trace("good.csv --channel LAMP=D1").refused_usage("wanted one of CONVST");
    trace("good.csv --rate-msps 0").refused(&["--rate-msps: found 0, wanted a number above 0"]);
    let header = std::fs::read_to_string(folder.path().join("good.csv"))
        .unwrap()
        .replace("CONVST", "D0");
    std::fs::write(folder.path().join("plain.csv"), header).unwrap();
    trace("plain.csv").refused(&["plain.csv", "found the channels D0, D1, wanted CONVST"]);
    asked(folder.path(), "--sim trace good.csv").refused(&["needs no board"]);
}
