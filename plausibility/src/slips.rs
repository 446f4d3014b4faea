//! Counters that step by whole teeth, found before it is known which wire carries which segment.
//!
//! A slip of one counter shows in every sum of the four outputs in which each stands once, whatever their signs; the motion shows in all
//! such sums but the right one (equation 6). So the sum that goes least far from row to row is looked at. Against a reference the same is done with
//! the scale at which both move: nothing is presumed of its unit, sign or axes.

use crate::readings::Readings;
use std::collections::HashMap;

/// More steps of whole teeth than this are no slips of a counter: then the rows are simply far apart.
const MOST_SLIPS: usize = 12;
/// Signs of the four outputs, up to a common one. By definition all of them: half of two to the fourth.
const SIGNS: [[f64; 4]; 8] = [
    [1.0, -1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0, 1.0],
    [1.0, 1.0, 1.0, -1.0],
    [1.0, 1.0, -1.0, 1.0],
    [1.0, 1.0, -1.0, -1.0],
    [1.0, -1.0, 1.0, 1.0],
    [1.0, -1.0, 1.0, -1.0],
    [1.0, -1.0, -1.0, -1.0],
];
/// One step in so many is a large one: slips are rarer.
const LARGE_STEP_RARITY: usize = 100;
/// Where a tooth's length in the log is not known, a slip is a step of so many times the large ones.
const SLIP_RATIO: f64 = 4.0;

impl Readings {
    /// Groups, cut where a counter steps by whole teeth from one row of a run to its next, whatever the wires and units are.
    pub(crate) fn cut_at_slips(&self) -> Vec<usize> {
        let slips = found(self);
        let runs = 1 + self.group.iter().copied().max().unwrap_or(0);
        let epoch = |i: usize| slips.partition_point(|slip| *slip <= i);
        (0..self.len())
            .map(|i| self.group[i] + runs * epoch(i))
            .collect()
    }
}

/// Rows at which a counter slips, in order.
fn found(readings: &Readings) -> Vec<usize> {
    let mut slips = Vec::new();
    if (0..4).all(|s| readings.has(s)) {
        let sums = SIGNS.iter().map(|signs| {
            let sum = |i: usize| (0..4).map(|s| signs[s] * readings.position_m[s][i]).sum();
            Steps::new(
                readings,
                &(0..readings.len()).map(sum).collect::<Vec<f64>>(),
            )
        });
        slips.extend(stillest(sums, readings));
    }
    for position_m in readings.position_m.iter().filter(|p| !p.is_empty()) {
        let axes = readings.reference[..2].iter().filter(|r| !r.is_empty());
        let against = axes.filter_map(|reference| {
            let scale = scale(readings, position_m, reference)?;
            let apart = position_m.iter().zip(reference).map(|(p, r)| p - scale * r);
            Some(Steps::new(readings, &apart.collect::<Vec<f64>>()))
        });
        slips.extend(stillest(against, readings));
    }
    slips.sort_unstable();
    slips.dedup();
    slips
}

/// How far a quantity goes from one row of a group to the next.
struct Steps {
    /// The later row of each two, and the step.
    list: Vec<(usize, f64)>,
    /// One step in a hundred is larger, in size.
    large: f64,
}

impl Steps {
    fn new(readings: &Readings, quantity: &[f64]) -> Self {
        let list: Vec<(usize, f64)> = changes(readings, quantity)
            .map(|([_, here], step)| (here, step))
            .collect();
        let mut sizes: Vec<f64> = list.iter().map(|(_, step)| step.abs()).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        let place = sizes
            .len()
            .saturating_sub(1 + sizes.len() / LARGE_STEP_RARITY);
        let large = sizes.get(place).copied().unwrap_or(0.0);
        Self { list, large }
    }

    /// Rows at which it steps by whole teeth; none if there are too many for slips. Logged positions may be in any unit: there it is a step
    /// far above all others.
    fn slips(&self, readings: &Readings) -> Vec<usize> {
        let least = if readings.logged.iter().any(|l| *l) {
            SLIP_RATIO * self.large
        } else {
            0.5 * readings.pitch_m
        };
        let far = self.list.iter().filter(|(_, step)| step.abs() > least);
        let rows: Vec<usize> = far.map(|(row, _)| *row).collect();
        if rows.len() > MOST_SLIPS {
            Vec::new()
        } else {
            rows
        }
    }
}

/// Slips of the quantity that goes least far.
fn stillest(quantities: impl Iterator<Item = Steps>, readings: &Readings) -> Vec<usize> {
    let stillest = quantities.min_by(|a, b| a.large.total_cmp(&b.large));
    stillest.map_or(Vec::new(), |steps| steps.slips(readings))
}

/// Each row of a group with the one of that group before it, where both have a value of the quantity, and how far it goes between them. A run may
/// be left and come back, and a counter slip meanwhile.
fn changes<'a>(
    readings: &'a Readings,
    quantity: &'a [f64],
) -> impl Iterator<Item = ([usize; 2], f64)> + 'a {
    let known = (0..readings.len()).filter(|i| quantity[*i].is_finite());
    let mut last: HashMap<usize, usize> = HashMap::new();
    known.filter_map(move |here| {
        let before = last.insert(readings.group[here], here)?;
        Some(([before, here], quantity[here] - quantity[before]))
    })
}

/// How far a position goes for each unit of a reference: the median over the larger half of the steps.
fn scale(readings: &Readings, position_m: &[f64], reference: &[f64]) -> Option<f64> {
    let mut both: Vec<[f64; 2]> = changes(readings, reference)
        .map(|([before, here], step)| [step, position_m[here] - position_m[before]])
        .filter(|[step, way_m]| step.abs() > 0.0 && way_m.is_finite())
        .collect();
    both.sort_unstable_by(|a, b| b[0].abs().total_cmp(&a[0].abs()));
    both.truncate(both.len().div_ceil(2));
    let mut scales: Vec<f64> = both.iter().map(|[step, way_m]| way_m / step).collect();
    let middle = scales.len() / 2;
    if scales.is_empty() {
        return None;
    }
    let (_, median, _) = scales.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}
