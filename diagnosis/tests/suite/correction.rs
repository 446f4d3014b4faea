//! What a correction without a name adds to the readings, as the model on disk keeps it.

use diagnosis::verdict::answer::Verdict;
use diagnosis::{Options, diagnose_fully};
use effects::identity::{Factor, Part};
use specimens::rig;

/// The independent simulator adds, in proportion to the speed, a sine of the first order and a cosine of the second, and nothing else. So
/// does the correction, as far as both speak of the same phase: the simulator's is off by up to 16 µm of equation (3), which turns the second
/// order by 0.2 and makes as much of it of the others.
#[test]
fn amounts_are_those_of_what_acts() {
    let options = rig::Options {
        samples: 600,
        beacon: false,
        counts: false,
        reference: true,
        segments: 1,
        ..rig::Options::default()
    };
    let (recording, _) = rig::record_as(81, 81, &[("speed_harmonics", 3.0e-6)], &options);
    let answer = diagnose_fully(&recording, "speed", &Options::default());
    assert_eq!(answer.diagnosis.verdict, Verdict::Unknown);
    let nameless = answer.model.expect("a model").nameless.expect("amounts");
    assert_eq!(nameless.coordinates[0], "speed and own tooth phase");
    let amount = |order, part| {
        let of_it = nameless.waves.iter().filter(|(wave, _)| {
            wave.factor == Factor::Speed && (wave.own_order, wave.part) == (order, part)
        });
        of_it.map(|(_, amount)| amount.abs()).sum::<f64>()
    };
    let acting = [amount(1, Part::Sine), amount(2, Part::Cosine)];
    let idle = [amount(1, Part::Cosine), amount(2, Part::Sine)];
    let largest = acting[0].max(acting[1]);
    assert!(
        idle.iter().all(|a| *a < 0.2 * largest),
        "{acting:?}, {idle:?}"
    );
}
