//! Whole teeth between the counts of recordings over one platen.
//!
//! Each courier sees the beacon, which has not moved. The beacon's place over the teeth is the courier's less its lever arm, and the arm is
//! known no better than the scale of the courier's angle, its span: 0.2 % of 9.7 mm is a fifth of a tooth at 90 mm. So there may be several
//! whole numbers of teeth, and the teeth themselves decide: of all shifts the one is taken under which both recordings' fields are one, by
//! the evidence (Teunissen 1995 for integers between receivers); and they are two platens where no shift makes one field of them.

use crate::begin::Beginning;
use crate::field_information::FieldInformation;
use crate::key::Platen;
use crate::state::{SPAN_M, STATE_VERSION, State};
use anyhow::{Context, Result, ensure};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Deviations of the beacon's place within which shifts are tried. Derived from the normal tail: one in 16,000 is beyond.
const WITHIN_DEVIATIONS: f64 = 4.0;
/// Teeth off a whole number within which a shift is tried even where its place is exact. Derived from the nearest: half of what
/// parts it from the next.
const BESIDE_TEETH: f64 = 0.25;
/// Most teeth to either side that are tried. A span that is a millimetre off puts the paper's arm of 90 mm off by 9 teeth; a prior besides.
const MOST_TEETH: f64 = 16.0;
/// Logarithm of the odds that a decision takes: a thousand to one, a choice.
const LOG_ODDS: f64 = 6.9;
/// Share by which two statements of one platen's pitch may differ. Derived from what aluminium, 23e-6 a kelvin, grows by in 40 K.
const PITCH_SHARE: f64 = 1.0e-3;

/// A platen as it is known so far.
struct Known<'a> {
    first: &'a Beginning,
    field: FieldInformation,
}

/// The state to start from. Of each platen the first recording's count is the platen's.
///
/// # Errors
/// Two recordings have one name, or another pitch; the teeth do not tell the shift, or are not the same.
pub fn register(beginnings: &[Beginning]) -> Result<State> {
    let mut state = State {
        courier_fleet_state: STATE_VERSION,
        ..State::default()
    };
    // By name: whose count a platen's is must not depend on the order in which recordings come.
    let mut beginnings: Vec<&Beginning> = beginnings.iter().collect();
    beginnings.sort_by(|a, b| a.recording.cmp(&b.recording));
    let mut known: BTreeMap<Platen, Known> = BTreeMap::new();
    for beginning in beginnings {
        let name = &beginning.recording;
        let platen = &beginning.placed.platen;
        let field = FieldInformation::of(platen, &beginning.sums, &beginning.state)
            .with_context(|| format!("{name}: found a reading that is no number, wanted none"))?;
        let mut placed = beginning.placed.clone();
        match known.get_mut(platen) {
            None => {
                let first = beginning;
                let seen_m = first.state.beacon_m(platen);
                state.beacons_m.insert(platen.clone(), seen_m);
                known.insert(platen.clone(), Known { first, field });
            }
            Some(known) => {
                check_pitch(beginning, known.first)?;
                placed.shift_teeth = shift(known, beginning, &field)?;
                known.field = known.field.plus(&field.shifted(placed.shift_teeth));
            }
        }
        let before = state.recordings.insert(name.clone(), placed);
        ensure!(
            before.is_none(),
            "{name}: found two recordings of this name, wanted one"
        );
        // Where each recording leads alone is no start: spans, arms and bows of lines are there as one recording likes them.
        for (key, value) in &beginning.plain.sensors {
            state.sensors.entry(key.clone()).or_insert(*value);
        }
        // For the weights of poses the waves that a courier's first recording tells alone are good enough.
        for (key, (value, _)) in &beginning.state.sensors {
            if key.courier().is_some() {
                state.weighing.entry(key.clone()).or_insert(*value);
            }
        }
    }
    Ok(state)
}

fn check_pitch(beginning: &Beginning, first: &Beginning) -> Result<()> {
    let difference = beginning.pitch_m / first.pitch_m - 1.0;
    ensure!(
        difference.abs() < PITCH_SHARE,
        "{}: recording.toml: pitch_m: found {} m, wanted {} m as in {}, which names the same platen",
        beginning.recording,
        beginning.pitch_m,
        first.pitch_m,
        first.recording
    );
    Ok(())
}

/// Teeth along an axis by which the platen's count is ahead, by the beacon alone.
fn teeth_ahead(first: &Beginning, other: &Beginning, axis: usize) -> f64 {
    let place_m = |of: &Beginning| {
        if first.placed.courier == other.placed.courier {
            of.seen_m[axis]
        } else {
            of.beacon_m[axis]
        }
    };
    (place_m(first) - place_m(other)) / first.pitch_m
}

/// Whole numbers of teeth along an axis by which the platen's count may be ahead.
fn candidates(first: &Beginning, other: &Beginning, axis: usize) -> std::ops::RangeInclusive<i32> {
    let teeth = teeth_ahead(first, other, axis);
    let off_m = if first.placed.courier == other.placed.courier {
        // The same arm, which is in what is compared.
        0.0
    } else {
        // What a recording alone tells of its span rests on how smooth teeth are taken to be: it is not believed below what a span may be off.
        let deviation_m = first.beacon_deviation_m[axis].hypot(other.beacon_deviation_m[axis]);
        (WITHIN_DEVIATIONS * deviation_m).max(SPAN_M / other.span_m * other.lever_m[axis].abs())
    };
    let within = (BESIDE_TEETH + off_m / first.pitch_m).min(MOST_TEETH);
    (teeth - within).ceil() as i32..=(teeth + within).floor() as i32
}

/// The shift under which both fields are one.
fn shift(known: &Known, other: &Beginning, field: &FieldInformation) -> Result<[i32; 2]> {
    let (name, first) = (&other.recording, &known.first.recording);
    let [x, y] = [0, 1].map(|axis| candidates(known.first, other, axis));
    let shifts: Vec<[i32; 2]> = x.flat_map(|x| y.clone().map(move |y| [x, y])).collect();
    let evidence = |shift: [i32; 2]| {
        known
            .field
            .plus(&field.clone().shifted(shift))
            .log_evidence()
    };
    let tried = shifts.into_par_iter().map(|shift| (shift, evidence(shift)));
    let mut tried: Vec<([i32; 2], f64)> = tried.collect();
    tried.sort_by(|a, b| b.1.total_cmp(&a.1));
    let off = [0, 1].map(|axis| {
        let teeth = teeth_ahead(known.first, other, axis);
        format!("{:+.2}", teeth - teeth.round())
    });
    let &[(best, log_best), ref rest @ ..] = tried.as_slice() else {
        anyhow::bail!(
            "{name}: the beacon: found it {} teeth off a whole number from where {first} has it, wanted within {BESIDE_TEETH}: it was moved, or this is another platen; state another beacon_id or platen_id",
            off.join(", ")
        );
    };
    let apart = known.field.log_evidence() + field.log_evidence();
    let log_odds = log_best - apart;
    ensure!(
        log_odds > LOG_ODDS || (rest.is_empty() && log_odds > -LOG_ODDS),
        "{name}: the teeth: found odds of e^{log_odds:.0} that they are those of {first}, wanted e^{LOG_ODDS}: another platen, a beacon that was moved, a courier of another make, whose segments average over other teeth, or no teeth in common; state another beacon_id or platen_id, fit that courier by itself, or add poses over the same teeth"
    );
    if let Some((second, log_second)) = rest.first() {
        let log_odds = log_best - log_second;
        ensure!(
            log_odds > LOG_ODDS,
            "{name}: whole teeth from {first}: found {best:?} or {second:?}, with odds of e^{log_odds:.1}, wanted e^{LOG_ODDS} or more: add poses over the same teeth"
        );
    }
    Ok(best)
}
