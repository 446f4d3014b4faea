//! The columns as they stand, beside every other way to read sine and cosine.

use super::{Relations, parity_m};
use crate::fault::Source;
use crate::poses::Poses;
use crate::quadrature::Reading;
use crate::readings::Readings;
use crate::view::{CLOSURE_RATIO, CLOSURE_TOLERANCE};
use crate::wiring::Wiring;
use recording::Recording;

impl Relations {
    /// Of the columns as they stand. Where another way to read sine and cosine leaves far less of the parity, or against the reference, no
    /// wiring of these is right: errors of a tooth's width are small over a recording that rests most of the time.
    pub fn of_stated(recording: &Recording) -> Self {
        let stated = Self::new(recording, Reading::Stated);
        if stated.has() == [true; 4] {
            stated.beside_other_parities(recording)
        } else {
            stated.beside_other_rests(recording)
        }
    }

    /// The readings of the recording in every other way to read sine and cosine.
    fn otherwise(&self, recording: &Recording) -> Vec<Readings> {
        let others = Reading::others(|s| self.readings.has(s) && !self.readings.logged[s]);
        let readings = |other| Readings::new(recording, other);
        others.into_iter().map(readings).collect()
    }

    fn beside_other_parities(mut self, recording: &Recording) -> Self {
        let closes_m = CLOSURE_TOLERANCE * self.readings.pitch_m + self.left_in_m();
        if self.parity_m(&Wiring::stated()) <= closes_m {
            return self;
        }
        let parities_m = self.otherwise(recording).into_iter().map(|readings| {
            let all: Vec<&Vec<f64>> = readings.position_m.iter().collect();
            let products = readings.products(&readings.rows_with(&all), &all);
            products.map_or(f64::INFINITY, |p| parity_m(&p, &Wiring::stated()))
        });
        self.smallest_parity_m = parities_m.fold(self.smallest_parity_m, f64::min);
        self
    }

    fn beside_other_rests(mut self, recording: &Recording) -> Self {
        let wiring = Wiring::stated();
        let view = self.view(&wiring, 1.0, 1.0);
        let left_m = |poses: &Option<Poses>| {
            let left_m = poses.as_ref().map(|poses| poses.left_m(&view));
            left_m.unwrap_or([f64::INFINITY; 2])
        };
        let stated_m = left_m(&self.reference);
        let beyond = |left_m: f64| left_m.is_finite() && left_m > CLOSURE_TOLERANCE * view.tooth_m;
        if !stated_m.into_iter().any(beyond) {
            return self;
        }
        let far_smaller = |other_m: [f64; 2]| {
            let mut pairs = stated_m.into_iter().zip(other_m);
            pairs.any(|(stated_m, other_m)| beyond(stated_m) && stated_m > CLOSURE_RATIO * other_m)
        };
        let mut others = self.otherwise(recording).into_iter();
        self.misread =
            others.any(|readings| far_smaller(left_m(&Poses::new(&readings, Source::Reference))));
        self
    }
}
