//! A calibration that the host ordered: how it starts, and what is said of it.

use super::background::{Background, Errand};
use crate::calibration::joint::JointConfig;
use crate::calibration::record::Method;
use crate::calibration::{Range, SessionConfig, Visits};
use crate::link::message::{CalibrateOrder, Refusal};
use crate::link::report::{Ending, Progress};
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

/// A session as ordered, over the defaults of [`SessionConfig`], which is set in its place: a copy is a kilobyte.
#[inline(never)]
#[allow(clippy::field_reassign_with_default)]
pub(super) fn calibrate<S, F>(
    order: &CalibrateOrder,
    background: &mut Background<'_, '_, S, F>,
) -> Result<(), Refusal>
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    let mut config = SessionConfig::default();
    set_visits(order, &mut config.visits, rate_hz(background));
    config.target_deviation_m = order.target_deviation_m;
    background.calibrate(&mut config, errand_of(order))
}

/// A joint session as ordered, over the defaults of [`JointConfig`].
#[inline(never)]
#[allow(clippy::field_reassign_with_default)]
pub(super) fn calibrate_joint<S, F>(
    order: &CalibrateOrder,
    background: &mut Background<'_, '_, S, F>,
) -> Result<(), Refusal>
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    let mut config = JointConfig::default();
    set_visits(order, &mut config.visits, rate_hz(background));
    background.calibrate_joint(&mut config, errand_of(order))
}

fn errand_of(order: &CalibrateOrder) -> Errand {
    Errand {
        speed_m_per_s: order.speed_m_per_s,
        commit: order.commit,
    }
}

fn rate_hz<S, F>(background: &Background<'_, '_, S, F>) -> f32
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    background.keeper().settings().rate_hz
}

/// The default settle limit is for the way to settle by; the way itself takes longer the longer it is. Twice the time that the longest
/// way, a diagonal, takes at the highest speed: a motion that starts and ends at rest without jerks takes 15/8 of it.
fn set_visits(order: &CalibrateOrder, visits: &mut Visits, rate_hz: f32) {
    let way_s = core::f32::consts::SQRT_2 * order.travel_m / order.speed_m_per_s;
    visits.settle_limit += (2.0 * way_s * rate_hz) as u32;
    visits.poses = order.poses.into();
    visits.held_out_poses = order.held_out_poses.into();
    visits.plan = order.plan;
    visits.seed = order.seed;
    visits.range = Range {
        travel_m: order.travel_m,
        turn_rad: order.turn_rad,
    };
}

/// How far the session is, or how the last one ended.
#[inline(never)]
pub(super) fn progress<S, F>(background: &Background<'_, '_, S, F>) -> Progress
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    let session = background.progress();
    let ending = background.ended().map(|ended| {
        let evidence = ended.evidence;
        match (ended.result, ended.not_kept) {
            (Err(refusal), _) => Ending::Refused { refusal, evidence },
            (Ok(_), Some(refusal)) => Ending::NotKept { evidence, refusal },
            (Ok(stored), None) => Ending::Accepted { evidence, stored },
        }
    });
    Progress {
        method: background.method(),
        stage: session.stage,
        done: session.done,
        of: session.of,
        lost: session.lost,
        worst_deviation_m: session.worst_deviation_m,
        steps: core::array::from_fn(|i| {
            let made = background.reports().get(i).copied();
            made.filter(|_| background.method() == Method::Joint)
        }),
        ending,
    }
}
