//! What else is there beside a tooth field, where only the teeth let it be seen.

use diagnosis::blind::{Case, Drawn, Kind};
use diagnosis::{Options, check, diagnose_fully};

/// A fly-by over teeth oscillates itself, at the beacon's frequencies as well: the lines are clear once the teeth are told.
#[test]
fn a_beacon_that_vibrates_beside_a_field_is_named() {
    let drawn = |name: &str, size_m: f64| Drawn {
        name: name.into(),
        size_m,
    };
    let case = Case {
        number: 0,
        seed: 4711,
        kind: Kind::Pair,
        effects: vec![
            drawn("tooth_variation", 1.8e-6),
            drawn("beacon_vibration", 1.2e-6),
        ],
    };
    let answer = diagnose_fully(&case.recorded(0), "first", &Options::default());
    let named = answer.diagnosis.effects.iter().map(|e| e.name.as_str());
    let mut named: Vec<&str> = named.collect();
    named.sort_unstable();
    assert_eq!(named, ["beacon_vibration", "tooth_variation"]);
    // Asked: what comes within 10 % of the claim.
    let model = answer.model.expect("a model");
    let came = check(&model, &case.recorded(1)).expect("residuals");
    let ratio = came.whitened_after / model.claimed.whitened_after;
    assert!((ratio - 1.0).abs() < 0.1, "{:?} {ratio}", model.claimed);
}
