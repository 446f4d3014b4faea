//! A column as one number a sample for each source that it acts by: what products of columns are formed of.

use crate::linearization::recording::{ROWS, SOURCES, TARGET};
use effects::sensor::{Action, CHANNELS, Covariates, READINGS, Regressor};
use std::ops::Range;

/// The readings among the sources of `SampleRows::white_sources`.
const BY_READING: Range<usize> = 0..READINGS;
/// The channels.
const BY_CHANNEL: Range<usize> = READINGS..READINGS + CHANNELS;

/// What a unit amount is at some samples, for each source that the column may act by; the sources are the same for all samples. The
/// samples of one column follow one another, so that its function and what it looks at stay at hand.
pub fn by_source(regressor: &Regressor, samples: &[&Covariates]) -> Vec<(usize, Vec<f64>)> {
    let one = |value: &dyn Fn(&Covariates) -> f64| {
        let at = |sample: &&Covariates| {
            if regressor.acts(sample) {
                value(sample)
            } else {
                0.0
            }
        };
        samples.iter().map(at).collect()
    };
    match &regressor.action {
        Action::Reading(reading, value) => vec![(BY_READING.start + reading, one(value))],
        Action::Channel(channel, value) => vec![(BY_CHANNEL.start + channel, one(value))],
        Action::Readings(_) => several(regressor, samples, BY_READING, |m| {
            regressor.action.on_readings(m)
        }),
        Action::Channels(_) => several(regressor, samples, BY_CHANNEL, |m| {
            regressor.action.on_channels(m)
        }),
    }
}

/// The same of a column that adds to several at once.
fn several<const N: usize>(
    regressor: &Regressor,
    samples: &[&Covariates],
    sources: Range<usize>,
    add: impl Fn(&Covariates) -> [f64; N],
) -> Vec<(usize, Vec<f64>)> {
    let mut out: Vec<_> = sources
        .map(|source| (source, vec![0.0; samples.len()]))
        .collect();
    for (i, sample) in samples.iter().enumerate() {
        if regressor.acts(sample) {
            let values = out.iter_mut().zip(add(sample));
            values.for_each(|((_, values), value)| values[i] = value);
        }
    }
    out
}

/// Numbers of columns, and of the target as the last, in the order of the sources that they act by: products of two sources are then
/// next to each other.
pub fn in_order_of_sources(regressors: &[Regressor]) -> Vec<usize> {
    let source = |c: &usize| match regressors.get(*c).map(|regressor| &regressor.action) {
        Some(Action::Reading(reading, _)) => BY_READING.start + reading,
        Some(Action::Readings(_)) => BY_READING.end - 1,
        Some(Action::Channel(channel, _)) => BY_CHANNEL.start + channel,
        Some(Action::Channels(_)) => BY_CHANNEL.end - 1,
        None => TARGET,
    };
    let mut order: Vec<usize> = (0..=regressors.len()).collect();
    order.sort_by_key(source);
    order
}

/// Place of each column, and of the target, in that order.
pub fn places(in_order: &[usize]) -> Vec<usize> {
    let mut place = vec![0; in_order.len()];
    in_order.iter().enumerate().for_each(|(k, c)| place[*c] = k);
    place
}

/// Product of the vectors of two sources of a sample.
pub fn product(vectors: &[[f64; ROWS]; SOURCES], [s, t]: [usize; 2]) -> f64 {
    let parts = vectors[s].iter().zip(&vectors[t]);
    parts.map(|(a, b)| a * b).sum()
}
