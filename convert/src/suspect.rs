//! What a segment's travel beside the reference's says of what was stated: the warnings, each with the option that would mend it.

use crate::against::{misfit, ratio, slope};
use crate::columns::Values;
use crate::order::Order;
use crate::source::Step;
use crate::table::Log;
use crate::told::{Warning, figures};
use crate::units::Quantity;

/// Ratios are taken over pieces of a pitch. One this near to one is that of the same travel: the sensor's own error at both ends of a
/// piece makes 0.06 of it ([`OWN_ERROR_PITCHES`](crate::teeth::OWN_ERROR_PITCHES)), and the next unit or number of periods is farther off.
pub const SAME_TRAVEL: f64 = 0.1;
/// Two units are told apart by a ratio this near.
const NEAR: f64 = 0.03;
/// A segment that strays from its reference by more than this share of its travel does not follow it: a sensor that is over-ranged
/// over a single period strays by a tenth.
const FOLLOWS: f64 = 0.3;
/// Steps of the two that differ by less than this rms, whole pitches apart, are of one motion: a third of what they would by chance.
const FITS: f64 = 0.1;
/// A pitch is called wrong where it is so by this share …
const PITCH_OFF: f64 = 2.0e-3;
/// … and puts the end of the travel off by this many times the greatest distance that is left.
const PITCH_SEEN: f64 = 3.0;

/// A segment beside its reference.
pub struct Beside<'a> {
    /// The log.
    pub log: &'a Log,
    /// The conversion's options.
    pub order: &'a Order,
    /// 0 to 3.
    pub segment: usize,
    /// The reference.
    pub reference: &'a Values,
    /// Length of a signal period, m.
    pub pitch_m: f64,
    /// The segment's path, pitches.
    pub own: &'a [f64],
}

impl Beside<'_> {
    fn reference_pitches(&self) -> Vec<f64> {
        self.reference
            .values
            .iter()
            .map(|value_m| value_m / self.pitch_m)
            .collect()
    }

    /// The reference in pitches, where it travels as the segment does and may tell steps of over half a pitch.
    #[must_use]
    pub fn guide(&self) -> Option<Vec<f64>> {
        let reference = self.reference_pitches();
        let steps = reference.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let agrees = if steps.fold(0.0, f64::max) > 0.5 {
            // The counted path may be wrong, its phases are not: they must agree step by step.
            misfit(self.own, &reference) < FITS
        } else {
            (ratio(self.own, &reference)? - 1.0).abs() < SAME_TRAVEL
                && self.strays(&reference) < FOLLOWS
        };
        agrees.then_some(reference)
    }

    /// Greatest distance from the reference, whatever its scale and sign, over the segment's travel.
    fn strays(&self, reference: &[f64]) -> f64 {
        let finite = || self.own.iter().copied().filter(|place| place.is_finite());
        let travel =
            finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min);
        slope(self.own, reference).map_or(0.0, |(_, distance)| distance / travel)
    }

    /// What looks wrong.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let reference = self.reference_pitches();
        let Some(ratio) = ratio(self.own, &reference) else {
            return Vec::new();
        };
        let strays = self.strays(&reference);
        if strays > FOLLOWS {
            let what = format!(
                "segment {} does not follow {}: it strays from it by {:.0} % of its travel",
                self.segment + 1,
                self.reference.column.name(),
                100.0 * strays
            );
            let mend = format!(
                "look whether {} is of the same axis and motion",
                self.reference
                    .source
                    .text(self.log, &self.reference.source.unit, "")
            );
            return vec![Warning { what, mend }];
        }
        let mut warnings: Vec<Warning> = [self.sign(ratio), self.size(ratio.abs())]
            .into_iter()
            .flatten()
            .collect();
        if warnings.is_empty() {
            warnings.extend(self.pitch(&reference));
        }
        warnings
    }

    fn sign(&self, ratio: f64) -> Option<Warning> {
        (ratio < 0.0).then(|| {
            let source = &self.reference.source;
            let own = self.segment + 1;
            let turned = match source.steps.iter().position(|step| *step == Step::Times(-1.0)) {
                Some(place) => {
                    let mut other = source.clone();
                    other.steps.remove(place);
                    other.text(self.log, &source.unit, "")
                }
                None => source.text(self.log, &source.unit, "*-1"),
            };
            Warning {
                what: format!("segment {own} counts down where {} rises", self.reference.column.name()),
                mend: format!("{turned} if the reference's sign is wrong, or exchange the columns of q{own}s and q{own}c"),
            }
        })
    }

    /// Travel of another size: another unit, another number of periods a turn, another pitch.
    fn size(&self, ratio: f64) -> Option<Warning> {
        if (ratio - 1.0).abs() < SAME_TRAVEL {
            return None;
        }
        let source = &self.reference.source;
        let name = self.reference.column.name();
        let what = format!(
            "segment {} travels {} times as far as {name}",
            self.segment + 1,
            figures(ratio)
        );
        let near = |wanted: f64| (ratio / wanted - 1.0).abs() < NEAR;
        let units = Quantity::of(self.reference.column).units();
        let other = units.iter().find(|unit| {
            unit.of_turn == source.unit.of_turn && near(unit.factor / source.unit.factor)
        });
        let mend = match other {
            Some(unit) => source.text(self.log, unit, ""),
            None if source.unit.of_turn && ratio > 1.5 && near(ratio.round()) => {
                format!(
                    "--periods-per-turn {}",
                    figures(ratio.round() * self.order.periods_per_turn.unwrap_or(1.0))
                )
            }
            None => format!(
                "--pitch {}m, or a factor as in {}",
                figures(self.pitch_m / ratio),
                source.text(self.log, &source.unit, &format!("*{}", figures(ratio)))
            ),
        };
        Some(Warning { what, mend })
    }

    /// Travel of nearly the same size: a pitch that is a little wrong.
    fn pitch(&self, reference: &[f64]) -> Option<Warning> {
        let (slope, distance) = slope(self.own, reference)?;
        let finite = || reference.iter().copied().filter(|place| place.is_finite());
        let travel =
            finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min);
        let off = slope - 1.0;
        (off.abs() > PITCH_OFF && off.abs() * travel > PITCH_SEEN * distance).then(|| Warning {
            what: format!(
                "segment {} travels {:+.2} % further than {}",
                self.segment + 1,
                100.0 * off,
                self.reference.column.name()
            ),
            mend: format!(
                "--pitch {}m if the pitch is wrong, else the reference's unit or factor",
                figures(self.pitch_m / slope)
            ),
        })
    }
}
