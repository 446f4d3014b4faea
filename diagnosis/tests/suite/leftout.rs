//! Pieces predicted from all others by one inverse, beside fits that were really made without them.

use specimens::rig;

use diagnosis::data::folds::folds;
use diagnosis::data::observations::Observations;
use diagnosis::design::gram::Gram;
use diagnosis::inference::fit::solve;
use diagnosis::inference::left_out::left_out;
use diagnosis::inference::residuals::Residuals;
use diagnosis::linearization::calibrate::{baseline_columns, calibrate};
use diagnosis::linearization::recording::LinearizedRecording;

#[test]
fn a_left_out_piece_is_what_a_fit_without_it_predicts() {
    let options = rig::Options {
        samples: 1500,
        ..rig::Options::default()
    };
    let (recording, _) = rig::record(3, &[("lateral_dependence", 2.0e-6)], &options);
    let observations = Observations::new(&recording).expect("enough samples");
    let all = vec![true; observations.len()];
    let baseline = calibrate(&observations, &all);
    let fold = folds(&observations.stretch);
    let linearized = |mask| LinearizedRecording::new(&observations, baseline.clone(), mask);
    let whole = linearized(all.clone());
    let columns = baseline_columns(&whole);
    let gram = Gram::new(&whole, &columns, &fold);
    let quick = left_out(&whole, &columns, &gram).expect("positive definite");
    let list: Vec<usize> = (0..gram.width()).collect();
    // Pieces are of ten samples: some of the still poses, of a fly-by, and of those under the beacon.
    for first in [0, 150, 500, 900] {
        let piece = first..first + 10;
        let stretch = &observations.stretch;
        if stretch[piece.start] != stretch[piece.end - 1] {
            continue;
        }
        let start = stretch
            .iter()
            .position(|s| *s == stretch[first])
            .unwrap_or(0);
        let piece = start + (first - start) / 10 * 10..start + (first - start) / 10 * 10 + 10;
        let mask = (0..all.len()).map(|i| !piece.contains(&i)).collect();
        let without = linearized(mask);
        let reduced = Gram::new(&without, &columns, &fold);
        let fit = solve(reduced.training(None), &list, &reduced.centre, 1.0).expect("solvable");
        let amounts: Vec<f64> = fit.coefficient.iter().copied().collect();
        let slow = Residuals::predicted(&without, &columns, &reduced, &list, |_| &amounts, true);
        let of = |r: &Residuals| -> Vec<f64> {
            let within = (0..r.sample.len()).filter(|k| piece.contains(&r.sample[*k]));
            within.map(|k| r.value_m[k]).collect()
        };
        let (quick, slow) = (of(&quick), of(&slow));
        assert_eq!(quick.len(), slow.len());
        for (a, b) in quick.iter().zip(&slow) {
            assert!((a - b).abs() < 1.0e-12 + 1.0e-6 * b.abs(), "{a} {b}");
        }
    }
}
