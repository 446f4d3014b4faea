//! A record's bytes: all that is written can be read, nothing else is.

use super::{calibration, flash, slots};
use crate::common::fullest::fullest;
use courier_sensor::calibration::record::{self, MAX_BYTES, Poses, RecordError};
use courier_sensor::calibration::slots::SlotError;
use courier_sensor::calibration::{Plan, Range, Sample};
use courier_sensor::device::Device;

#[test]
fn every_flipped_bit_of_a_record_is_noticed() {
    let mut buffer = [0; MAX_BYTES];
    let length = record::encode(&calibration(1.0), 7, &mut buffer).unwrap();
    assert_eq!(record::decode(&buffer), Ok((7, calibration(1.0))));
    for bit in 0..8 * length {
        buffer[bit / 8] ^= 1 << (bit % 8);
        assert!(record::decode(&buffer).is_err(), "bit {bit}");
        buffer[bit / 8] ^= 1 << (bit % 8);
    }
    for end in 0..length {
        assert!(record::decode(&buffer[..end]).is_err(), "{end} bytes");
    }
}

#[test]
fn numbers_that_cannot_be_used_are_neither_written_nor_read() {
    let mut flash = flash(1);
    let mut bad = calibration(1.0);
    bad.geometry.span_m = f32::NAN;
    let refusal = slots(&mut flash).commit(&bad, false).unwrap_err();
    assert_eq!(
        refusal.to_string(),
        "record: geometry (a length or the full scale) is NaN, wanted -100 to 100"
    );
    let mut bad = calibration(1.0);
    bad.model.coefficients.pop();
    assert!(matches!(
        slots(&mut flash).commit(&bad, false),
        Err(SlotError::Record(RecordError::Model(_)))
    ));
    assert_eq!(flash.steps(), 0, "nothing was erased or written");
}

#[test]
fn the_fullest_record_fits() {
    let mut buffer = [0; MAX_BYTES];
    let length = record::encode(&fullest(), u32::MAX, &mut buffer).unwrap();
    assert!(length < MAX_BYTES, "{length}");
    println!("fullest record: {length} of {MAX_BYTES} bytes");
}

proptest::proptest! {
    #[test]
    fn any_record_round_trips(
        sequence in proptest::num::u32::ANY,
        coefficients in proptest::collection::vec(-1.0e3f32..1.0e3, 0..192),
        device in proptest::array::uniform12(0u8..),
        unix_s in proptest::option::of(0u64..),
        temperature_c in -50.0f32..150.0,
        poses in proptest::option::of((0u64.., 0u16.., -0.5f32..0.5)),
    ) {
        let mut calibration = calibration(1.0);
        calibration.device = Device(device);
        calibration.made.unix_s = unix_s;
        calibration.temperature_c = temperature_c;
        calibration.poses = poses.map(|(seed, visited, fraction_turns)| {
            let mut start = Sample::ZERO;
            start.unmodified[2].fraction_turns = fraction_turns;
            let range = Range { travel_m: 0.01, turn_rad: 0.02 };
            let poses = Poses::new(Plan::Optimal, seed, range, &start, [visited, 200]);
            // To half a step of 1/256, modulo a tooth.
            let off = poses.start().unmodified[2].fraction_turns - fraction_turns;
            assert!((off - off.round()).abs() <= 0.5 / 256.0, "{off}");
            poses
        });
        let slots = calibration.model.coefficients.iter_mut().flatten().flatten();
        slots.zip(&coefficients).for_each(|(slot, value)| *slot = *value);
        let mut buffer = [0; MAX_BYTES];
        let length = record::encode(&calibration, sequence, &mut buffer).unwrap();
        proptest::prop_assert_eq!(record::decode(&buffer[..length]), Ok((sequence, calibration)));
    }

    #[test]
    fn bytes_of_any_kind_never_panic_and_never_pass(mut bytes in proptest::collection::vec(0u8.., 0..200), header in 0u8..3) {
        if header > 0 && bytes.len() >= 16 {
            bytes[..8].copy_from_slice(b"CSRC\x01\0\0\0");
            let body = (bytes.len() - 16) as u32;
            bytes[8..12].copy_from_slice(&body.saturating_sub(4 * u32::from(header - 1)).to_le_bytes());
        }
        proptest::prop_assert!(record::decode(&bytes).is_err());
    }
}
