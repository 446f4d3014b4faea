//! The answer of `courier compare` for the terminal.

use crate::terminal::{figure, micrometres, table};
use comparison::answer::{Answer, Budgets, Input, Line, Pair, Told};
use comparison::budget::{Budget, Kind};
use comparison::changes::Change;
use comparison::largest::Largest;
use comparison::significance::JointTest;
use comparison::workspace::{Pose, Quantity};
use courier_sensor::geometry::Geometry;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

/// Terms that are listed at most.
const TERMS: usize = 8;

/// All of it, for a courier of this geometry.
#[must_use]
pub fn text(answer: &Answer, geometry: &Geometry) -> String {
    let pitch_m = f64::from(geometry.pitch_m);
    let mut parts = vec![
        answer
            .compared
            .iter()
            .map(input)
            .collect::<Vec<_>>()
            .join("\n"),
    ];
    parts.extend(
        answer
            .differences
            .iter()
            .map(|pair| pair_text(pair, pitch_m)),
    );
    match &answer.trend {
        Some(Told::Known(line)) => parts.push(line_text(line, pitch_m)),
        Some(Told::Unknown(why)) => parts.push(format!("trend: not told: {why}")),
        None => {}
    }
    for of in &answer.budgets {
        parts.push(match of {
            Told::Known(budgets) => budgets_text(budgets, pitch_m),
            Told::Unknown(why) => format!("budget: not told: {why}"),
        });
    }
    let mut left_out: Vec<&str> = answer
        .compared
        .iter()
        .flat_map(|of| of.left_out.iter().map(String::as_str))
        .collect();
    left_out.sort_unstable();
    left_out.dedup();
    parts.push(format!("not compared:\n{}", lines(&left_out)));
    parts.join("\n\n")
}

fn lines(list: &[&str]) -> String {
    list.iter()
        .map(|line| format!("  {line}"))
        .collect::<Vec<_>>()
        .join("\n")
}

/// When something was made.
#[must_use]
pub fn made(made_s: f64) -> String {
    let time = OffsetDateTime::from_unix_timestamp(made_s as i64).ok();
    time.and_then(|time| time.format(&Rfc3339).ok())
        .unwrap_or_default()
}

fn input(input: &Input) -> String {
    let made = input
        .made_s
        .map_or(String::new(), |made_s| format!(", {}", made(made_s)));
    let certainty = match &input.certainty {
        Told::Known(source) => source.clone(),
        Told::Unknown(why) => format!("no covariance: {why}"),
    };
    format!("{}: {}{made}\n  {certainty}", input.name, input.about)
}

fn pair_text(pair: &Pair, pitch_m: f64) -> String {
    let verdict = match (&pair.test, pair.changed) {
        (Told::Known(test), Some(true)) => format!("changed beyond chance ({})", test_text(test)),
        (Told::Known(test), _) => format!("no change beyond chance ({})", test_text(test)),
        (Told::Unknown(why), _) => format!("whether that is more than chance is not told: {why}"),
    };
    let mut text = format!(
        "{} against {}: {verdict}\n{}",
        pair.second,
        pair.first,
        largest_table(&pair.largest, pitch_m, "")
    );
    // One alone is the whole.
    let several = pair.effects.iter().filter(|_| pair.effects.len() > 1);
    let effects = several.filter_map(|of| {
        let (test, changed) = (of.test.as_ref()?, of.changed?);
        let verdict = if changed {
            "changed"
        } else {
            "no change beyond chance"
        };
        Some(format!("{}: {verdict} ({})", of.effect, test_text(test)))
    });
    text += &effects.map(|line| format!("\n{line}")).collect::<String>();
    text + &terms_table(&pair.terms, "")
}

fn line_text(line: &Line, pitch_m: f64) -> String {
    let unit = line.over.unit();
    let verdict = if line.changes {
        "a slope beyond chance"
    } else {
        "no slope beyond chance"
    };
    let straying = if line.strays {
        format!(
            "\nthey stray from the line beyond chance ({}): it is no steady change, and the ± are too small",
            test_text(&line.straying)
        )
    } else {
        String::new()
    };
    format!(
        "trend a {unit}: {verdict} ({}){straying}\n{}{}",
        test_text(&line.test),
        largest_table(&line.largest, pitch_m, unit),
        terms_table(&line.terms, unit)
    )
}

fn test_text(test: &JointTest) -> String {
    let freedom = test.freedom.map_or("a known scale".to_owned(), |freedom| {
        format!("{freedom:.0} degrees of freedom")
    });
    let fixed = match test.unknowns - test.directions {
        0 => String::new(),
        n => format!(", {n} more left out as conventions fix them"),
    };
    let convention = if test.convention_differs {
        ", whose conventions are not the same"
    } else {
        ""
    };
    format!(
        "mean square {} over {} directions{fixed}{convention} and {freedom}; by chance {}",
        figure(test.mean_square),
        test.directions,
        probability(test.chance)
    )
}

/// A probability in words of a terminal.
fn probability(chance: f64) -> String {
    if chance < 1.0e-4 {
        "below 0.0001".into()
    } else {
        format!("{chance:.4}")
    }
}

/// A place as people say it.
#[must_use]
pub fn place(pose: &Pose, pitch_m: f64) -> String {
    let [x, y] = pose.centre_m.map(|at_m| (at_m / pitch_m).rem_euclid(1.0));
    format!(
        "x {x:.2}, y {y:.2} of a tooth, {:+.2}°",
        pose.theta_rad.to_degrees()
    )
}

/// What a quantity is called, with its unit, and how many of these a metre or a radian is.
#[must_use]
pub fn named(quantity: Quantity) -> (&'static str, f64) {
    match quantity {
        Quantity::X => ("x, µm", 1.0e6),
        Quantity::Y => ("y, µm", 1.0e6),
        Quantity::Theta => ("angle, µrad", 1.0e6),
    }
}

fn largest_table(list: &[Largest], pitch_m: f64, a: &str) -> String {
    let rows: Vec<Vec<String>> = list
        .iter()
        .map(|of| {
            let (name, unit) = named(of.quantity);
            let told = |value: Option<f64>| {
                value.map_or("not told".to_owned(), |value| figure(unit * value))
            };
            vec![
                name.to_owned(),
                figure(unit * of.value),
                told(of.band),
                place(&of.pose, pitch_m),
                figure(unit * of.rms),
                told(of.chance_rms),
            ]
        })
        .collect();
    let first = if a.is_empty() {
        "largest change".to_owned()
    } else {
        format!("largest change a {a}")
    };
    table(
        &[
            &first,
            "change",
            "± 95 % everywhere",
            "where",
            "rms",
            "by chance",
        ],
        &rows,
    )
}

fn terms_table(terms: &[Change], a: &str) -> String {
    if terms.is_empty() {
        return String::new();
    }
    let shown = &terms[..terms.len().min(TERMS)];
    let rows: Vec<Vec<String>> = shown
        .iter()
        .map(|of| {
            let scaled = |value: f64| scaled(value, &of.unit);
            let mut row = vec![of.name.clone()];
            if a.is_empty() {
                row.extend([scaled(of.first), scaled(of.second)]);
            }
            row.push(scaled(of.change));
            row.push(of.half_width.map_or("not told".into(), scaled));
            row.push(of.chance.map_or("not told".into(), probability));
            row
        })
        .collect();
    let change = if a.is_empty() {
        "change".to_owned()
    } else {
        format!("a {a}")
    };
    let header = if a.is_empty() {
        vec![
            "term",
            "before",
            "after",
            change.as_str(),
            "± 95 %",
            "by chance",
        ]
    } else {
        vec!["term", change.as_str(), "± 95 %", "by chance"]
    };
    let changed = terms[shown.len()..]
        .iter()
        .filter(|of| of.changed == Some(true))
        .count();
    let more = match terms.len() - shown.len() {
        0 => String::new(),
        n => format!("\nand {n} more terms, {changed} of them changed (--json has all)"),
    };
    format!("\n{}{more}", table(&header, &rows))
}

/// A value with its unit: lengths in micrometres.
fn scaled(value: f64, unit: &str) -> String {
    match unit.strip_prefix('m') {
        Some(rest) if rest.is_empty() || rest.starts_with(['/', ' ']) => {
            format!("{} µm{rest}", micrometres(value))
        }
        _ => format!("{value:.3e} {unit}"),
    }
}

fn budgets_text(budgets: &Budgets, pitch_m: f64) -> String {
    let mut parts: Vec<String> = budgets
        .budgets
        .iter()
        .map(|budget| budget_text(&budgets.of, budget, pitch_m))
        .collect();
    let rows: Vec<Vec<String>> = budgets
        .range
        .iter()
        .map(|of| {
            let (name, unit) = named(of.quantity);
            let sizes = [of.smallest, of.rms, of.largest].map(|size| figure(unit * size));
            [
                vec![name.to_owned()],
                sizes.to_vec(),
                vec![place(&of.pose, pitch_m)],
            ]
            .concat()
        })
        .collect();
    parts.push(table(
        &[
            "expanded, over the workspace",
            "smallest",
            "rms",
            "largest",
            "where",
        ],
        &rows,
    ));
    parts.push(format!("not counted:\n{}", lines(&budgets.not_counted)));
    parts.join("\n\n")
}

fn budget_text(of: &str, budget: &Budget, pitch_m: f64) -> String {
    let (name, unit) = named(budget.quantity);
    let rows: Vec<Vec<String>> = budget
        .contributions
        .iter()
        .map(|of| {
            let kind = match of.kind {
                Kind::A => "A",
                Kind::B => "B",
            };
            let uncertainty = if of.unit == "m" {
                format!("{} µm", micrometres(of.uncertainty))
            } else {
                format!("{} {}", figure(of.uncertainty), of.unit)
            };
            vec![
                of.name.clone(),
                kind.to_owned(),
                uncertainty,
                sensitivity(of.sensitivity, budget.quantity, of.unit),
                figure(unit * of.contribution),
                of.freedom
                    .map_or("∞".to_owned(), |freedom| format!("{freedom:.0}")),
            ]
        })
        .collect();
    let freedom = budget
        .freedom
        .map_or("∞".to_owned(), |freedom| format!("{freedom:.0}"));
    format!(
        "budget of {name} by {of}, at {}\n{}\ncombined {}, {freedom} degrees of freedom, coverage factor {:.2}: expanded {} (95 %)",
        place(&budget.pose, pitch_m),
        table(
            &[
                "contribution",
                "kind",
                "standard uncertainty",
                "sensitivity",
                name,
                "freedom"
            ],
            &rows
        ),
        figure(unit * budget.combined),
        budget.factor,
        figure(unit * budget.expanded)
    )
}

/// How a quantity follows a source, with its unit where it has one.
fn sensitivity(value: f64, quantity: Quantity, unit: &str) -> String {
    match (quantity, unit) {
        (_, "K") => format!("{} µm/K", micrometres(value)),
        (Quantity::Theta, _) => format!("{} µrad/µm", figure(value)),
        _ => figure(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_the_units_that_people_read() {
        assert_eq!(scaled(1.5e-6, "m"), "1.50 µm");
        assert_eq!(scaled(1.5e-6, "m/rad^1"), "1.50 µm/rad^1");
        assert_eq!(scaled(0.02, "rad"), "2.000e-2 rad");
        assert_eq!(scaled(0.02, "mT"), "2.000e-2 mT");
        assert_eq!(made(0.0), "1970-01-01T00:00:00Z");
        let pose = Pose {
            centre_m: [1.25e-3, -0.25e-3],
            theta_rad: 0.0,
        };
        assert_eq!(place(&pose, 1.0e-3), "x 0.25, y 0.75 of a tooth, +0.00°");
    }
}
