//! Mean residuals over the platen.

use super::{Figure, strings};
use crate::evidence::{Evidence, Trace};
use crate::html::plots::{self, MICRO};
use crate::html::svg::{Area, plot, short};
use crate::html::telling::range;
use std::collections::BTreeMap;

/// Cells along the longer side of the map.
const MAP_CELLS: f64 = 24.0;
/// Fewest residuals in a cell of the map.
const FEWEST: usize = 3;

/// Mean residuals over the platen, before and after.
pub fn map(evidence: &Evidence, trace: &Trace) -> Option<Figure> {
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
    let mut cells: BTreeMap<[i64; 2], (usize, f64, f64)> = BTreeMap::new();
    for (place, point) in at.iter().zip(&trace.points) {
        let cell = cells
            .entry([
                ((place[0] - x.0) / size) as i64,
                ((place[1] - y.0) / size) as i64,
            ])
            .or_default();
        cell.0 += 1;
        cell.1 += point.before_m;
        cell.2 += point.after_m;
    }
    cells.retain(|_, cell| cell.0 >= FEWEST);
    if cells.len() < 4 {
        return None;
    }
    let middle = |key: &[i64; 2]| {
        [
            x.0 + (key[0] as f64 + 0.5) * size,
            y.0 + (key[1] as f64 + 0.5) * size,
        ]
    };
    let of = |after: bool| -> Vec<plots::Cell> {
        cells
            .iter()
            .map(|(key, c)| {
                (
                    middle(key),
                    MICRO * if after { c.2 } else { c.1 } / c.0 as f64,
                )
            })
            .collect()
    };
    let maps = [("before", of(false)), ("after", of(true))];
    let rms = |list: &[plots::Cell]| crate::statistics::rms(list.iter().map(|c| c.1));
    let full = 2.0 * rms(&maps[0].1).max(1e-6);
    let caption = format!(
        "Mean {} in {} cells of {} mm: rms {} µm before, {} µm after. Warm is positive, cool negative; full colour is {} µm.",
        trace.channel,
        cells.len(),
        short(size),
        short(rms(&maps[0].1)),
        short(rms(&maps[1].1)),
        short(full)
    );
    let mut rows: Vec<(f64, Vec<String>)> = maps[0]
        .1
        .iter()
        .zip(&maps[1].1)
        .map(|((p, b), (_, a))| {
            (
                b.abs(),
                vec![short(p[0]), short(p[1]), short(*b), short(*a)],
            )
        })
        .collect();
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    rows.truncate(12);
    let draw = |area: &Area, narrow: bool| {
        let parts = area.split_evenly(if narrow { (2, 1) } else { (1, 2) });
        for (part, (name, cells)) in parts.iter().zip(&maps) {
            plots::map(part, narrow, name, cells, size, full)?;
        }
        Ok(())
    };
    Some(Figure {
        id: "map",
        title: format!("Map over the platen, {}", trace.channel),
        plots: plot(&caption, [1, 2], draw),
        caption,
        table: (
            strings(["x, mm", "y, mm", "mean before, µm", "mean after, µm"]),
            rows.into_iter().map(|r| r.1).collect(),
        ),
    })
}
