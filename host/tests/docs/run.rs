//! The commands of a page, run in order in one shell and one scratch folder, and what they printed.

use crate::page::{Block, Page, entries};
use snapbox::filter::NormalizeToExpected;
use snapbox::report::{Palette, write_diff};
use snapbox::{Data, IntoData};
use std::path::Path;
use std::process::{Command, Stdio};

/// What ends a command's output in the shell's output: this, the exit code, a line's end.
const END: &str = "\u{1}ended with ";

/// `cargo demo` runs what `courier demo` runs: building it again within a test would take minutes.
const CARGO: &str = "cargo() { case \"$1\" in demo) shift; courier demo \"$@\" ;; *) echo \"cargo $1 is not run here\"; return 101 ;; esac; }\n";

/// A command of a page and the output that stands below it.
struct Step {
    /// What the reader types, its lines as they stand in the page.
    typed: String,
    /// What the shell runs.
    command: String,
    /// The exit code that it must have.
    code: i32,
    /// What the page says that it prints; `None`: the page shows no output, whatever comes is right.
    printed: Option<String>,
}

/// What stands after the fence of a block that is run.
enum Kind {
    /// Commands after `$ `, each with its output.
    Console,
    /// Commands to be copied, without output.
    Script,
}

/// How a block is meant: `None` for one that holds no commands.
fn kind(block: &Block) -> Option<Kind> {
    match block.info.split_whitespace().next() {
        Some("console") => Some(Kind::Console),
        Some("sh" | "bash" | "shell") => Some(Kind::Script),
        _ => None,
    }
}

/// Whether the page says that a block is not run.
pub fn is_left_out(block: &Block) -> bool {
    block.info.split_whitespace().any(|word| word == "not-run")
}

/// Whether the page says that a block is run at night alone.
pub fn is_nightly(block: &Block) -> bool {
    block.info.split_whitespace().any(|word| word == "nightly")
}

/// Whether a block's commands are run.
pub fn is_run(block: &Block) -> bool {
    kind(block).is_some() && !is_left_out(block)
}

/// Whether a block holds commands, whatever stands after its fence.
pub fn holds_commands(page: &Page, block: &Block) -> bool {
    kind(block).is_some()
        || page
            .lines(block)
            .lines()
            .any(|line| line.starts_with("$ ") || line.starts_with("courier "))
}

/// The exit code that the last command of a block must have: `exit-1` after the fence, else 0.
fn code(block: &Block) -> i32 {
    let named = block.info.split_whitespace();
    named
        .filter_map(|word| word.strip_prefix("exit-"))
        .map(|code| code.parse().unwrap())
        .next()
        .unwrap_or(0)
}

/// Lines joined where one ends with a backslash.
fn joined(lines: &str) -> Vec<String> {
    let mut joined: Vec<String> = vec![];
    let mut open = false;
    for line in lines.split_inclusive('\n') {
        match joined.last_mut().filter(|_| open) {
            Some(last) => last.push_str(line),
            None => joined.push(line.to_owned()),
        }
        open = line.trim_end_matches('\n').ends_with('\\');
    }
    joined
}

fn steps(page: &Page, block: &Block) -> Vec<Step> {
    let console = matches!(kind(block), Some(Kind::Console));
    let mut steps: Vec<Step> = vec![];
    for line in joined(page.lines(block)) {
        let command = if console {
            line.strip_prefix("$ ")
        } else {
            Some(&*line)
        };
        match (command, steps.last_mut()) {
            (Some(command), _) if !command.trim().is_empty() => steps.push(Step {
                typed: line.clone(),
                command: command.to_owned(),
                code: 0,
                printed: console.then(String::new),
            }),
            (Some(_), _) => {}
            (None, Some(step)) => step.printed.as_mut().unwrap().push_str(&line),
            (None, None) => panic!("{}: an output without a command: {line}", page.name),
        }
    }
    if let Some(last) = steps.last_mut() {
        last.code = code(block);
    }
    steps
}

/// What a command gave: its exit code and what it printed, both streams in the order in which they came.
struct Gave {
    code: Option<i32>,
    printed: String,
}

/// Runs the commands of a page, one after another in one shell that stands in a folder of its own.
fn run(root: &Path, courier: &Path, steps: &[Step]) -> Vec<Gave> {
    let scratch = tempfile::tempdir().unwrap();
    let stand = scratch.path();
    for folder in ["examples", "convert/tests/files"] {
        if steps.iter().any(|step| step.command.contains(folder)) {
            copy(&root.join(folder), &stand.join(folder));
        }
    }
    let mut script = format!("exec 2>&1\n{CARGO}");
    for step in steps {
        script += &format!(
            "{{ {}\n}}; printf '{END}%d\\n' \"$?\"\n",
            step.command.trim_end()
        );
    }
    let path = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("sh")
        .args(["-c", &script])
        .current_dir(stand)
        .env_clear()
        .env("HOME", stand)
        .env("LANG", "C.UTF-8")
        .env(
            "PATH",
            format!("{}:{path}", courier.parent().unwrap().display()),
        )
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    let mut rest = &*text;
    let gave = steps.iter().map(|_| {
        let Some((printed, after)) = rest.split_once(END) else {
            let printed = std::mem::take(&mut rest).to_owned();
            return Gave {
                code: None,
                printed,
            };
        };
        let (code, after) = after.split_once('\n').unwrap_or((after, ""));
        rest = after;
        Gave {
            code: code.parse().ok(),
            printed: printed.to_owned(),
        }
    });
    gave.collect()
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for path in entries(from) {
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::copy(&path, &target).unwrap();
        }
    }
}

/// What a page should say, and what is wrong with what it says.
#[derive(Default)]
pub struct Compared {
    /// The page with every output as it came, wildcards kept where they fit.
    pub renewed: String,
    /// One entry a command that failed or printed something else.
    pub wrong: Vec<String>,
    /// Commands that were run.
    pub ran: usize,
}

/// Runs every block of a page that is to be run, by day or at night, and compares what comes with what the page says.
pub fn compare(root: &Path, courier: &Path, page: &Page, nightly: bool) -> Compared {
    let chosen = |block: &&Block| is_run(block) && is_nightly(block) == nightly;
    let blocks: Vec<&Block> = page.blocks.iter().filter(chosen).collect();
    let by_block: Vec<Vec<Step>> = blocks.iter().map(|block| steps(page, block)).collect();
    let all: Vec<Step> = by_block.into_iter().flatten().collect();
    let mut compared = Compared {
        ran: all.len(),
        ..Compared::default()
    };
    if all.is_empty() {
        compared.renewed.clone_from(&page.text);
        return compared;
    }
    let gave = run(root, courier, &all);
    let mut pairs = all.iter().zip(&gave);
    let mut written = 0;
    for block in blocks {
        let mut lines = String::new();
        for (step, gave) in pairs.by_ref().take(steps(page, block).len()) {
            let (text, wrong) = compare_step(page, step, gave);
            lines += &text;
            compared.wrong.extend(wrong);
        }
        if matches!(kind(block), Some(Kind::Console)) {
            compared.renewed += &page.text[written..block.lines.start];
            compared.renewed += &lines;
            written = block.lines.end;
        }
    }
    compared.renewed += &page.text[written..];
    compared
}

/// The command with what it printed, and what is wrong with it.
fn compare_step(page: &Page, step: &Step, gave: &Gave) -> (String, Option<String>) {
    let typed = step.typed.trim_end();
    if gave.code != Some(step.code) {
        let code = gave.code.map_or("none".to_owned(), |code| code.to_string());
        let wrong = format!(
            "{}: {typed}\nexit code {code}, wanted {}; it printed\n{}",
            page.name, step.code, gave.printed
        );
        return (step.typed.clone() + &gave.printed, Some(wrong));
    }
    let Some(expected) = &step.printed else {
        return (step.typed.clone(), None);
    };
    let expected: Data = expected.clone().into_data();
    // Lines end where the page's do, without spaces that nobody sees.
    let trimmed: String = gave
        .printed
        .lines()
        .map(|line| format!("{}\n", line.trim_end()))
        .collect();
    let came = NormalizeToExpected::new()
        .redact()
        .normalize(trimmed.into_data(), &expected);
    let text = step.typed.clone() + &came.render().unwrap();
    if came == expected {
        return (text, None);
    }
    let mut wrong = format!("{}: {typed}\n", page.name);
    write_diff(
        &mut wrong,
        &expected,
        &came,
        Some(&"the page"),
        Some(&"what came"),
        Palette::plain(),
    )
    .unwrap();
    (text, Some(wrong))
}
