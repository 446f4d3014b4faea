//! Rulings that are not two equal ones at right angles: what they add to the outputs by the place of a segment.

use courier_sensor::frame::SEGMENTS;

/// How the rulings of a platen are known to differ from two equal ones at right angles. Without any amount they do not.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rulings {
    /// Amounts of the shapes ([`Rulings::shapes`]): pitch of x over that of y, less one; how much x grows with y along the lines of x, rad; bows of x's
    /// and of y's lines, 1/m.
    pub amounts: [f64; 4],
    /// The place from which they are told, x and y, m from the count's zero.
    pub from_m: [f64; 2],
}

impl Rulings {
    /// True if they add nothing anywhere.
    #[must_use]
    pub fn are_straight(&self) -> bool {
        self.amounts == [0.0; 4]
    }

    /// What each shape adds to the output of a segment per amount of one, by the segment's place along and across its direction, m from the count's zero.
    #[must_use]
    pub fn shapes(&self, segment: usize, [along_m, across_m]: [f64; 2]) -> [f64; 4] {
        let axis = segment % 2;
        let (along_m, across_m) = (
            along_m - self.from_m[axis],
            across_m - self.from_m[1 - axis],
        );
        let squared_m2 = across_m * across_m;
        match axis {
            0 => [0.5 * along_m, across_m, squared_m2, 0.0],
            _ => [-0.5 * along_m, 0.0, 0.0, squared_m2],
        }
    }

    /// What the rulings add to each output at the segments' places, m.
    #[must_use]
    pub fn corrections_m(&self, places_m: &[[f64; 2]; SEGMENTS]) -> [f64; SEGMENTS] {
        std::array::from_fn(|s| {
            let each = self.shapes(s, places_m[s]).into_iter();
            each.zip(self.amounts).map(|(by, amount)| by * amount).sum()
        })
    }
}
