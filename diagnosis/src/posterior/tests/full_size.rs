//! Simulation-based calibration at full size: the columns are those of a whole survey, with all effects of the catalogue; which of them act, by
//! how much, and the noise are drawn from the prior, as in [`super`]. The decision is made of sums over the rows alone, and so are the
//! problems: sums of a target that was never formed, with the distribution that sums of drawn noise have.

use super::{Drawn, are_calibrated, worth_naming};
use crate::data::prepare::prepare;
use crate::design::assembly::{DesignOptions, Options};
use crate::posterior::look::design;
use crate::posterior::noise_scale::STATED_TO;
use crate::posterior::prior::log_odds;
use crate::posterior::problem::{Prior, Problem};
use crate::posterior::reduced::Reduced;
use crate::posterior::weighing::Weighing;
use effects::random::{ChaCha8Rng, SeedableRng, normal, uniform};
use nalgebra::{DMatrix, DVector};
use specimens::{Case, Conditions, Kind};

/// Most effects in a set. By definition of the answer (`docs/formulation.md`): up to four.
const MOST: usize = 4;

/// Normal equations of a survey, of which the targets are drawn.
struct Survey {
    reduced: Reduced,
    effects: Vec<Prior>,
    /// A square root of the columns' products.
    root: DMatrix<f64>,
}

impl Survey {
    /// Of which amounts of the stated size do this share of what they do.
    fn of(seed: u64, share: f64) -> Self {
        let case = Case {
            number: 0,
            seed,
            kind: Kind::None,
            effects: Vec::new(),
            conditions: Conditions::Usual,
        };
        let prepared = prepare(&case.recorded(0)).expect("a survey");
        let options = Options::default();
        let design = design(
            &prepared,
            &options,
            &prepared.point(),
            DesignOptions::default(),
        );
        let weighing = Weighing::of(&design);
        let whole = weighing.problem();
        let listed = whole.effects.iter().filter(|e| e.listed);
        let effects: Vec<Prior> = listed
            .map(|e| Prior {
                inexactness: 0.0,
                ..*e
            })
            .collect();
        let nothing = DVector::zeros(whole.reduced.normal.nrows());
        let mut reduced = whole.reduced.with_target(nothing, 0.0);
        reduced.normal *= share * share;
        let eigen = reduced.normal.clone().symmetric_eigen();
        let roots = eigen.eigenvalues.map(|e| e.max(0.0).sqrt());
        let root = eigen.eigenvectors * DMatrix::from_diagonal(&roots);
        Self {
            reduced,
            effects,
            root,
        }
    }

    /// A problem whose effects act as often as their prior says, and what weighing it shows.
    fn drawn(&self, rng: &mut ChaCha8Rng) -> Drawn {
        let noise = (STATED_TO * normal(rng)).exp();
        let set = loop {
            let acts = |e: &&Prior| uniform(rng, 0.0, 1.0) < 1.0 / (1.0 + (-e.log_odds).exp());
            let set: Vec<usize> = self.effects.iter().filter(acts).map(|e| e.block).collect();
            if set.len() <= MOST {
                break set;
            }
        };
        let (sizes, truth) = worth_naming(&self.reduced, &set, noise, rng);
        let amounts = DVector::from_vec(truth);
        let drawn = DVector::from_fn(amounts.len(), |_, _| noise.sqrt() * normal(rng));
        let of_noise = &self.root * &drawn;
        let within = drawn.iter().zip(self.root.column_iter());
        let within = within.filter(|(_, column)| column.norm_squared() > 0.0);
        let within: Vec<f64> = within.map(|(z, _)| z * z).collect();
        let degrees = self.reduced.rows - (self.reduced.baseline + within.len()) as f64;
        let beside = noise * (degrees + (2.0 * degrees).sqrt() * normal(rng));
        let squares = amounts.dot(&(&self.reduced.normal * &amounts + 2.0 * &of_noise))
            + within.iter().sum::<f64>()
            + beside;
        let right = &self.reduced.normal * &amounts + of_noise;
        let reduced = self.reduced.with_target(right, squares);
        let problem = Problem::of_unit_noise(&reduced, &self.effects, log_odds());
        Drawn::of(&problem, &set, (&sizes, amounts.as_slice()), noise)
    }
}

/// `cargo test -p diagnosis --release --lib full_size -- --ignored --nocapture`.
#[test]
#[ignore = "nightly: some minutes"]
fn the_posterior_of_a_whole_survey_is_right_as_often_as_it_says() {
    for share in SHARES {
        let survey = Survey::of(12, share);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let all: Vec<Drawn> = (0..PROBLEMS).map(|_| survey.drawn(&mut rng)).collect();
        are_calibrated(&all);
    }
}

/// Problems that are drawn of each kind. A bound on the work: of some ten effects one acts every second time, so that a hundred act in all.
const PROBLEMS: usize = 200;
/// Share of what they do. Derived from the least size: amounts as stated do thousands of times what is worth a name, and a fiftieth of
/// them is near that.
const SHARES: [f64; 2] = [1.0, 0.02];
