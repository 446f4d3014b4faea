//! What the data tell of a platen's two fields of splines.

use crate::blocks::{KINDS, Told};
use crate::field_information::FieldInformation;
use crate::key::Key;
use nalgebra::{DMatrix, DVector};
use normal_equations::cholesky::Factor;

/// Precision and right side of spline coefficients over two rectangles, without a prior, in the tooth map's prior deviations: nodes of x's field and of
/// y's, across running fastest, then the lines of both.
#[derive(Clone, Debug)]
pub struct Splines {
    /// Of the whole.
    pub precision: DMatrix<f64>,
    /// See [`Self::precision`].
    pub right: DVector<f64>,
    /// Those of x's field and of y's.
    pub rectangles: [Rectangle; 2],
    /// Of each direction, for each number along, whether the data tell any spline there: segments apart leave much of a rectangle untold.
    pub told: [Vec<bool>; 2],
    /// 2 where they are halved, or else 1.
    pub per_pitch: i32,
}

/// Numbers along and across of the first node, and how many there are.
pub type Rectangle = ([i32; 2], [usize; 2]);

impl Splines {
    /// Of what is told about nodes, half a pitch apart where they are halved. Nodes of the rectangles that are not among them are not told.
    pub fn of(information: &FieldInformation, is_halved: bool) -> Self {
        let rectangles = [0, 1].map(|direction| about(information.keys(), direction));
        let mut all = Self::over(rectangles, if is_halved { 2 } else { 1 });
        let keys = information.keys().iter();
        let places: Vec<usize> = keys.map(|key| all.place(key)).collect();
        all.told.iter_mut().for_each(|told| told.fill(false));
        for key in information.keys() {
            if let Key::Node(d, [along, _]) | Key::Line(d, along) = key {
                let d = usize::from(*d);
                let (first, _) = all.rectangles[d];
                let at = along.abs_diff(first[0]) as usize;
                if let Some(told) = all.told[d].get_mut(at) {
                    *told = true;
                }
            }
        }
        let from = information.precision();
        for (j, column) in places.iter().enumerate() {
            all.right[*column] = information.right()[j];
            for (i, row) in places.iter().enumerate() {
                all.precision[(*row, *column)] = from[(i, j)];
            }
        }
        all
    }

    /// Over these rectangles, of which all may be told.
    pub fn over(rectangles: [Rectangle; 2], per_pitch: i32) -> Self {
        let count = rectangles
            .iter()
            .map(|(_, [along, across])| along * (across + 1));
        let count = count.sum();
        Self {
            precision: DMatrix::zeros(count, count),
            right: DVector::zeros(count),
            told: rectangles.map(|(_, [along, _])| vec![true; along]),
            rectangles,
            per_pitch,
        }
    }

    /// Logarithm of the evidence of coefficients that are independent of each other; minus infinity where the precision is no positive matrix.
    pub fn log_evidence(&self) -> f64 {
        let mut precision = self.precision.clone();
        (0..self.right.len()).for_each(|k| precision[(k, k)] += 1.0);
        log_evidence(precision, &self.right)
    }

    /// Which of them are told, by kind.
    pub fn kinds(&self) -> [Told; KINDS] {
        let mut first = 0;
        std::array::from_fn(|kind| {
            let (_, [along, nodes]) = self.rectangles[kind % 2];
            let across = if kind < 2 { nodes } else { 1 };
            let told = self.told[kind % 2].iter().enumerate();
            let told = Told {
                first,
                across,
                along: told.filter(|(_, is)| **is).map(|(i, _)| i).collect(),
            };
            first += along * across;
            told
        })
    }

    fn place(&self, key: &Key) -> usize {
        let [x, y] = self.rectangles.map(|(_, counts)| counts);
        let number = |direction: u8, k: usize, at: i32| {
            let (first, _) = self.rectangles[usize::from(direction)];
            at.abs_diff(first[k]) as usize
        };
        match key {
            Key::Node(d, [along, across]) => {
                let before = usize::from(*d) * x[0] * x[1];
                let row = [x, y][usize::from(*d)][1];
                before + number(*d, 0, *along) * row + number(*d, 1, *across)
            }
            Key::Line(d, along) => {
                let before = x[0] * x[1] + y[0] * y[1] + usize::from(*d) * x[0];
                before + number(*d, 0, *along)
            }
            // There are no others in a field's information.
            _ => 0,
        }
    }
}

/// The rectangle about all nodes of a direction.
fn about(keys: &[Key], direction: u8) -> Rectangle {
    let (mut low, mut high) = ([i32::MAX; 2], [i32::MIN; 2]);
    for key in keys {
        if let Key::Node(of, node) = key
            && *of == direction
        {
            low = [0, 1].map(|k| low[k].min(node[k]));
            high = [0, 1].map(|k| high[k].max(node[k]));
        }
    }
    if low[0] > high[0] {
        return ([0; 2], [0; 2]);
    }
    (low, [0, 1].map(|k| high[k].abs_diff(low[k]) as usize + 1))
}

/// Logarithm of the evidence of independent unknowns of unit deviation, by their precision with that of the prior and the right side; minus
/// infinity where that is no positive matrix (Rasmussen and Williams 2006, section 5.4).
pub fn log_evidence(precision: DMatrix<f64>, right: &DVector<f64>) -> f64 {
    Factor::new(precision).map_or(f64::NEG_INFINITY, |factor| {
        0.5 * right.dot(&factor.solve(right)) - factor.half_log_determinant()
    })
}
