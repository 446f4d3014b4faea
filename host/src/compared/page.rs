//! The answer of `courier compare` as a page with plots, in the report's style.

use super::text::left_out;
use super::words;
use comparison::answer::{Answer, Budgets, Cell, Line, Pair, Told};
use comparison::budget::{Budget, Kind};
use comparison::changes::Change;
use comparison::workspace::Quantity;
use courier_sensor::geometry::Geometry;
use maud::{Markup, html};
use report::html::figures::Figure;
use report::html::plots::{self, Bar, BarAxis, Group, MICRO, Scale, bars, heights};
use report::html::svg::{AFTER, BEFORE, plot, short};
use report::html::{Origin, document, drawn, origin, table};

/// Terms that are drawn at most.
const TERMS: usize = 10;
/// Colours are full at no less than this, µm: a hundredth of what the sensor resolves.
const LEAST_FULL_UM: f64 = 0.002;
/// Anchors of figures, by pair or budget: so many are drawn, the others stand in tables.
const CHANGES: [&str; 4] = ["change-1", "change-2", "change-3", "change-4"];
const TERM_CHANGES: [&str; 4] = ["terms-1", "terms-2", "terms-3", "terms-4"];
const BUDGETS: [&str; 4] = ["budget-1", "budget-2", "budget-3", "budget-4"];
const MAPS: [&str; 4] = ["map-1", "map-2", "map-3", "map-4"];

/// One self-contained HTML file.
#[must_use]
pub fn page(answer: &Answer, geometry: &Geometry, origin: &Origin) -> String {
    let pitch_m = f64::from(geometry.pitch_m);
    let names: Vec<&str> = answer.compared.iter().map(|of| of.name.as_str()).collect();
    let body = html! {
        header {
            p.over { "Calibrations compared: " code { (names.join(", ")) } }
            h1 { (headline(answer)) }
        }
        main {
            (inputs(answer))
            @if let Some(repeats) = &answer.repeats { p.note { (words::repeats(repeats)) } }
            @for (place, of) in answer.differences.iter().enumerate() { (pair(of, pitch_m, place)) }
            @match &answer.trend {
                Some(Told::Known(of)) => { (line(of, pitch_m)) }
                Some(Told::Unknown(why)) => { p.note { "Trend: not told: " (why) } }
                None => {}
            }
            @for (place, of) in answer.budgets.iter().enumerate() {
                @match of {
                    Told::Known(of) => { (budgets(of, pitch_m, place)) }
                    Told::Unknown(why) => { p.note { "Budget: not told: " (why) } }
                }
            }
            section aria-labelledby="left-out" {
                h2 id="left-out" { "Not compared" }
                ul { @for line in left_out(answer) { li { (line) } } }
            }
            (origin::section(origin))
        }
    };
    document(&format!("Comparison of {}", names.join(", ")), &body)
}

/// The last against the first, or the first's budget, in a sentence.
fn headline(answer: &Answer) -> Markup {
    if let Some(pair) = answer.differences.last() {
        let (tone, word) = match pair.changed {
            Some(true) => ("warn", "changed"),
            Some(false) => ("good", "no change beyond chance"),
            None => ("calm", "not told"),
        };
        let moves = pair
            .largest
            .iter()
            .filter(|of| of.quantity != Quantity::Theta);
        let most = moves.max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()));
        let told = most.map_or(String::new(), |of| {
            let band = of
                .band
                .map_or(String::new(), |band| format!(" ± {}", short(MICRO * band)));
            format!(
                "positions move by {}{band} µm at most",
                short(MICRO * of.value.abs())
            )
        });
        return html! { span class={ "pill " (tone) } { (word) } " " (told) };
    }
    match answer.budgets.first() {
        Some(Told::Known(of)) => {
            html! { "A position is known to ± " (largest_um(of)) " µm (95 %)" }
        }
        _ => html! { "No budget" },
    }
}

fn largest_um(budgets: &Budgets) -> String {
    let positions = budgets
        .range
        .iter()
        .filter(|of| of.quantity != Quantity::Theta);
    short(MICRO * positions.map(|of| of.largest).fold(0.0, f64::max))
}

fn inputs(answer: &Answer) -> Markup {
    html! {
        section aria-labelledby="inputs" {
            h2 id="inputs" { "What was compared" }
            dl.pairs {
                @for of in &answer.compared {
                    div { dt { code { (of.name) } } dd { (words::about(of)) "; " (words::certainty(of)) } }
                }
            }
        }
    }
}

fn pair(pair: &Pair, pitch_m: f64, place: usize) -> Markup {
    let id = format!("pair-{place}");
    let (header, rows) = words::largest(&pair.largest, pitch_m, "");
    html! {
        section aria-labelledby=(id) {
            h2 id=(id) { (pair.second) " against " (pair.first) }
            p { (words::verdict(pair)) }
            @for line in words::effects(pair) { p { (line) } }
            (table(&header, &rows))
            @for line in &pair.left_out { p.note { (line) } }
        }
        @if let (Some(change), Some(terms)) = (CHANGES.get(place), TERM_CHANGES.get(place)) {
            (drawn(&change_map(pair, change)))
            (drawn(&terms_figure(pair, terms)))
        }
    }
}

/// A quantity of a map's cells, for the plot: places in mm, values in µm.
fn cells(map: &[Cell], axis: usize) -> Vec<plots::Cell> {
    let one = |cell: &Cell| {
        (
            cell.centre_m.map(|at_m| 1.0e3 * at_m),
            MICRO * cell.values[axis],
        )
    };
    map.iter().map(one).collect()
}

/// Side of a map's cell, mm.
fn side_mm(map: &[Cell]) -> f64 {
    map.get(1)
        .map_or(1.0, |cell| 1.0e3 * (cell.centre_m[0] - map[0].centre_m[0]))
}

/// Maps of x and y side by side.
fn position_maps(map: &[Cell], id: &'static str, title: String, caption: String) -> Figure {
    let both = [cells(map, 0), cells(map, 1)];
    let most = both
        .iter()
        .flatten()
        .fold(LEAST_FULL_UM, |most, cell| most.max(cell.1.abs()));
    let scale = Scale {
        cell_mm: side_mm(map),
        full_um: most,
    };
    let rows = [("x", &both[0]), ("y", &both[1])].map(|(name, cells)| {
        let values = cells.iter().map(|cell| cell.1);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        vec![name.to_owned(), short(low), short(high)]
    });
    Figure {
        id,
        title,
        plots: plot(&caption, [400, 580], |area, narrow| {
            let parts = area.split_evenly(if narrow { (2, 1) } else { (1, 2) });
            let mut marks = plots::map(&parts[0], narrow, "x", &both[0], scale)?;
            marks.extend(plots::map(&parts[1], narrow, "y", &both[1], scale)?);
            Ok(marks)
        }),
        caption,
        legend: Vec::new(),
        table: (
            ["µm", "smallest", "largest"].map(String::from).to_vec(),
            rows.to_vec(),
        ),
    }
}

fn change_map(pair: &Pair, id: &'static str) -> Figure {
    let title = format!("Change of the position over a tooth, {}", pair.second);
    let caption = "Change of the calibrated x and y over a tooth of the platen, the courier straight, at rest and at the calibration's temperature.";
    position_maps(&pair.map, id, title, caption.into())
}

fn terms_figure(pair: &Pair, id: &'static str) -> Figure {
    // A length beside a length: what has another unit stands in the table alone.
    let lengths: Vec<&Change> = pair
        .terms
        .iter()
        .filter(|of| of.unit == "m")
        .take(TERMS)
        .collect();
    let group = |of: &&Change| {
        let [change, half] = [of.change, of.half_width.unwrap_or(0.0)].map(|m| MICRO * m);
        let bar = Bar {
            value: change,
            was: None,
            interval: of
                .half_width
                .map(|_| [(change - half).max(0.0), change + half]),
            colour: if of.changed == Some(true) {
                AFTER
            } else {
                BEFORE
            },
            label: short(change),
            told: format!("{}: {} ± {} µm", of.name, short(change), short(half)),
        };
        (of.name.clone(), vec![bar])
    };
    let groups: Vec<Group> = lengths.iter().map(group).collect();
    let caption = "Size of the change of each term, sine and cosine together, with its 95 % interval; the surest first. Terms are tested together: those that changed beyond chance are marked.";
    let axis = BarAxis {
        title: "µm",
        line: None,
    };
    Figure {
        id,
        title: format!("Terms that changed, {}", pair.second),
        plots: plot(caption, heights(groups.len(), 1), |area, narrow| {
            bars(area, narrow, &groups, &axis)
        }),
        caption: caption.into(),
        legend: vec![
            ("after", "changed beyond chance"),
            ("before", "within chance"),
        ],
        table: words::terms(&pair.terms, ""),
    }
}

fn line(line: &Line, pitch_m: f64) -> Markup {
    let unit = line.over.unit();
    let (header, rows) = words::largest(&line.largest, pitch_m, unit);
    let (term_header, term_rows) = words::terms(&line.terms, unit);
    html! {
        section aria-labelledby="trend" {
            h2 id="trend" { "Trend" }
            @for told in words::slope(line) { p { (told) } }
            (table(&header, &rows))
            details { summary { "By term" } (table(&term_header, &term_rows)) }
        }
    }
}

fn budgets(budgets: &Budgets, pitch_m: f64, place: usize) -> Markup {
    let id = format!("budgets-{place}");
    let (header, rows) = words::range(budgets, pitch_m);
    let drawn_too = BUDGETS.get(place).zip(MAPS.get(place));
    html! {
        section aria-labelledby=(id) {
            h2 id=(id) { "Uncertainty by " (budgets.of) }
            @for budget in &budgets.budgets { (one_budget(budget, pitch_m)) }
            (table(&header, &rows))
            p { "Not counted:" }
            ul { @for line in &budgets.not_counted { li { (line) } } }
        }
        @if let Some((bars, map)) = drawn_too {
            @if let Some(budget) = budgets.budgets.first() { (drawn(&contributions(budget, bars))) }
            (drawn(&uncertainty_map(budgets, map)))
        }
    }
}

fn one_budget(budget: &Budget, pitch_m: f64) -> Markup {
    let (header, rows) = words::contributions(budget);
    let (name, _) = words::named(budget.quantity);
    html! {
        h3 { (name) ", at " (words::place(&budget.pose, pitch_m)) }
        (table(&header, &rows))
        p { (words::combined(budget)) }
    }
}

fn contributions(budget: &Budget, id: &'static str) -> Figure {
    let (name, unit) = words::named(budget.quantity);
    let groups: Vec<Group> = budget
        .contributions
        .iter()
        .map(|of| {
            let value = unit * of.contribution;
            let bar = Bar {
                value,
                was: None,
                interval: None,
                colour: if of.kind == Kind::A { AFTER } else { BEFORE },
                label: short(value),
                told: format!("{}: {}", of.name, short(value)),
            };
            (of.name.clone(), vec![bar])
        })
        .collect();
    let caption = "What each source contributes, as a standard uncertainty; they add as squares.";
    let axis = BarAxis {
        title: name,
        line: None,
    };
    Figure {
        id,
        title: format!("Contributions to {name}"),
        plots: plot(caption, heights(groups.len(), 1), |area, narrow| {
            bars(area, narrow, &groups, &axis)
        }),
        caption: caption.into(),
        legend: vec![
            ("after", "A: by statistics"),
            ("before", "B: by anything else"),
        ],
        table: words::contributions(budget),
    }
}

fn uncertainty_map(budgets: &Budgets, id: &'static str) -> Figure {
    let title = format!("Expanded uncertainty over a tooth, {}", budgets.of);
    let caption =
        "Expanded uncertainty (95 %) of x and y over a tooth of the platen, the courier straight.";
    position_maps(&budgets.map, id, title, caption.into())
}
