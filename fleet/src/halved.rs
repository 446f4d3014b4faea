//! Fields of splines half a pitch apart, for three steps: splines a pitch apart cannot follow 2.3 % of a field, and that part tells an aperture
//! from another one.

use crate::key::Key;
use crate::state::State;
use crate::sums::Sums;

/// Longest side of a lattice of splines that is halved, nodes. Derived from 255 of the halved one, which are twice as many less three.
const LONGEST: u32 = 129;
/// A spline in splines half as long, half a pitch apart, times eight (de Boor 2001: the two-scale relation of cubic ones).
const IN_HALVES: [f64; 5] = [1.0, 4.0, 6.0, 4.0, 1.0];

/// Whether a platen's field is short enough. Of a longer one, splines a pitch apart tell the aperture (`window`). Cost where it is: four times as
/// many nodes; of 754 a pitch apart, which three couriers within four pitches of a beacon cross, a fit takes 0.5 GB.
pub fn can_be_halved(sums: &Sums) -> bool {
    let mut ends = [[i32::MAX, i32::MIN]; 2];
    for (key, _) in &sums.columns {
        let places = match key {
            Key::Node(_, [along, across]) => [*along, *across],
            Key::Line(_, along) => [*along; 2],
            _ => continue,
        };
        for (end, place) in ends.iter_mut().zip(places) {
            *end = [end[0].min(place), end[1].max(place)];
        }
    }
    let is_short = |[low, high]: [i32; 2]| low > high || high.abs_diff(low) < LONGEST;
    ends.into_iter().all(is_short)
}

/// The same state with its fields in splines half a pitch apart.
pub fn halved(state: &State) -> State {
    let mut next = state.clone();
    next.is_halved = true;
    next.steps += 1;
    next.before = None;
    next.platens.clear();
    for ((platen, key), value) in &state.platens {
        for (key, share) in in_halves(key) {
            *next.platens.entry((platen.clone(), key)).or_default() += share * value;
        }
    }
    next
}

/// A coefficient's shares in those half a pitch apart. What is no field stays.
fn in_halves(key: &Key) -> Vec<(Key, f64)> {
    let each = |place: i32| {
        let halves = IN_HALVES.into_iter().zip(2 * place - 2..);
        halves.map(|(eighths, half)| (half, eighths / 8.0))
    };
    match key {
        Key::Node(direction, [along, across]) => each(*along)
            .flat_map(|(i, a)| each(*across).map(move |(j, b)| ([i, j], a * b)))
            .map(|(node, share)| (Key::Node(*direction, node), share))
            .collect(),
        Key::Line(direction, along) => each(*along)
            .map(|(i, share)| (Key::Line(*direction, i), share))
            .collect(),
        _ => vec![(key.clone(), 1.0)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::Platen;
    use tooth_field::Lattice;
    use tooth_map::FieldKernel;

    /// A field is the same in both, node and line together.
    #[test]
    fn a_halved_field_is_the_same_field() {
        let platen = Platen::default();
        let mut state = State::default();
        for i in -3..=4 {
            for j in -3..=4 {
                let value = f64::from(i * i - 3 * j).sin();
                let key = (platen.clone(), Key::Node(1, [i, j]));
                state.platens.insert(key, value);
            }
            let key = (platen.clone(), Key::Line(1, i));
            state.platens.insert(key, f64::from(i).cos());
        }
        let field = |state: &State, kernel: FieldKernel, step: f64, place: [f64; 2]| -> f64 {
            let lattice = Lattice {
                kernel,
                step_pitches: [step; 2],
            };
            let value = |key| state.platens.get(&(platen.clone(), key)).copied();
            let nodes = lattice.nodes(place);
            let nodes = nodes.map(|(node, w)| w * value(Key::Node(1, node)).unwrap());
            let lines = lattice.lines(place);
            let lines = lines.map(|(line, w)| w * value(Key::Line(1, line)).unwrap());
            nodes.sum::<f64>() + lines.sum::<f64>()
        };
        let other = halved(&state);
        for place in [[0.1, 0.2], [1.6, -0.9], [-1.3, 2.4]] {
            let wanted = field(&state, FieldKernel::Spline, 1.0, place);
            let found = field(&other, FieldKernel::HalfSpline, 0.5, place);
            assert!((wanted - found).abs() < 1.0e-12, "{place:?}");
        }
    }
}
