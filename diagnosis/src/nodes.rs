//! Nodes of a field over the platen: those that the recording passes often enough.

use crate::scene::Scene;
use crate::visited::places_m;
use std::collections::BTreeMap;

/// Weight of samples that a node must carry to be judged.
const WEIGHT: f64 = 3.0;
/// Most nodes of all channels: beyond, the mesh gets coarser.
const MOST: usize = 700;

/// Mesh width, m, and the nodes of each channel (or of each segment against a reference); nothing where the courier hardly
/// moves.
pub fn nodes(scene: &Scene) -> (f64, [Vec<[i32; 2]>; 4]) {
    for pitches in [1.0, 1.5, 2.0, 3.0, 4.0, 6.0] {
        let step_m = pitches * scene.observations.pitch_m;
        let list = at(scene, step_m);
        let count: usize = list.iter().map(Vec::len).sum();
        if count < 8 {
            break;
        }
        if count <= MOST {
            return (step_m, list);
        }
    }
    (0.0, Default::default())
}

fn at(scene: &Scene, step_m: f64) -> [Vec<[i32; 2]>; 4] {
    let mut weights: [BTreeMap<[i32; 2], f64>; 4] = Default::default();
    for i in (0..scene.len()).filter(|&i| scene.keep[i]) {
        for (s, place_m) in places_m(scene, i) {
            let [a, b] = place_m.map(|p| p / step_m);
            for (di, dj) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                let (x, y) = (a.floor() + di, b.floor() + dj);
                let weight = (1.0 - (a - x).abs()) * (1.0 - (b - y).abs());
                *weights[s].entry([x as i32, y as i32]).or_default() += weight;
            }
        }
    }
    weights.map(|map| {
        map.into_iter()
            .filter(|(_, w)| *w > WEIGHT)
            .map(|(node, _)| node)
            .collect()
    })
}
