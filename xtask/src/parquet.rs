//! The command built with its feature `parquet`, which the tests of every change leave out: recordings through every kind of command,
//! files to and from DuckDB, Arrow and Polars, and what a million samples cost. Part of `cargo xtask nightly`, and alone `cargo xtask parquet`.

mod cost;

use crate::arm;
use crate::cargo::cargo;
use crate::permission;
use crate::python::environment;
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Command lines, in order, in a folder of their own: `survey` is the example's folder, `log.csv` its log. All of them succeed.
const LINES: [&str; 18] = [
    "convert survey s.parquet",
    "convert s.parquet again",
    "convert s.parquet compact.parquet --compact",
    "convert compact.parquet of-compact",
    "convert log.csv encoder.parquet --column t_s=time:ms --column q1s=sin --column q1c=cos --column ref_x_m=stage:mm --pitch 1.016mm",
    "convert encoder.parquet encoder",
    "replay s.parquet",
    "replay encoder.parquet --json=by-file.json",
    "replay encoder --json=by-folder.json",
    "diagnose s.parquet --model model.json --report page.html",
    "check model.json s.parquet",
    "compare model.json s.parquet",
    "encoder encoder.parquet",
    "--sim-preset ideal record board.parquet --seconds 0.2 --platen-id west",
    "demo --record demo.parquet --force",
    "diagnose s.parquet survey missing --out answers",
    "--sim-courier 1 record c1.parquet --under-beacon --platen-id west --decimation 60",
    "map c1.parquet",
];

/// Builds the command with the feature and runs all of it.
///
/// # Errors
/// It does not compile, a command line fails or gives another answer than from a folder, or a file costs too much.
pub fn nightly() -> Result<()> {
    permission::grant();
    let command = built()?;
    let folder = example("parquet")?;
    let folder = folder.as_path();
    for line in LINES {
        courier(&command, folder, line)?;
    }
    let same = |one: &str, other: &str| -> Result<()> {
        let read = |name: &str| std::fs::read(folder.join(name)).with_context(|| name.to_owned());
        ensure!(
            read(one)? == read(other)?,
            "{one} and {other}: found a difference, wanted none"
        );
        Ok(())
    };
    for name in ["recording.toml", "samples.csv"] {
        same(&format!("survey/{name}"), &format!("again/{name}"))?;
        same(&format!("survey/{name}"), &format!("of-compact/{name}"))?;
    }
    let answer = |name: &str| -> Result<String> {
        let text = std::fs::read_to_string(folder.join(name))?;
        Ok(text.replace("encoder.parquet", "encoder"))
    };
    ensure!(
        answer("by-file.json")? == answer("by-folder.json")?,
        "replay: found another answer from the file than from the folder"
    );
    with_others(&command, folder)?;
    cost::check(&command, folder)
}

/// A new folder of this name below `target`, with the example's recording `survey` and its log `log.csv`.
///
/// # Errors
/// It cannot be made.
pub fn example(name: &str) -> Result<PathBuf> {
    let folder = arm::root().join("target").join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    let examples = arm::root().join("examples");
    std::fs::create_dir_all(folder.join("survey"))?;
    for name in ["recording.toml", "samples.csv"] {
        std::fs::copy(
            examples.join("survey-lateral").join(name),
            folder.join("survey").join(name),
        )?;
    }
    std::fs::copy(examples.join("encoder-log/log.csv"), folder.join("log.csv"))?;
    Ok(folder)
}

/// Builds the command with the features `parquet` and `mcap`, once for both checks, and tells where it is.
///
/// # Errors
/// It does not compile.
pub fn built() -> Result<PathBuf> {
    let words = "build --quiet --profile checked --package courier --features parquet,mcap --message-format json-render-diagnostics";
    let text = arm::output(&mut cargo(&words.split(' ').collect::<Vec<_>>()))?;
    let named = |line: &str| {
        let message: Value = serde_json::from_str(line).ok()?;
        let is_it = message["target"]["name"] == "courier";
        message["executable"]
            .as_str()
            .filter(|_| is_it)
            .map(PathBuf::from)
    };
    text.lines()
        .filter_map(named)
        .next_back()
        .context("cargo named no program")
}

/// Runs a command line in a folder.
///
/// # Errors
/// It fails.
pub fn courier(command: &Path, folder: &Path, line: &str) -> Result<()> {
    arm::run(
        Command::new(command)
            .args(line.split(' '))
            .stdout(Stdio::null())
            .current_dir(folder),
    )
    .with_context(|| format!("courier {line}"))
}

/// What other programs read, in an environment of their own.
const READERS: [&str; 3] = ["duckdb", "pyarrow", "polars"];

/// Every number of the files of the lines before by three readers that share no code, against the folder's text; and files that DuckDB writes.
const BY_OTHERS: &str = r#"
import csv, math
import duckdb, polars, pyarrow.parquet
with open('survey/samples.csv') as file:
    rows = list(csv.DictReader(file))
def wanted(name):
    if name == 'run':
        return [row[name] for row in rows]
    return [float(row[name]) if row[name] else math.nan for row in rows]
def found(name, values):
    return list(values) if name == 'run' else [math.nan if value is None else float(value) for value in values]
def by_duckdb(path):
    got = duckdb.sql(f"SELECT * FROM '{path}'")
    return dict(zip(got.columns, zip(*got.fetchall())))
readers = {
    'DuckDB': by_duckdb,
    'Arrow': lambda path: pyarrow.parquet.read_table(path).to_pydict(),
    'Polars': lambda path: polars.read_parquet(path).to_dict(as_series=False),
}
for path in ('s.parquet', 'compact.parquet'):
    for reader, read in readers.items():
        columns = read(path)
        left_out = set(rows[0]) - set(columns)
        assert all(math.isnan(value) for name in left_out for value in wanted(name)), left_out
        for name, values in columns.items():
            one, other = found(name, values), wanted(name)
            assert len(one) == len(other), (path, reader, name)
            assert all(a == b or a != a and b != b for a, b in zip(one, other)), (path, reader, name)
toml = open('survey/recording.toml').read().replace("'", "''")
duckdb.execute(f"COPY (SELECT * FROM 'survey/samples.csv') TO 'duck.parquet' (KV_METADATA {{'recording.toml': '{toml}'}})")
duckdb.execute("COPY (SELECT * FROM 'log.csv') TO 'ducklog.parquet'")
polars.read_csv('log.csv', separator=';').write_parquet('polarslog.parquet')
platen = duckdb.execute("SELECT decode(value) FROM parquet_kv_metadata('board.parquet') WHERE decode(key) = 'platen_id'").fetchall()
assert platen == [('west',)], platen
"#;

fn with_others(command: &Path, folder: &Path) -> Result<()> {
    let Some(python) = environment(folder, "other readers of Parquet", &READERS)? else {
        return Ok(());
    };
    arm::run(
        Command::new(&python)
            .args(["-c", BY_OTHERS])
            .current_dir(folder),
    )
    .context("other readers of Parquet")?;
    courier(command, folder, "convert duck.parquet by-duck")?;
    courier(command, folder, "replay duck.parquet")?;
    for log in ["ducklog", "polarslog"] {
        courier(
            command,
            folder,
            &format!(
                "convert {log}.parquet {log} --column t_s=time:ms --column q1s=sin --column q1c=cos --pitch 1.016mm"
            ),
        )?;
    }
    Ok(())
}
