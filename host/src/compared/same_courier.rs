//! Whether estimates are of one courier, so that their difference means something.

use super::source::{Compared, Device};
use anyhow::{Result, bail, ensure};

/// Lengths that differ by more than this share are not the same: those of a record are f32.
const SAME: f64 = 1.0e-6;

/// Refuses what cannot be compared with the first.
///
/// # Errors
/// Another pitch, span or lateral offset; another board, unless that is allowed; the same thing twice.
pub fn check(list: &[Compared], other_device: bool) -> Result<()> {
    for (place, second) in list.iter().enumerate() {
        for first in &list[..place] {
            lengths(first, second)?;
            if !other_device {
                device(first, second)?;
            }
            twice(first, second)?;
        }
    }
    Ok(())
}

fn lengths(first: &Compared, second: &Compared) -> Result<()> {
    let (name, other) = (&second.estimate.name, &first.estimate.name);
    let pitch = |of: &Compared| Some(f64::from(of.estimate.geometry.pitch_m));
    let lengths = [
        (
            "pitch_m",
            pitch(first),
            pitch(second),
            "phases of two pitches are not the same phases",
        ),
        (
            "span_m",
            first.stated[0],
            second.stated[0],
            "its segments sit elsewhere",
        ),
        (
            "lateral_m",
            first.stated[1],
            second.stated[1],
            "its segments sit elsewhere",
        ),
    ];
    for (length, one, two, why) in lengths {
        if let (Some(one), Some(two)) = (one, two) {
            ensure!(
                (one - two).abs() <= SAME * one.abs(),
                "{name}: geometry.{length}: found {two}, wanted {one} as in {other}: {why}"
            );
        }
    }
    Ok(())
}

fn device(first: &Compared, second: &Compared) -> Result<()> {
    let (name, other) = (&second.estimate.name, &first.estimate.name);
    match (&first.device, &second.device) {
        (Some(Device::Board(one)), Some(Device::Board(two))) if one != two => {
            bail!("{name}: found board {two}, wanted {one} as in {other} (or --other-device)")
        }
        (Some(Device::Recording(one)), Some(Device::Recording(two))) if one != two => {
            bail!("{name}: found device {two:?}, wanted {one:?} as in {other} (or --other-device)")
        }
        _ => Ok(()),
    }
}

fn twice(first: &Compared, second: &Compared) -> Result<()> {
    let (one, two) = (&first.estimate, &second.estimate);
    ensure!(
        one.unknowns != two.unknowns || one.values != two.values,
        "{}: found the very values of {}, wanted another calibration",
        two.name,
        one.name
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::calibration::record::Calibration;
    use courier_sensor::geometry::Geometry;
    use courier_sensor::model::{ErrorModel, TermTable};

    fn one(size_m: f32, change: fn(&mut Compared)) -> Compared {
        let mut calibration = Calibration::identity(Geometry::PAPER);
        calibration.model = ErrorModel::zero(TermTable::equation_3());
        calibration.model.coefficients[0][0][0] = size_m;
        let mut compared = Compared {
            estimate: comparison::record::estimate("a.json", &calibration),
            device: Some(Device::Board("7".into())),
            stated: [Some(9.7e-3), Some(3.0e-3)],
        };
        change(&mut compared);
        compared
    }

    #[test]
    fn what_is_of_another_courier_is_named() {
        let told = |other: bool, change: fn(&mut Compared)| {
            let list = [one(1.0e-6, |_| ()), one(2.0e-6, change)];
            check(&list, other)
                .err()
                .map_or(String::new(), |error| error.to_string())
        };
        assert_eq!(told(false, |_| ()), "");
        let cases: [(fn(&mut Compared), &str); 4] = [
            (|c| c.estimate.geometry.pitch_m *= 1.01, "pitch_m"),
            (|c| c.stated[0] = Some(9.8e-3), "span_m"),
            (|c| c.stated[1] = Some(2.0e-3), "lateral_m"),
            (
                |c| c.device = Some(Device::Board("8".into())),
                "found board 8, wanted 7",
            ),
        ];
        for (change, wanted) in cases {
            assert!(
                told(false, change).contains(wanted),
                "{wanted}: {}",
                told(false, change)
            );
        }
        assert_eq!(
            told(true, |c| c.device = Some(Device::Board("8".into()))),
            ""
        );
        // A model does not say whose it is, nor where the segments sit.
        assert_eq!(
            told(false, |c| (c.device, c.stated) = (None, [None; 2])),
            ""
        );
        assert!(told(false, |c| c.device = Some(Device::Recording("b".into()))).is_empty());
    }

    #[test]
    fn the_same_thing_twice_is_named() {
        let list = [
            one(1.0e-6, |_| ()),
            one(2.0e-6, |_| ()),
            one(1.0e-6, |_| ()),
        ];
        assert!(
            check(&list, false)
                .unwrap_err()
                .to_string()
                .contains("the very values of a.json")
        );
    }
}
