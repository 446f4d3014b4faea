//! Mean residuals over the platen.

use super::{Figure, changed, strings, without_after};
use crate::html::plots::{self, Cell, MICRO, Scale};
use crate::html::svg::{Area, plot, short};
use crate::html::telling::range;
use diagnosis::algebra::statistics::median;
use diagnosis::verdict::evidence::{Evidence, Trace};
use std::collections::BTreeMap;

/// Cells along the longer side of the map.
const MAP_CELLS: f64 = 24.0;
/// Fewest residuals in a cell of the map.
const FEWEST: usize = 3;
/// Fewest cells of a map along each side: a single fly-by is a line and no map.
const SIDES: usize = 3;
/// Colours are full at no less than so many times what chance gives: so that chance stays pale.
const CHANCE: f64 = 4.0;
/// Largest number of rows in the table.
const ROWS: usize = 12;

/// Sums over a cell.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: f64,
    before_m: f64,
    after_m: f64,
    floor_m2: f64,
}

/// Mean residuals over the platen, before and after; before alone where nothing named changes them.
pub fn map(evidence: &Evidence, trace: &Trace) -> Option<Figure> {
    let (cell_mm, cells) = cells(evidence, trace)?;
    let of = |pick: fn(&Sums) -> f64| -> Vec<Cell> {
        let one = |(at, sums): &([f64; 2], Sums)| (*at, MICRO * pick(sums) / sums.count);
        cells.iter().map(one).collect()
    };
    let (before, after) = (of(|s| s.before_m), of(|s| s.after_m));
    let rms = |list: &[Cell]| diagnosis::algebra::statistics::rms(list.iter().map(|c| c.1));
    let by_chance = |(_, s): &([f64; 2], Sums)| MICRO * s.floor_m2.sqrt() / s.count;
    let chance = median(&mut cells.iter().map(by_chance).collect::<Vec<_>>()).unwrap_or(0.0);
    let changed = changed(trace);
    let scale = Scale {
        cell_mm,
        full_um: (2.0 * rms(&before)).max(CHANCE * chance).max(1e-6),
    };
    let mut maps = vec![(if changed { "before" } else { "" }, &before)];
    maps.extend(changed.then_some(("after", &after)));
    let left = if changed {
        format!(" before, {} µm after", short(rms(&after)))
    } else {
        String::new()
    };
    let caption = format!(
        "Mean residual of {} in {} cells of {} mm: {} µm rms{left}; the simulator's own scatter alone gives {} µm in the middle one of them. Beyond the ends of the colour bar colours stay as they are.",
        trace.channel,
        cells.len(),
        short(cell_mm),
        short(rms(&before)),
        short(chance)
    );
    let draw = |area: &Area, narrow: bool| {
        let count = maps.len();
        let parts = area.split_evenly(if narrow { (count, 1) } else { (1, count) });
        let mut marks = Vec::new();
        for (part, (name, cells)) in parts.iter().zip(&maps) {
            marks.extend(plots::map(part, narrow, name, cells, scale)?);
        }
        Ok(marks)
    };
    Some(Figure {
        id: "map",
        title: format!("Map over the platen, {}", trace.channel),
        plots: plot(&caption, [400, 290 * maps.len() as u32], draw),
        caption,
        legend: Vec::new(),
        table: table(&before, &after, changed),
    })
}

/// Side of a cell, mm, and the middle, mm, and sums of each cell that holds enough.
fn cells(evidence: &Evidence, trace: &Trace) -> Option<(f64, Vec<([f64; 2], Sums)>)> {
    let at: Vec<[f64; 2]> = trace
        .points
        .iter()
        .map(|p| evidence.places[p.place].centre_m.map(|v| 1.0e3 * v))
        .collect();
    let spread = [0, 1].map(|axis| range(&at.iter().map(|p| p[axis]).collect::<Vec<_>>()));
    let [Some(x), Some(y)] = spread else {
        return None;
    };
    let size = (x.1 - x.0).max(y.1 - y.0) / MAP_CELLS;
    let mut cells: BTreeMap<[i64; 2], Sums> = BTreeMap::new();
    for (place, point) in at.iter().zip(&trace.points) {
        let key = [(place[0] - x.0) / size, (place[1] - y.0) / size].map(|v| v as i64);
        let cell = cells.entry(key).or_default();
        cell.count += 1.0;
        cell.before_m += point.before_m;
        cell.after_m += point.after_m;
        cell.floor_m2 += point.floor_m.powi(2);
    }
    cells.retain(|_, cell| cell.count >= FEWEST as f64);
    let sides = [0, 1].map(|axis| {
        let mut list: Vec<i64> = cells.keys().map(|key| key[axis]).collect();
        list.sort_unstable();
        list.dedup();
        list.len()
    });
    if sides.iter().any(|n| *n < SIDES) {
        return None;
    }
    let middle = |key: &[i64; 2]| {
        [
            x.0 + (key[0] as f64 + 0.5) * size,
            y.0 + (key[1] as f64 + 0.5) * size,
        ]
    };
    let list = cells.iter().map(|(key, sums)| (middle(key), *sums));
    Some((size, list.collect()))
}

fn table(before: &[Cell], after: &[Cell], changed: bool) -> (Vec<String>, Vec<Vec<String>>) {
    let mut rows: Vec<(f64, Vec<String>)> = before
        .iter()
        .zip(after)
        .map(|((p, b), (_, a))| {
            let row = [p[0], p[1], *b, *a].map(short).to_vec();
            (b.abs(), without_after(changed, row, 3))
        })
        .collect();
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    rows.truncate(ROWS);
    let header = strings(["x, mm", "y, mm", "mean before, µm", "mean after, µm"]);
    (
        without_after(changed, header, 3),
        rows.into_iter().map(|r| r.1).collect(),
    )
}
