//! What an answer of `courier compare` is told in: words, units and tables, for the terminal and for the page.

use crate::terminal::{figure, micrometres};
use comparison::answer::{Budgets, Input, Line, Pair, Told};
use comparison::budget::{Budget, Contribution, Kind};
use comparison::changes::Change;
use comparison::largest::Largest;
use comparison::repeats::Repeats;
use comparison::significance::JointTest;
use comparison::workspace::{Pose, Quantity};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

/// A header and its rows.
pub type Table = (Vec<String>, Vec<Vec<String>>);

fn header<const N: usize>(titles: [&str; N]) -> Vec<String> {
    titles.map(String::from).to_vec()
}

/// When something was made.
#[must_use]
pub fn made(made_s: f64) -> String {
    let time = OffsetDateTime::from_unix_timestamp(made_s as i64).ok();
    let text = time.and_then(|time| time.format(&Rfc3339).ok());
    text.unwrap_or_default()
}

/// What one is, with its date.
#[must_use]
pub fn about(input: &Input) -> String {
    let made = input
        .made_s
        .map_or(String::new(), |made_s| format!(", {}", made(made_s)));
    format!("{}{made}", input.about)
}

/// How well one is known, or why that is not.
#[must_use]
pub fn certainty(input: &Input) -> String {
    match &input.certainty {
        Told::Known(source) => source.clone(),
        Told::Unknown(why) => format!("no covariance: {why}"),
    }
}

/// Whether two differ.
#[must_use]
pub fn verdict(pair: &Pair) -> String {
    match (&pair.test, pair.changed) {
        (Told::Known(test), Some(true)) => format!("changed beyond chance ({})", of_test(test)),
        (Told::Known(test), _) => format!("no change beyond chance ({})", of_test(test)),
        (Told::Unknown(why), _) => format!("whether that is more than chance is not told: {why}"),
    }
}

/// How far repeats scatter, and what follows of it.
#[must_use]
pub fn repeats(repeats: &Told<Repeats>) -> String {
    match repeats {
        Told::Known(of) => format!(
            "repeats scatter about their mean ({}): each ± is {} {}",
            of_test(&of.test),
            if of.raised < 1.0 {
                "lowered by"
            } else {
                "raised by"
            },
            figure(of.raised)
        ),
        Told::Unknown(why) => format!("repeats: not told: {why}"),
    }
}

/// The effects of a pair, where there are several: one alone is the whole.
#[must_use]
pub fn effects(pair: &Pair) -> Vec<String> {
    let several = pair.effects.iter().filter(|_| pair.effects.len() > 1);
    let told = several.filter_map(|of| {
        let (test, changed) = (of.test.as_ref()?, of.changed?);
        let verdict = if changed {
            "changed"
        } else {
            "no change beyond chance"
        };
        Some(format!("{}: {verdict} ({})", of.effect, of_test(test)))
    });
    told.collect()
}

/// Whether there is a slope, and whether a line describes it.
#[must_use]
pub fn slope(line: &Line) -> Vec<String> {
    let verdict = if line.changes {
        "a slope beyond chance"
    } else {
        "no slope beyond chance"
    };
    let straying = line.strays.then(|| {
        format!(
            "they stray from the line beyond chance ({}): each ± is raised by {}",
            of_test(&line.straying),
            figure(line.raised)
        )
    });
    let first = format!(
        "trend a {}: {verdict} ({})",
        line.over.unit(),
        of_test(&line.test)
    );
    [Some(first), straying].into_iter().flatten().collect()
}

fn of_test(test: &JointTest) -> String {
    let scale = |freedom| format!("{freedom:.0} degrees of freedom");
    let freedom = test.freedom.map_or("a known scale".to_owned(), scale);
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
    let degrees = pose.theta_rad.to_degrees();
    format!("x {x:.2}, y {y:.2} of a tooth, {degrees:+.2}°")
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

fn or_not(value: Option<String>) -> String {
    value.unwrap_or_else(|| "not told".to_owned())
}

/// The largest change of each quantity; `a` is a day or a step, or nothing.
#[must_use]
pub fn largest(list: &[Largest], pitch_m: f64, a: &str) -> Table {
    let row = |of: &Largest| {
        let (name, unit) = named(of.quantity);
        let scaled = |value: f64| figure(unit * value);
        vec![
            name.to_owned(),
            scaled(of.value),
            or_not(of.band.map(scaled)),
            place(&of.pose, pitch_m),
            scaled(of.rms),
            or_not(of.chance_rms.map(scaled)),
        ]
    };
    let first = if a.is_empty() {
        "largest change".to_owned()
    } else {
        format!("largest change a {a}")
    };
    let titles = [
        &first,
        "change",
        "± 95 % everywhere",
        "where",
        "rms",
        "by chance",
    ];
    (header(titles), list.iter().map(row).collect())
}

/// Terms with their sizes and changes.
#[must_use]
pub fn terms(list: &[Change], a: &str) -> Table {
    let row = |of: &Change| {
        let scaled = |value: f64| scaled(value, &of.unit);
        let mut row = vec![of.name.clone()];
        if a.is_empty() {
            row.extend([scaled(of.first), scaled(of.second)]);
        }
        row.push(scaled(of.change));
        row.push(or_not(of.half_width.map(scaled)));
        row.push(or_not(of.chance.map(probability)));
        row
    };
    let titles = if a.is_empty() {
        header(["term", "before", "after", "change", "± 95 %", "by chance"])
    } else {
        header(["term", &format!("a {a}"), "± 95 %", "by chance"])
    };
    (titles, list.iter().map(row).collect())
}

/// A value with its unit: lengths in micrometres.
#[must_use]
pub fn scaled(value: f64, unit: &str) -> String {
    match unit.strip_prefix('m') {
        Some(rest) if rest.is_empty() || rest.starts_with(['/', ' ']) => {
            format!("{} µm{rest}", micrometres(value))
        }
        _ => format!("{value:.3e} {unit}"),
    }
}

/// The contributions of a budget.
#[must_use]
pub fn contributions(budget: &Budget) -> Table {
    let (name, unit) = named(budget.quantity);
    let row = |of: &Contribution| {
        vec![
            of.name.clone(),
            kind(of.kind).to_owned(),
            standard(of),
            sensitivity(of.sensitivity, budget.quantity, of.unit),
            figure(unit * of.contribution),
            freedom(of.freedom),
        ]
    };
    let titles = [
        "contribution",
        "kind",
        "standard uncertainty",
        "sensitivity",
        name,
        "freedom",
    ];
    (
        header(titles),
        budget.contributions.iter().map(row).collect(),
    )
}

fn kind(kind: Kind) -> &'static str {
    match kind {
        Kind::A => "A",
        Kind::B => "B",
    }
}

fn standard(of: &Contribution) -> String {
    match of.unit {
        "m" => format!("{} µm", micrometres(of.uncertainty)),
        unit => format!("{} {unit}", figure(of.uncertainty)),
    }
}

/// How a quantity follows a source, with its unit where it has one.
fn sensitivity(value: f64, quantity: Quantity, unit: &str) -> String {
    match (quantity, unit) {
        (_, "K") => format!("{} µm/K", micrometres(value)),
        (Quantity::Theta, _) => format!("{} µrad/µm", figure(value)),
        _ => figure(value),
    }
}

fn freedom(freedom: Option<f64>) -> String {
    freedom.map_or("∞".to_owned(), |freedom| format!("{freedom:.0}"))
}

/// What a budget comes to.
#[must_use]
pub fn combined(budget: &Budget) -> String {
    let (_, unit) = named(budget.quantity);
    format!(
        "combined {}, {} degrees of freedom, coverage factor {:.2}: expanded {} (95 %)",
        figure(unit * budget.combined),
        freedom(budget.freedom),
        budget.factor,
        figure(unit * budget.expanded)
    )
}

/// How expanded uncertainties go over the workspace.
#[must_use]
pub fn range(budgets: &Budgets, pitch_m: f64) -> Table {
    let rows = budgets.range.iter().map(|of| {
        let (name, unit) = named(of.quantity);
        let [smallest, rms, largest] =
            [of.smallest, of.rms, of.largest].map(|size| figure(unit * size));
        vec![
            name.to_owned(),
            smallest,
            rms,
            largest,
            place(&of.pose, pitch_m),
        ]
    });
    let titles = [
        "expanded, over the workspace",
        "smallest",
        "rms",
        "largest",
        "where",
    ];
    (header(titles), rows.collect())
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
