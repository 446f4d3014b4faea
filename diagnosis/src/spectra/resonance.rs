//! How a vibration swells and strays: lines beside a stronger one stand for it, and another recording has others. What another
//! recording will show is what one half of this one foretells of the other: within a stronger line's resonance nearly as much of it
//! as is there, and over many beats. So it is where the drive itself is modulated, by a shaft that turns unevenly; what a mount
//! rings with by chance keeps no phase.

use crate::algebra::normal_equations::Sums;
use crate::inference::residuals::Residuals;
use crate::linearization::recording::range;
use crate::linearization::relinearized::RelinearizedFit;
use effects::Detection;
use effects::sensor::SLOWEST_LINE_HZ;
use nalgebra::DVector;

/// A mount rings some ten times: lines nearer to a stronger one than this share of its frequency are one resonance's. Derived
/// from a damped mount's width: one that rings ten times has a quality of about 30, and is as wide as a thirtieth of its
/// frequency.
pub const RESONANCE: f64 = 1.0 / 30.0;
/// Within a resonance a line is a modulation's if one half of the recording foretells this share of what it takes of the other,
const PERSISTS: f64 = 0.8;
/// and it has this many beats with the stronger line: a swell as slow as the recording keeps its phase in it as well.
const PERSISTING_BEATS: f64 = 8.0;
/// What holds the amount of a line: next to nothing. Derived from 16 digits: beside one reading it is a thousand millionth, and
/// the sums are still solved.
const FREE: f64 = 1e-9;
/// Columns of one line: sine and cosine, along x and y. A definition: two and two.
const OF_A_LINE: usize = 4;

/// Columns of the lines beside a vibration's strongest.
#[derive(Default)]
pub struct AmplitudeModulation {
    /// Those that belong to this recording's time.
    pub time_bound: Vec<usize>,
    /// Those within a stronger line's resonance that another recording will show: of one whose drive is modulated alike.
    pub beats: Vec<usize>,
}

/// Tells the lines that another recording will show from those that it will not.
pub fn amplitude_modulation(relinearized: &RelinearizedFit) -> AmplitudeModulation {
    let mut out = AmplitudeModulation::default();
    let Some(block) = relinearized
        .columns
        .blocks
        .iter()
        .find(|b| effects::is(&b.name, Detection::ByLines))
    else {
        return out;
    };
    let columns: Vec<usize> = block.columns.clone().collect();
    let hz = relinearized
        .linearized
        .inputs
        .beacon_lines_hz
        .iter()
        .copied();
    let hz = hz.filter(|hz| *hz >= SLOWEST_LINE_HZ);
    let mut lines: Vec<(&[usize], f64)> = columns.chunks(OF_A_LINE).zip(hz).collect();
    if lines.len() < 2 {
        return out;
    }
    let power = |line: &[usize]| {
        line.iter()
            .map(|c| relinearized.coefficient(*c).powi(2))
            .sum::<f64>()
    };
    lines.sort_by(|a, b| power(b.0).total_cmp(&power(a.0)));
    let halves = halves(relinearized, &columns);
    let times = relinearized.residuals().sample.iter();
    let times: Vec<f64> = times
        .map(|i| relinearized.linearized.observations.t_s[*i])
        .collect();
    let span_s = range(&times).map_or(0.0, |[from, to]| to - from);
    let places = |line: &[usize]| line.iter().map(|c| c - columns[0]).collect::<Vec<usize>>();
    let mut kept = places(lines[0].0);
    for (k, (line, hz)) in lines.iter().enumerate().skip(1) {
        let stronger = lines[..k].iter().map(|line| line.1);
        let beside: Vec<f64> = stronger
            .filter(|s| (hz / s - 1.0).abs() < RESONANCE)
            .collect();
        let slow = beside
            .iter()
            .any(|s| (hz - s).abs() * span_s < PERSISTING_BEATS);
        let least = if beside.is_empty() { 0.0 } else { PERSISTS };
        let with: Vec<usize> = kept.iter().copied().chain(places(line)).collect();
        if slow || !persists(&halves, &kept, &with, least) {
            out.time_bound.extend_from_slice(line);
            continue;
        }
        kept = with;
        if !beside.is_empty() {
            out.beats.extend_from_slice(line);
        }
    }
    out
}

/// True if either half foretells of the other more than this share of what some columns take beside those that are known.
fn persists(halves: &[Sums; 2], known: &[usize], with: &[usize], share: f64) -> bool {
    let taken: f64 = halves.iter().map(|h| h.left(known) - h.left(with)).sum();
    foretold(halves, known) - foretold(halves, with) > share * taken
}

/// Both halves, in the order of the samples.
fn halves(relinearized: &RelinearizedFit, columns: &[usize]) -> [Sums; 2] {
    let left: &Residuals = relinearized.residuals();
    let middle = left.sample.get(left.sample.len() / 2).copied();
    let mut halves = [0, 1].map(|_| Sums::new(columns.len(), FREE));
    let mut start = 0;
    while start < left.sample.len() {
        let i = left.sample[start];
        let rows = relinearized.linearized.rows(i);
        let covariates = relinearized.linearized.covariates(i);
        let responses: Vec<_> = columns
            .iter()
            .map(|c| rows.response(&relinearized.columns.regressors[*c], &covariates))
            .collect();
        let half = &mut halves[usize::from(Some(i) >= middle)];
        for row in 0..rows.count {
            let k = start + row;
            let weight = 1.0 / left.noise_m[k].max(1e-12);
            let regressor =
                DVector::from_iterator(columns.len(), responses.iter().map(|r| weight * r[row]));
            let added = columns.iter().zip(&responses);
            let added: f64 = added
                .map(|(c, r)| relinearized.coefficient(*c) * r[row])
                .sum();
            let without = weight * (left.value_m[k] - added);
            half.add(&regressor, without);
        }
        start += rows.count.max(1);
    }
    halves
}

/// Whitened squares of each half with some columns, fitted on the other.
fn foretold(halves: &[Sums; 2], list: &[usize]) -> f64 {
    let [one, other] = halves;
    one.left_with(list, other.coefficients(list)) + other.left_with(list, one.coefficients(list))
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};

    const ROWS: usize = 4000;
    const LINE: f64 = 0.21;
    const BEAT: f64 = 0.005;

    /// A wave whose size follows the sample; columns: sine and cosine of the line, then of the one that the beat lays above it.
    fn halves(mut size: impl FnMut(f64) -> f64) -> [Sums; 2] {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut halves = [0, 1].map(|_| Sums::new(4, FREE));
        for i in 0..ROWS {
            let t = std::f64::consts::TAU * i as f64;
            let (a, b) = (LINE * t, (LINE + BEAT) * t);
            let columns = DVector::from_vec(vec![a.sin(), a.cos(), b.sin(), b.cos()]);
            let value = 5.0 * size(i as f64) * a.sin() + normal(&mut rng);
            halves[usize::from(2 * i >= ROWS)].add(&columns, value);
        }
        halves
    }

    #[test]
    fn what_beats_evenly_persists_and_what_swells_by_chance_does_not() {
        let persists = |halves| persists(&halves, &[0, 1], &[0, 1, 2, 3], PERSISTS);
        let even = |i: f64| 1.0 + 0.4 * (std::f64::consts::TAU * BEAT * i).sin();
        assert!(persists(halves(even)));
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let keeps = 1.0 - BEAT;
        let mut kept = 0;
        for _ in 0..20 {
            let mut level = normal(&mut rng);
            let chance = |_: f64| {
                level = keeps * level + (1.0 - keeps * keeps).sqrt() * normal(&mut rng);
                1.0 + 0.4 * level
            };
            kept += usize::from(persists(halves(chance)));
        }
        assert!(kept <= 1, "{kept} of 20");
    }
}
