//! How a vibration swells and strays: lines beside a stronger one stand for it, and another recording has others. What another
//! recording will show lies within no stronger line's resonance, and is what one half of this one foretells of the other.

use crate::heldout::Residuals;
use crate::phase::VIBRATION;
use crate::refine::Refined;
use effects::beacon_vibration::sensor_side::SLOWEST_HZ;
use nalgebra::{DMatrix, DVector};

/// A mount rings some ten times: lines nearer to a stronger one than this share of its frequency are one resonance's.
const RESONANCE: f64 = 1.0 / 30.0;
/// Columns of one line: sine and cosine, along x and y.
const OF_A_LINE: usize = 4;

/// Products of the lines' columns, and of them with what the residuals would be without any, over half a recording.
struct Half {
    normal: DMatrix<f64>,
    right: DVector<f64>,
    squares: f64,
}

/// Columns of the vibration's lines that belong to this recording's time; none of the strongest line.
pub fn of_its_time(fine: &Refined) -> Vec<usize> {
    let Some(block) = fine.columns.blocks.iter().find(|b| b.name == VIBRATION) else {
        return Vec::new();
    };
    let columns: Vec<usize> = block.columns.clone().collect();
    let hz = fine.scene.survey.beacon_lines_hz.iter().copied();
    let hz = hz.filter(|hz| *hz >= SLOWEST_HZ);
    let mut lines: Vec<(&[usize], f64)> = columns.chunks(OF_A_LINE).zip(hz).collect();
    if lines.len() < 2 {
        return Vec::new();
    }
    let power = |line: &[usize]| line.iter().map(|c| fine.amount(*c).powi(2)).sum::<f64>();
    lines.sort_by(|a, b| power(b.0).total_cmp(&power(a.0)));
    let halves = halves(fine, &columns);
    let places = |line: &[usize]| line.iter().map(|c| c - columns[0]).collect::<Vec<usize>>();
    let mut kept = places(lines[0].0);
    let mut gone = Vec::new();
    for (k, (line, hz)) in lines.iter().enumerate().skip(1) {
        let one_resonance = |stronger: &(&[usize], f64)| (hz / stronger.1 - 1.0).abs() < RESONANCE;
        if lines[..k].iter().any(one_resonance) {
            gone.extend_from_slice(line);
            continue;
        }
        let with: Vec<usize> = kept.iter().copied().chain(places(line)).collect();
        if foretold(&halves, &with) < foretold(&halves, &kept) {
            kept = with;
        } else {
            gone.extend_from_slice(line);
        }
    }
    gone
}

/// Both halves, in the order of the samples.
fn halves(fine: &Refined, columns: &[usize]) -> [Half; 2] {
    let left: &Residuals = &fine.residuals;
    let middle = left.sample.get(left.sample.len() / 2).copied();
    let mut halves = [0, 1].map(|_| Half {
        normal: DMatrix::identity(columns.len(), columns.len()) * 1e-9,
        right: DVector::zeros(columns.len()),
        squares: 0.0,
    });
    let mut start = 0;
    while start < left.sample.len() {
        let i = left.sample[start];
        let rows = fine.scene.rows(i);
        let moment = fine.scene.moment(i);
        let responses: Vec<_> = columns
            .iter()
            .map(|c| rows.response(&fine.columns.regressors[*c], &moment))
            .collect();
        let half = &mut halves[usize::from(Some(i) >= middle)];
        for row in 0..rows.count {
            let k = start + row;
            let weight = 1.0 / left.noise_m[k].max(1e-12);
            let regressor =
                DVector::from_iterator(columns.len(), responses.iter().map(|r| weight * r[row]));
            let added = columns.iter().zip(&responses);
            let added: f64 = added.map(|(c, r)| fine.amount(*c) * r[row]).sum();
            let without = weight * (left.value_m[k] - added);
            half.normal.ger(1.0, &regressor, &regressor, 1.0);
            half.right.axpy(without, &regressor, 1.0);
            half.squares += without * without;
        }
        start += rows.count.max(1);
    }
    halves
}

/// Whitened squares of each half with some columns, fitted on the other.
fn foretold(halves: &[Half; 2], list: &[usize]) -> f64 {
    let of = |half: &Half| {
        let normal = DMatrix::from_fn(list.len(), list.len(), |r, c| {
            half.normal[(list[r], list[c])]
        });
        let right = DVector::from_fn(list.len(), |r, _| half.right[list[r]]);
        (normal, right)
    };
    let left = |from: &Half, to: &Half| {
        let (normal, right) = of(from);
        let Some(factors) = normal.cholesky() else {
            return f64::INFINITY;
        };
        let amounts = -factors.solve(&right);
        let (normal, right) = of(to);
        to.squares + 2.0 * amounts.dot(&right) + amounts.dot(&(normal * &amounts))
    };
    left(&halves[0], &halves[1]) + left(&halves[1], &halves[0])
}
