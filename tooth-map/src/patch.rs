//! What of a field a board is given: a field that is larger than the board's memory loses rows at its rim, those first that lose
//! the fewest trusted cells for their nodes.

use super::lattice::SUPPORT;
use courier_sensor::teeth::Grid;

/// One direction's field on its lattice; cells are numbered as their first node.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// The lattice.
    pub grid: Grid,
    /// Nodes, nanometres.
    pub nodes_nm: Vec<i16>,
    /// Predicted deviation of each cell's middle, metres; none where nothing was visited.
    pub deviations_m: Vec<Option<f64>>,
    /// Cells in which places are corrected.
    pub trusted: Vec<bool>,
}

/// A row of nodes at the rim: along (0) or across (1) the measured direction, first or last.
type Rim = (usize, bool);
const RIMS: [Rim; 4] = [(0, false), (0, true), (1, false), (1, true)];

/// Takes rows off the rims until both fields together have so many nodes at most, or are too narrow for less.
pub fn crop(patches: &mut [Patch; 2], most_nodes: usize) {
    let nodes = |patches: &[Patch; 2]| -> usize { patches.iter().map(|p| p.nodes_nm.len()).sum() };
    while nodes(patches) > most_nodes {
        let rims = (0..2).flat_map(|field| RIMS.map(|rim| (field, rim)));
        let costs = rims.filter_map(|(field, rim)| Some((patches[field].cost(rim)?, field, rim)));
        let Some((_, field, rim)) = costs.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return;
        };
        patches[field] = patches[field].without(rim);
    }
}

impl Patch {
    fn sides(&self) -> [usize; 2] {
        self.grid.nodes.map(usize::from)
    }

    /// Trusted cells that go with a rim, for each of its nodes; none if the field is too narrow to lose it.
    fn cost(&self, (side, last): Rim) -> Option<f64> {
        let nodes = self.sides();
        if nodes[side] <= SUPPORT {
            return None;
        }
        // A cell rests on four rows from its first node's on.
        let row = if last { nodes[side] - SUPPORT } else { 0 };
        let cells = (0..nodes[1 - side]).map(|other| match side {
            0 => row * nodes[1] + other,
            _ => other * nodes[1] + row,
        });
        let lost = cells.filter(|cell| self.trusted[*cell]).count();
        Some(lost as f64 / nodes[1 - side] as f64)
    }

    fn without(&self, (side, last): Rim) -> Self {
        let nodes = self.sides();
        let mut kept = nodes;
        kept[side] -= 1;
        let mut first = [0; 2];
        first[side] = usize::from(!last);
        let places: Vec<(usize, bool)> = (0..kept[0] * kept[1])
            .map(|place| {
                let at = [place / kept[1], place % kept[1]];
                let whole = (0..2).all(|k| at[k] + SUPPORT <= kept[k]);
                ((at[0] + first[0]) * nodes[1] + at[1] + first[1], whole)
            })
            .collect();
        let mut grid = self.grid;
        grid.nodes[side] -= 1;
        grid.first_teeth[side] += i32::from(!last);
        Self {
            grid,
            nodes_nm: places.iter().map(|(old, _)| self.nodes_nm[*old]).collect(),
            deviations_m: places
                .iter()
                .map(|(old, whole)| self.deviations_m[*old].filter(|_| *whole))
                .collect(),
            trusted: places
                .iter()
                .map(|(old, whole)| self.trusted[*old] && *whole)
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A field of `along` by `across` nodes, each of which holds its own place; `doubted` cells, the first rows, are not trusted.
    fn patch(along: u8, across: u8, doubted: usize) -> Patch {
        let count = usize::from(along) * usize::from(across);
        let whole = |cell: usize| {
            cell / usize::from(across) + SUPPORT <= usize::from(along)
                && cell % usize::from(across) + SUPPORT <= usize::from(across)
        };
        Patch {
            grid: Grid {
                first_teeth: [-3, 10],
                nodes: [along, across],
            },
            nodes_nm: (0..count).map(|node| node as i16).collect(),
            deviations_m: (0..count).map(|c| whole(c).then_some(1.0e-7)).collect(),
            trusted: (0..count).map(|c| whole(c) && c >= doubted).collect(),
        }
    }

    #[test]
    fn the_rim_that_is_not_trusted_goes_first() {
        let mut patches = [patch(8, 6, 0), patch(5, 5, 5)];
        crop(&mut patches, 48 + 25);
        assert_eq!(patches, [patch(8, 6, 0), patch(5, 5, 5)]);
        crop(&mut patches, 48 + 24);
        assert_eq!(
            (patches[0].grid.nodes, patches[0].grid.first_teeth),
            ([8, 6], [-3, 10])
        );
        assert_eq!(
            (patches[1].grid.nodes, patches[1].grid.first_teeth),
            ([4, 5], [-2, 10])
        );
        assert_eq!(patches[1].nodes_nm, (5..25).collect::<Vec<i16>>());
        assert_eq!(patches[1].trusted.iter().filter(|t| **t).count(), 2);
    }

    #[test]
    fn cells_at_a_cut_are_trusted_no_more() {
        let cut = patch(6, 6, 6).without((1, true));
        assert_eq!(cut.grid.nodes, [6, 5]);
        assert_eq!(cut.nodes_nm[..6], [0, 1, 2, 3, 4, 6]);
        // Cells of rows 1 and 2 along, and now of two across.
        assert_eq!(cut.trusted.iter().filter(|t| **t).count(), 4);
        let mut narrow = [patch(4, 4, 0), patch(4, 4, 0)];
        crop(&mut narrow, 0);
        assert_eq!(narrow[0].grid.nodes, [4, 4]);
    }
}
