//! What the board saw at each pose of a joint session: the same averages that the session takes, for another method to fit.

use courier_sensor::calibration::joint::{JointBuffer, JointSample};
use courier_sensor::calibration::{Progress, Sample, Stage};
use courier_sensor::frame::{Frame, SEGMENTS};
use std::collections::VecDeque;

/// Frames and the session's progress go in, averaged poses come out.
pub struct Poses {
    frames: VecDeque<Frame>,
    averaged: usize,
    full_scale: f32,
    last: Progress,
    origin_teeth: [i32; SEGMENTS],
    /// Poses in the order of their visit.
    pub buffer: Box<JointBuffer>,
}

impl Poses {
    /// For a session that averages so many frames a pose, at this full scale of tan psi.
    pub fn new(averaged: u32, full_scale: f32, start: Progress) -> Self {
        Self {
            frames: VecDeque::new(),
            averaged: averaged as usize,
            full_scale,
            last: start,
            origin_teeth: [0; SEGMENTS],
            buffer: Box::new(JointBuffer::new()),
        }
    }

    /// A frame, and how far the session was after it.
    pub fn see(&mut self, frame: &Frame, now: Progress) {
        if self.frames.len() == self.averaged {
            self.frames.pop_front();
        }
        self.frames.push_back(*frame);
        let before = core::mem::replace(&mut self.last, now);
        if (before.stage, before.done) == (now.stage, now.done) || now.stage == Stage::Finished {
            return;
        }
        if before.stage == Stage::Origin {
            let [x, y] = [0, 1].map(|i: usize| self.mean().0.unmodified[i].teeth);
            self.origin_teeth = [x, y, x, y];
        } else if now.lost == before.lost {
            let (sample, deflection) = self.mean();
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
