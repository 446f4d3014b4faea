//! Which wire carries which segment, and in which direction.

use crate::fault::Fault;

/// An assignment: the true segment `j` is `sign[j]` times the column of segment `column[j]`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wiring {
    /// Index of the column of each true segment.
    pub column: [usize; 4],
    /// Its sign.
    pub sign: [f64; 4],
    /// What is wrong with it, simplest first.
    pub faults: Vec<Fault>,
}

impl Wiring {
    /// As stated.
    pub fn stated() -> Self {
        Self {
            column: [0, 1, 2, 3],
            sign: [1.0; 4],
            faults: Vec::new(),
        }
    }

    /// Every wiring of at most two faults, the stated one first, then by the number of faults.
    pub fn all() -> Vec<Self> {
        let mut list = vec![Self::stated()];
        for _ in 0..2 {
            for from in list.clone() {
                for (fault, [column, sign]) in simple() {
                    let next = from.then(fault, column, sign);
                    let known = |w: &Self| w.column == next.column && w.sign == next.sign;
                    if !list.iter().any(known) {
                        list.push(next);
                    }
                }
            }
        }
        list
    }

    /// This wiring with one more fault on top.
    fn then(&self, fault: Fault, column: [f64; 4], sign: [f64; 4]) -> Self {
        let place = column.map(|c| c as usize);
        let mut faults = self.faults.clone();
        faults.push(fault);
        Self {
            column: place.map(|c| self.column[c]),
            sign: [0, 1, 2, 3].map(|j| sign[j] * self.sign[place[j]]),
            faults,
        }
    }

    /// Weights of the columns that make the parity of equation (6).
    pub fn parity(&self) -> [f64; 4] {
        self.combine(courier_signal::equations::PARITY_SIGN.map(f64::from))
    }

    /// Weights of the columns that make a combination of the true segments.
    pub fn combine(&self, weights: [f64; 4]) -> [f64; 4] {
        let mut columns = [0.0; 4];
        for j in 0..4 {
            columns[self.column[j]] += weights[j] * self.sign[j];
        }
        columns
    }
}

/// What one hand does wrong at once: a fault, the columns and the signs.
fn simple() -> Vec<(Fault, [[f64; 4]; 2])> {
    let straight = [0.0, 1.0, 2.0, 3.0];
    let mut list = Vec::new();
    for a in 0..4 {
        for b in a + 1..4 {
            let mut column = straight;
            column.swap(a, b);
            list.push((Fault::SegmentsExchanged(a, b), [column, [1.0; 4]]));
        }
    }
    for segment in 0..4 {
        let mut sign = [1.0; 4];
        sign[segment] = -1.0;
        list.push((Fault::SegmentReversed(segment), [straight, sign]));
    }
    list.push((Fault::AxesExchanged, [[1.0, 0.0, 3.0, 2.0], [1.0; 4]]));
    list.push((Fault::PairReversed(0), [straight, [-1.0, 1.0, -1.0, 1.0]]));
    list.push((Fault::PairReversed(1), [straight, [1.0, -1.0, 1.0, -1.0]]));
    list.push((Fault::AllReversed, [straight, [-1.0; 4]]));
    list
}
