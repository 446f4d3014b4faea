//! The answer of `courier compare` for the terminal.

use super::words::{self, Table};
use crate::terminal::table;
use comparison::answer::{Answer, Budgets, Line, Pair, Told};
use comparison::changes::Change;
use courier_sensor::geometry::Geometry;

/// Terms that are listed at most.
const TERMS: usize = 8;

/// All of it, for a courier of this geometry.
#[must_use]
pub fn text(answer: &Answer, geometry: &Geometry) -> String {
    let pitch_m = f64::from(geometry.pitch_m);
    let input = |of| format!("{}\n  {}", words::about(of), words::certainty(of));
    let inputs = answer
        .compared
        .iter()
        .map(|of| format!("{}: {}", of.name, input(of)));
    let mut parts = vec![inputs.collect::<Vec<_>>().join("\n")];
    parts.extend(answer.repeats.as_ref().map(words::repeats));
    parts.extend(answer.differences.iter().map(|of| pair(of, pitch_m)));
    match &answer.trend {
        Some(Told::Known(of)) => parts.push(line(of, pitch_m)),
        Some(Told::Unknown(why)) => parts.push(format!("trend: not told: {why}")),
        None => {}
    }
    for of in &answer.budgets {
        parts.push(match of {
            Told::Known(of) => budgets(of, pitch_m),
            Told::Unknown(why) => format!("budget: not told: {why}"),
        });
    }
    parts.push(format!("not compared:\n{}", lines(&left_out(answer))));
    parts.join("\n\n")
}

/// What is left out of any of them, each once.
#[must_use]
pub fn left_out(answer: &Answer) -> Vec<&str> {
    let all = answer.compared.iter().flat_map(|of| &of.left_out);
    let mut list: Vec<&str> = all.map(String::as_str).collect();
    list.sort_unstable();
    list.dedup();
    list
}

fn lines(list: &[&str]) -> String {
    let lines: Vec<String> = list.iter().map(|line| format!("  {line}")).collect();
    lines.join("\n")
}

fn drawn((header, rows): &Table) -> String {
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    table(&header, rows)
}

fn pair(pair: &Pair, pitch_m: f64) -> String {
    let first = format!(
        "{} against {}: {}",
        pair.second,
        pair.first,
        words::verdict(pair)
    );
    let mut parts = vec![first, drawn(&words::largest(&pair.largest, pitch_m, ""))];
    parts.extend(words::effects(pair));
    parts.extend(terms(&pair.terms, ""));
    parts.extend(pair.left_out.iter().cloned());
    parts.join("\n")
}

fn line(line: &Line, pitch_m: f64) -> String {
    let unit = line.over.unit();
    let mut parts = words::slope(line);
    parts.push(drawn(&words::largest(&line.largest, pitch_m, unit)));
    parts.extend(terms(&line.terms, unit));
    parts.join("\n")
}

/// The first of them, and how many more there are.
fn terms(terms: &[Change], a: &str) -> Vec<String> {
    if terms.is_empty() {
        return Vec::new();
    }
    let (shown, rest) = terms.split_at(terms.len().min(TERMS));
    let changed = rest.iter().filter(|of| of.changed == Some(true)).count();
    let more = format!(
        "and {} more terms, {changed} of them changed (--json has all)",
        rest.len()
    );
    let mut parts = vec![drawn(&words::terms(shown, a))];
    parts.extend((!rest.is_empty()).then_some(more));
    parts
}

fn budgets(budgets: &Budgets, pitch_m: f64) -> String {
    let one = |budget| {
        let table = drawn(&words::contributions(budget));
        let (name, _) = words::named(budget.quantity);
        let place = words::place(&budget.pose, pitch_m);
        format!(
            "budget of {name} by {}, at {place}\n{table}\n{}",
            budgets.of,
            words::combined(budget)
        )
    };
    let mut parts: Vec<String> = budgets.budgets.iter().map(one).collect();
    parts.push(drawn(&words::range(budgets, pitch_m)));
    parts.push(format!("not counted:\n{}", lines(&budgets.not_counted)));
    parts.join("\n\n")
}
