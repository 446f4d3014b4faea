use super::*;
use crate::difference::tests::of_order;

fn at_quarter() -> Pose {
    Pose {
        centre_m: [
            0.25 * f64::from(courier_sensor::geometry::Geometry::PAPER.pitch_m),
            0.0,
        ],
        theta_rad: 0.0,
    }
}

#[test]
fn contributions_add_up_as_squares() {
    let estimate = of_order(1, [0.0; 2], 0.2e-6);
    let conditions = Conditions {
        teeth_m: 0.3e-6,
        lateral_m: Some(0.4e-6),
        within_k: 2.0,
        distance_m: [0.1, 0.0],
    };
    let budget = budget(&estimate, &conditions, &at_quarter(), Quantity::X).unwrap();
    let of = |name: &str| {
        budget
            .contributions
            .iter()
            .find(|c| c.name.contains(name))
            .unwrap()
            .contribution
    };
    // A sine of segment 1 at a quarter of a tooth; two readings of half a µm, halved; 16 bit of 20,000 counts; 2 K of 100 mm.
    let wanted = [
        ("order 1", 0.1e-6),
        ("readings", 0.5e-6 / 2.0_f64.sqrt()),
        (
            "count",
            1.016e-3 / (std::f64::consts::TAU * 20_000.0) / 12.0_f64.sqrt() / 2.0_f64.sqrt(),
        ),
        ("lateral", 0.4e-6 / 2.0_f64.sqrt()),
        ("teeth", 0.3e-6),
        ("temperature", 0.1 * 11.5e-6 * 2.0 / 3.0_f64.sqrt()),
    ];
    for (name, size) in wanted {
        assert!(
            (of(name) / size - 1.0).abs() < 1.0e-6,
            "{name}: {:e}, {size:e}",
            of(name)
        );
    }
    let sum = wanted
        .iter()
        .map(|(_, size)| size * size)
        .sum::<f64>()
        .sqrt();
    assert!(
        (budget.combined / sum - 1.0).abs() < 1.0e-6
            && (budget.expanded / budget.combined - budget.factor).abs() < 1e-9
    );
    // All but type B, which is the most of it here, have 100 degrees of freedom.
    assert!(
        budget.freedom.unwrap() > 100.0 && (1.96..1.99).contains(&budget.factor),
        "{budget:?}"
    );
}

#[test]
fn an_angle_sees_neither_shared_teeth_nor_expansion() {
    let conditions = Conditions {
        within_k: 5.0,
        distance_m: [1.0; 2],
        ..Conditions::default()
    };
    let budget = budget(
        &of_order(1, [0.0; 2], 0.2e-6),
        &conditions,
        &at_quarter(),
        Quantity::Theta,
    )
    .unwrap();
    let names: Vec<&str> = budget
        .contributions
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    assert!(
        names
            .iter()
            .all(|name| !name.contains("teeth") && !name.contains("temperature")),
        "{names:?}"
    );
    // Four readings of half a µm over twice the span.
    let readings = budget
        .contributions
        .iter()
        .find(|c| c.name.contains("readings"))
        .unwrap();
    assert!(
        (readings.contribution / (0.5e-6 / 9.7e-3) - 1.0).abs() < 1.0e-6,
        "{readings:?}"
    );
}

#[test]
fn what_is_not_known_gives_no_budget() {
    let mut estimate = of_order(1, [0.0; 2], 0.2e-6);
    estimate.parity = None;
    let refused = |estimate: &Estimate| {
        let conditions = Conditions::default();
        budget(estimate, &conditions, &at_quarter(), Quantity::X).unwrap_err()
    };
    let told = refused(&estimate);
    assert!(told.contains("held-out"), "{told}");
    estimate.parity = Some((1.0e-6, 100.0));
    estimate.certainty = Err("a gauge".into());
    assert_eq!(refused(&estimate), "a gauge");
}
