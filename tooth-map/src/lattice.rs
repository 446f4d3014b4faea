//! A field over a patch of the platen as the firmware's lattice has it (`courier_sensor::teeth`): a rectangle of nodes, whose weights at
//! a place are those of [`FIELD`].

use courier_sensor::teeth::Grid;
use tooth_field::{ApertureKernel, CubicSpline, Kernel, Lattice};

/// Weights of the nodes at a place: what the firmware applies, in f64.
pub const FIELD: Lattice<CubicSpline> = Lattice::of_teeth(CubicSpline);

/// What a node of a field is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FieldKernel {
    /// A coefficient of a cubic B-spline, as a board has it: whatever the field is of.
    #[default]
    Spline,
    /// The same of a spline half as long: such ones stand half a pitch apart.
    HalfSpline,
    /// A tooth, as an aperture sees it that has been measured.
    Aperture(ApertureKernel),
}

impl Kernel for FieldKernel {
    fn half_pitches(&self, direction: usize) -> f64 {
        match self {
            Self::Spline => CubicSpline.half_pitches(direction),
            Self::HalfSpline => 0.5 * CubicSpline.half_pitches(direction),
            Self::Aperture(aperture) => aperture.half_pitches(direction),
        }
    }

    fn weight(&self, direction: usize, away_pitches: f64) -> f64 {
        match self {
            Self::Spline => CubicSpline.weight(direction, away_pitches),
            Self::HalfSpline => CubicSpline.weight(direction, 2.0 * away_pitches),
            Self::Aperture(aperture) => share(aperture, direction, away_pitches),
        }
    }
}

/// Weight of a tooth among all under an aperture, which add up to one wherever it stands: a platen that is moved as a whole moves every reading
/// by as much. A window's own values at teeth add up to that on average only, and what is missing from place to place would be taken for waves of
/// the sensor.
fn share(aperture: &ApertureKernel, direction: usize, away_pitches: f64) -> f64 {
    let weight = aperture.weight(direction, away_pitches);
    if weight == 0.0 {
        return 0.0;
    }
    let teeth = aperture.half_pitches(direction).ceil() as i32 + 1;
    let others = (-teeth..=teeth).map(|k| away_pitches.fract() + f64::from(k));
    let sum: f64 = others.map(|away| aperture.weight(direction, away)).sum();
    weight / sum
}

/// The lattice that holds the nodes under a kernel wherever one holds those under a spline, as far as a [`Grid`] can count.
#[must_use]
pub fn widened(grid: &Grid, kernel: &impl Kernel) -> Grid {
    let mut wide = *grid;
    for k in 0..2 {
        let half = kernel.half_pitches(k);
        // A spline's first node is one before the tooth below the lowest place, its last two behind the one below the highest.
        let before = (half.floor() - 1.0).max(0.0) as i32;
        let behind = (half.ceil() - 2.0).max(0.0) as i32;
        let nodes = i32::from(grid.nodes[k]) + before + behind;
        wide.first_teeth[k] = grid.first_teeth[k].saturating_sub(before);
        wide.nodes[k] = u8::try_from(nodes).unwrap_or(u8::MAX);
    }
    wide
}

/// The lattice of half splines that holds the places which a lattice of splines holds; none where that is longer than a [`Grid`] can count.
pub fn halved(grid: &Grid) -> Option<Grid> {
    let nodes = |k: usize| {
        let twice = 2 * usize::from(grid.nodes[k]);
        u8::try_from(twice.checked_sub(3)?).ok()
    };
    Some(Grid {
        first_teeth: grid.first_teeth.map(|first| 2 * first + 1),
        nodes: [nodes(0)?, nodes(1)?],
    })
}

/// Nodes about a place, either way. By definition of a cubic spline.
pub const SUPPORT: usize = 4;

/// Smallest lattice that holds places within these bounds, pitches: `[lowest, highest]` along and across. How far the places reach
/// instead, where that is more than a [`Grid`] can count.
pub fn covering(bounds: [[f64; 2]; 2]) -> Result<Grid, f64> {
    let first = bounds.map(|[low, _]| low.floor() - 1.0);
    let nodes = bounds.map(|[low, high]| high.floor() - low.floor() + SUPPORT as f64);
    for k in 0..2 {
        let counted = nodes[k] <= f64::from(u8::MAX) && first[k].abs() <= f64::from(i32::MAX / 2);
        if !counted {
            return Err(nodes[k].max(first[k].abs()));
        }
    }
    Ok(Grid {
        first_teeth: first.map(|first| first as i32),
        nodes: nodes.map(|nodes| nodes as u8),
    })
}

/// The cell that a place is in, numbered as its first node; none where the lattice does not reach about it.
pub fn cell(grid: &Grid, place: [f64; 2]) -> Option<usize> {
    let first = |k: usize| {
        let from_first = place[k].floor() - f64::from(grid.first_teeth[k]) - 1.0;
        let last = f64::from(grid.nodes[k]) - SUPPORT as f64;
        (0.0..=last)
            .contains(&from_first)
            .then_some(from_first as usize)
    };
    Some(first(0)? * usize::from(grid.nodes[1]) + first(1)?)
}

/// Number of a node, across running fastest, and of its line. None outside.
pub fn number(grid: &Grid, node: [i32; 2]) -> Option<(usize, usize)> {
    let from_first = |k: usize| {
        let count = usize::try_from(node[k].checked_sub(grid.first_teeth[k])?).ok()?;
        (count < usize::from(grid.nodes[k])).then_some(count)
    };
    let line = from_first(0)?;
    Some((line * usize::from(grid.nodes[1]) + from_first(1)?, line))
}

/// The middle of a cell, pitches; none where the lattice ends before it.
pub fn middle(grid: &Grid, cell: usize) -> Option<[f64; 2]> {
    let row = usize::from(grid.nodes[1]);
    let at = [cell / row, cell % row];
    let inside = (0..2).all(|k| at[k] + SUPPORT <= usize::from(grid.nodes[k]));
    inside.then(|| std::array::from_fn(|k| f64::from(grid.first_teeth[k]) + at[k] as f64 + 1.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_of_teeth_add_up_to_one_wherever_an_aperture_stands() {
        let aperture = ApertureKernel {
            half_pitches: [2.6, 3.3],
            edge: 0.9,
        };
        let lattice = Lattice::of_teeth(FieldKernel::Aperture(aperture));
        for place in [[0.0, 0.5], [3.3, -2.2], [-4.1, 7.9]] {
            let sum: f64 = lattice.nodes(place).map(|(_, weight)| weight).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{place:?}: {sum}");
        }
    }

    #[test]
    fn lattice_covers_its_bounds_and_nothing_else() {
        let grid = covering([[-3.2, 4.9], [10.0, 12.5]]).unwrap();
        assert_eq!(grid.first_teeth, [-5, 9]);
        assert_eq!(grid.nodes, [12, 6]);
        for place in [[-3.2, 10.0], [4.9, 12.5], [0.3, 11.0]] {
            let first = cell(&grid, place).unwrap();
            let mut numbers: Vec<usize> = FIELD
                .nodes(place)
                .map(|(node, _)| number(&grid, node).unwrap().0)
                .collect();
            numbers.sort_unstable();
            assert_eq!(numbers.first(), Some(&first), "{place:?}");
        }
        assert!(cell(&grid, [-4.1, 11.0]).is_none() && cell(&grid, [5.0, 11.0]).is_none());
        assert_eq!(number(&grid, [-5, 9]), Some((0, 0)));
        assert_eq!(number(&grid, [6, 14]), Some((71, 11)));
        assert!(number(&grid, [7, 9]).is_none() && number(&grid, [-5, 15]).is_none());
        assert_eq!(covering([[0.0, 252.0], [0.0, 1.0]]), Err(256.0));
        assert_eq!(covering([[-4.0e9, -4.0e9], [0.0, 1.0]]), Err(4.0e9 + 1.0));
        assert!(covering([[f64::NAN, 1.0], [0.0, 1.0]]).is_err());
        let [i, j] = middle(&grid, cell(&grid, [0.3, 11.2]).unwrap()).unwrap();
        assert!((i - 0.5).abs() < 1e-12 && (j - 11.5).abs() < 1e-12);
    }
}
