//! What of a diagnosed model has terms on the board: its effects, or a correction without a name, as rows of the board's table.

use super::row::Row;
use super::terms::{Place, place, places};
use courier_sensor::model::{MAX_TERMS, most_further_rows};
use courier_sensor::settings::Settings;
use diagnosis::Model;
use diagnosis::transfer::model::{EffectAmounts, NamelessAmounts};
use diagnosis::verdict::evidence::WITHOUT_A_NAME;

/// Most terms of the own phase alone that the board can recalibrate with (`calibration::StartError::Terms`). By definition of the
/// board's fit (`calibration::regression::MAX_FITTED`).
const MOST_OWN: usize = 6;

/// The effects' terms.
pub(super) struct Effects {
    /// Every one that the board's error model can express.
    pub(super) all: Vec<Row>,
    /// Those that have room in its table.
    pub(super) chosen: Vec<Row>,
    /// Names of what became terms, and how many each.
    pub(super) taken: Vec<(String, usize)>,
    /// What became none, one line each.
    pub(super) left: Vec<String>,
}

/// What has a name, or is a correction without one, as rows of the board's table.
struct Source {
    name: String,
    rows: Vec<Row>,
    /// Amounts that are no term of the board's.
    unknown: usize,
}

impl Source {
    fn of(
        name: String,
        unknown: usize,
        amounts: impl Iterator<Item = (Option<Place>, f64)>,
    ) -> Self {
        let mut out = Self {
            name,
            rows: Vec::new(),
            unknown,
        };
        for (place, amount) in amounts {
            match place {
                Some(place) => set(&mut out.rows, &place, amount),
                None => out.unknown += 1,
            }
        }
        out
    }

    fn effect(diagnosed: &Model, effect: &EffectAmounts) -> Self {
        let places = places(diagnosed, effect);
        let amounts = effect.amounts.iter();
        let amounts = amounts.map(|a| (places.get(&a.name).copied(), a.value));
        Self::of(effect.name.clone(), 0, amounts)
    }

    fn nameless(nameless: &NamelessAmounts) -> Self {
        let name = format!("{WITHOUT_A_NAME} over {}", nameless.coordinates.join(", "));
        let waves = nameless.waves.iter();
        let amounts = waves.map(|(wave, amount)| (place(wave), *amount));
        Self::of(name, nameless.other_shapes, amounts)
    }
}

/// The rows of a model beside those of equation (3), `own`.
pub(super) fn effects(diagnosed: &Model, own: &[Row]) -> Effects {
    let (mut all, mut table) = (Vec::new(), own.to_vec());
    let (mut taken, mut left) = (Vec::new(), Vec::new());
    let named = diagnosed.effects.iter();
    let named = named.map(|effect| Source::effect(diagnosed, effect));
    for source in named.chain(diagnosed.nameless.iter().map(Source::nameless)) {
        let Source {
            name,
            mut rows,
            unknown,
        } = source;
        all.extend_from_slice(&rows);
        let dropped = fit_in(&table, &mut rows);
        if !rows.is_empty() {
            taken.push((name.clone(), rows.len()));
        }
        table.extend(rows);
        if unknown > 0 {
            left.push(format!(
                "{name}: amounts that are no term of the board's error model: {unknown}"
            ));
        }
        if dropped > 0 {
            left.push(format!(
                "{name}: terms that have no room in the board's error model: {dropped}"
            ));
        }
    }
    let chosen = table.split_off(own.len());
    Effects {
        all,
        chosen,
        taken,
        left,
    }
}

fn set(rows: &mut Vec<Row>, place: &Place, amount: f64) {
    if !rows.iter().any(|row| row.term == place.term) {
        rows.push(Row::empty(place.term));
    }
    if let Some(row) = rows.iter_mut().find(|row| row.term == place.term) {
        row.coefficients[place.segment][place.part] += place.share * amount;
    }
}

/// Keeps the largest rows that there is room for beside those before, and tells how many had none.
fn fit_in(before: &[Row], rows: &mut Vec<Row>) -> usize {
    let all = rows.len();
    rows.sort_by(|a, b| b.size_m().total_cmp(&a.size_m()));
    let mut room_own = MOST_OWN.saturating_sub(before.iter().filter(|row| row.is_own()).count());
    rows.retain(|row| {
        let fits = !row.is_own() || room_own > 0;
        room_own -= usize::from(row.is_own() && fits);
        fits
    });
    // One place is left for a candidate that stands for what the lateral ones lack.
    let most = most_further_rows(Settings::default().rate_hz).saturating_sub(1);
    let mut further = 0;
    rows.retain(|row| {
        further += usize::from(row.term.is_further());
        further <= most
    });
    rows.truncate(MAX_TERMS - before.len());
    all - rows.len()
}
