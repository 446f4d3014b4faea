//! The next motion: that of most expected information a second about what is not determined yet.

use crate::cover::covered;
use crate::known::{Group, Known, SIGHT_S, Seen, ToldBy, groups, known};
use crate::motion::{Area, Move, SPEEDS_M_S, available};
use crate::products::Totals;
use crate::question::Question;
use diagnosis::Insufficient;
use diagnosis::design::excitation::{Excitation, PAUSE_S, Path, excitation};
use diagnosis::design::gram::Products;
use effects::motion::Pose;
use recording::{Recording, Samples};

/// What is recorded and asked.
#[derive(Clone, Copy, Debug)]
pub struct Recorded<'a> {
    /// The samples.
    pub recording: &'a Recording,
    /// The motions that they were taken on, in order.
    pub made: &'a [Move],
    /// Where the courier stands.
    pub at: Pose,
    /// Where motions may go.
    pub area: &'a Area,
    /// The question.
    pub question: Question,
}

/// What is known, and what each motion that may follow would add.
pub struct Outlook {
    excitation: Excitation,
    groups: Vec<Group>,
    totals: Totals,
    samples_a_step: Vec<f64>,
    moves: Vec<Move>,
    /// What was made, and what would be with each motion.
    now: Seen,
    then: Vec<Seen>,
    known: Vec<Known>,
}

/// Samples of a recording that are looked at, at most. A bound on the work: of longer ones they are evenly spread.
const LOOKED_AT: usize = 3000;
/// Times that each motion may be made before its information counts as all that it can give. A prior: one recording keeps to
/// that, since a survey's time has room for some ten motions.
const MANY_TIMES: f64 = 20.0;

impl Outlook {
    /// Looks at what is recorded. Cost: some thousand samples by the square of some hundred columns.
    ///
    /// # Errors
    /// Too little is recorded for a first calibration.
    pub fn new(recorded: &Recorded) -> Result<Self, Insufficient> {
        let moves = available(recorded.at, recorded.area);
        let paths: Vec<Path> = moves.iter().map(Move::path).collect();
        let samples = &recorded.recording.samples;
        let thinned = samples.len().div_ceil(LOOKED_AT).max(1) as f64;
        let excitation = excitation(&every(recorded.recording, thinned as usize), &paths)?;
        let step_s = samples.sample_interval_s().unwrap_or(1.0e-3);
        let samples_a_step: Vec<f64> = paths.iter().map(|path| path.step_s / step_s).collect();
        let totals = Totals::new(&excitation, thinned);
        let all = samples_a_step
            .iter()
            .enumerate()
            .fold(totals.clone(), |all, (k, weight)| {
                all.with(&excitation, k, MANY_TIMES * weight)
            });
        let mut groups = groups(recorded.question, &excitation);
        let asked: Vec<usize> = groups.iter().flat_map(|g| g.columns.clone()).collect();
        for group in &mut groups {
            group.look(&excitation, &all, &asked);
        }
        let sight = |products: &Products, step_s: f64| products.in_sight as f64 * step_s / SIGHT_S;
        let now = Seen {
            cover: covered(recorded.made, recorded.area),
            sight: sight(&excitation.so_far, thinned * step_s),
        };
        let with = |(k, go): (usize, &Move)| Seen {
            cover: covered(&[recorded.made, &[*go]].concat(), recorded.area),
            sight: now.sight + sight(&excitation.paths[k], paths[k].step_s),
        };
        let then = moves.iter().enumerate().map(with).collect();
        let judge = |group: &Group| known(group, &excitation, &totals, now);
        Ok(Self {
            known: groups.iter().map(judge).collect(),
            excitation,
            groups,
            totals,
            samples_a_step,
            moves,
            now,
            then,
        })
    }

    /// What is known of each group that is asked for.
    #[must_use]
    pub fn known(&self) -> &[Known] {
        &self.known
    }

    /// The motion of most expected information a second about what is not determined; none where no motion adds to it.
    #[must_use]
    pub fn next(&self) -> Option<Move> {
        self.best(&|known| !known.is_determined())
    }

    /// The same about some groups by name, though they count as determined; about all of them where none of those is asked for. For what a
    /// diagnosis leaves open on data that should have told.
    #[must_use]
    pub fn more_about(&self, names: &[String]) -> Move {
        let any = self.known.iter().any(|known| names.contains(&known.name));
        self.best(&|known| !any || names.contains(&known.name))
            .unwrap_or_else(|| self.across())
    }

    /// The longest way at the usual speed: what none of the columns waits for shows there if anywhere.
    fn across(&self) -> Move {
        let usual = self.moves.iter().filter(|go| go.speed_m_s == SPEEDS_M_S[1]);
        let longest = usual.max_by(|a, b| a.distance_m().total_cmp(&b.distance_m()));
        *longest.unwrap_or(&self.moves[0])
    }

    fn best(&self, wanted: &dyn Fn(&Known) -> bool) -> Option<Move> {
        let open: Vec<usize> = (0..self.groups.len())
            .filter(|g| wanted(&self.known[*g]))
            .collect();
        let before: Vec<f64> = open
            .iter()
            .map(|g| self.information(*g, &self.totals, self.now))
            .collect();
        let gain = |path: usize| {
            let weight = self.samples_a_step[path];
            let after = self.totals.clone().with(&self.excitation, path, weight);
            let gained = open
                .iter()
                .zip(&before)
                .map(|(g, before)| self.information(*g, &after, self.then[path]) - before);
            gained.sum::<f64>() / (self.moves[path].seconds() + PAUSE_S)
        };
        let gains = (0..self.moves.len()).map(gain).enumerate();
        let best = gains.max_by(|a, b| a.1.total_cmp(&b.1));
        best.filter(|(_, gain)| *gain > LEAST_GAIN)
            .map(|(path, _)| self.moves[path])
    }

    /// Of one group, beside the baseline and its closest rival.
    fn information(&self, group: usize, totals: &Totals, seen: Seen) -> f64 {
        let of = &self.groups[group];
        let ToldBy::Columns(list) = &of.told_by else {
            return of.made(seen).unwrap_or_default();
        };
        let rival = &self.known[group].rival;
        let closest = list.iter().find(|beside| beside.rival == *rival);
        closest.map_or(0.0, |b| totals.given(&b.own, &b.others).information())
    }
}

/// A motion that adds less than this to the logarithm of what is known, a column and second, adds nothing.
const LEAST_GAIN: f64 = 1.0e-3;

/// One sample in so many.
fn every(recording: &Recording, thinned: usize) -> Recording {
    if thinned == 1 {
        return recording.clone();
    }
    let mut samples = Samples::default();
    let kept: Vec<usize> = (0..recording.samples.len()).step_by(thinned).collect();
    kept.iter()
        .for_each(|i| samples.push(&recording.samples.row(*i)));
    for logged in recording.samples.logged() {
        samples.log(recording::Logged {
            name: logged.name.clone(),
            values: kept.iter().map(|i| logged.values[*i]).collect(),
        });
    }
    Recording {
        meta: recording.meta.clone(),
        samples,
        warnings: Vec::new(),
    }
}
