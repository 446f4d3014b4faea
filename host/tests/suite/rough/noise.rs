//! Stated noise that is wrong by a factor of ten either way: said so, and no other name for it.

use super::field::{LATERAL, diagnose, sound, with_lateral};
use recording::Recording;

fn stated(of: &Recording, factor: f64) -> Recording {
    let mut of = of.clone();
    let electronics = &mut of.meta.electronics;
    for noise in [
        &mut electronics.quadrature_noise_counts,
        &mut electronics.psd_noise_counts,
    ] {
        *noise = noise.map(|n| factor * n);
    }
    of
}

#[test]
fn ten_times_too_much() {
    for of in [sound(), with_lateral()] {
        diagnose(&stated(&of, 10.0)).insufficient(&["stated noise"]);
    }
}

/// The data cannot tell noise above what is stated from a statement below what there is: it is named, and the doubt is said.
#[test]
fn ten_times_too_little() {
    for (of, factor) in [(sound(), 0.1), (with_lateral(), 0.1), (sound(), 0.0)] {
        let told = diagnose(&stated(&of, factor));
        told.names_only(&["excess_noise", LATERAL]);
        let notes = told.answer()["notes"].to_string();
        assert!(
            notes.contains("stated noise") && notes.contains("may be the statement"),
            "{notes}"
        );
    }
}

/// Over separate poses alone any pattern looks like noise, and is not called so.
#[test]
fn separate_poses_do_not_show_noise() {
    for of in [sound(), with_lateral()] {
        let halves = of.with_rows(|i, row| {
            let keep = row.run == "scatter";
            row.run = if i % 600 < 300 { "one" } else { "other" };
            keep
        });
        diagnose(&halves).names_only(&[LATERAL]);
    }
}
