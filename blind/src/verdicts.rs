//! Where an unlisted effect lies: the coordinates that an answer may rightly point to.

/// Parts of the coordinates' names, any of which is right.
pub fn coordinates(unlisted: &str) -> &'static [&'static str] {
    match unlisted {
        "subharmonic" => &["own tooth phase, fractional", "own tooth phase, order"],
        "mains_pickup" => &["frequency", "speed"],
        "ambient_light" => &["time", "deflection"],
        "crosstalk" => &["both segments", "lateral tooth phase", "own tooth phase"],
        "missing_codes" => &["own tooth phase", "signal amplitude"],
        "cable_drag" => &["direction", "place on the platen", "time"],
        "reference_mirror" => &["temperature", "time"],
        "tooth_resonance" => &["speed", "frequency"],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_unlisted_effect_has_its_coordinates() {
        for entry in effects::unlisted::UNLISTED {
            assert!(!super::coordinates(entry.name).is_empty(), "{}", entry.name);
        }
    }
}
