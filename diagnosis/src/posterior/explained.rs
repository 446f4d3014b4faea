//! The likeliest sets, each with its numbers and with why it lost.

use super::alias::divergence;
use super::problem::Problem;
use super::weighed::Weighed;

/// A set of effects as it is told. Logarithms are natural.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its effects.
    pub effects: Vec<String>,
    /// Coordinates that hold what it leaves.
    pub shapes: Vec<String>,
    /// Probability.
    pub probability: f64,
    /// Logarithm of the evidence, over the best set's; with its shapes and its noise.
    pub log_evidence: f64,
    /// Logarithm of the prior odds, over the best set's.
    pub log_prior: f64,
    /// Logarithm of what cutting off trifles makes of it.
    pub log_least: f64,
    /// Held-out whitened squares that it takes off the baseline's.
    pub held_out_gain: f64,
    /// It predicts what the best set predicts, as far as this motion can tell.
    pub alias: bool,
    /// Why it lost.
    pub lost: &'static str,
}

/// What [`Row::cells`] holds.
pub const HEADER: [&str; 8] = [
    "set of effects (what none holds, by)",
    "probability",
    "ln evidence",
    "ln prior",
    "ln size",
    "held-out gain",
    "alias",
    "why it is not the first",
];

impl Row {
    /// Its line of a table under [`HEADER`].
    pub fn cells(&self) -> [String; HEADER.len()] {
        let effects = match &self.effects[..] {
            [] => "none".to_owned(),
            effects => effects.join(" + "),
        };
        let set = match &self.shapes[..] {
            [] => effects,
            shapes => format!("{effects} ({})", shapes.join(", ")),
        };
        [
            set,
            format!("{:.3}", self.probability),
            format!("{:.1}", self.log_evidence),
            format!("{:.1}", self.log_prior),
            format!("{:.1}", self.log_least),
            format!("{:.0}", self.held_out_gain),
            if self.alias { "yes" } else { "" }.to_owned(),
            self.lost.to_owned(),
        ]
    }
}

/// Rows of the likeliest sets. `held_out` gives a set's held-out squares.
pub fn rows(
    problem: &Problem,
    told: &[Weighed],
    names: &[String],
    mut held_out: impl FnMut(&[usize]) -> f64,
) -> Vec<Row> {
    let weight = |w: &Weighed| w.log_weight(problem.log_odds);
    let Some(best) = told.first() else {
        return Vec::new();
    };
    let total = super::noise_scale::log_sum(told.iter().map(weight));
    let baseline = held_out(&[]);
    let prior = |w: &Weighed| w.log_prior + w.nameless.as_ref().map_or(0.0, |n| n.0.log_prior);
    let evidence = |w: &Weighed| weight(w) - prior(w) - w.log_least;
    let name = |b: &usize| names[*b].clone();
    let row = |w: &Weighed| {
        let shapes = w.nameless.iter().flat_map(|n| n.0.coordinates.iter());
        let mut out = Row {
            effects: w.set().iter().map(name).collect(),
            shapes: shapes.map(|c| name(&problem.coordinates[*c])).collect(),
            probability: (weight(w) - total).exp(),
            log_evidence: evidence(w) - evidence(best),
            log_prior: prior(w) - prior(best),
            log_least: w.log_least,
            held_out_gain: baseline - held_out(w.set()),
            alias: !w.set().is_empty()
                && w.set() != best.set()
                && divergence(problem, best, w).is_alias(),
            lost: "",
        };
        out.lost = if w.set() == best.set() {
            "the likeliest"
        } else {
            why(&out, best.log_least)
        };
        out
    };
    told.iter().map(row).collect()
}

/// What weighs most against a set.
fn why(row: &Row, least_of_best: f64) -> &'static str {
    let all = [
        (row.log_evidence, "the data are less likely under it"),
        (
            row.log_prior,
            "it is less likely before the data: more effects, or a nameless shape",
        ),
        (
            row.log_least - least_of_best,
            "one of its effects is too small to be worth a name",
        ),
    ];
    all.into_iter()
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or("", |least| least.1)
}
