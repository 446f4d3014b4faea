//! What the tests of stored maps share: a courier under a beacon, a calibration, and a map that adds the same at every node.

use crate::bench::{Bench, marked};
use courier_sensor::calibration::record::{Beacon, Calibration};
use courier_sensor::link::message::{Action, MapPlace, Reply, StoredMap};
use courier_sensor::maps::homing::Anchor;
use courier_sensor::maps::{MapSlot, MapSlotState};
use courier_sensor::settings::Settings;
use courier_sensor::teeth::{Grid, MapHeader};
use effects::motion::Pose;
use hal_sim::board::SharedFlash;
use hal_sim::presets;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;

/// The paper's.
pub(super) const PITCH_M: f64 = 1.016e-3;
pub(super) const RATE_HZ: u32 = 20_000;
/// Asked: from the restart to the map in force.
pub(super) const MOST_S: f32 = 2.0;
/// Nodes of a field along and across.
pub(super) const SIDE: u8 = 20;
/// What every node of the map adds, nanometres: more than segments' noise.
pub(super) const NODE_NM: i16 = 2000;

/// An `ideal` courier that stands at `home`, its beacon over `beacon`.
pub(super) fn world(home: Pose, beacon: Option<Pose>) -> World {
    let world = World::new(presets::ideal(39), ControllerConfig::TYPICAL, home, 39);
    let world = world.expect("monotonic");
    world.with_courier(|courier| courier.set_beacon(beacon));
    world
}

/// A place by teeth, under the beacon over the origin while it is within the diode's middle.
pub(super) fn at(x_teeth: f64, y_teeth: f64) -> Pose {
    Pose::new(x_teeth * PITCH_M, y_teeth * PITCH_M, 0.0)
}

pub(super) const ORIGIN: Pose = Pose {
    x_m: 0.0,
    y_m: 0.0,
    theta_rad: 0.0,
};

pub(super) fn start(home: Pose, beacon: Option<Pose>, flash: &SharedFlash) -> Bench {
    Bench::start(world(home, beacon), flash.clone())
}

/// About the origin, in a count that is 100 and -40 teeth ahead of the platen's.
pub(super) fn header() -> MapHeader {
    let first = -i32::from(SIDE) / 2;
    let grid = |along, across| Grid {
        first_teeth: [first + along, first + across],
        nodes: [SIDE; 2],
    };
    let words = 2 * usize::from(SIDE) * usize::from(SIDE) / 32;
    MapHeader {
        grids: [grid(100, -40), grid(-40, 100)],
        waves: Default::default(),
        trusted: (0..words).map(|_| u32::MAX).collect(),
    }
}

/// A place of that name, its beacon over the origin.
pub(super) fn place(name: &str) -> MapPlace {
    let geometry = Settings::default().geometry;
    MapPlace {
        name: name.try_into().unwrap(),
        anchor: Anchor {
            beacon_teeth: [100, -40],
            beacon_m: [0.0; 2],
            height_m: geometry.height_m,
            lever_m: geometry.lever_m,
        },
        parity_m: 0.5e-6,
    }
}

/// Stores the courier's own errors as a calibration, with a beacon's place that is not this start's.
pub(super) fn calibrate(bench: &mut Bench, mark: u32) {
    let calibration = Calibration {
        beacon: Some(Beacon {
            segment_sd_m: 1.0e-6,
            displacement_sd_m: 1.0e-6,
            ..Beacon::default()
        }),
        ..marked(mark)
    };
    assert_eq!(bench.ask(Action::take_over(calibration)), Reply::Done);
    bench.run(2);
    let lose_unknown = false;
    assert!(matches!(
        bench.ask(Action::Commit { lose_unknown }),
        Reply::Place(_)
    ));
}

/// Stores a map of these nodes; what the board says at its end.
pub(super) fn store(bench: &mut Bench, name: &str, node_nm: impl Fn(usize) -> i16) -> Reply {
    store_at(bench, place(name), node_nm)
}

pub(super) fn store_at(
    bench: &mut Bench,
    place: MapPlace,
    node_nm: impl Fn(usize) -> i16,
) -> Reply {
    let header = header();
    let nodes: Vec<i16> = (0..header.nodes()).map(node_nm).collect();
    let begun = bench.ask(Action::MapStore { place, header });
    if begun != Reply::Done {
        return begun;
    }
    for nodes in nodes.chunks(200) {
        let nodes = nodes.iter().copied().collect();
        assert_eq!(bench.ask(Action::MapStoreNodes(nodes)), Reply::Done);
    }
    bench.ask(Action::MapStoreEnd)
}

/// Flash with a calibration and a map of the origin.
pub(super) fn with_map() -> SharedFlash {
    let flash = SharedFlash::erased(39);
    let mut bench = start(at(0.3, -0.4), Some(ORIGIN), &flash);
    calibrate(&mut bench, 1);
    let stored = store(&mut bench, "origin", |_| NODE_NM);
    assert!(
        matches!(
            stored,
            Reply::MapSlot(MapSlot {
                slot: 0,
                state: MapSlotState::Current,
                ..
            })
        ),
        "{stored:?}"
    );
    flash
}

/// State of the stored maps after so long.
pub(super) fn state_after(bench: &mut Bench, seconds: f32) -> StoredMap {
    bench.run((seconds * RATE_HZ as f32) as u32);
    bench.status().stored_map
}
