//! The catalogue of effects: one file each, with the plant side, the sensor side, which do not call each other, and what is known
//! of it as data ([`effect::Card`]).
//!
//! Adding an effect: one file and one line of the list below. `unlisted` holds effects that no diagnosis knows, for blind
//! tests of its answer `unknown`.

pub mod basis;
pub mod covariates;
pub mod effect;
pub mod identity;
mod inexactness;
pub mod motion;
mod nested_forms;
pub mod over;
pub mod page;
pub mod plant;
pub mod rails;
pub mod random;
pub mod sensor;
pub mod shape;
mod tooth_regressors;
pub mod unlisted;

pub use effect::{Card, Detection, Effect};
pub use inexactness::{inexactness, lacks_along, lacks_in_lines};
use plant::Draw;

/// What the simulator needs of an effect.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Name, as in the diagnosis' output.
    pub name: &'static str,
    /// What it is.
    pub summary: &'static str,
    /// Draws the plant's side.
    pub draw: Draw,
}

/// Declares each effect's module and its lines of [`EFFECTS`] and [`CATALOGUE`].
macro_rules! catalogue {
    ($($module:ident;)*) => {
        $(pub mod $module;)*

        /// Every catalogued effect, in the order of the list.
        pub static EFFECTS: &[&dyn Effect] = &[$(&$module::Definition),*];

        /// The same for the simulator.
        pub static CATALOGUE: &[Entry] = &[
            $(Entry {
                name: $module::CARD.name,
                summary: $module::CARD.summary,
                draw: |scene, rng, size_rms_m| $module::Definition.draw(scene, rng, size_rms_m),
            }),*
        ];

        #[cfg(test)]
        const FILES: &[&str] = &[$(stringify!($module)),*];
    };
}

catalogue! {
    lateral_dependence;
    extra_harmonics;
    tooth_variation;
    angle_dependence;
    psd_nonlinearity;
    psd_misalignment;
    thermal_drift;
    velocity_lag;
    psd_latency;
    hysteresis;
    gap_variation;
    beacon_vibration;
    axis_skew;
    cycle_slip;
    outlier_bursts;
    excess_noise;
    adc_clipping;
    quadrature_drift;
    span_error;
    stray_field;
}

/// The simulator's line of a name.
#[must_use]
pub fn entry(name: &str) -> Option<&'static Entry> {
    CATALOGUE.iter().find(|entry| entry.name == name)
}

/// The effect of a name.
#[must_use]
pub fn effect(name: &str) -> Option<&'static dyn Effect> {
    EFFECTS.iter().copied().find(|effect| effect.name() == name)
}

/// The card of a name.
#[must_use]
pub fn card(name: &str) -> Option<&'static Card> {
    effect(name).map(Effect::card)
}

/// The motion that tells an effect from others, where its card states one.
#[must_use]
pub fn telling_motion(effect: &str) -> Option<&'static str> {
    card(effect)
        .map(|card| card.telling_motion)
        .filter(|motion| !motion.is_empty())
}

/// True if a name is that of an effect with a property; a shape without a name has none.
#[must_use]
pub fn has(name: &str, property: impl Fn(&Card) -> bool) -> bool {
    card(name).is_some_and(property)
}

/// True if a name is that of an effect which is found in some way.
#[must_use]
pub fn is(name: &str, detection: Detection) -> bool {
    has(name, |card| card.detection == detection)
}

/// Every card, in the order of the list.
pub fn cards() -> impl Iterator<Item = &'static Card> {
    EFFECTS.iter().map(|effect| effect.card())
}

/// The name of the effect that is found in a way of its own.
#[must_use]
pub fn name_of(detection: Detection) -> &'static str {
    // A test holds that each way but the usual fit has one effect.
    let mut of_it = cards().filter(|card| card.detection == detection);
    of_it.next().map_or("", |card| card.name)
}

/// The effects that add something to the readings, in the order of their unknowns; slips, bursts and noise are judged directly.
#[must_use]
pub fn sensor_sides() -> Vec<&'static dyn Effect> {
    let mut list: Vec<&'static dyn Effect> = EFFECTS.to_vec();
    list.retain(|effect| effect.card().detection.is_fitted());
    list.sort_by_key(|effect| effect.card().order);
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use effect::Quantity;
    use sensor::{BasisInputs, NestedForms};

    #[test]
    fn an_effect_has_the_name_of_its_file() {
        let names: Vec<&str> = cards().map(|card| card.name).collect();
        assert_eq!(names, FILES);
    }

    #[test]
    fn every_card_is_filled_in() {
        for card in cards() {
            let fitted = card.detection.is_fitted();
            let told = [card.summary, card.sizes, card.carries_over];
            assert!(told.iter().all(|text| !text.is_empty()), "{}", card.name);
            for text in [card.coordinate, card.telling_motion] {
                assert_eq!(fitted, !text.is_empty(), "{}", card.name);
            }
            let alone = card.detection == Detection::AsSlips;
            assert_eq!(alone, card.confusable.is_empty(), "{}", card.name);
            assert_eq!(card.follows == Quantity::Nothing, !fitted, "{}", card.name);
        }
    }

    #[test]
    fn what_is_judged_in_a_way_of_its_own_is_one_effect() {
        for way in [
            Detection::AsField,
            Detection::ByLines,
            Detection::ByRails,
            Detection::AsSlips,
            Detection::AsBursts,
            Detection::AsNoise,
        ] {
            let of_it = cards().filter(|card| card.detection == way);
            assert_eq!(of_it.count(), 1, "{way:?}");
        }
        assert_eq!(cards().filter(|card| card.follows_temperature()).count(), 1);
        assert_eq!(cards().filter(|card| card.keeps_its_own_time()).count(), 1);
    }

    #[test]
    fn effects_speak_of_others_that_there_are() {
        for card in cards() {
            let forms = card.forms.iter().flat_map(|f| [f.found_as, f.completed_by]);
            let held = card.subsumes.iter().map(|subsumes| subsumes.other);
            let alike = card.confusable.iter().map(|other| other.with);
            for name in forms.flatten().chain(held).chain(alike) {
                assert!(effect(name).is_some(), "{}: {name}", card.name);
                assert_ne!(name, card.name);
            }
        }
    }

    #[test]
    fn fuller_forms_tell_more() {
        let inputs = BasisInputs {
            segments: [true; 4],
            turning: true,
            moving: true,
            lateral: true,
            beacon: true,
            temperature: true,
            pitch_m: 1.0e-3,
            tan_full_scale: 0.1,
            ..BasisInputs::default()
        };
        let names = |effect: &dyn Effect, forms: NestedForms| {
            let inputs = BasisInputs {
                forms,
                ..inputs.clone()
            };
            let all = effect.regressors(&inputs).into_iter();
            all.map(|regressor| regressor.name).collect::<Vec<_>>()
        };
        for effect in EFFECTS {
            for form in effect.card().forms {
                let mut forms = NestedForms::default();
                (form.tell)(&mut forms);
                let (plain, more) = (
                    names(*effect, NestedForms::default()),
                    names(*effect, forms),
                );
                assert_ne!(plain, more, "{}: {}", effect.name(), form.tells);
                assert!(more.len() >= plain.len(), "{}", form.tells);
            }
        }
    }

    #[test]
    fn what_a_recording_does_not_offer_is_not_judged() {
        for effect in EFFECTS {
            let nothing = effect.regressors(&BasisInputs::default());
            assert!(nothing.is_empty(), "{}", effect.name());
        }
    }
}
