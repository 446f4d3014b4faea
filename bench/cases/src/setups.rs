//! Configurations of the signal path that are measured and compared.

use courier_sensor::model::{
    ErrorModel, MAX_LATERAL_ORDER, MAX_OWN_ORDER, MAX_TERMS, Multiplier, Term, TermTable,
};
use courier_sensor::quadrature::PairCorrection;
use courier_sensor::settings::Settings;
use courier_sensor::step::StepConfig;
use courier_sensor::teeth::{Grid, MAX_NODES, MapHeader, TRUST_WORDS, ToothMap, Wave};

/// Which rows the error model has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setup {
    /// Equation (3): the orders 1, 2, 4, 6 of the own phase.
    Own,
    /// Equation (9): the lateral terms besides.
    Lateral,
    /// Further rows: powers of theta, speed, direction, temperature, mixed orders.
    Extended,
    /// Equation (9) and as many rows as there is room for, of those that cost the most: of the highest orders.
    Dearest,
    /// The same with one such row.
    DearestRow,
}

impl Setup {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Own, Self::Lateral, Self::Extended, Self::Dearest];

    /// The interrupt's configuration: every coefficient of a different, plausible size; corrections of the pairs.
    ///
    /// # Panics
    /// Never: the settings are within their ranges (a test sees to it).
    pub fn config(self) -> StepConfig {
        StepConfig::build(&self.settings())
            .unwrap_or_else(|_| unreachable!("settings of the bench are in range"))
    }

    /// The same in SI units.
    pub fn settings(self) -> Settings {
        let mut model = ErrorModel::zero(self.terms());
        model.constants_m = [1.0e-6, -2.0e-6, 3.0e-6, -4.0e-6];
        for (row, coefficients) in model.coefficients.iter_mut().enumerate() {
            for (k, value) in coefficients.as_flattened_mut().iter_mut().enumerate() {
                *value =
                    (1 + (5 * row + 3 * k) % 7) as f32 * if k % 3 == 0 { -2.0e-6 } else { 1.5e-6 };
            }
        }
        let mut settings = Settings {
            model: Some(model),
            ..Settings::default()
        };
        for (i, pair) in settings.pairs.iter_mut().enumerate() {
            let i = i as f32;
            *pair = PairCorrection {
                offset_counts: [30.0 - 10.0 * i, 20.0 * i],
                gain: 1.0 + 0.01 * i,
                angle_rad: 0.01 * i,
            };
        }
        settings
    }

    fn terms(self) -> TermTable {
        match self {
            Self::Own => TermTable::equation_3(),
            Self::Lateral => TermTable::equation_9(),
            Self::Extended => {
                let mut table = TermTable::equation_9();
                let mixed = Term {
                    own_order: 1,
                    lateral_order: -1,
                    ..Term::default()
                };
                let third = Term::own(3);
                let warm = Term::default().with(Multiplier::Temperature);
                let moving = Term::own(1).with(Multiplier::Direction);
                for term in [third, third.with_theta(1), mixed, warm, moving] {
                    let _ = table.push(term);
                }
                table
            }
            Self::Dearest => with_dearest(MAX_TERMS),
            Self::DearestRow => with_dearest(1),
        }
    }
}

/// Equation (9) and rows that no others cost more than, as far as there is room: of the highest own order, the first also of the
/// highest lateral one.
pub fn with_dearest(rows: usize) -> TermTable {
    let lateral = MAX_LATERAL_ORDER as i8;
    let kinds = [Multiplier::None, Multiplier::Speed, Multiplier::Direction];
    let all = kinds.into_iter().flat_map(|multiplier| {
        (-lateral..=lateral).map(move |lateral_order| Term {
            own_order: MAX_OWN_ORDER,
            lateral_order,
            theta_power: (lateral_order & 1) as u8,
            multiplier,
        })
    });
    let mut table = TermTable::equation_9();
    all.take(rows).for_each(|term| {
        let _ = table.push(term);
    });
    table
}

/// As large a tooth map as there is room for, about tooth count zero, every cell trusted, with the waves of mixed order that
/// `courier map` fits.
///
/// # Panics
/// If the map were out of its bounds.
pub fn fill_map(map: &mut ToothMap) {
    let grid = Grid {
        first_teeth: [-10, -10],
        nodes: [20, 20],
    };
    let mut header = MapHeader {
        grids: [grid; 2],
        ..MapHeader::default()
    };
    for (own_order, lateral_order) in [(0, 1), (0, 2), (1, 1), (1, -1), (2, 1), (2, -1)] {
        let _ = header.waves.push(Wave {
            own_order,
            lateral_order,
            coefficients_m: [[1.0e-6, -2.0e-6]; 4],
        });
    }
    let _ = header.trusted.resize(TRUST_WORDS, u32::MAX);
    let begun = map.begin(&header, &Settings::default().geometry);
    for n in 0..MAX_NODES {
        let _ = map.extend(&[(n * 37 % 401) as i16 - 200]);
    }
    assert!(begun.is_ok() && map.complete().is_ok(), "{begun:?}");
}
