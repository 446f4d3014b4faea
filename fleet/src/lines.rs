//! The straight parts of platens' lines, each less the mean of all that couriers connect: the angle between a diode's axes and the difference of their
//! gains add the same to every platen that its courier crosses.

use crate::functions::{Function, value, visited_by_segments};
use crate::key::{Key, Platen, RULINGS};
use crate::member::Member;
use crate::passes::{Fitted, by_platen};
use crate::state::State;
use crate::straight::{SegmentCells, straight};
use crate::sums::Sums;
use crate::told::Told;
use std::collections::{BTreeMap, BTreeSet};

/// What is asked of each platen, and what is known of it before the data.
pub struct Lines {
    /// Functions, where a platen's cells tell any.
    functions: BTreeMap<Platen, [Function; 2]>,
    /// Deviations of the unknowns.
    priors: BTreeMap<Platen, BTreeMap<Key, f64>>,
}

/// The share of each of so many in their mean. What is by itself is told as it is: less itself it would be nothing.
pub fn share_of_mean(count: usize) -> f64 {
    if count > 1 { 1.0 / count as f64 } else { 0.0 }
}

/// The straight parts over some cells of a recording's platen.
pub fn straight_of(member: &Member, state: &State, cells: &SegmentCells) -> Option<[Function; 2]> {
    let lattice = state.unknowns(member).lattice();
    let beacon_m = state.beacon_m(&member.platen);
    straight(lattice, cells, member.setup.pitch_m, beacon_m)
}

impl Lines {
    /// Over all cells that were crossed.
    pub fn of(members: &[Member], fitted: &Fitted) -> Self {
        let mut crossed: BTreeMap<&Platen, (&Member, SegmentCells)> = BTreeMap::new();
        for member in members {
            let first = || (member, SegmentCells::default());
            let (_, of_it) = crossed.entry(&member.platen).or_insert_with(first);
            let visited = visited_by_segments(member, &fitted.state);
            of_it
                .iter_mut()
                .zip(visited)
                .for_each(|(all, own)| all.extend(own));
        }
        let of_one = |(platen, (member, cells)): (&Platen, (&Member, SegmentCells))| {
            let functions = straight_of(member, &fitted.state, &cells)?;
            Some((platen.clone(), functions))
        };
        let prior = |(platen, sums): (Platen, Sums)| {
            let columns = sums.columns.into_iter();
            let deviations = columns.map(|(key, prior)| (key, prior.deviation));
            (platen, deviations.collect())
        };
        let sums = by_platen(members, &fitted.sums);
        Self {
            functions: crossed.into_iter().filter_map(of_one).collect(),
            priors: sums.into_iter().map(prior).collect(),
        }
    }

    /// One of the straight parts of a platen, less the mean of some. What one recording tells is left open. A platen whose cells tell none is told no
    /// better than before the data.
    pub fn less_mean(
        &self,
        fitted: &Fitted,
        name: &Platen,
        names: &BTreeSet<&Platen>,
        which: usize,
    ) -> Told {
        let each = names.iter();
        let told: Vec<(&Platen, &Function)> = each
            .filter_map(|platen| Some((*platen, &self.functions.get(platen)?[which])))
            .collect();
        let share = share_of_mean(told.len());
        let functions: Vec<(&Platen, Function)> = told
            .into_iter()
            .map(|(platen, function)| {
                let weight = f64::from(u8::from(platen == name)) - share;
                let weighted = function.iter().map(|(key, w)| (key.clone(), weight * w));
                (platen, weighted.collect())
            })
            .collect();
        let prior = self.prior(&functions);
        let is_open = !self.functions.contains_key(name);
        if is_open {
            return Told {
                value: 0.0,
                deviation: prior,
                alone: prior,
                prior,
            };
        }
        let values = functions.iter();
        let values = values.map(|(platen, f)| value(&fitted.state, platen, f));
        let parts: Vec<(&Platen, &[(Key, f64)])> =
            functions.iter().map(|(p, f)| (*p, &f[..])).collect();
        Told {
            value: values.sum(),
            deviation: fitted.solution.posterior.deviation_of_sum(&parts),
            alone: prior,
            prior,
        }
    }

    /// Deviation before the data by pitches and angle of the rulings, which no recording tells alone: of a field's slope and of bows it may tell
    /// something.
    fn prior(&self, functions: &[(&Platen, Function)]) -> f64 {
        let variances = functions.iter().flat_map(|(platen, function)| {
            let priors = self.priors.get(*platen);
            let rulings = function
                .iter()
                .filter(|(key, _)| RULINGS[..2].contains(key));
            rulings.map(move |(key, w)| {
                let prior = priors.and_then(|of| of.get(key)).copied();
                (w * prior.unwrap_or(0.0)).powi(2)
            })
        });
        variances.sum::<f64>().sqrt()
    }
}
