//! What is refused, and in which words.

use super::{META, folder, read, refused};
use recording::Recording;

#[test]
fn numbers_that_cannot_be() {
    let cases: [(&str, &str); 12] = [
        (
            "t_s,p1_m\n0,nan\n",
            "samples.csv: row 2, column p1_m, found \"nan\", wanted a finite number",
        ),
        (
            "t_s,p1_m\n0,-inf\n",
            "samples.csv: row 2, column p1_m, found \"-inf\", wanted a finite number",
        ),
        (
            "t_s,p1_m\n0,1e999\n",
            "samples.csv: row 2, column p1_m, found \"1e999\", wanted a finite number",
        ),
        (
            "t_s,p1_m\n0,1e300\n",
            "samples.csv: row 2, column p1_m, found \"1e300\", wanted -1000 to 1000 m",
        ),
        (
            "t_s,p1_m\n0,0,5\n",
            "samples.csv: row 2, found 3 fields, wanted 2 as in the header",
        ),
        (
            "t_s,p1_m\n0,5 mm\n",
            "samples.csv: row 2, column p1_m, found \"5 mm\", wanted a number",
        ),
        (
            "t_s,q1s,q1c,n1\n0,32768,0,0\n",
            "samples.csv: row 2, column q1s, found \"32768\", wanted a count within the converter's range, -32768 to 32767",
        ),
        (
            "t_s,q1s,q1c,n1\n0,1,0,0.5\n",
            "samples.csv: row 2, column n1, found \"0.5\", wanted a whole number of teeth within 32 bits",
        ),
        (
            "t_s,q1s,q1c,n1\n0,1,0,3000000000\n",
            "samples.csv: row 2, column n1, found \"3000000000\", wanted a whole number of teeth within 32 bits",
        ),
        (
            "t_s,p1_m\n0,0\n1,0\n1,0\n",
            "samples.csv: row 4, column t_s, found \"1\", wanted a time after the row before, 1 s",
        ),
        (
            "t_s,p1_m\n0,0\n,0\n",
            "samples.csv: row 3, column t_s, found an empty field, wanted a time in every row, s",
        ),
        (
            "t_s,p1_m,temp_c\n0,0,-300\n",
            "samples.csv: row 2, column temp_c, found \"-300\", wanted -273.15 to 500 °C",
        ),
    ];
    for (samples, line) in cases {
        refused(META, samples.as_bytes(), line);
    }
}

#[test]
fn columns_that_are_missing_or_twice() {
    let cases: [(&[u8], &str); 9] = [
        (
            b"",
            "samples.csv: found an empty file, wanted a header row and samples",
        ),
        (
            b"t_s,p1_m\n",
            "samples.csv: found no samples, wanted at least one row after the header",
        ),
        (
            b"p1_m\n1\n",
            "samples.csv: row 1, column t_s, found none, wanted the column of time, s",
        ),
        (
            b"t_s,run\n1,a\n",
            "samples.csv: row 1, found no segment, wanted q1s, q1c, n1 or p1_m, or those of segment 2, 3 or 4",
        ),
        (
            b"t_s,p1_m\n1,\n",
            "samples.csv: found no output of any segment, wanted counts with their tooth count, or positions",
        ),
        (
            b"t_s,q1s,n1\n1,1,1\n",
            "samples.csv: row 1, column q1c, found none, wanted it beside the segment's other columns of counts",
        ),
        (
            b"t_s,p1_m,psd_xp\n1,1,1\n",
            "samples.csv: row 1, column psd_xn, found none, wanted all four electrodes",
        ),
        (
            b"t_s,p1_m,p1_m\n1,1,1\n",
            "samples.csv: row 1, column p1_m, found the name a second time, wanted each column once",
        ),
        (
            b"t_s,p1_m,\xff\n1,1,1\n",
            "samples.csv: row 1, found \"\u{fffd}\" (not UTF-8), wanted names of columns in UTF-8",
        ),
    ];
    for (samples, line) in cases {
        refused(META, samples, line);
    }
}

/// A log of another program's making is told as what it is, and what takes it.
#[test]
fn dialects_of_other_programs() {
    let end = "; `courier convert` makes a recording of such a file";
    for (samples, line) in [
        (
            "t_s;p1_m\n0;0\n",
            "samples.csv: row 1, found columns separated by semicolons, wanted commas",
        ),
        (
            "\u{feff}t_s\tp1_m\n0\t0\n",
            "samples.csv: row 1, found columns separated by tabs, wanted commas",
        ),
        (
            "T_S,P1_M\n0,0\n",
            "samples.csv: row 1, found the column \"T_S\", wanted it in small letters, \"t_s\"",
        ),
        (
            "# t_s,p1_m\n0,0\n",
            "samples.csv: row 1, found a \"#\" before the header, wanted the names of the columns alone",
        ),
    ] {
        refused(META, samples.as_bytes(), &format!("{line}{end}"));
    }
}

#[test]
fn tables_that_are_missing_or_wrong() {
    let samples = b"t_s,p1_m,p3_m\n0,0,0\n";
    let cases = [
        (
            "schema = 1\n",
            "schema = 2\n",
            "recording.toml: key schema, found 2, wanted 1, the only schema that is known",
        ),
        (
            "schema = 1\n",
            "schema = '1'\n",
            "recording.toml: key schema, found \"1\", wanted 1, the only schema that is known",
        ),
        (
            "schema = 1\n",
            "",
            "recording.toml: key schema, found none, wanted 1",
        ),
        (
            "pitch_m = 1.0e-3\n",
            "",
            "recording.toml: key [geometry] pitch_m, found none, wanted a number",
        ),
        (
            "pitch_m = 1.0e-3",
            "pitch_m = 1.016",
            "recording.toml: key [geometry] pitch_m, found 1.016, wanted 1e-7 to 0.1 m",
        ),
        (
            "pitch_m = 1.0e-3",
            "pitch_m = nan",
            "recording.toml: key [geometry] pitch_m, found NaN, wanted 1e-7 to 0.1 m",
        ),
        (
            "pitch_m = 1.0e-3",
            "pitch_m = 'x'",
            "recording.toml: key [geometry] pitch_m, found \"x\", wanted a number",
        ),
        (
            "span_m = 9.7e-3\n",
            "",
            "recording.toml: key [geometry] span_m, found none, wanted the distance of a pair's segments, m",
        ),
        (
            "[geometry]",
            "[geometri]",
            "recording.toml: key [geometry], found none, wanted the table [geometry] with pitch_m",
        ),
        (
            "[electronics]",
            "[x]",
            "recording.toml: key [electronics], found none, wanted the table [electronics] with the stated noise",
        ),
        (
            "position_noise_m = 1e-8\n",
            "",
            "recording.toml: key [electronics] position_noise_m, found none, wanted the noise of the recorded positions, m",
        ),
        (
            "adc_bits = 16",
            "adc_bits = 15.5",
            "recording.toml: key [electronics] adc_bits, found 15.5, wanted a whole number of bits",
        ),
    ];
    for (from, to, line) in cases {
        refused(&META.replace(from, to), samples, line);
    }
    let line = read("schema = 1\n[geometry\n", samples).unwrap_err();
    assert!(
        line.starts_with("recording.toml: row 2, found ") && line.ends_with(", wanted TOML"),
        "{line}"
    );
    let psd = b"t_s,p1_m,psd_xp,psd_xn,psd_yp,psd_yn\n0,0,1,1,1,1\n";
    refused(
        META,
        psd,
        "recording.toml: key [coordination], found none, wanted the table [coordination], since electrodes were recorded",
    );
}

#[test]
fn hostile_files_cost_no_memory_and_end_in_one_line() {
    let long = [b"t_s,p1_m\n0,".as_slice(), &vec![b'1'; 1 << 20]].concat();
    refused(
        META,
        &long,
        "samples.csv: row 2, found more than 65536 bytes, wanted a row of numbers (is a quotation mark left open?)",
    );
    let open = [
        b"t_s,p1_m\n0,\"".as_slice(),
        b"0\n1,".repeat(1 << 16).as_slice(),
    ]
    .concat();
    refused(
        META,
        &open,
        "samples.csv: row 2, found more than 65536 bytes, wanted a row of numbers (is a quotation mark left open?)",
    );
    refused(
        META,
        &b"t_s,".repeat(2000),
        "samples.csv: row 1, found more than 1024 fields, wanted a row of the layout's columns",
    );
    refused(
        META,
        &[0; 100],
        "samples.csv: row 1, column t_s, found none, wanted the column of time, s",
    );
    let digits = format!("t_s,p1_m\n0,{}\n", "0".repeat(60_000));
    assert!(read(META, digits.as_bytes()).is_ok());
    let folder = folder(&vec![b'#'; 2 << 20], b"");
    assert!(
        Recording::read(folder.path())
            .unwrap_err()
            .to_string()
            .ends_with("found more than 1048576 bytes, wanted a page of TOML")
    );
    std::fs::write(folder.path().join("recording.toml"), b"schema = 1\n\xff").unwrap();
    assert!(
        Recording::read(folder.path())
            .unwrap_err()
            .to_string()
            .ends_with("row 2, found bytes that are not UTF-8, wanted TOML in UTF-8")
    );
}
