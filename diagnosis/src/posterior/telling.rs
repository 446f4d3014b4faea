//! What may be told where a set is found: the set, or a part of it, where the rest is a trifle or what the forms of the others lack.

use super::discrepancy::{AT_MOST, log_density_of_size};
use super::least_size::{lacking, least_squares, log_trifle};
use super::problem::{Prior, Problem};
use super::weighed::Weighed;
use std::collections::HashMap;

/// What is told where a set is found.
pub(super) struct Telling {
    /// Place of the set that is told.
    pub(super) set: usize,
    /// Logarithm of what this changes in the set's weight.
    pub(super) log_change: f64,
    /// Whitened squares of what is found and is taken not to be worth a name: no more of them than that.
    pub(super) trifles: f64,
    /// Whitened squares that the forms of the effects that are told may lack.
    pub(super) lacking: f64,
    /// Those of them that may be lines in the spectrum.
    pub(super) lacking_of_lines: f64,
}

/// Sizes of an effect that are told, in floors: any between them is as likely, by its logarithm. A prior: the sizes by which the diagnosis is judged
/// (`specimens::drawn`). How large an effect may be in metres says little of this, since sensors differ by orders of magnitude.
const SIZES_TOLD: [f64; 2] = [1.0 / 3.0, 20.0];

/// A set that was found, its effects told by their places in it, and what their forms may lack.
#[derive(Clone, Copy)]
pub(super) struct Found<'a> {
    problem: &'a Problem<'a>,
    all: &'a [Weighed],
    places: &'a Places<'a>,
    whole: &'a Weighed,
    /// Whitened squares below which no effect is worth a name.
    least: f64,
}

impl<'a> Found<'a> {
    /// One of all sets that were weighed.
    pub(super) fn of(
        problem: &'a Problem,
        all: &'a [Weighed],
        places: &'a Places,
        which: usize,
    ) -> Self {
        Self {
            problem,
            all,
            places,
            whole: &all[which],
            least: least_squares(problem.reduced.rows),
        }
    }

    /// What may be told of a set of several effects where not all of it is worth a name: all but one, which does less than that. A prior that is
    /// cut off below leaves what lies below to these: amounts that are not worth a name are none of a gap, and no reason to name an effect at a
    /// size that the data refute. The form of a trifle lacks nothing.
    pub(super) fn without_a_trifle(self) -> impl Iterator<Item = Telling> + 'a {
        let count = self.whole.shares.len();
        let each = 0..if count > 1 { count } else { 0 };
        each.filter_map(move |trifle| {
            let share = &self.whole.shares[trifle];
            let told: Vec<usize> = (0..count).filter(|k| *k != trifle).collect();
            let log_change = share.log_trifle - share.log_least;
            self.telling(&told, log_change, share.power.min(self.least))
        })
    }

    /// Nothing, where all effects of the set do less together than is worth a name.
    pub(super) fn nothing(self) -> Option<Telling> {
        let whole = self.whole;
        let (log_trifle, log_least, power) = match &whole.shares[..] {
            [] => return None,
            [share] => (share.log_trifle, share.log_least, share.power),
            _ => {
                let together = log_trifle(whole.explained, self.problem.reduced.rows);
                (together, whole.log_least, whole.explained)
            }
        };
        Some(Telling {
            set: self.places.of_set(&[], whole)?,
            log_change: log_trifle - log_least,
            trifles: power.clamp(0.0, self.least),
            lacking: 0.0,
            lacking_of_lines: 0.0,
        })
    }

    /// What may be told where some of the effects describe what the forms of the others lack: those others. What a form lacks lies along the
    /// columns of another effect with a probability that is measured (`effects::lacks_along`). Where several are not told, some of these may be
    /// trifles; that one alone is a trifle is told of by [`Self::without_a_trifle`].
    pub(super) fn without_what_forms_lack(self) -> impl Iterator<Item = Telling> + 'a {
        let shares = &self.whole.shares;
        let count = shares.len();
        let one = move |kept: usize| {
            let is_kept = |k: &usize| kept & (1 << k) != 0;
            let told: Vec<usize> = (0..count).filter(is_kept).collect();
            let (mut log_change, mut trifles) = (0.0, 0.0);
            for dropped in (0..count).filter(|k| !is_kept(k)) {
                let share = &shares[dropped];
                let each = told.iter().map(|of| self.log_lacking(*of, dropped));
                let along = each.fold(f64::NEG_INFINITY, f64::max);
                let alone = told.len() + 1 == count;
                if share.log_trifle > along && !alone {
                    trifles += share.power.min(self.least);
                    log_change += share.log_trifle - share.log_least;
                } else {
                    log_change += along - share.log_least;
                }
            }
            if !log_change.is_finite() {
                return None;
            }
            self.telling(&told, log_change, trifles)
        };
        (1..(1_usize << count).saturating_sub(1)).filter_map(one)
    }

    fn prior(&self, k: usize) -> Option<&Prior> {
        let block = self.whole.set()[k];
        self.problem.effects.iter().find(|e| e.block == block)
    }

    fn log_odds(&self, k: usize) -> f64 {
        self.prior(k).map_or(0.0, |e| e.log_odds)
    }

    /// Share of its amplitude that an effect's form may lack.
    fn inexactness(&self, k: usize) -> f64 {
        self.prior(k).map_or(0.0, |e| e.inexactness)
    }

    /// The same of lines in the spectrum.
    fn in_lines(&self, k: usize) -> f64 {
        let block = self.whole.set()[k];
        self.problem.in_lines(block, self.inexactness(k))
    }

    /// Whitened squares that the form of one effect may lack along the columns of another.
    fn may_lack(&self, of: usize, along: usize) -> f64 {
        let makes_lines = self.problem.of_lines.contains(&self.whole.set()[along]);
        let share = if makes_lines {
            self.in_lines(of)
        } else {
            self.inexactness(of)
        };
        share * share * self.whole.powers[of]
    }

    /// Logarithm of how much likelier it is that one effect is what the form of another lacks than that it acts, whatever its size.
    fn log_lacking(&self, of: usize, along: usize) -> f64 {
        let power = self.whole.shares[along].power;
        let may_lack = self.may_lack(of, along);
        if power > AT_MOST * AT_MOST * may_lack {
            return f64::NEG_INFINITY;
        }
        let [of, block] = [of, along].map(|k| self.whole.set()[k]);
        let lacks = self.problem.along.along(of, block).ln() + log_density_of_size(power, may_lack);
        let range: f64 = SIZES_TOLD[1] / SIZES_TOLD[0];
        let acts = self.log_odds(along) - range.powi(2).ln().ln();
        lacks - acts
    }

    /// What is told where some of the effects are, and the others are not.
    fn telling(&self, told: &[usize], log_change: f64, trifles: f64) -> Option<Telling> {
        let set: Vec<usize> = told.iter().map(|k| self.whole.set()[*k]).collect();
        let place = self.places.of_set(&set, self.whole)?;
        let by = |share: &dyn Fn(usize) -> f64| {
            let each = told.iter().map(|k| (self.whole.powers[*k], share(*k)));
            lacking(self.whole.explained, each)
        };
        Some(Telling {
            set: without_trifling_shapes(self.problem, self.all, self.places, place),
            log_change,
            trifles,
            lacking: by(&|k| self.inexactness(k)),
            lacking_of_lines: by(&|k| self.in_lines(k)),
        })
    }
}

/// Places of sets among all that were weighed.
pub(super) struct Places<'a>(HashMap<(&'a [usize], u64), usize>);

impl<'a> Places<'a> {
    pub(super) fn of(all: &'a [Weighed]) -> Self {
        let each = all.iter().enumerate().rev();
        Self(each.map(|(k, w)| ((w.set(), Self::noise(w)), k)).collect())
    }

    /// Sets are weighed at few noises, each with all its sets at the very same.
    fn noise(weighed: &Weighed) -> u64 {
        weighed.left.log_noise.to_bits()
    }

    /// Place of a set at the noise of another.
    fn of_set(&self, set: &[usize], at: &Weighed) -> Option<usize> {
        self.0.get(&(set, Self::noise(at))).copied()
    }
}

/// Place of the set that is told where a set is found. An effect that is a shape may describe what the forms of the set's causes lack, as
/// nameless shapes may: where it does no more than that, the causes are told without it.
pub(super) fn without_trifling_shapes(
    problem: &Problem,
    all: &[Weighed],
    places: &Places,
    of: usize,
) -> usize {
    let is_shape = |b: &usize| problem.effects.iter().any(|e| e.block == *b && e.shape);
    let each = all[of].set().iter().zip(&all[of].shares);
    let stays = each.filter(|(b, share)| !is_shape(b) || share.power > share.may_be_lacking);
    let causes: Vec<usize> = stays.map(|(b, _)| *b).collect();
    let place = places.of_set(&causes, &all[of]);
    place.filter(|_| !causes.is_empty()).unwrap_or(of)
}
