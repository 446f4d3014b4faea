//! Right recordings drawn anew: couriers, effects, motions, cuts.

use effects::motion::Pose;
use effects::plant::{Geometry, Scene};
use effects::random::{ChaCha8Rng, SeedableRng, index, log_uniform, normal, uniform};
use hal_sim::coordination::origin_under;
use hal_sim::courier::Courier;
use hal_sim::presets;
use hal_sim::record::record;
use hal_sim::spec::CourierSpec;
use hal_sim::trajectory::{OpenLoop, Plan};
use recording::{Recording, Row, Samples};

/// What a recording has to hold.
#[derive(Clone, Copy, Debug, Default)]
pub struct Needs {
    /// A beacon over some of the motion, with turning.
    pub beacon: bool,
    /// An independent reference.
    pub reference: bool,
    /// Positions in the place of counts.
    pub positions: bool,
    /// The first segment alone.
    pub single: bool,
    /// A short lever arm of a centimetre or more: what a motion tells better than its own error.
    pub long_lever: bool,
}

/// Size of an effect, m rms: up to 20 noise floors of 0.3 µm.
const SIZES_M: [f64; 2] = [0.3e-6, 6.0e-6];
/// Noise of logged positions, m: that of the board's counts.
const POSITION_NOISE_M: f64 = 0.16e-6;

/// A right recording with all that is needed, up to `effects` effects, and motions of its own.
pub fn recording(seed: u64, needs: Needs, most_effects: usize) -> Recording {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed_0000_0000);
    let mut spec = courier(&mut rng, needs.long_lever);
    let plan = plan(&spec, &mut rng, needs.beacon);
    let scene = Scene {
        geometry: spec.geometry,
        duration_s: plan.duration_s(),
        amplitude_counts: spec.electronics.amplitude_counts,
    };
    for _ in 0..index(&mut rng, most_effects + 1) {
        let entry = effects::CATALOGUE[index(&mut rng, effects::CATALOGUE.len())];
        let size_m = log_uniform(&mut rng, SIZES_M[0], SIZES_M[1]);
        spec.effects.push((entry.draw)(&scene, &mut rng, size_m));
    }
    if !needs.beacon {
        spec.beacon_over = None;
    }
    let mut courier = Courier::new(spec, seed).expect("monotonic");
    let whole = record(&mut courier, &plan, needs.reference);
    let stride = 1 + index(&mut rng, 6);
    thinned(&whole, stride, &needs)
}

/// A courier of another build: geometry within some percent of its drawing.
fn courier(rng: &mut ChaCha8Rng, long_lever: bool) -> CourierSpec {
    let seed = uniform(rng, 0.0, 1.0e9) as u64;
    if uniform(rng, 0.0, 1.0) < 0.15 && !long_lever {
        return presets::paper_on_platen(seed);
    }
    let mut spec = presets::ideal(seed);
    let side = if uniform(rng, 0.0, 1.0) < 0.5 {
        -1.0
    } else {
        1.0
    };
    let nominal = Geometry {
        span_m: uniform(rng, 8.0e-3, 14.0e-3),
        lateral_m: uniform(rng, 1.5e-3, 4.5e-3),
        height_m: uniform(rng, 45.0e-3, 90.0e-3),
        lever_m: [
            uniform(rng, 70.0e-3, 100.0e-3),
            side * uniform(rng, if long_lever { 10.0e-3 } else { 5.0e-3 }, 15.0e-3),
        ],
        tan_full_scale: uniform(rng, 0.08, 0.15),
        ..Geometry::PAPER
    };
    let mut built = |length_m: f64| length_m * (1.0 + 0.02 * normal(rng).clamp(-2.5, 2.5));
    spec.geometry = Geometry {
        height_m: built(nominal.height_m),
        lever_m: nominal.lever_m.map(&mut built),
        ..nominal
    };
    spec.nominal = nominal;
    spec
}

/// Motions drawn anew: still poses, sweeps of some speed and length, a turn; in any order, some twice.
fn plan(spec: &CourierSpec, rng: &mut ChaCha8Rng, beacon: bool) -> Plan {
    let seed = uniform(rng, 0.0, 1.0e9) as u64;
    let home = spec.places.beacon;
    let mut plan = Plan::new(home, spec.nominal, OpenLoop::COURIER, seed);
    let origin_m = origin_under(&spec.geometry, home);
    let mut order: Vec<usize> = (0..4).collect();
    order.extend(
        (0..index(rng, 3))
            .map(|_| index(rng, 4))
            .collect::<Vec<_>>(),
    );
    for k in (1..order.len()).rev() {
        order.swap(k, index(rng, k + 1));
    }
    let degree = std::f64::consts::PI / 180.0;
    let about = |half: Pose| [home.plus(half, -1.0), home.plus(half, 1.0)];
    for kind in order {
        let turn_rad = uniform(rng, -0.3, 0.3) * degree;
        let speed_m_s = log_uniform(rng, 8.0e-3, 0.15);
        let half_m = uniform(rng, 3.0e-3, 20.0e-3);
        let [x, y] = [Pose::new(half_m, 0.0, 0.0), Pose::new(0.0, half_m, 0.0)];
        let tilted = |ends: [Pose; 2]| ends.map(|p| p.plus(Pose::new(0.0, 0.0, turn_rad), 1.0));
        let poses = 150 + index(rng, 400);
        plan = match kind {
            0 => plan.sweep_both_ways("sweep_x", tilted(about(x)), speed_m_s),
            1 => plan.sweep_both_ways("sweep_y", tilted(about(y)), speed_m_s),
            2 => plan.spin(origin_m, uniform(rng, 0.5, 1.3) * degree),
            _ if beacon => plan.beacon(poses, origin_m, uniform(rng, 0.5, 1.5) * degree),
            _ => plan.scatter(poses, home, uniform(rng, 4.0e-3, 12.0e-3), 0.5 * degree),
        };
    }
    plan.still(home, 0.2)
}

/// Every so many-th row, with the columns that are needed; half of the recordings without the commands.
fn thinned(whole: &Recording, stride: usize, needs: &Needs) -> Recording {
    let mut meta = whole.meta.clone();
    let pitch_m = meta.geometry.pitch_m;
    let mut samples = Samples::default();
    let commanded = stride % 2 == 0;
    // Rows of still poses are single: they are kept whatever the stride.
    let names = whole.samples.run_names();
    for k in 0..whole.samples.len() {
        let row = whole.samples.row(k);
        let still = matches!(
            names[whole.samples.run_number(k)].as_str(),
            "beacon" | "scatter"
        );
        if !still && k % stride != 0 {
            continue;
        }
        let mut row = Row { ..row };
        if !commanded {
            row.commanded = [None; 3];
        }
        if !needs.beacon {
            row.electrode_counts = None;
        }
        if needs.positions {
            row.position_m = [0, 1, 2, 3].map(|s| whole.samples.unmodified_m(s, k, pitch_m));
            (row.quadrature_counts, row.teeth) = ([None; 4], [None; 4]);
        }
        if needs.single {
            for s in 1..4 {
                row.quadrature_counts[s] = None;
                row.teeth[s] = None;
                row.position_m[s] = None;
            }
        }
        samples.push(&row);
    }
    if needs.positions {
        meta.electronics.position_noise_m = Some(POSITION_NOISE_M);
    }
    if !needs.beacon {
        meta.coordination = None;
    }
    Recording {
        meta,
        samples,
        warnings: Vec::new(),
    }
}

/// The first rows alone.
pub fn cut(whole: &Recording, rows: usize) -> Recording {
    whole.with_rows(|k, _| k < rows)
}

/// Lets a segment's counter slip by a tooth in the middle.
pub fn slip(whole: &mut Recording, segment: usize) {
    let middle = whole.samples.len() / 2;
    *whole = whole.with_rows(|k, row| {
        row.teeth[segment] = row.teeth[segment].map(|n| n + i32::from(k >= middle));
        true
    });
}
