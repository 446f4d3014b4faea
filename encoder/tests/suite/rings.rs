//! Magnetic rings of 25 pole pairs: learned on three turns without the reference, judged by it on the fourth.

use crate::shared::shared;
use crate::spun::rms_about_mean;
use encoder::{Input, Question, learn};
use recording::{Column, Recording};

const PERIODS: f64 = 25.0;
/// What is asked of them, m.
const WANTED_M: f64 = 7.0e-6;

#[test]
fn rings_learned_on_three_turns_are_right_on_the_fourth() {
    for ring in ["magnetic-ring-1", "magnetic-ring-2", "magnetic-ring-3"] {
        let Some(folder) = shared(ring) else { return };
        let recording = Recording::read(folder).unwrap();
        let whole = Input::of(&recording, 0).unwrap();
        let reference = recording.samples.column(Column::Reference(0));
        let start = whole.place[0];
        let turn = |row: usize| (whole.place[row] - start) / PERIODS;
        let until = (0..whole.t_s.len()).find(|row| turn(*row) >= 3.0).unwrap();
        let learned = Input {
            t_s: whole.t_s[..until].to_vec(),
            place: whole.place[..until].to_vec(),
            counts: whole.counts[..until].to_vec(),
            ..whole.clone()
        };
        let question = Question {
            periods_per_turn: Some(PERIODS as u32),
        };
        let answer = learn(&learned, &question).unwrap();
        let fourth: Vec<usize> = (until..whole.t_s.len())
            .filter(|row| turn(*row) < 4.0)
            .collect();
        let error = |of: &dyn Fn(usize) -> f64| {
            let errors: Vec<f64> = fourth
                .iter()
                .map(|row| of(*row) - reference[*row] / whole.pitch_m)
                .collect();
            rms_about_mean(&errors) * whole.pitch_m
        };
        let before = error(&|row| whole.place[row]);
        let after = error(&|row| answer.calibrated(whole.place[row], Some(whole.counts[row])));
        println!(
            "{ring}: {:.2} -> {:.2} µm, {} orders of the turn",
            1e6 * before,
            1e6 * after,
            answer.turn.as_ref().map_or(0, |turn| turn.orders.len())
        );
        assert!(after <= WANTED_M, "{ring}: {after}");
    }
}
