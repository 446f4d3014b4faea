//! What the board saw at each pose of a joint session: the same averages that the session takes, for another method to fit, and
//! for the tooth map.

use crate::teeth::TeethPose;
use courier_sensor::calibration::joint::{JointBuffer, JointSample};
use courier_sensor::calibration::{Progress, Sample, Stage};
use courier_sensor::frame::{Frame, SEGMENTS};
use courier_sensor::geometry::Geometry;
use std::collections::VecDeque;

/// Frames and the session's progress go in, averaged poses come out.
pub struct Poses {
    frames: VecDeque<Frame>,
    averaged: usize,
    full_scale: f32,
    last: Progress,
    origin_teeth: [i32; SEGMENTS],
    pitch_m: f64,
    /// Poses in the order of their visit.
    pub buffer: Box<JointBuffer>,
    /// The same in metres from the board's tooth count zero.
    pub teeth: Vec<TeethPose>,
}

impl Poses {
    /// For a session that averages so many frames a pose.
    pub fn new(averaged: u32, geometry: &Geometry, start: Progress) -> Self {
        Self {
            frames: VecDeque::new(),
            averaged: averaged as usize,
            full_scale: geometry.tan_full_scale,
            pitch_m: f64::from(geometry.pitch_m),
            last: start,
            origin_teeth: [0; SEGMENTS],
            buffer: Box::new(JointBuffer::new()),
            teeth: Vec::new(),
        }
    }

    /// A frame, and how far the session was after it.
    pub fn see(&mut self, frame: &Frame, now: Progress) {
        if self.frames.len() == self.averaged {
            self.frames.pop_front();
        }
        self.frames.push_back(*frame);
        let before = core::mem::replace(&mut self.last, now);
        let is_visiting = now.stage != Stage::Finished && before.stage != Stage::Solving;
        if !is_visiting || (before.stage, before.done) == (now.stage, now.done) {
            return;
        }
        if before.stage == Stage::Origin {
            let [x, y] = [0, 1].map(|i: usize| self.mean().0.unmodified[i].teeth);
            self.origin_teeth = [x, y, x, y];
        } else if now.lost == before.lost {
            let (sample, deflection) = self.mean();
            self.teeth.push(TeethPose {
                outputs_m: sample
                    .unmodified
                    .map(|output| output.metres(self.pitch_m as f32)),
                deflection: deflection.map(f64::from),
            });
            if let Some(sample) = JointSample::new(&self.origin_teeth, &sample, deflection) {
                self.buffer.push(sample);
            }
        }
        if before.stage == Stage::Fit && now.stage == Stage::HeldOut {
            self.buffer.hold_out_rest();
        }
    }

    fn mean(&self) -> (Sample, [f32; 2]) {
        let share = 1.0 / self.frames.len() as f32;
        let mut sample = self.frames.front().map_or(Sample::ZERO, Sample::of);
        let first = sample.unmodified;
        let mut deflection = [0.0; 2];
        for frame in &self.frames {
            for ((mean, first), segment) in
                sample.unmodified.iter_mut().zip(first).zip(&frame.segments)
            {
                mean.fraction_turns += share * segment.unmodified.minus_turns(first);
            }
            for (mean, tan_psi) in deflection.iter_mut().zip(frame.tan_psi) {
                *mean += share * tan_psi / self.full_scale;
            }
        }
        (sample, deflection)
    }
}
