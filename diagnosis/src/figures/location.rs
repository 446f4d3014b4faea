//! Where a gap lies: shares of what is left over the coordinates of diagnosis.md.

use super::attribution::{Attribution, attribution};
use super::fitted_effects::FittedEffects;
use crate::data::channel_names::CHANNEL_NAMES;
use crate::design::assembly::{BlockKind, Design, DesignOptions, assemble};
use crate::figures::gap::unexplained_fraction;
use crate::inference::cross_validation::CrossValidation;
use crate::linearization::point::LinearizationPoint;
use crate::trace::log;
use crate::verdict::answer::Share;
use effects::sensor::Regressor;
use nalgebra::{Matrix3, Vector3};

/// Shares that are told. A bound on the work: of a reader, who has the others in what is left.
const REPORTED_SHARE: f64 = 0.02;
/// See [`REPORTED_SHARE`].
const REPORTED_COORDINATES: usize = 10;

/// Half the mean squared step over the mean square from which on residuals are rough, and the neighbours that tell it. As noise's
/// is 1 (von Neumann 1941), and `ROUGH_NEIGHBOURS` tell it to 0.06.
const ROUGH_STEP_RATIO: f64 = 0.6;
/// See [`ROUGH_STEP_RATIO`].
const ROUGH_NEIGHBOURS: usize = 300;
/// Standard deviations from which on scatter is said to grow. Derived from the normal tail: by chance once in a thousand million.
const GROWTH_DEVIATIONS: f64 = 6.0;

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), v| (sum + v, count + 1));
    sum / f64::from(count.max(1))
}

/// A coordinate, the share of what is left that shapes over it take, and whose it is.
#[derive(Default)]
pub struct Located {
    /// In the words of diagnosis.md.
    pub coordinate: String,
    /// Of what is left.
    pub share: f64,
    /// The shapes' columns.
    columns: Vec<usize>,
    /// Whose it is, where that was asked for.
    attribution: Attribution,
}

impl Located {
    /// The shapes' columns, in the design that they were found in.
    pub(super) fn columns(&self) -> &[usize] {
        &self.columns
    }

    /// What is known of some segments without a shape.
    pub(super) fn of_segments(coordinate: &str, share: f64, segments: [bool; 4]) -> Self {
        Self {
            coordinate: coordinate.into(),
            share,
            attribution: Attribution {
                channel: None,
                segments,
            },
            ..Self::default()
        }
    }
}

/// Takes over the larger share of every coordinate, largest first.
pub(super) fn merge(list: &mut Vec<Located>, more: Vec<Located>) {
    for finer in more {
        match list.iter_mut().find(|l| l.coordinate == finer.coordinate) {
            Some(known) if finer.share > known.share => *known = finer,
            Some(_) => {}
            None => list.push(finer),
        }
    }
    list.sort_by(|a, b| b.share.total_cmp(&a.share));
}

/// What a pair's amplitude tells comes of the same readings: an offset that comes and goes moves both, and lies where it comes from. What
/// acts from outside and takes this share of what the amplitude does is told before it.
const OUTSIDE_SHARE: f64 = 0.5;
/// See [`OUTSIDE_SHARE`].
const AMPLITUDE_COORDINATE: &str = "signal amplitude";
/// See [`OUTSIDE_SHARE`].
const OUTSIDE_COORDINATES: [&str; 6] = [
    "frequency",
    "speed",
    "direction",
    "time",
    "temperature",
    "place on the platen",
];

/// Puts the amplitude behind what acts from outside and takes nearly as much.
pub(super) fn outside_first(list: &mut [Located]) {
    let Some(amplitude) = list
        .iter()
        .position(|l| l.coordinate == AMPLITUDE_COORDINATE)
    else {
        return;
    };
    let least = OUTSIDE_SHARE * list[amplitude].share;
    let outside = list
        .iter()
        .position(|l| OUTSIDE_COORDINATES.contains(&l.coordinate.as_str()));
    if let Some(outside) = outside.filter(|k| *k > amplitude && list[*k].share > least) {
        list[amplitude..=outside].rotate_right(1);
    }
}

/// What follows the temperature does so wholly: as was measured on 13 mirrors that creep with it, it took 0.998 or more. Where it
/// takes less than this, it is slow, as what creeps or is switched on is,
const WHOLLY_THERMAL_SHARE: f64 = 0.97;
/// and the clock, which takes this share of what the temperature takes, is told before it.
const CLOCK_SHARE: f64 = 0.8;

/// Puts the temperature behind the time where it only goes with it.
pub(super) fn clock_first(list: &mut [Located]) {
    let at = |name: &str| list.iter().position(|l| l.coordinate == name);
    let (Some(temperature), Some(time)) = (at("temperature"), at("time")) else {
        return;
    };
    let taken = list[temperature].share;
    if time > temperature && taken < WHOLLY_THERMAL_SHARE && list[time].share > CLOCK_SHARE * taken
    {
        list[temperature..=time].rotate_right(1);
    }
}

impl FittedEffects<'_> {
    /// Shares of the excess that is left after `blocks`, by coordinate, largest first.
    pub(super) fn locate(
        &self,
        validation: &mut CrossValidation,
        blocks: &[usize],
    ) -> Vec<Located> {
        located(&self.design, validation, self.base, blocks)
    }

    /// Finer shapes over the coordinates, about the baseline: for a gap that nothing explains.
    pub(super) fn fine_design(&self) -> Design<'_> {
        let point = LinearizationPoint {
            noise: self.noise,
            ..self.prepared.point()
        };
        let design_options = DesignOptions {
            previous_inputs: Some(&self.design.linearized.inputs),
            fine_basis: true,
            ..DesignOptions::default()
        };
        assemble(self.prepared, self.options, &point, design_options)
    }

    /// Shares of the whole excess by the shapes of [`Self::fine_design`].
    pub(super) fn locate_finely(
        &self,
        design: &Design,
        validation: &mut CrossValidation,
    ) -> Vec<Located> {
        let mut found = located(design, validation, self.base, &[]);
        attribute(design, validation, &[], &mut found);
        if let Some(missing) = self.missing_codes() {
            found.push(missing);
            found.sort_by(|a, b| b.share.total_cmp(&a.share));
        }
        for l in &found {
            log(&format!("finely: {} {:.3}", l.coordinate, l.share));
        }
        found
    }

    /// The same of the whole excess, with scatter that grows with speed: no shape has a place for that.
    pub(super) fn locate_whole(&self, validation: &mut CrossValidation) -> Vec<Located> {
        let mut out = self.locate(validation, &[]);
        attribute(&self.design, validation, &[], &mut out);
        if let Some(share) = self.scatter_with_speed() {
            let coordinate = "speed".to_string();
            let known = out.iter().position(|l| l.coordinate == coordinate);
            let least = known.map_or(0.0, |k| out.swap_remove(k).share);
            out.push(Located {
                coordinate,
                share: share.max(least),
                ..Located::default()
            });
            out.sort_by(|a, b| b.share.total_cmp(&a.share));
        }
        out
    }

    /// Share of the excess that is rough from sample to sample and whose variance grows with the square of the speed: samples
    /// taken at uncertain times.
    fn scatter_with_speed(&self) -> Option<f64> {
        let before = &self.before;
        let path = self.path_steps(before);
        if path.pairs < ROUGH_NEIGHBOURS || path.step < ROUGH_STEP_RATIO * path.level {
            return None;
        }
        let speeds = &self.design.linearized.motion.speed_m_s;
        let squared = |axis: usize, i: usize| {
            let v = |s: usize| speeds[s].get(i).copied().unwrap_or(0.0);
            v(axis).powi(2).max(v(axis + 2).powi(2))
        };
        let unit = [0, 1].map(|axis| {
            mean((0..self.design.linearized.len()).map(|i| squared(axis, i))).max(1e-30)
        });
        let mut normal = Matrix3::identity() * 1e-9;
        let mut right = Vector3::zeros();
        for (k, &i) in before.sample.iter().enumerate() {
            let row = Vector3::new(1.0, squared(0, i) / unit[0], squared(1, i) / unit[1]);
            normal += row * row.transpose();
            right += row * before.white[k].powi(2);
        }
        let inverse = normal.try_inverse()?;
        let amount = inverse * right;
        // A squared normal deviate scatters by the square root of two of its mean.
        let scale = 2.0 * before.white_rms().powi(4);
        let sure = |k: usize| amount[k] > GROWTH_DEVIATIONS * (scale * inverse[(k, k)]).sqrt();
        let count = before.sample.len() as f64;
        let grows: f64 = (1..3)
            .filter(|k| sure(*k))
            .map(|k| amount[k] * normal[(0, k)] / count)
            .sum();
        let excess = before.white_rms().powi(2) - self.floor.white_square;
        (grows > 0.0 && excess > 0.0).then(|| (grows / excess).min(1.0))
    }

    /// The largest, as they are told.
    pub(super) fn shares(&self, list: Vec<Located>) -> Vec<Share> {
        let main = self.main_channel();
        reported(&list)
            .map(|l| Share {
                channel: l
                    .attribution
                    .channel
                    .map_or(main, |c| CHANNEL_NAMES[c])
                    .into(),
                coordinate: format!("{}{}", l.coordinate, of_segments(l.attribution.segments)),
                share: l.share.min(1.0),
            })
            .collect()
    }

    /// The channel with the largest excess over its own floor.
    pub(super) fn main_channel(&self) -> &'static str {
        let excess = |c: &usize| {
            self.before.channel_rms_m(*c).0 / self.design.floor.channel_rms_m[*c].max(1e-12)
        };
        let best = self
            .before
            .channels()
            .into_iter()
            .max_by(|a, b| excess(a).total_cmp(&excess(b)));
        CHANNEL_NAMES[best.unwrap_or(0)]
    }
}

/// Those that are told.
pub(super) fn reported(list: &[Located]) -> impl Iterator<Item = &Located> {
    list.iter()
        .filter(|l| l.share > REPORTED_SHARE)
        .take(REPORTED_COORDINATES)
}

/// Finds whose the shares that are told are: of what is left after `blocks`.
pub(super) fn attribute(
    design: &Design,
    validation: &mut CrossValidation,
    blocks: &[usize],
    list: &mut [Located],
) {
    let known = design.list(blocks);
    let before = design.residuals(blocks);
    for l in list
        .iter_mut()
        .filter(|l| l.share > REPORTED_SHARE)
        .take(REPORTED_COORDINATES)
    {
        l.attribution = attribution(design, validation, (&known, &before), &l.columns);
    }
}

fn of_segments(segments: [bool; 4]) -> String {
    let list: Vec<String> = (0..4)
        .filter(|s| segments[*s])
        .map(|s| (s + 1).to_string())
        .collect();
    match list.as_slice() {
        [] => String::new(),
        [one] => format!(", segment {one}"),
        [more @ .., last] => format!(", segments {} and {last}", more.join(", ")),
    }
}

/// Shares of the excess over `base` that is left after `blocks`, by coordinate, largest first.
fn located(
    design: &Design,
    validation: &mut CrossValidation,
    base: f64,
    blocks: &[usize],
) -> Vec<Located> {
    let with = unexplained_fraction(validation, blocks, base);
    if with <= 0.0 {
        return Vec::new();
    }
    let whole_gap = (validation.score(&[]).squares - base).max(1e-9);
    let base_list = design.list(blocks);
    let mut out: Vec<Located> = Vec::new();
    for (coordinate, groups) in coordinates(design, blocks) {
        // Groups over one coordinate that nearly cancel are of no physical size together, and each may be by itself.
        let together = groups.concat();
        let mut best = (f64::INFINITY, Vec::new());
        for mut columns in std::iter::once(together).chain(groups) {
            columns.retain(|c| !base_list.contains(c));
            let list = [&base_list[..], &columns].concat();
            let left = (validation.score_columns(&list).squares - base) / whole_gap;
            if left < best.0 {
                best = (left, columns);
            }
        }
        out.push(Located {
            coordinate,
            share: (with - best.0) / with,
            columns: best.1,
            attribution: Attribution::default(),
        });
    }
    out.sort_by(|a, b| b.share.total_cmp(&a.share));
    out
}

/// Groups of columns by coordinate: those of one block together.
fn coordinates(design: &Design, without: &[usize]) -> Vec<(String, Vec<Vec<usize>>)> {
    let mut list: Vec<(String, Vec<Vec<usize>>)> = Vec::new();
    for (b, block) in design.columns.blocks.iter().enumerate().skip(1) {
        if without.contains(&b) {
            continue;
        }
        let mut own: Vec<(String, Vec<usize>)> = Vec::new();
        for c in block.columns.clone() {
            let label = coordinate(&design.kinds[b - 1], &design.columns.regressors[c]);
            match own.iter_mut().find(|group| group.0 == label) {
                Some(group) => group.1.push(c),
                None => own.push((label, vec![c])),
            }
        }
        for (label, columns) in own {
            match list.iter_mut().find(|entry| entry.0 == label) {
                Some(entry) => entry.1.push(columns),
                None => list.push((label, vec![columns])),
            }
        }
    }
    list
}

/// The coordinate of a column in the words of diagnosis.md.
fn coordinate(kind: &BlockKind, column: &Regressor) -> String {
    match kind {
        BlockKind::Coordinate(name) => name.clone(),
        BlockKind::Effect(name) | BlockKind::WithheldEffect(name) => {
            effects::effect(name).map_or_else(|| name.clone(), |effect| effect.coordinate(column))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_is_told_before_a_temperature_that_only_goes_with_it() {
        let order = |temperature: f64, time: f64| {
            let shares = [
                ("speed", 0.99),
                ("temperature", temperature),
                ("time", time),
            ];
            let mut list =
                shares.map(|(name, share)| Located::of_segments(name, share, [false; 4]));
            list.sort_by(|a, b| b.share.total_cmp(&a.share));
            clock_first(&mut list);
            list.map(|l| l.coordinate)
        };
        assert_eq!(order(0.92, 0.89), ["speed", "time", "temperature"]);
        assert_eq!(order(0.98, 0.97), ["speed", "temperature", "time"]);
        assert_eq!(order(0.9, 0.5), ["speed", "temperature", "time"]);
        assert_eq!(order(0.5, 0.9), ["speed", "time", "temperature"]);
    }

    #[test]
    fn what_acts_from_outside_is_told_before_the_amplitude_that_it_changes() {
        let order = |shares: &[(&str, f64)]| {
            let one = |(name, share): &(&str, f64)| Located::of_segments(name, *share, [false; 4]);
            let mut list: Vec<Located> = shares.iter().map(one).collect();
            outside_first(&mut list);
            list.into_iter().map(|l| l.coordinate).collect::<Vec<_>>()
        };
        let near = [
            (AMPLITUDE_COORDINATE, 0.7),
            ("theta", 0.6),
            ("speed", 0.5),
            ("time", 0.4),
        ];
        assert_eq!(
            order(&near),
            ["speed", AMPLITUDE_COORDINATE, "theta", "time"]
        );
        let far = [("theta", 0.9), (AMPLITUDE_COORDINATE, 0.7), ("speed", 0.3)];
        assert_eq!(order(&far), ["theta", AMPLITUDE_COORDINATE, "speed"]);
        let before = [("time", 0.9), (AMPLITUDE_COORDINATE, 0.7), ("speed", 0.6)];
        assert_eq!(order(&before), ["time", AMPLITUDE_COORDINATE, "speed"]);
    }
}
