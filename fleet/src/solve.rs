//! The step that all platens' sums ask for, and what they leave open.
//!
//! With N the platen's own part of the normal equations (priors included), C its products with the couriers' columns and D those of
//! the couriers alone, L the factor of N and W the inverse of L times C, the couriers' part of the precision is D less the product of W
//! with itself, summed over the platens, plus the couriers' priors (Schur complement; the Helmert block method of geodesy, Wolf 1978). The covariance of a function a of the platen's
//! and c of the couriers' unknowns follows from h, the inverse of L times a: its variance is the square of h, plus that of c less W's
//! transpose times h under the couriers' covariance.

use crate::key::{Key, Platen};
use crate::state::{Prior, State};
use crate::sums::Sums;
use anyhow::{Context, Result};
use nalgebra::{DMatrix, DVector};
use normal_equations::cholesky::Factor;
use std::collections::BTreeMap;

/// A platen with its unknowns eliminated.
struct Eliminated {
    /// Places of its own unknowns, by key.
    own: BTreeMap<Key, (usize, f64)>,
    /// Inverse of L.
    half: DMatrix<f64>,
    /// W, over all couriers' columns.
    with_couriers: DMatrix<f64>,
}

/// What the data leave open.
pub struct Posterior {
    platens: BTreeMap<Platen, Eliminated>,
    couriers: BTreeMap<Key, (usize, f64)>,
    factor: Factor,
}

/// A solution.
pub struct Solution {
    /// Of each platen's unknowns and the couriers', by key, in their own units.
    pub steps: Vec<(Platen, Key, f64)>,
    /// By how much the objective falls where nothing bends: the sum of squares of the step over the deviations that the data leave.
    pub decrement: f64,
    /// Squares of what is left at the state, and of the unknowns' distances from their priors: what the steps make small.
    pub objective: f64,
    /// What the data leave open.
    pub posterior: Posterior,
}

/// Solves for the step from a state. `damping` is added to each prior's weight, toward the state (Levenberg 1944); only the posterior of
/// none of it is that of the data.
///
/// # Errors
/// The sums do not make a positive matrix: a reading that is no number.
pub fn solve(sums: &BTreeMap<Platen, Sums>, state: &State, damping: f64) -> Result<Solution> {
    let mut couriers: BTreeMap<Key, (usize, Prior)> = BTreeMap::new();
    for (key, prior) in sums.values().flat_map(|sums| &sums.columns) {
        if key.is_shared() {
            couriers.insert(key.clone(), (0, *prior));
        }
    }
    couriers
        .values_mut()
        .enumerate()
        .for_each(|(k, slot)| slot.0 = k);
    let count = couriers.len();
    let mut precision = DMatrix::identity(count, count) * (1.0 + damping);
    let mut objective = sums.values().map(|sums| sums.squares).sum::<f64>();
    let mut right = DVector::zeros(count);
    for (key, (at, prior)) in &couriers {
        right[*at] = back(state, &Platen::default(), key, prior);
        objective += right[*at].powi(2);
    }
    let mut platens = BTreeMap::new();
    let mut forwards = Vec::new();
    for (platen, sums) in sums {
        let (eliminated, forward) = eliminate(
            platen,
            sums,
            state,
            1.0 + damping,
            &couriers,
            &mut precision,
            &mut right,
        )
        .with_context(|| format!("{platen}: found a reading that is no number, wanted none"))?;
        let own = sums.columns.iter().filter(|(key, _)| !key.is_shared());
        let own = own.map(|(key, prior)| back(state, platen, key, prior).powi(2));
        objective += own.sum::<f64>();
        platens.insert(platen.clone(), eliminated);
        forwards.push(forward);
    }
    let factor = Factor::new(precision)
        .context("the couriers: found a reading that is no number, wanted none")?;
    let of_couriers = factor.solve(&right);
    let mut decrement = right.dot(&of_couriers);
    let unit = |prior: &Prior| prior.deviation;
    let mut steps: Vec<(Platen, Key, f64)> = couriers
        .iter()
        .map(|(key, (at, prior))| {
            (
                Platen::default(),
                key.clone(),
                of_couriers[*at] * unit(prior),
            )
        })
        .collect();
    for ((platen, eliminated), forward) in platens.iter().zip(forwards) {
        decrement += forward.norm_squared();
        let left = forward - &eliminated.with_couriers * &of_couriers;
        let own = eliminated.half.tr_mul(&left);
        let step = eliminated.own.iter();
        steps.extend(step.map(|(key, (at, unit))| (platen.clone(), key.clone(), own[*at] * unit)));
    }
    let couriers = couriers
        .into_iter()
        .map(|(key, (at, prior))| (key, (at, prior.deviation)));
    Ok(Solution {
        steps,
        decrement,
        objective,
        posterior: Posterior {
            platens,
            couriers: couriers.collect(),
            factor,
        },
    })
}

/// The step, in deviations, that would lead back to the prior's mean.
fn back(state: &State, platen: &Platen, key: &Key, prior: &Prior) -> f64 {
    (prior.mean - state.value(platen, key)) / prior.deviation
}

/// Takes a platen's own unknowns out: what is left of its sums is added to the couriers'. With it, the inverse of L times the platen's right side.
fn eliminate(
    platen: &Platen,
    sums: &Sums,
    state: &State,
    prior_weight: f64,
    couriers: &BTreeMap<Key, (usize, Prior)>,
    precision: &mut DMatrix<f64>,
    right: &mut DVector<f64>,
) -> Option<(Eliminated, DVector<f64>)> {
    // Keys ascend, and those that platens share are the last.
    let count = sums
        .columns
        .iter()
        .take_while(|(key, _)| !key.is_shared())
        .count();
    let gram = &sums.gram;
    let own = DMatrix::from_fn(count, count, |i, j| match i.cmp(&j) {
        std::cmp::Ordering::Less => 0.0,
        std::cmp::Ordering::Equal => gram[(i, j)] + prior_weight,
        std::cmp::Ordering::Greater => gram[(i, j)],
    });
    let own_right = DVector::from_fn(count, |k, _| {
        let (key, prior) = &sums.columns[k];
        sums.right[k] + back(state, platen, key, prior)
    });
    let half = Factor::new(own)?.lower_inverse();
    let of_couriers = &sums.columns[count..];
    let places: Vec<usize> = of_couriers
        .iter()
        .filter_map(|(key, _)| Some(couriers.get(key)?.0))
        .collect();
    let products = DMatrix::from_fn(count, places.len(), |i, j| gram[(count + j, i)]);
    let with = &half * products;
    let forward = &half * own_right;
    // Not tr_mul, which goes element by element.
    let taken = with.transpose() * &with;
    let taken_right = with.tr_mul(&forward);
    let mut with_couriers = DMatrix::zeros(count, couriers.len());
    for (j, at) in places.iter().enumerate() {
        with_couriers.set_column(*at, &with.column(j));
        right[*at] += sums.right[count + j] - taken_right[j];
        for (i, other) in places.iter().enumerate() {
            precision[(*other, *at)] += gram[(count + i, count + j)] - taken[(i, j)];
        }
    }
    let keys = sums.columns[..count].iter().enumerate();
    let own = keys
        .map(|(k, (key, prior))| (key.clone(), (k, prior.deviation)))
        .collect();
    Some((
        Eliminated {
            own,
            half,
            with_couriers,
        },
        forward,
    ))
}

impl Posterior {
    /// Predicted deviation of a linear function of a platen's and the couriers' unknowns, in the function's unit. An unknown that is in no
    /// sum adds nothing.
    #[must_use]
    pub fn deviation(&self, platen: &Platen, function: &[(Key, f64)]) -> f64 {
        self.deviation_of_sum(&[(platen, function)])
    }

    /// The same of the sum of a function of each of several platens.
    #[must_use]
    pub fn deviation_of_sum(&self, functions: &[(&Platen, &[(Key, f64)])]) -> f64 {
        let mut of_couriers = DVector::zeros(self.couriers.len());
        let mut variance = 0.0;
        for (platen, function) in functions {
            let [own, couriers] = self.unsolved(platen, function);
            variance += own.norm_squared();
            of_couriers += couriers;
        }
        (variance + self.factor.half(&of_couriers).norm_squared()).sqrt()
    }

    /// Predicted covariance of such functions of one platen.
    #[must_use]
    pub fn covariance(&self, platen: &Platen, functions: &[Vec<(Key, f64)>]) -> DMatrix<f64> {
        let roots = functions.iter().map(|f| self.root(platen, f));
        let (own, of_couriers): (Vec<_>, Vec<_>) = roots.map(|[own, rest]| (own, rest)).unzip();
        let count = functions.len();
        let mut covariance = DMatrix::zeros(count, count);
        for columns in [own, of_couriers] {
            if !columns.is_empty() {
                let root = DMatrix::from_columns(&columns);
                covariance += root.transpose() * root;
            }
        }
        covariance
    }

    /// What is left of each unknown's prior variance, by key.
    #[must_use]
    pub fn shares_left(&self) -> Vec<(Platen, Key, f64)> {
        let courier = self.factor.clone().lower_inverse();
        let each = self.couriers.iter();
        let mut shares: Vec<(Platen, Key, f64)> = each
            .map(|(key, (at, _))| {
                (
                    Platen::default(),
                    key.clone(),
                    courier.column(*at).norm_squared(),
                )
            })
            .collect();
        for (platen, eliminated) in &self.platens {
            let with = &courier * (eliminated.with_couriers.transpose() * &eliminated.half);
            shares.extend(eliminated.own.iter().map(|(key, (at, _))| {
                let own = eliminated.half.column(*at).norm_squared();
                (
                    platen.clone(),
                    key.clone(),
                    own + with.column(*at).norm_squared(),
                )
            }));
        }
        shares
    }

    /// Vectors whose products with those of another function make the covariance of both: of the platen's unknowns and of the couriers'.
    fn root(&self, platen: &Platen, function: &[(Key, f64)]) -> [DVector<f64>; 2] {
        let [own, of_couriers] = self.unsolved(platen, function);
        [own, self.factor.half(&of_couriers)]
    }

    /// The same before the couriers' factor is solved for.
    fn unsolved(&self, platen: &Platen, function: &[(Key, f64)]) -> [DVector<f64>; 2] {
        let mut of_couriers = DVector::zeros(self.couriers.len());
        for (key, weight) in function {
            if let Some((at, unit)) = self.couriers.get(key) {
                of_couriers[*at] += weight * unit;
            }
        }
        let mut own = DVector::zeros(0);
        if let Some(eliminated) = self.platens.get(platen) {
            own = DVector::zeros(eliminated.half.nrows());
            for (key, weight) in function {
                if let Some((at, unit)) = eliminated.own.get(key) {
                    own.axpy(weight * unit, &eliminated.half.column(*at), 1.0);
                }
            }
            of_couriers -= eliminated.with_couriers.tr_mul(&own);
        }
        [own, of_couriers]
    }
}

impl Solution {
    /// The state behind the step.
    #[must_use]
    pub fn stepped(&self, state: &State) -> State {
        let mut next = state.clone();
        for (platen, key, step) in &self.steps {
            next.add(platen, key, *step);
        }
        next.steps += 1;
        next
    }
}
