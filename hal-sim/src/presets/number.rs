//! The number by which a simulated board introduces itself.

use courier_sensor::device::Device;

/// Of the board on the courier of a preset and a seed: the preset's first five letters and six digits of the seed, `paper-000001`, which
/// people can read. A larger seed takes eight bytes behind three letters and a zero: no text, so never the number of a smaller one.
#[must_use]
pub fn device_number(preset: &str, seed: u64) -> Device {
    let mut bytes = [0; 12];
    if seed <= 999_999 {
        let text = format!("{preset:-<5.5}-{seed:06}");
        bytes.copy_from_slice(&text.as_bytes()[..12]);
    } else {
        for (place, letter) in bytes.iter_mut().zip(preset.bytes().take(3)) {
            *place = letter;
        }
        bytes[4..].copy_from_slice(&seed.to_be_bytes());
    }
    Device(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_preset_and_seed_has_a_number_of_its_own() {
        let seeds = [0, 1, 2, 10, 999_999, 1_000_000, 1_000_001, u64::MAX];
        let numbers: HashSet<[u8; 12]> = ["paper", "ideal", "measured"]
            .iter()
            .flat_map(|preset| seeds.map(|seed| device_number(preset, seed).0))
            .collect();
        assert_eq!(numbers.len(), 3 * seeds.len());
        assert_eq!(device_number("paper", 1).0, *b"paper-000001");
        assert_eq!(device_number("measured", 42).to_string(), "measu-000042");
    }
}
