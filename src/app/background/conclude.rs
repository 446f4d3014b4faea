//! What a session leaves that has ended: its result as a calibration's record, in force and stored, or why not.

use super::{Background, Ended};
use crate::app::task::Task;
use crate::calibration::joint::JointResult;
use crate::calibration::record::{Beacon, Calibration, Gauge, Method, Quality};
use crate::calibration::{Evidence, Refusal as SessionRefusal};
use crate::model::ErrorModel;
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

impl<S, F> Background<'_, '_, S, F>
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    /// Keeps what the session came to, and writes that down.
    pub(super) fn conclude_task(&mut self) {
        self.keep_outcome();
        self.keep_event(None, false);
    }

    #[inline(never)] // a calibration on the stack, and only here for a moment
    fn keep_outcome(&mut self) {
        let mut calibration = Calibration::identity(self.keeper.settings().geometry);
        let Some((result, evidence)) = self.outcome(&mut calibration) else {
            return;
        };
        self.ended = Some(match result {
            Ok(()) => self.keep(&calibration, evidence),
            Err(refusal) => Ended {
                evidence,
                result: Err(refusal),
                not_kept: None,
            },
        });
    }

    /// What the session came to, once it has: writes the record that is to be kept, or tells why there is none.
    #[inline(never)]
    fn outcome(&self, record: &mut Calibration) -> Option<(Result<(), SessionRefusal>, Evidence)> {
        match &*self.task {
            Task::Idle | Task::Watch(_) => None,
            Task::Platen(session) => session.outcome().map(|outcome| {
                let result = outcome.result.as_ref().map_err(|refusal| *refusal);
                let written = result.map(|model| self.record(model, &outcome.evidence, record));
                record.poses = session.poses();
                (written, outcome.evidence)
            }),
            Task::Joint(session) => session.outcome().map(|outcome| {
                let result = outcome.result.as_ref().map_err(|refusal| *refusal);
                let written =
                    result.map(|result| self.joint_record(result, &outcome.evidence, record));
                (written, outcome.evidence)
            }),
        }
    }

    /// Puts an accepted calibration in force, stored first if that was ordered.
    fn keep(&mut self, calibration: &Calibration, evidence: Evidence) -> Ended {
        let kept = if self.errand.commit {
            self.keeper.store(calibration).map(Some)
        } else {
            self.keeper.load(calibration).map(|()| None)
        };
        let (place, not_kept) = match kept {
            Ok(place) => (place, None),
            Err(refusal) => (None, Some(refusal)),
        };
        Ended {
            evidence,
            result: Ok(place),
            not_kept,
        }
    }

    fn joint_record(&self, result: &JointResult, evidence: &Evidence, record: &mut Calibration) {
        self.record(&result.model, evidence, record);
        record.method = Method::Joint;
        record.gauge = Gauge::OffsetsSpreadBeaconFree;
        record.geometry = result.geometry;
        record.beacon = Some(Beacon {
            origin_teeth: result.origin_teeth,
            origin_m: result.origin_m,
            sensor: result.sensor,
            segment_sd_m: result.noise.segment_m,
            displacement_sd_m: result.noise.displacement_m,
        });
    }

    /// Writes a platen calibration's record, every field of it.
    fn record(&self, model: &ErrorModel, evidence: &Evidence, record: &mut Calibration) {
        let settings = self.keeper.settings();
        let Calibration {
            device,
            made,
            temperature_c,
            method,
            gauge,
            amplitude_counts,
            geometry,
            pairs,
            model: stored,
            beacon,
            quality: summary,
            poses,
        } = record;
        *device = self.keeper.device();
        *made = self.time();
        *temperature_c = self.reference_c() + evidence.temperature_delta_k;
        (*method, *gauge) = (Method::Platen, Gauge::OffsetsSpread);
        *amplitude_counts = evidence.amplitude_counts;
        (*geometry, *pairs) = (settings.geometry, settings.pairs);
        stored.clone_from(model);
        *beacon = None;
        *summary = quality(evidence);
        *poses = None;
    }
}

fn quality(evidence: &Evidence) -> Quality {
    let count = |n: u32| u16::try_from(n).unwrap_or(u16::MAX);
    Quality {
        residual_before_m: evidence.held_out_in_force_m,
        residual_after_m: evidence.held_out_m,
        predicted_worst_m: evidence.worst_deviation_m,
        condition_number: evidence.condition,
        rank: count(evidence.rank),
        unknowns: count(evidence.unknowns),
        poses: count(evidence.poses),
        rejected: count(evidence.lost),
    }
}
