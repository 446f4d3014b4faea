//! Recordings that a tooth map can be made of: hundreds of poses under a beacon, turned, with whatever else was recorded.

use super::chance::chance;
use super::cut::cut;
use super::{columns, courier, runs, stated};
use effects::random::{ChaCha8Rng, index, log_uniform, uniform};
use hal_sim::coordination::origin_under;
use hal_sim::courier::Courier;
use hal_sim::presets::paper_on_platen;
use hal_sim::trajectory::{OpenLoop, Plan};
use recording::Recording;

/// Poses: a map wants 240 to fit. A usual one has a thousand, which takes longer and tries the same code.
const POSES: [f64; 2] = [350.0, 600.0];
/// Largest angle either way, rad: a map wants 1.75 mrad rms.
const TURN_RAD: [f64; 2] = [2.0e-3, 0.03];
/// Most further runs.
const MOST_RUNS: usize = 3;

/// One of them. Two in three are of a courier whose teeth are displaced, since others want no map.
pub fn drawn(rng: &mut ChaCha8Rng) -> Recording {
    let seed = (uniform(rng, 0.0, 1.0) * 2.0_f64.powi(52)) as u64;
    let displaced = chance(rng, 0.67);
    let platen = paper_on_platen(seed);
    let mut spec = if displaced {
        platen
    } else {
        courier::spec(1.0, rng)
    };
    let home = spec.places.beacon;
    spec.beacon_over.get_or_insert(home);
    let origin_m = origin_under(&spec.geometry, home);
    let poses = log_uniform(rng, POSES[0], POSES[1]) as usize;
    let turn_rad = uniform(rng, TURN_RAD[0], TURN_RAD[1]);
    let plan = Plan::new(home, spec.nominal, OpenLoop::COURIER, seed);
    let mut plan = plan.beacon(poses, origin_m, turn_rad);
    for _ in 0..index(rng, MOST_RUNS + 1) {
        plan = runs::with_run(plan, home, rng);
    }
    runs::relabel(&mut plan, rng);
    let mut courier = Courier::new(spec, seed).unwrap_or_else(|error| panic!("{error}"));
    let whole = hal_sim::record::record(&mut courier, &thinned(plan, poses), chance(rng, 0.2));
    let mut drawn = if chance(rng, 0.2) {
        cut(&whole, rng)
    } else {
        whole
    };
    if chance(rng, 0.3) {
        drawn = columns::changed(&drawn, rng);
    }
    stated::restate(&mut drawn.meta, rng);
    drawn
}

/// Every pose, and of the other runs as many samples as there are poses.
fn thinned(mut plan: Plan, poses: usize) -> Plan {
    let others = plan.samples().saturating_sub(poses);
    let every = others.div_ceil(poses).max(1);
    for run in plan.runs.iter_mut().skip(1) {
        let kept = run.times_s.iter().copied().step_by(every);
        run.times_s = kept.collect();
    }
    plan
}
