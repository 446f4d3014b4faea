//! Sums add in any grouping, parts are files, and recordings that do not go together are refused.

use crate::simulated::{member, ruled};
use effects::axis_skew::AxisSkew;
use fleet::{DIODE_SHEAR, Key, Member, Part, Platen, State, answer, begin, fit, register, sums_of};

fn three() -> [Member; 3] {
    let askew = AxisSkew {
        skew_rad: 1.5e-3,
        pitch_difference: 0.0,
        bow_per_m: 0.0,
    };
    [1, 2, 3].map(|c| ruled(askew, [c, 5, 50 + c], 130, 1.5))
}

/// Through its file: JSON.
fn stored(part: &Part) -> Part {
    serde_json::from_str(&serde_json::to_string(part).unwrap()).unwrap()
}

/// An engine's tree of parts leads to where the whole fit leads.
#[test]
fn parts_that_are_added_in_any_grouping_lead_to_the_same() {
    let members = three();
    let mut state: Option<State> = None;
    loop {
        let parts = members
            .each_ref()
            .map(|m| stored(&Part::of(m, state.as_ref()).unwrap()));
        let [a, b, c] = parts;
        let whole = Part::join([c, stored(&Part::join([b, a]).unwrap())]).unwrap();
        let (next, progress) = whole.next(state.as_ref()).unwrap();
        if progress.is_settled {
            break;
        }
        assert!(progress.steps < 25);
        state = Some(next);
    }
    let state = state.unwrap();
    let fitted = fit(&members, &|| ()).unwrap();
    assert_eq!(state.steps, fitted.state.steps);
    let platen = &members[0].platen;
    for (key, (value, prior)) in &fitted.state.sensors {
        let difference = (state.value(platen, key) - value) / prior.deviation;
        assert!(difference.abs() < 1e-6, "{key:?}: {difference:e}");
    }
    // Of one platen neither is told by itself: diodes whose axes are so look the same.
    let answer = answer(&members, &fitted).unwrap();
    let of_it = &answer.platens[0];
    for told in [of_it.out_of_square_rad, of_it.pitch_difference] {
        assert!(!told.is_told() && !told.is_told_alone(), "{told:?}");
    }
}

#[test]
fn parts_that_do_not_go_together_are_refused() {
    let members = three();
    let start = Part::of(&members[0], None).unwrap();
    let (state, _) = start.next(None).unwrap();
    let there = Part::of(&members[0], Some(&state)).unwrap();
    let wrong = |result: anyhow::Result<Part>| result.unwrap_err().to_string();
    let told = wrong(Part::join([start.clone(), there.clone()]));
    assert!(told.contains("no and 0 steps"), "{told}");
    let told = wrong(Part::join([there.clone(), there.clone()]));
    assert!(told.contains("in two parts"), "{told}");
    let told = wrong(Part::of(&members[1], Some(&state)));
    assert!(told.contains("no recording of the state"), "{told}");
    let told = start.next(Some(&state)).unwrap_err().to_string();
    assert!(told.contains("wanted them alike"), "{told}");
}

/// A file that was spoilt or made by another version is refused, and no panic.
#[test]
fn spoilt_parts_and_states_are_refused() {
    let member = &three()[0];
    let start = Part::of(member, None).unwrap();
    let (mut state, _) = start.next(None).unwrap();
    let there = serde_json::to_string(&Part::of(member, Some(&state)).unwrap()).unwrap();
    let told = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut value = serde_json::from_str(&there).unwrap();
        change(&mut value);
        let part: Part = serde_json::from_str(&value.to_string()).unwrap();
        part.next(Some(&state)).err().unwrap().to_string()
    };
    let short = told(&|part| part["sums"][0][1]["right"] = [1.0].into());
    assert!(short.contains("1 right sides"), "{short}");
    let disordered = told(&|part| {
        part["sums"][0][1]["columns"]
            .as_array_mut()
            .unwrap()
            .reverse()
    });
    assert!(disordered.contains("out of order"), "{disordered}");
    let older = told(&|part| part["courier_fleet_part"] = 0.into());
    assert!(older.contains("another version"), "{older}");
    state.check().unwrap();
    state.courier_fleet_state += 1;
    assert!(state.check().is_err());
}

/// The derivatives by all kinds of unknowns, where fields and waves are in force, against a difference of what is left.
#[test]
fn derivatives_are_those_of_what_is_left() {
    let member = member(1, 5, 1, 130, 1.5);
    let beginning = begin(&member).unwrap();
    let state = beginning.state.clone();
    let (sums, _) = sums_of(&member, &state);
    let (mut tried, platen) = (0, &member.platen);
    for (k, (key, prior)) in sums.columns.iter().enumerate() {
        // Of many nodes some; a beacon's place is told so well that its prior's step leaves the straight part.
        let is_left_out = match key {
            Key::Node(..) => k % 9 != 0,
            Key::Recording(_, number) => *number >= 3,
            _ => false,
        };
        if is_left_out {
            continue;
        }
        tried += 1;
        // With rows r + J d of unit noise the squares' difference over 2 d is -J r: the right side.
        let unit = 1.0e-3 * prior.deviation;
        let mut squares = [1.0, -1.0].map(|sign| {
            let mut moved = state.clone();
            moved.add(platen, key, sign * unit);
            sums_of(&member, &moved).0.squares
        });
        squares.iter_mut().for_each(|s| *s *= 0.5);
        let wanted = -(squares[0] - squares[1]) / 2.0e-3;
        let found = sums.right[k];
        let scale = (sums.gram[(k, k)] * sums.squares).sqrt();
        assert!(
            (found - wanted).abs() <= 0.01 * scale,
            "{key:?}: {found} {wanted} of {scale}"
        );
    }
    assert!(tried > 200, "{tried}");
}

/// What poses leave is the same again where a diode's axes were turned toward each other and its shear says so, and is not where it does not.
#[test]
fn a_diode_s_shear_takes_back_what_its_axes_do() {
    let shear_rad = 1.0e-3;
    let straight = member(1, 5, 1, 130, 1.5);
    let mut turned = straight.clone();
    for pose in &mut turned.poses {
        let [u, v] = pose.deflection;
        pose.deflection = [u - shear_rad * v, v - shear_rad * u];
    }
    let state = begin(&straight).unwrap().state;
    let key = Key::Courier(straight.courier.clone(), DIODE_SHEAR);
    let mut told = state.clone();
    told.add(&straight.platen, &key, shear_rad);
    let squares = |member: &Member, state: &State| sums_of(member, state).0.squares;
    let wanted = squares(&straight, &state);
    let [back, unsaid] = [&told, &state].map(|state| squares(&turned, state));
    assert!(unsaid > 5.0 * wanted, "{unsaid} {wanted}");
    // The diode's polynomial is taken where the turned axes say: its slopes, up to a fifth, are left of the shear, a twenty-fifth of the squares.
    let left = (back - wanted).abs() / (unsaid - wanted);
    assert!(left < 0.04, "{left}: {back} {wanted} {unsaid}");
}

#[test]
fn another_platen_of_the_same_name_is_refused() {
    let mut other = member(2, 6, 7, 200, 2.0);
    let here = member(1, 5, 8, 200, 2.0);
    other.platen = Platen::clone(&here.platen);
    let told = fit(&[here, other], &|| ()).err().unwrap().to_string();
    assert!(
        told.contains("another platen") || told.contains("whole teeth"),
        "{told}"
    );
}

/// Two recordings of one courier take its lever arm for different ones, by up to half a tooth; their beacons are compared without it.
#[test]
fn recordings_of_one_courier_are_laid_over_each_other() {
    let first = begin(&member(1, 5, 8, 130, 1.5)).unwrap();
    let second = begin(&member(1, 5, 9, 130, 1.5)).unwrap();
    let apart = [0, 1].map(|k| (first.beacon_m[k] - second.beacon_m[k]) / first.pitch_m);
    // More than is tried about a whole number.
    assert!(apart[0].abs() > 0.25, "{apart:?}");
    let name = second.recording.clone();
    let state = register(&[first, second]).unwrap();
    assert_eq!(state.shift_teeth(&name), [0, 0]);
}

/// A beacon that was moved by part of a tooth leaves no shift under which the same courier's places are right.
#[test]
fn a_beacon_that_was_moved_is_refused() {
    let here = member(1, 5, 8, 130, 1.5);
    let mut moved = member(1, 5, 9, 130, 1.5);
    // Everything along y is counted from elsewhere: by part of a tooth.
    let part_m = 0.45 * here.setup.pitch_m;
    for pose in &mut moved.poses {
        pose.outputs_m[1] += part_m;
        pose.outputs_m[3] += part_m;
    }
    let told = fit(&[here, moved], &|| ()).err().unwrap().to_string();
    assert!(told.contains("off a whole number"), "{told}");
}
