//! The segments: counts, tooth counts and places of each, with what was noticed on the way.

use crate::columns::Values;
use crate::order::Order;
use crate::pair::{Converter, NOISE_COUNTS_WANTED, Pair, bits_for, off_centre, scaling, whole};
use crate::suspect::Beside;
use crate::table::Log;
use crate::teeth::count;
use crate::told::{Told, ToldPair, figures};
use recording::noise::ROUNDING_VARIANCE;
use recording::noise::in_motion::{Scatter, scatter, step};
use recording::{Column, Error};
use std::path::Path;

/// One segment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Segment {
    /// 0 to 3.
    pub number: usize,
    /// Whole counts `[sine, cosine]`, where there are any; NaN where not measured.
    pub counts: Option<[Vec<f64>; 2]>,
    /// Tooth counts; NaN where not measured.
    pub teeth: Vec<f64>,
    /// Logged positions, m.
    pub position_m: Option<Vec<f64>>,
    /// The output, pitches; NaN where not measured.
    pub place: Vec<f64>,
    /// Its noise, counts or m, where it could be measured.
    pub noise: Option<Scatter>,
    /// Counts: amplitude.
    pub amplitude_counts: f64,
}

/// Everything that segments are made from.
pub struct Given<'a> {
    /// The file, for errors.
    pub file: &'a Path,
    /// The log.
    pub log: &'a Log,
    /// Options.
    pub order: &'a Order,
    /// Columns in the recording's units.
    pub values: &'a [Values],
    /// Length of a signal period, m.
    pub pitch_m: f64,
    /// True where a row came one interval after the one before.
    pub follows: &'a [bool],
}

/// A pair on rounder figures than this of its radius is no circle: of a sensor with 10 % between its gains it is 0.05.
const ROUND: f64 = 0.25;
/// A log with a larger share of unsure steps than this cannot be counted.
const UNSURE_SHARE: f64 = 0.01;

impl Given<'_> {
    fn column(&self, column: Column) -> Option<&Values> {
        self.values.iter().find(|values| values.column == column)
    }

    fn pair(&self, segment: usize) -> Option<[&[f64]; 2]> {
        Some([
            self.column(Column::Sine(segment))?.values.as_slice(),
            self.column(Column::Cosine(segment))?.values.as_slice(),
        ])
    }

    fn reference(&self, segment: usize) -> Option<&Values> {
        self.column(Column::Reference(segment % 2))
    }

    /// All segments, and the bits of the converter where there are counts.
    ///
    /// # Errors
    /// Steps of over half a pitch that nothing tells apart.
    pub fn segments(&self, told: &mut Told) -> Result<(Vec<Segment>, Option<u32>), Error> {
        let (pairs, bits) = self.pairs(told);
        let mut segments = Vec::new();
        for (number, pair) in pairs.into_iter().enumerate() {
            let position = self.column(Column::Position(number));
            if pair.is_none() && position.is_none() {
                continue;
            }
            let mut segment = match pair {
                Some(pair) => self.counted(number, &pair, told)?,
                None => Segment {
                    number,
                    ..Segment::default()
                },
            };
            if let Some(position) = position {
                self.positioned(&mut segment, &position.values);
            }
            self.beside(&segment, told);
            segments.push(segment);
        }
        Ok((segments, bits))
    }

    /// Pairs of all segments on one scale.
    fn pairs(&self, told: &mut Told) -> ([Option<Pair>; 4], Option<u32>) {
        let pairs: [Option<[&[f64]; 2]>; 4] = std::array::from_fn(|segment| self.pair(segment));
        let centres = pairs.map(|pair| pair.and_then(off_centre));
        let all = || pairs.iter().flatten();
        if all().next().is_none() {
            return ([const { None }; 4], None);
        }
        let counts = all().all(|pair| whole(*pair));
        let centre = |segment: usize| {
            centres[segment].map_or([0.0; 2], |c| if counts { c.map(f64::round) } else { c })
        };
        for (segment, _) in centres
            .iter()
            .enumerate()
            .filter(|(_, centre)| centre.is_some())
        {
            let [sine, cosine] = centre(segment);
            let what = format!(
                "q{0}s and q{0}c lie about {1} and {2}, which were taken off",
                segment + 1,
                figures(sine),
                figures(cosine)
            );
            told.assume(
                what,
                format!("--column q{}s=COLUMN-{}", segment + 1, figures(sine)),
            );
        }
        let largest = (0..4)
            .filter_map(|segment| Some(largest(pairs[segment]?, centre(segment))))
            .fold(0.0, f64::max);
        let (bits, scale) = match counts {
            true => (
                self.order
                    .stated
                    .adc_bits
                    .unwrap_or_else(|| bits_for(largest)),
                1.0,
            ),
            false => self.scale(&pairs, &centre, largest, told),
        };
        if counts && self.order.stated.adc_bits.is_none() {
            told.assume(
                format!("counts are of a converter of {bits} bits with sign"),
                "--adc-bits N",
            );
        }
        let is_there = |segment: &usize| pairs[*segment].is_some();
        told.pairs = (0..4)
            .filter(is_there)
            .map(|segment| ToldPair {
                segment,
                centre: centre(segment),
                scale,
            })
            .collect();
        let made =
            std::array::from_fn(|segment| Some(Pair::new(pairs[segment]?, centre(segment), scale)));
        (made, Some(bits))
    }

    fn scale(
        &self,
        pairs: &[Option<[&[f64]; 2]>; 4],
        centre: &dyn Fn(usize) -> [f64; 2],
        largest: f64,
        told: &mut Told,
    ) -> (u32, f64) {
        /// Finer than any log.
        const FINE: f64 = 1.0e7;
        let fine = FINE / largest.max(f64::MIN_POSITIVE);
        let noises = (0..4).filter_map(|segment| {
            let pair = Pair::new(pairs[segment]?, centre(segment), fine);
            Some(
                self.noise_of(&pair, &count(&pair.phase_turns, None).turns)?
                    .rms
                    / fine,
            )
        });
        let noise = noises.fold(f64::INFINITY, f64::min);
        let noise = if noise.is_finite() { noise } else { 0.0 };
        let stated = &self.order.stated;
        let (bits, scale) = scaling(
            largest,
            noise,
            Converter {
                bits: stated.adc_bits,
                full_scale: stated.full_scale,
            },
        );
        let option = if stated.full_scale.is_some() {
            "--adc-bits N"
        } else {
            "--full-scale VALUE and --adc-bits N"
        };
        let what = format!(
            "sine and cosine are no whole counts: 1 of the log's unit is {} counts of {bits} bits; rounding adds {:.2} counts to a noise of {}",
            figures(scale),
            ROUNDING_VARIANCE.sqrt(),
            figures(noise * scale)
        );
        told.assume(what, option);
        if noise > 0.0 && noise * scale < NOISE_COUNTS_WANTED {
            told.warn(
                format!(
                    "rounding to counts is not small beside the noise of {} counts",
                    figures(noise * scale)
                ),
                "--adc-bits with more bits",
            );
        }
        (bits, scale)
    }

    fn noise_of(&self, pair: &Pair, turns: &[f64]) -> Option<Scatter> {
        let [radius, way] = pair.polar(turns);
        scatter(&[&radius, &way], turns, self.follows)
    }

    /// A pair with its tooth count: the log's, or by the phase.
    fn counted(&self, number: usize, pair: &Pair, told: &mut Told) -> Result<Segment, Error> {
        let no_circle = (pair.roundness > ROUND).then(|| {
            let what = format!(
                "q{0}s and q{0}c on no circle: its radius varies by {1:.0} %",
                number + 1,
                100.0 * pair.roundness
            );
            let mend = format!(
                "one sensor's sine and cosine, --column q{0}s=COLUMN --column q{0}c=COLUMN",
                number + 1
            );
            (what, mend)
        });
        let (teeth, place) = match self.column(Column::Teeth(number)) {
            Some(logged) => {
                let place = logged
                    .values
                    .iter()
                    .zip(&pair.phase_turns)
                    .map(|(teeth, phase)| teeth + phase)
                    .collect();
                (logged.values.clone(), place)
            }
            None => {
                let counted = self.count(number, &pair.phase_turns, told);
                // A phase that jumps about is explained by a pair that is none.
                counted.map_err(|error| match &no_circle {
                    Some((what, mend)) => Error::new(self.file, what.as_str(), mend.as_str()),
                    None => error,
                })?
            }
        };
        if let Some((what, mend)) = no_circle {
            told.warn(what, mend);
        }
        let rounding = if pair.scale == 1.0 {
            ROUNDING_VARIANCE
        } else {
            0.0
        };
        let noise = self.noise_of(pair, &place).map(|noise| Scatter {
            rms: (noise.rms.powi(2) - rounding).max(0.0).sqrt(),
            ..noise
        });
        Ok(Segment {
            number,
            counts: Some(pair.counts.clone()),
            teeth,
            place,
            noise,
            amplitude_counts: pair.amplitude_counts,
            position_m: None,
        })
    }

    /// Tooth counts by the phase, and the places.
    fn count(
        &self,
        number: usize,
        phases: &[f64],
        told: &mut Told,
    ) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let alone = count(phases, None);
        let reference = self.reference(number);
        let guide =
            reference.and_then(|reference| self.against(number, reference, &alone.turns).guide());
        let counted = match &guide {
            Some(guide) => count(phases, Some(guide)),
            None => alone,
        };
        let name = format!("n{}", number + 1);
        let largest = figures(counted.largest_step);
        told.did(match counted.guided {
            0 => format!("{name} by following the phase of q{0}s and q{0}c: steps of up to {largest} pitches", number + 1),
            steps => format!("{name} by following the phase of q{0}s and q{0}c; {steps} steps of over half a pitch, up to {largest}, by the reference", number + 1),
        });
        if let Some(row) = counted.first_unsure {
            let steps = counted.teeth.iter().flatten().count().max(1);
            let line = self.log.lines[row];
            let found = format!(
                "{} of {steps} steps that may be half a pitch and more",
                counted.unsure
            );
            let wanted = "quicker sampling or a slower motion, a reference to tell them apart (--column ref_x_m=…), or a logged count (--column n1=…)";
            if counted.unsure as f64 > UNSURE_SHARE * steps as f64 {
                return Err(Error::new(self.file, found, wanted).row(line).column(&name));
            }
            told.warn(format!("{name}: {found}, the first at row {line}: the count may be whole teeth off from there on"), wanted);
        }
        let teeth = counted
            .teeth
            .iter()
            .map(|teeth| teeth.map_or(f64::NAN, f64::from))
            .collect();
        Ok((teeth, counted.turns))
    }

    fn positioned(&self, segment: &mut Segment, position_m: &[f64]) {
        let place: Vec<f64> = position_m
            .iter()
            .map(|place_m| place_m / self.pitch_m)
            .collect();
        segment.position_m = Some(position_m.to_vec());
        if segment.counts.is_none() {
            let written_m = step(position_m).unwrap_or(0.0) * ROUNDING_VARIANCE.sqrt();
            segment.noise = scatter(&[position_m], &place, self.follows).map(|noise| Scatter {
                rms: noise.rms.max(written_m),
                ..noise
            });
            segment.place = place;
        }
    }

    fn against<'a>(&'a self, segment: usize, reference: &'a Values, own: &'a [f64]) -> Beside<'a> {
        Beside {
            log: self.log,
            order: self.order,
            segment,
            reference,
            pitch_m: self.pitch_m,
            own,
        }
    }

    fn beside(&self, segment: &Segment, told: &mut Told) {
        if let Some(reference) = self.reference(segment.number) {
            told.warnings.extend(
                self.against(segment.number, reference, &segment.place)
                    .warnings(),
            );
        }
    }
}

fn largest([sine, cosine]: [&[f64]; 2], centre: [f64; 2]) -> f64 {
    let of = |channel: &[f64], centre: f64| {
        channel
            .iter()
            .filter(|value| value.is_finite())
            .map(|value| (value - centre).abs())
            .fold(0.0, f64::max)
    };
    of(sine, centre[0]).max(of(cosine, centre[1]))
}
