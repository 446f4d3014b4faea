//! Effects that are in no catalogue: physical, of like size, and not in the diagnosis' words. Its right answer is `unknown`.

use crate::Entry;

/// Declares each effect's module and its line of [`UNLISTED`].
macro_rules! unlisted {
    ($($module:ident :: $plant:ident, $summary:literal;)*) => {
        $(pub mod $module;)*

        /// Every effect that is not catalogued.
        pub const UNLISTED: &[Entry] = &[
            $(Entry { name: stringify!($module), summary: $summary, draw: $module::$plant::draw },)*
        ];
    };
}

unlisted! {
    subharmonic::Subharmonic, "every other tooth differs: orders 1/2 and 3/2 of the pitch";
    mains_pickup::MainsPickup, "mains frequency on one quadrature pair, stronger with speed";
    ambient_light::AmbientLight, "a lamp is switched on: every electrode gets its share of it";
    crosstalk::Crosstalk, "a segment's signals leak into the next one's amplifier";
    missing_codes::MissingCodes, "a converter bit sticks: codes are missing at regular places";
    cable_drag::CableDrag, "the cable bends the sensor head, with a memory of millimetres";
    reference_mirror::ReferenceMirror, "the interferometer's mirror creeps with temperature";
    tooth_resonance::ToothResonance, "the sensor head resonates where the tooth frequency meets its own";
}
