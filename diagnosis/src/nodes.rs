//! Nodes of a field over the platen: those that the recording passes often enough.

use crate::scene::Scene;
use crate::visited::places_m;
use effects::tooth_variation::sensor_side::{REACH, share};
use std::collections::BTreeMap;

/// Weight of samples that a node must carry to be judged.
const WEIGHT: f64 = 3.0;
/// Most nodes of all channels: beyond, the mesh gets coarser.
const MOST: usize = 700;

/// Sets a survey's mesh and nodes: a tooth apart for each segment where there are few enough, else as fine as can be for the
/// channels; none where the courier hardly moves.
pub fn lay(scene: &mut Scene) {
    scene.survey.field_by_segment = true;
    for pitches in [1.0, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0] {
        let step_m = pitches * scene.observations.pitch_m;
        let list = at(scene, step_m);
        let count: usize = list.iter().map(Vec::len).sum();
        if count < 8 {
            break;
        }
        if count <= MOST {
            (scene.survey.node_step_m, scene.survey.nodes) = (step_m, list);
            return;
        }
        scene.survey.field_by_segment = false;
    }
    (scene.survey.node_step_m, scene.survey.nodes) = Default::default();
}

fn at(scene: &Scene, step_m: f64) -> [Vec<[i32; 2]>; 4] {
    let step = step_m / scene.observations.pitch_m;
    let mut weights: [BTreeMap<[i32; 2], f64>; 4] = Default::default();
    for i in (0..scene.len()).filter(|&i| scene.keep[i]) {
        for (s, place_m) in places_m(scene, i) {
            let [a, b] = place_m.map(|p| p / step_m);
            for x in a.floor() as i32 - REACH + 1..=a.floor() as i32 + REACH {
                let along = share(a - f64::from(x), step);
                for y in b.floor() as i32 - REACH + 1..=b.floor() as i32 + REACH {
                    let weight = along * share(b - f64::from(y), step);
                    if weight > 0.0 {
                        *weights[s].entry([x, y]).or_default() += weight;
                    }
                }
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
