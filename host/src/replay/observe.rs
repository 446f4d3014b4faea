//! Rows of a recording through the firmware's signal path.

use courier_sensor::frame::{Coordinate, RawFrame, SEGMENTS};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::Observation;
use courier_sensor::settings::Settings;
use courier_sensor::step::{StepConfig, StepState, step};
use recording::Recording;

/// One row as the firmware and as f64 see it.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Which segments have an output.
    pub seen: [bool; SEGMENTS],
    /// By the firmware: phases from counts through its interpolation, or logged outputs as tooth count and phase.
    pub observation: Observation,
    /// The same outputs in f64 from the recording itself; 0 where not seen.
    pub unmodified_m: [f64; SEGMENTS],
    /// Where the reference puts each segment, equation (4).
    pub reference_m: [Option<f64>; SEGMENTS],
}

/// Runs the firmware's signal path over a recording.
#[derive(Debug)]
pub struct Observer {
    config: StepConfig,
    /// The recording's geometry as the firmware holds it; what it does not state is the paper's.
    pub geometry: Geometry,
    pitch_m: f64,
    span_m: f64,
}

impl Observer {
    /// For one recording.
    ///
    /// # Errors
    /// A geometry that the firmware refuses.
    pub fn new(recording: &Recording) -> anyhow::Result<Self> {
        let recorded = &recording.meta.geometry;
        let paper = Geometry::PAPER;
        let geometry = Geometry {
            pitch_m: recorded.pitch_m as f32,
            span_m: recorded.span_m.map_or(paper.span_m, |span| span as f32),
            lateral_m: recorded
                .lateral_m
                .map_or(paper.lateral_m, |lateral| lateral as f32),
            ..paper
        };
        Ok(Self {
            config: StepConfig::build(&Settings {
                geometry,
                ..Settings::default()
            })?,
            geometry,
            pitch_m: recorded.pitch_m,
            span_m: recorded.span_m.unwrap_or(f64::from(paper.span_m)),
        })
    }

    /// One row.
    pub fn sample(&self, recording: &Recording, index: usize) -> Sample {
        let samples = &recording.samples;
        let outputs: [Option<f64>; SEGMENTS] =
            std::array::from_fn(|segment| samples.unmodified_m(segment, index, self.pitch_m));
        let counts: [Option<[f64; 2]>; SEGMENTS] =
            std::array::from_fn(|segment| samples.quadrature_counts(segment, index));
        let phases = self.phases(&counts);
        let unmodified = std::array::from_fn(|segment| {
            let turns = outputs[segment].unwrap_or(0.0) / self.pitch_m;
            match phases[segment] {
                Some(phase) => Coordinate {
                    teeth: (turns - f64::from(phase)).round() as i32,
                    fraction_turns: phase,
                },
                None => coordinate(turns),
            }
        });
        let theta_rad = samples.row(index).reference[2].unwrap_or(0.0);
        let reference_m = std::array::from_fn(|segment| {
            let along = samples.row(index).reference[segment % 2]?;
            let side = if segment < 2 { 0.5 } else { -0.5 };
            Some(along + side * self.span_m * theta_rad)
        });
        Sample {
            seen: outputs.map(|output| output.is_some()),
            observation: Observation {
                unmodified,
                ..Observation::default()
            },
            unmodified_m: outputs.map(|output| output.unwrap_or(0.0)),
            reference_m,
        }
    }

    /// The firmware's phases, turns, of the segments with counts that its 16 bit converter can give.
    fn phases(&self, counts: &[Option<[f64; 2]>; SEGMENTS]) -> [Option<f32>; SEGMENTS] {
        let whole = counts
            .map(|pair| pair.and_then(|[sine, cosine]| Some([as_count(sine)?, as_count(cosine)?])));
        if whole.iter().all(Option::is_none) {
            return [None; SEGMENTS];
        }
        let raw = RawFrame {
            quadrature_counts: whole.map(Option::unwrap_or_default),
            ..RawFrame::default()
        };
        let frame = step(&self.config, &mut StepState::new(), &raw);
        std::array::from_fn(|segment| {
            whole[segment].map(|_| frame.segments[segment].unmodified.fraction_turns)
        })
    }
}

/// A count of a 16 bit converter; none if it is not whole or too large.
pub(super) fn as_count(value: f64) -> Option<i16> {
    (value.fract() == 0.0 && (f64::from(i16::MIN)..=f64::from(i16::MAX)).contains(&value))
        .then_some(value as i16)
}

/// A logged output in the firmware's form: whole teeth and a fraction in f32.
fn coordinate(turns: f64) -> Coordinate {
    let teeth = turns.round();
    Coordinate {
        teeth: teeth as i32,
        fraction_turns: (turns - teeth) as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::{Electronics, Geometry as Recorded, Meta, Row, Samples};

    /// Counts all round the circle, its ends included: the firmware's outputs and those of f64 are the same.
    #[test]
    fn counts_through_the_firmware_are_the_outputs_of_the_layout() {
        let mut samples = Samples::default();
        for step in 0..=1000_i32 {
            let turns = f64::from(step) / 1000.0 - 0.5;
            let (sine, cosine) = (turns * std::f64::consts::TAU).sin_cos();
            samples.push(&Row {
                t_s: f64::from(step),
                quadrature_counts: [
                    Some([(20_000.0 * sine).round(), (20_000.0 * cosine).round()]),
                    None,
                    None,
                    None,
                ],
                teeth: [Some(7), None, None, None],
                ..Row::default()
            });
        }
        let geometry = Recorded {
            pitch_m: 1.016e-3,
            span_m: None,
            lateral_m: None,
        };
        let meta = Meta {
            geometry,
            electronics: Electronics::default(),
            ..Meta::default()
        };
        let recording = Recording {
            meta,
            samples,
            warnings: Vec::new(),
        };
        let observer = Observer::new(&recording).unwrap();
        for index in 0..=1000 {
            let sample = observer.sample(&recording, index);
            let device_m = sample.observation.unmodified[0].metres(1.016e-3);
            let exact_m = sample.unmodified_m[0];
            assert!(
                (device_m - exact_m).abs() < 5.0e-9,
                "row {index}: {device_m} against {exact_m}"
            );
            assert_eq!(sample.seen, [true, false, false, false]);
        }
    }
}
