//! A recording by itself: without a field, where the crossed problem starts; with one, where the beacon stands in the recording's count.

use crate::key::{Key, Name};
use crate::member::Member;
use crate::solve::solve;
use crate::state::{Placed, State, sensors_of};
use crate::step::{advanced, is_settled};
use crate::sums::{Sums, sums_of};
use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use tooth_map::{FIRST_NOISE, Fit, Problem, Unknowns};

/// Most steps with a field. A bound on the work: what is not settled then is left to the crossed problem.
const STEPS_ALONE: u32 = 20;

/// What a recording says by itself.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Beginning {
    /// The recording's name.
    pub recording: Name,
    /// Courier and platen; no teeth are shifted yet.
    pub placed: Placed,
    /// Tooth pitch as entered, m.
    pub pitch_m: f64,
    /// Lever arms and span as entered, m.
    pub lever_m: [f64; 2],
    /// See [`Self::lever_m`].
    pub span_m: f64,
    /// Where it is seen from the platen sensor at angle zero, from the recording's count zero, m: b = o' + l. Recordings of one courier have one lever
    /// arm, so that their beacons are as far apart as these, whatever each takes the arm for.
    pub seen_m: [f64; 2],
    /// The beacon's place over the teeth, from the recording's count zero, m: o' of equation (11).
    pub beacon_m: [f64; 2],
    /// Its predicted deviation, m: that of the lever arm, above all.
    pub beacon_deviation_m: [f64; 2],
    /// Where nothing but what a plain joint calibration fits is known.
    pub plain: State,
    /// Where this recording alone leads, with a field and the spans.
    pub state: State,
    /// Sums at that state.
    pub sums: Sums,
}

/// Fits what a plain joint calibration fits, equations (3), (9) in its first order, (10) and (11), and then a field and the spans as well.
///
/// # Errors
/// A reading is no number.
pub fn begin(member: &Member) -> Result<Beginning> {
    let unknowns = Unknowns::new(member.grids);
    let problem = Problem {
        setup: &member.setup,
        unknowns: &unknowns,
        poses: &member.poses,
    };
    let mut fit = Fit::start(&problem, FIRST_NOISE);
    fit.improve(&problem, |i| unknowns.is_plain(i), &mut || ())
        .with_context(|| member.recording.clone())?;
    let placed = Placed {
        courier: member.courier.clone(),
        platen: member.platen.clone(),
        shift_teeth: [0; 2],
    };
    let place = unknowns.mounting() + 3;
    let seen_m = [fit.values[place], fit.values[place + 1]];
    let mut state = State {
        beacons_m: BTreeMap::from([(member.platen.clone(), seen_m)]),
        recordings: BTreeMap::from([(member.recording.clone(), placed.clone())]),
        sensors: sensors_of(member, &unknowns, &fit.values),
        // One recording tells too little of an aperture: it is not looked for.
        is_aperture_told: true,
        ..State::default()
    };
    let plain = state.clone();
    let (sums, solution) = loop {
        let (sums, shown) = sums_of(member, &state);
        let of_it = BTreeMap::from([(member.platen.clone(), sums.clone())]);
        let solution = solve(&of_it, &state, 0.0).with_context(|| member.recording.clone())?;
        if is_settled(&state, &solution) || state.steps == STEPS_ALONE {
            break (sums, solution);
        }
        state = advanced(
            &of_it,
            &state,
            &solution,
            [(member.recording.clone(), shown)],
        )?;
    };
    // What is fitted is b = o' + l, where the platen sensor is under the beacon at angle zero.
    let beacon = [0, 1].map(|axis| {
        let lever = Key::Courier(
            member.courier.clone(),
            (unknowns.mounting() + 1 + axis) as u16,
        );
        let place = Key::Recording(member.recording.clone(), 3 + axis as u16);
        [(place, 1.0), (lever, -1.0)]
    });
    let value = |f: &[(Key, f64)]| {
        f.iter()
            .map(|(k, w)| w * state.value(&member.platen, k))
            .sum()
    };
    Ok(Beginning {
        recording: member.recording.clone(),
        placed,
        seen_m: beacon.each_ref().map(|f| value(&f[..1])),
        pitch_m: member.setup.pitch_m,
        lever_m: member.setup.lever_m,
        span_m: member.setup.span_m,
        beacon_m: beacon.each_ref().map(|f| value(f)),
        beacon_deviation_m: beacon
            .each_ref()
            .map(|f| solution.posterior.deviation(&member.platen, f)),
        plain,
        state,
        sums,
    })
}
