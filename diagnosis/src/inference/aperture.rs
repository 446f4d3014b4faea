//! How many teeth a segment averages over, and how much they are displaced: what makes the readings over a few patches of the
//! platen likeliest. Displacements are independent of each other, so that an aperture gives the covariance of any two readings
//! (Rasmussen and Williams 2006, sections 2.2 and 5.4); no tooth is asked for.

use crate::linearization::relinearized::RelinearizedFit;
use effects::Detection;
use effects::sensor::READINGS;
use nalgebra::{DMatrix, DVector};
use normal_equations::cholesky::Factor;
use rayon::prelude::*;
use std::collections::BTreeMap;
use tooth_field::{ApertureKernel, Teeth, correlations};

/// Patches of the platen, those that most samples went over; pitches to a side, and most samples of each. A bound on the work: a
/// likelihood costs the cube of a patch's rows, and of fewer samples the footprint is known less well.
const PATCHES: usize = 2;
/// See [`PATCHES`].
const SIDE_PITCHES: f64 = 5.0;
/// See [`PATCHES`].
const MOST_PATCH_SAMPLES: usize = 90;
/// Fewest samples of a patch. Derived from the six parameters that are looked for: five samples to each.
const FEWEST_PATCH_SAMPLES: usize = 30;
/// Deviation of what a patch's rows of a channel have in common, of the noise. Derived from a free offset: a hundred noises hold
/// it at a ten-thousandth of what one reading tells.
const COMMON_OFFSET_NOISES: f64 = 100.0;
/// A search ends where its steps are this small. Derived from what follows: a footprint that is off by 4 % shifts an edge by an
/// eighth of a pitch at the most (of 3 pitches), which amounts a pitch apart do not tell.
const SMALLEST_STEP: f64 = 0.04;
/// Values of a covariance that are tabulated for a pitch. Derived from straight lines between them: of a covariance that bends
/// over a pitch, 1/8 (1/64)² is 3e-5.
const PER_PITCH: f64 = 64.0;

/// Edges from which on an aperture is a bell, and amounts to its half: the most that are not too many.
const BELL_EDGE: f64 = 0.6;
/// See [`BELL_EDGE`].
const COEFFICIENTS_TO_A_HALF: [f64; 3] = [3.0, 2.4, 2.0];

/// What is looked for.
#[derive(Clone, Copy, Debug)]
struct ApertureParameters {
    aperture: ApertureKernel,
    /// Deviation of a reading by single teeth, m, and of one by whole lines over that.
    size_m: f64,
    lines: f64,
    /// What else shows under a beacon, over the noise.
    beacon: f64,
}

/// Several readings of a whitened row: a segment's place, pitches, and the row's derivative by its reading, 1/m.
struct Row {
    channel: usize,
    value: f64,
    by_reading: [f64; READINGS],
    places: [[f64; 2]; 4],
}

/// Rows over a patch.
type Patch = Vec<Row>;

/// Footprint, prior deviations and teeth of a field that was found. None where there is too little to tell, or too much to ask for.
pub fn find(relinearized: &RelinearizedFit) -> Option<Teeth> {
    let patches = patches(relinearized);
    if patches.is_empty() {
        return None;
    }
    let (guess, likelihood) = likeliest(&patches)?;
    crate::trace::log(&format!("{guess:.2?}, log likelihood {likelihood:.0}"));
    let in_steps = |step_pitches: [f64; 2]| {
        let mut teeth = Teeth {
            aperture: guess.aperture,
            step_pitches,
            ..Teeth::default()
        };
        let lattice = teeth.lattice();
        teeth.deviation_m = [
            guess.size_m / lattice.deviation_by_nodes(),
            guess.lines * guess.size_m / lattice.deviation_by_lines(),
        ];
        crate::design::knots::list_teeth(&relinearized.linearized, &mut teeth).then_some(teeth)
    };
    steps(&guess.aperture).into_iter().find_map(in_steps)
}

/// Pitches from one amount to the next, finest first. A bell blurs what is shorter than its half, and amounts so far apart as a good
/// part of that give every field that it lets through; what has edges shows each tooth as it comes in.
fn steps(aperture: &ApertureKernel) -> Vec<[f64; 2]> {
    let half = aperture.half_pitches;
    let apart = |n: f64| half.map(|half| (half / n).max(1.0));
    let edged = (aperture.edge <= BELL_EDGE).then_some([1.0; 2]);
    edged
        .into_iter()
        .chain(COEFFICIENTS_TO_A_HALF.map(apart))
        .collect()
}

/// What the recording shows of its field, where most samples are.
fn patches(relinearized: &RelinearizedFit) -> Vec<Patch> {
    let linearized = &relinearized.linearized;
    let side_m = SIDE_PITCHES * linearized.observations.pitch_m;
    let mut cells: BTreeMap<[i32; 2], Vec<usize>> = BTreeMap::new();
    for i in (0..linearized.len()).filter(|i| linearized.mask[*i]) {
        let centre_m = linearized.refined_centre_m(i);
        cells
            .entry(centre_m.map(|c| (c / side_m).floor() as i32))
            .or_default()
            .push(i);
    }
    let mut cells: Vec<Vec<usize>> = cells
        .into_values()
        .filter(|c| c.len() >= FEWEST_PATCH_SAMPLES)
        .collect();
    cells.sort_by_key(|c| std::cmp::Reverse(c.len()));
    cells
        .iter()
        .take(PATCHES)
        .map(|cell| {
            let step = cell.len().div_ceil(MOST_PATCH_SAMPLES);
            cell.iter()
                .step_by(step)
                .flat_map(|i| rows(relinearized, *i))
                .collect()
        })
        .collect()
}

/// Rows of a sample, as they are without the field.
fn rows(relinearized: &RelinearizedFit, i: usize) -> Vec<Row> {
    let (linearized, columns) = (&relinearized.linearized, &relinearized.columns);
    let rows = linearized.rows(i);
    let covariates = linearized.covariates(i);
    let mut value = rows.residual_m;
    for block in columns
        .blocks
        .iter()
        .filter(|b| !effects::is(&b.name, Detection::AsField))
    {
        for c in block.columns.clone() {
            let response = rows.response(&columns.regressors[c], &covariates);
            for (value, response) in value.iter_mut().zip(response) {
                *value += relinearized.coefficient(c) * response;
            }
        }
    }
    let white = rows.whitened(&value);
    let by_reading = rows.white_by_reading();
    let pitch_m = linearized.observations.pitch_m;
    let places = covariates.place_m.map(|place| place.map(|p| p / pitch_m));
    (0..rows.count)
        .map(|row| Row {
            channel: rows.channel[row],
            value: white[row],
            by_reading: by_reading[row],
            places,
        })
        .collect()
}

/// A pattern search (Hooke and Jeeves 1961).
fn likeliest(patches: &[Patch]) -> Option<(ApertureParameters, f64)> {
    let squares = patches.iter().flatten().map(|r| r.value * r.value);
    let slopes = patches.iter().flatten();
    let slopes = slopes.map(|r| r.by_reading[..4].iter().map(|s| s * s).sum::<f64>());
    let size_m = (squares.sum::<f64>() / slopes.sum::<f64>().max(1e-30)).sqrt();
    let start = ApertureParameters {
        aperture: ApertureKernel {
            half_pitches: [3.0; 2],
            edge: 0.7,
        },
        size_m,
        lines: 0.3,
        beacon: 0.0,
    };
    let mut best = (start, likelihood(patches, &start));
    let mut step = 0.32;
    while step > SMALLEST_STEP {
        let before = best.1;
        for change in CHANGES {
            for way in [step, -step] {
                let mut next = best.0;
                change(&mut next, way);
                let found = likelihood(patches, &next);
                if found > best.1 {
                    best = (next, found);
                    break;
                }
            }
        }
        if best.1 <= before + 1.0 {
            step *= 0.5;
        }
    }
    best.1.is_finite().then_some(best)
}

/// What a search may change, by a share.
const CHANGES: [fn(&mut ApertureParameters, f64); 6] = [
    |guess, by| guess.size_m *= by.exp(),
    |guess, by| guess.aperture.half_pitches[0] = within(guess.aperture.half_pitches[0], by),
    |guess, by| guess.aperture.half_pitches[1] = within(guess.aperture.half_pitches[1], by),
    |guess, by| guess.aperture.edge = (guess.aperture.edge + by).clamp(0.1, 1.0),
    |guess, by| guess.lines = (guess.lines + by).clamp(0.0, 2.0),
    |guess, by| guess.beacon = ((guess.beacon + 1.0) * (2.0 * by).exp() - 1.0).max(0.0),
];

/// Footprints of one tooth to a dozen.
fn within(half_pitches: f64, by: f64) -> f64 {
    (half_pitches * by.exp()).clamp(0.6, 6.0)
}

/// Logarithm of the likelihood of all patches, up to a constant.
fn likelihood(patches: &[Patch], guess: &ApertureParameters) -> f64 {
    let along = overlaps(&guess.aperture, 0);
    let across = overlaps(&guess.aperture, 1);
    let one = |patch: &Patch| of_patch(patch, guess, &along, &across);
    // Summed in the order of the patches: a sum side by side has other last digits in every run.
    let each: Vec<f64> = patches.par_iter().map(one).collect();
    each.iter().sum()
}

/// Correlation of two readings by the distance of their apertures, tabulated as far as they overlap.
fn overlaps(aperture: &ApertureKernel, direction: usize) -> Vec<f64> {
    let whole = 2.0 * aperture.half_pitches[direction] * PER_PITCH;
    correlations(
        aperture,
        direction,
        1.0 / PER_PITCH,
        whole.ceil() as usize + 1,
    )
}

/// Between two values of a table; beyond it nothing.
fn at(table: &[f64], away_pitches: f64) -> f64 {
    let place = away_pitches.abs() * PER_PITCH;
    let (first, part) = (place as usize, place.fract());
    match table.get(first..first + 2) {
        Some([here, next]) => here + part * (next - here),
        _ => 0.0,
    }
}

fn of_patch(patch: &Patch, guess: &ApertureParameters, along: &[f64], across: &[f64]) -> f64 {
    let n = patch.len();
    let lines = guess.lines * guess.lines;
    let mut covariance = DMatrix::zeros(n, n);
    for a in 0..n {
        for b in a..n {
            let mut sum = 0.0;
            for s in 0..4 {
                let here = patch[a].places[s];
                for t in [s, (s + 2) % 4] {
                    let slopes = patch[a].by_reading[s] * patch[b].by_reading[t];
                    let there = patch[b].places[t];
                    let together = at(along, here[0] - there[0]);
                    if slopes != 0.0 && together != 0.0 {
                        sum += slopes * together * (at(across, here[1] - there[1]) + lines);
                    }
                }
            }
            let mut value = sum * guess.size_m * guess.size_m;
            if patch[a].channel == patch[b].channel {
                value += COMMON_OFFSET_NOISES * COMMON_OFFSET_NOISES;
            }
            covariance[(b, a)] = value;
        }
        let under_a_beacon = (1..3).contains(&patch[a].channel);
        covariance[(a, a)] += 1.0
            + if under_a_beacon {
                guess.beacon.powi(2)
            } else {
                0.0
            };
    }
    let right = DVector::from_iterator(n, patch.iter().map(|r| r.value));
    Factor::new(covariance).map_or(f64::NEG_INFINITY, |factor| {
        -0.5 * right.dot(&factor.solve(&right)) - factor.half_log_determinant()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal, uniform};
    use tooth_field::Kernel;

    const TEETH: usize = 40;
    const NOISE_M: f64 = 0.2e-6;

    /// Share of a tooth under an aperture of another family than the search's: a parabola, squared.
    fn share(away: f64, half: f64) -> f64 {
        (1.0 - (away / half).powi(2)).max(0.0).powi(2)
    }

    /// A reading of posts of unit deviation.
    fn read(posts: &[f64], half: [f64; 2], place: [f64; 2]) -> f64 {
        let (mut sum, mut squares) = (0.0, 0.0);
        for (k, post) in posts.iter().enumerate() {
            let away = |d: usize, tooth: usize| tooth as f64 - 0.5 * TEETH as f64 - place[d];
            let weight = share(away(0, k % TEETH), half[0]) * share(away(1, k / TEETH), half[1]);
            sum += weight * post;
            squares += weight * weight;
        }
        sum / f64::max(squares, 1e-12).sqrt()
    }

    /// Rows of the parity and of x and y under a beacon.
    fn patch(rng: &mut ChaCha8Rng, half: [f64; 2], size_m: f64) -> Patch {
        let span = 9.5;
        let sides = [-1.0, 1.0, 1.0, -1.0];
        let mut posts = || {
            (0..TEETH * TEETH)
                .map(|_| normal(rng))
                .collect::<Vec<f64>>()
        };
        let fields = [posts(), posts()];
        let mut out = Patch::new();
        for _ in 0..90 {
            let centre = [0, 1].map(|_| uniform(rng, -2.5, 2.5));
            let places: [[f64; 2]; 4] =
                std::array::from_fn(|s| [centre[s % 2], centre[1 - s % 2] + 0.5 * span * sides[s]]);
            let readings: [f64; 4] = std::array::from_fn(|s| {
                size_m * read(&fields[s % 2], half, places[s]) + NOISE_M * normal(rng)
            });
            let rows = [
                (0, [0.5, -0.5, -0.5, 0.5]),
                (1, [0.5, 0.0, 0.5, 0.0]),
                (2, [0.0, 0.5, 0.0, 0.5]),
            ];
            for (channel, slopes) in rows {
                let slopes: [f64; 4] = slopes.map(|s: f64| {
                    let rms = if channel == 0 { 1.0 } else { 0.5_f64.sqrt() };
                    s / rms / NOISE_M
                });
                let mut by_reading = [0.0; READINGS];
                by_reading[..4].copy_from_slice(&slopes);
                out.push(Row {
                    channel,
                    value: slopes.iter().zip(readings).map(|(s, r)| s * r).sum(),
                    by_reading,
                    places,
                });
            }
        }
        out
    }

    /// Second moment of an aperture.
    fn spread(share: impl Fn(f64) -> f64) -> f64 {
        let at = |k: i32| f64::from(k) * 0.01;
        let weights = || (-900..=900).map(|k| (at(k), share(at(k))));
        let whole: f64 = weights().map(|w| w.1).sum();
        (weights().map(|(u, w)| u * u * w).sum::<f64>() / whole).sqrt()
    }

    #[test]
    fn a_footprint_and_its_size_are_told_without_its_teeth() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut ratios = Vec::new();
        for (half, size_m) in [
            ([3.0, 3.5], 3.0e-6),
            ([2.5, 4.5], 1.5e-6),
            ([4.0, 3.0], 6.0e-6),
            ([3.5, 2.5], 3.0e-6),
        ] {
            let patches: Vec<Patch> = (0..2).map(|_| patch(&mut rng, half, size_m)).collect();
            let (guess, _) = likeliest(&patches).expect("a guess");
            for d in 0..2 {
                let found = spread(|u| guess.aperture.weight(d, u));
                ratios.push((found / spread(|u| share(u, half[d]))).ln());
            }
            // Two patches hold some twenty independent places.
            assert!((guess.size_m / size_m).ln().abs() < 0.5, "{guess:?}");
        }
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        assert!(mean.abs() < 0.1, "{mean} {ratios:?}");
        assert!(ratios.iter().all(|r| r.abs() < 0.3), "{ratios:?}");
    }
}
