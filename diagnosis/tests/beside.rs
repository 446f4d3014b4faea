//! Two effects at once, one of which hides the other or stands in for it.

use diagnosis::blind::{Case, Drawn, Kind};
use diagnosis::{Model, Options, check, diagnose_fully};

fn pair(seed: u64, effects: [(&str, f64); 2]) -> Case {
    let drawn = |(name, size_m): (&str, f64)| Drawn {
        name: name.into(),
        size_m,
    };
    Case {
        number: 0,
        seed,
        kind: Kind::Pair,
        effects: effects.map(drawn).to_vec(),
    }
}

/// The model of a case's first recording, which names both of its effects and nothing else.
fn both_named(case: &Case) -> Model {
    let answer = diagnose_fully(&case.recorded(0), "first", &Options::default());
    let sorted = |names: &mut dyn Iterator<Item = String>| {
        let mut names: Vec<String> = names.collect();
        names.sort_unstable();
        names
    };
    let named = sorted(&mut answer.diagnosis.effects.iter().map(|e| e.name.clone()));
    let wanted = sorted(&mut case.effects.iter().map(|e| e.name.clone()));
    assert_eq!(named, wanted, "{:?}", answer.diagnosis.held_out);
    answer.model.expect("a model")
}

/// A fly-by over teeth oscillates itself, at the beacon's frequencies as well: the lines are clear once the teeth are told.
#[test]
fn a_beacon_that_vibrates_beside_a_field_is_named() {
    let case = pair(
        4711,
        [("tooth_variation", 1.8e-6), ("beacon_vibration", 1.2e-6)],
    );
    let model = both_named(&case);
    // Asked: what comes within 10 % of the claim.
    let came = check(&model, &case.recorded(1)).expect("residuals");
    let ratio = came.whitened_after / model.claimed.whitened_after;
    assert!((ratio - 1.0).abs() < 0.1, "{:?} {ratio}", model.claimed);
}

/// A channel that turns with the angle takes the place of a span or a gap that are none, and of none that is there.
#[test]
fn what_is_there_beside_a_change_with_the_angle_stays() {
    for (seed, other) in [(4712, "span_error"), (4713, "gap_variation")] {
        both_named(&pair(seed, [("angle_dependence", 2.0e-6), (other, 1.5e-6)]));
    }
}
