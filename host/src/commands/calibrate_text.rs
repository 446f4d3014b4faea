//! How `courier calibrate` tells what a session found: what was really computed, and what it is worth.

use crate::terminal::figure;
use courier_sensor::calibration::Evidence;

fn um(length_m: f32) -> String {
    figure(1.0e6 * f64::from(length_m))
}

/// What is known about a fit; a session that ended early knows less, and then less is said.
pub fn evidence(evidence: &Evidence) -> String {
    let mut parts = vec![format!("{} poses", evidence.poses)];
    if evidence.lost > 0 {
        parts.push(format!("{} lost", evidence.lost));
    }
    // A solved fit has a rank, and a condition number if no direction is lost.
    if evidence.rank > 0 {
        if evidence.condition.is_finite() {
            parts.push(format!("condition number {:.1}", evidence.condition));
        }
        parts.push(format!("rank {} of {}", evidence.rank, evidence.unknowns));
    }
    if evidence.held_out_poses > 1 {
        parts.push(format!(
            "held-out g_p residual {} -> {} µm",
            um(evidence.held_out_in_force_m),
            um(evidence.held_out_m)
        ));
    }
    parts.join(", ")
}

/// How much better an accepted calibration is than the one before, whether that is more than chance, and what remains.
pub fn worth(evidence: &Evidence) -> Vec<String> {
    let n = evidence.held_out_poses as f32;
    let (before, after, raw) = (
        evidence.held_out_in_force_m,
        evidence.held_out_m,
        evidence.held_out_raw_m,
    );
    if !(n > 1.0 && before > 0.0 && raw > 0.0) {
        return Vec::new();
    }
    let gain = 1.0 - after / before;
    // Relative standard deviation of an rms over n poses.
    let scatter = 1.0 / (2.0 * n).sqrt();
    let mut told = vec![format!(
        "the residual is {:.1} % smaller than with what was in force, and over {n} poses it scatters by {:.1} %",
        100.0 * gain,
        100.0 * scatter
    )];
    // Of the error's variance that an uncalibrated sensor shows.
    let explained = 1.0 - (after / raw).powi(2);
    if explained < 0.5 {
        told.push(format!(
            "it explains {:.0} % of the uncalibrated residual's {} µm (by variance), so most of the error is of another kind; next: \
             courier record first --survey X,Y,THETA && courier diagnose first",
            100.0 * explained.max(0.0),
            um(raw)
        ));
    } else if gain < 2.0 * scatter {
        told.push("what was in force was as good within the scatter".to_owned());
    }
    told
}

/// That a deviation which was wanted was not reached; none if it was, or if none was wanted.
pub fn missed_target(evidence: &Evidence, target_m: f32) -> Option<String> {
    let reached_m = evidence.worst_deviation_m;
    let missed = target_m > 0.0 && !(reached_m <= target_m);
    missed.then(|| {
        format!(
            "--target-um: reached {} µm with all {} poses, wanted {}; more poses (--poses) or a larger turn (--turn-deg) reach further",
            um(reached_m),
            evidence.poses,
            um(target_m)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: Evidence = Evidence {
        poses: 1000,
        lost: 0,
        unknowns: 33,
        rank: 33,
        condition: 8.3,
        residual_m: 4.0e-6,
        raw_m: 30.0e-6,
        worst_deviation_m: 0.5e-6,
        held_out_poses: 200,
        held_out_raw_m: 30.0e-6,
        held_out_in_force_m: 30.0e-6,
        held_out_m: 4.0e-6,
        amplitude_counts: [2.0e4; 4],
        temperature_delta_k: 0.0,
    };

    #[test]
    fn only_what_was_computed_is_told() {
        let early = Evidence {
            poses: 12,
            lost: 1,
            condition: f32::INFINITY,
            ..Evidence::default()
        };
        assert_eq!(evidence(&early), "12 poses, 1 lost");
        let undetermined = Evidence {
            rank: 17,
            unknowns: 33,
            condition: f32::INFINITY,
            ..early
        };
        assert_eq!(evidence(&undetermined), "12 poses, 1 lost, rank 17 of 33");
        let whole = evidence(&GOOD);
        assert!(
            whole.contains(
                "condition number 8.3, rank 33 of 33, held-out g_p residual 30.00 -> 4.00 µm"
            ),
            "{whole}"
        );
    }

    #[test]
    fn a_calibration_is_told_as_what_it_is_worth() {
        let told = |in_force_m: f32, after_m: f32| {
            let evidence = Evidence {
                held_out_raw_m: 65.5e-6,
                held_out_in_force_m: in_force_m,
                held_out_m: after_m,
                ..GOOD
            };
            worth(&evidence).join("; ")
        };
        let good = told(65.5e-6, 4.4e-6);
        assert!(
            good.contains("93.3 % smaller") && !good.contains(';'),
            "{good}"
        );
        let again = told(4.41e-6, 4.4e-6);
        assert!(again.contains("as good within the scatter"), "{again}");
        let other = told(65.4e-6, 64.62e-6);
        for word in [
            "1.2 % smaller",
            "scatters by 5.0 %",
            "another kind",
            "courier diagnose",
        ] {
            assert!(other.contains(word), "{other}");
        }
        assert!(worth(&Evidence::default()).is_empty());
    }

    #[test]
    fn a_target_that_was_missed_is_told() {
        assert_eq!(missed_target(&GOOD, 0.0), None);
        assert_eq!(missed_target(&GOOD, 1.0e-6), None);
        let told = missed_target(&GOOD, 0.1e-6).unwrap();
        assert!(
            told.contains("reached 0.500 µm") && told.contains("wanted 0.100"),
            "{told}"
        );
        let nothing = Evidence {
            worst_deviation_m: f32::INFINITY,
            ..GOOD
        };
        assert!(missed_target(&nothing, 0.1e-6).is_some());
    }
}
