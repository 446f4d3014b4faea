//! What is told of a gap that no effect explains: what of it follows a logged column, and how far a correction without a name would get.

use crate::advice::joined;
use crate::units::{self, micrometres};
use diagnosis::verdict::answer::{Correction, Diagnosis, HeldOutChannel, Verdict};

/// The sentences, none where there is nothing to tell.
#[must_use]
pub fn remainder(diagnosis: &Diagnosis) -> Vec<String> {
    let left = &diagnosis.unexplained;
    let what = if matches!(diagnosis.verdict, Verdict::Named | Verdict::Alias) {
        "What is left"
    } else {
        "The gap"
    };
    let follows = left.follows.iter();
    let follows = follows.map(|f| format!("{what} follows {}: {}.", f.column, units::follows(f)));
    let correction = left.correction.iter().filter_map(sentence);
    follows.chain(correction).collect()
}

/// How far the correction gets, in the channel with the largest gap.
fn sentence(correction: &Correction) -> Option<String> {
    let beyond = |c: &&HeldOutChannel| c.before_rms_m - c.floor_rms_m;
    let channels = correction.channels.iter();
    let worst = channels.max_by(|a, b| beyond(a).total_cmp(&beyond(b)))?;
    let names: Vec<&str> = correction.coordinates.iter().map(String::as_str).collect();
    let [before, after, low, high, floor] = [
        worst.before_rms_m,
        worst.after_rms_m,
        worst.after_ci95_m[0],
        worst.after_ci95_m[1],
        worst.floor_rms_m,
    ]
    .map(micrometres);
    Some(format!(
        "A correction without a name, by shapes over {}, would leave {after} rms ({low} to {high}) of {before} in {}, on samples that it was not fitted to; the floor is {floor}. It corrects and explains nothing: on another motion it may do worse.",
        joined(&names),
        worst.channel
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use diagnosis::verdict::answer::{Follows, Unexplained};

    #[test]
    fn the_channel_with_the_largest_gap_is_told() {
        let channel = |name: &str, before_um: f64, after_um: f64| HeldOutChannel {
            channel: name.into(),
            before_rms_m: 1.0e-6 * before_um,
            after_rms_m: 1.0e-6 * after_um,
            after_ci95_m: [0.9e-6 * after_um, 1.1e-6 * after_um],
            floor_rms_m: 0.2e-6,
        };
        let correction = Correction {
            coordinates: vec!["temperature".into(), "time".into()],
            whitened_after: 1.2,
            channels: vec![channel("g_p", 1.0, 0.3), channel("g_x", 4.0, 2.0)],
        };
        let follows = Follows {
            column: "aux_rh".into(),
            of: "g_x".into(),
            per_unit_m: 1.0e-7,
            deviation_m: 1.0e-8,
            ..Follows::default()
        };
        let mut diagnosis = Diagnosis {
            verdict: Verdict::Unknown,
            unexplained: Unexplained {
                correction: Some(correction),
                follows: vec![follows],
                ..Unexplained::default()
            },
            ..Diagnosis::default()
        };
        assert_eq!(
            remainder(&diagnosis),
            [
                "The gap follows aux_rh: 0.100 ± 0.010 µm rms for 1 % RH of aux_rh in g_x.",
                "A correction without a name, by shapes over temperature and time, would leave 2 µm rms (1.8 µm to 2.2 µm) of 4 µm in g_x, on samples that it was not fitted to; the floor is 0.2 µm. It corrects and explains nothing: on another motion it may do worse."
            ]
        );
        diagnosis.unexplained = Unexplained::default();
        assert!(remainder(&diagnosis).is_empty());
    }
}
