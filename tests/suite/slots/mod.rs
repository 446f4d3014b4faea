//! Calibration records and their slots on the simulated flash.

mod histories;
mod power_cuts;
mod records;
mod two_slots;

use courier_sensor::calibration::record::{Calibration, Instant};
use courier_sensor::calibration::slots::Slots;
use courier_sensor::device::Device;
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, Term, TermTable};
use hal_sim::wire::flash::{Flash, PAGE_BYTES};

/// A calibration like a joint one's, told apart by `mark`.
fn calibration(mark: f32) -> Calibration {
    let terms = [1, 2, 4, 6]
        .map(Term::own)
        .into_iter()
        .chain([Term::lateral(1)]);
    let mut table = TermTable::default();
    terms.for_each(|term| table.push(term).unwrap());
    let mut model = ErrorModel::zero(table);
    model.constants_m = [
        0.25e-6 * mark,
        -0.25e-6 * mark,
        -0.25e-6 * mark,
        0.25e-6 * mark,
    ];
    model
        .coefficients
        .iter_mut()
        .flatten()
        .flatten()
        .enumerate()
        .for_each(|(n, k)| *k = 1.0e-6 * mark + n as f32 * 1.0e-8);
    Calibration {
        device: Device(*b"board-000001"),
        made: Instant {
            unix_s: Some(1_700_000_000),
            uptime_s: mark as u32,
        },
        temperature_c: 24.5,
        amplitude_counts: [20_000.0; 4],
        model,
        ..Calibration::identity(Geometry::PAPER)
    }
}

fn slots(flash: &mut Flash) -> Slots<&mut Flash> {
    Slots::new(flash, PAGE_BYTES as u32)
}

fn in_force(flash: &mut Flash) -> Option<f32> {
    let loaded = slots(flash).load().ok()?;
    Some(loaded.1.made.uptime_s as f32)
}

/// Three pages: one that is not ours before the slots.
fn flash(seed: u64) -> Flash {
    Flash::new(3, seed)
}

/// Commits that calibration; a cut is no failure.
fn commit(mark: f32) -> impl Fn(&mut Flash) {
    move |flash| {
        let _ = slots(flash).commit(&calibration(mark), false);
    }
}
