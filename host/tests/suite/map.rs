//! `courier map` and `courier load` of what it writes: on a simulated courier under a beacon, and everything that is refused.

use crate::common::{asked, courier_in, json_in};
use board_link::{Link, SimWire, motion};
use courier_sensor::drivers::motion::Target;
use courier_sensor::link::message::StoredMap;
use courier_sensor::update::layout::{MAPS_END, MAPS_START, SLOTS_START};
use hal_sim::board::SharedFlash;
use hal_sim::coordination::origin_under;
use hal_sim::courier::Courier;
use hal_sim::presets;
use hal_sim::record::record;
use hal_sim::trajectory::{OpenLoop, Plan};
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;
use recording::Existing;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Duration;

const PITCH_M: f64 = 1.016e-3;

/// Still poses under the beacon of the `paper` courier, ±1 pitch and ±`turn_deg`, in a recording.
fn write(folder: &Path, name: &str, poses: usize, turn_deg: f64) {
    let spec = presets::paper();
    let (geometry, places) = (spec.nominal, spec.places);
    let origin_m = origin_under(&spec.geometry, places.beacon);
    let mut courier = Courier::new(spec, 1).unwrap();
    let plan = Plan::new(places.beacon, geometry, OpenLoop::COURIER, 1).beacon(
        poses,
        origin_m,
        turn_deg.to_radians(),
    );
    record(&mut courier, &plan, false)
        .write(folder.join(name), Existing::Refuse)
        .unwrap();
}

#[test]
fn map_is_estimated_written_and_loaded() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "beacon", 900, 1.5);
    let evidence = courier_in(folder, &["map", "beacon", "--out", "teeth.json", "--json"]).json();
    let after = |k: usize| evidence["after_m"][k].as_f64().unwrap();
    let before = |k: usize| evidence["before_m"][k].as_f64().unwrap();
    println!(
        "held-out g_p, g_x, g_y: {} -> {}",
        evidence["before_m"], evidence["after_m"]
    );
    // Single samples: 0.33 um of noise in g_p, and the angle's at the end of the lever arm in g_y.
    assert!(
        after(0) < 0.25 * before(0) && after(2) < 0.25 * before(2),
        "{evidence}"
    );
    assert!(after(0) < 0.6e-6 && after(2) < 3.0e-6, "{evidence}");
    courier_in(folder, &["map", "beacon", "--out", "teeth.json"])
        .refused(&["teeth.json", "--force"]);
    courier_in(folder, &["load", "teeth.json"]).refused(&["no calibration is in force"]);
    let calibrate = [
        "--sim-flash",
        "f.bin",
        "calibrate",
        "--poses",
        "150",
        "--held-out",
        "40",
    ];
    let calibrated = courier_in(folder, &calibrate);
    assert_eq!(calibrated.code, 0, "{}", calibrated.err);
    let loaded = courier_in(folder, &["--sim-flash", "f.bin", "load", "teeth.json"]).quiet();
    assert!(
        loaded.contains("stored: map slot 0, `teeth`") && loaded.contains("nodes in force"),
        "{loaded}"
    );
    a_map_fits_its_platen_and_no_other_place(folder);
    a_map_is_kept(folder);
    a_map_outlives_the_tooth_count(folder);
}

/// The board of `f.bin` under its beacon, which stands so many teeth beside where it stood.
fn under_the_beacon(folder: &Path, moved_teeth: f64) -> Link {
    let mut spec = presets::paper();
    spec.number = presets::device_number("paper", 1);
    let home = spec.places.beacon;
    spec.beacon_over = Some(effects::motion::Pose::new(
        home.x_m + moved_teeth * PITCH_M,
        home.y_m,
        0.0,
    ));
    let flash = SharedFlash::erased(1);
    let bytes = std::fs::read(folder.join("f.bin")).unwrap();
    let slots = SLOTS_START as usize..SLOTS_START as usize + 8192;
    let places = slots.chain(MAPS_START as usize..MAPS_END as usize);
    for (place, word) in places.step_by(8).zip(bytes.chunks(8)) {
        if word != [0xFF; 8] {
            flash.0.borrow_mut().force(place, word);
        }
    }
    let home = effects::motion::Pose::new(home.x_m + moved_teeth * PITCH_M, home.y_m, 0.0);
    let world = World::new(spec, ControllerConfig::TYPICAL, home, 1).unwrap();
    let wire = SimWire::around(world, flash).unwrap();
    Link::connect(Box::new(wire)).unwrap()
}

/// The map on its own platen is confirmed by g_p once the courier has moved about; one that lies whole teeth beside its place, since
/// its beacon was moved by as many, is taken out of force.
fn a_map_fits_its_platen_and_no_other_place(folder: &Path) {
    let home = presets::paper().places.beacon;
    for moved_teeth in [0.0, 7.0, -12.0, 30.0] {
        let mut link = under_the_beacon(folder, moved_teeth);
        link.pass(Duration::from_millis(500)).unwrap();
        let state = link.status().unwrap().stored_map;
        assert!(matches!(state, StoredMap::InForce { .. }), "{state:?}");
        // To and fro over the middle of the map.
        let mut legs = [(-1.0, 0.0), (-1.0, 1.0), (0.0, 0.5), (-0.5, 1.0)]
            .into_iter()
            .cycle();
        let parity = loop {
            let (x, y) = legs.next().unwrap();
            let target = Target {
                x_m: (home.x_m + (moved_teeth + x) * PITCH_M) as f32,
                y_m: (home.y_m + y * PITCH_M) as f32,
                theta_rad: 0.0,
            };
            motion::go(&mut link, target, 0.03).unwrap();
            match link.status().unwrap().stored_map {
                StoredMap::InForce { parity, .. } if parity.fits().is_none() => {}
                StoredMap::InForce { parity, .. } | StoredMap::OtherPlaten { parity, .. } => {
                    break parity;
                }
                other => panic!("{other:?}"),
            }
        };
        println!("a map {moved_teeth} teeth beside its place: {parity:?}");
        assert_eq!(parity.fits(), Some(moved_teeth == 0.0));
        assert_eq!(link.status().unwrap().map.is_some(), moved_teeth == 0.0);
    }
}

/// Where no beacon is, a mark of the motion controller puts the map in force, if its place is whole teeth from the board's count.
fn by_a_mark(folder: &Path) {
    let maps = |words: &str| asked(folder, &format!("--sim-flash f.bin maps {words}"));
    maps("--learn-mark mark.json").refused(&["no stored tooth map in force", "by its beacon"]);
    // The courier starts at the count's zero.
    let write = |place: &str, left: f64| {
        let at = json!({ "teeth": 3, "fraction_turns": left });
        let file = json!({ "courier_mark": 1, "place": place, "mark": [at, at] });
        std::fs::write(folder.join("mark.json"), file.to_string()).unwrap();
    };
    write("teeth", 0.0);
    let told = maps("--at-mark mark.json").quiet();
    assert!(
        told.contains("tooth map of teeth in force by its mark"),
        "{told}"
    );
    write("teeth", 0.4);
    maps("--at-mark mark.json").refused(&[
        "teeth ahead of the mark's place",
        "wanted whole numbers within 0.25",
    ]);
    write("nowhere", 0.0);
    maps("--at-mark mark.json").refused(&["mark.json", "no tooth map of nowhere"]);
    write("teeth", 7.0);
    maps("--at-mark mark.json").refused(&["mark.json", "beyond one tooth"]);
    std::fs::write(folder.join("mark.json"), "{}").unwrap();
    maps("--at-mark mark.json").refused(&[
        "mark.json",
        "a mark by `courier maps --learn-mark` was wanted",
    ]);
}

/// The board's own mark: its place is kept on the way to the beacon, and the next start needs neither beacon nor host.
fn by_the_boards_own_mark(folder: &Path) {
    let board = |mark: &str, words: &str| {
        asked(
            folder,
            &format!("--sim-flash f.bin --sim-mark {mark} {words}"),
        )
    };
    board("x=10", "maps --keep-mark").refused(&["no stored tooth map is in force"]);
    assert!(board("x=10", "maps --json").json()[0]["mark"].is_null());
    let beacon = presets::paper().places.beacon;
    let on_the_way = |part: f64| {
        let [x_mm, y_mm] = [beacon.x_m, beacon.y_m].map(|m| 1.0e3 * m * part);
        format!("maps --cross {x_mm},{y_mm},0")
    };
    let kept = board("x=10", &(on_the_way(1.0) + " --keep-mark")).quiet();
    assert!(kept.contains("the mark's place is kept"), "{kept}");
    // It is listed beside its map, and beside no other slot.
    let slots = board("x=10", "maps --json").json();
    let teeth = [0, 1].map(|axis| {
        let along = &slots[0]["mark"][axis];
        along["teeth"].as_f64().unwrap() + along["fraction_turns"].as_f64().unwrap()
    });
    assert!(slots[1]["mark"].is_null(), "{slots}");
    let listed = board("x=10", "maps").quiet();
    let told = format!("teeth {:.2}, {:.2}", teeth[0], teeth[1]);
    assert!(listed.contains(&told), "{listed}");
    let status = board("x=10", "status").quiet();
    assert!(
        status.contains("map waits for a beacon, or for its mark"),
        "{status}"
    );
    // Half the way, where the beacon is too far off.
    let crossed = board("x=10", &on_the_way(0.5)).quiet();
    assert!(crossed.contains("`teeth` since"), "{crossed}");
    let moved = board("x=10.4", &on_the_way(0.5)).quiet();
    assert!(
        moved.contains("does not fit: the board counts") && moved.contains("the mark was moved"),
        "{moved}"
    );
    board("z=1", "status").refused(&["--sim-mark", "wanted an axis and mm"]);
}

/// The next start is away from the beacon: the map is listed and waits. A place's next map takes the place of the one before.
fn a_map_is_kept(folder: &Path) {
    let board = |words: &str| asked(folder, &format!("--sim-flash f.bin {words}"));
    let status = board("status").quiet();
    assert!(status.contains("map waits for a beacon"), "{status}");
    assert!(status.contains("bring the courier under"), "{status}");
    let status = board("status --json").json();
    assert_eq!(status["status"]["stored_map"]["Waits"], "NoBeacon");
    assert_eq!(status["stored_map"], "map waits for a beacon");
    by_a_mark(folder);
    by_the_boards_own_mark(folder);
    for (place, slot) in [("teeth", 1), ("bench-2", 0)] {
        let told = board(&format!("load teeth.json --place {place} --json")).json();
        assert_eq!(told["stored"]["slot"], slot);
        assert_eq!(told["stored"]["name"], place);
    }
    let states = |told: Value| -> Vec<String> {
        let slots = told.as_array().unwrap().iter();
        slots.map(|slot| slot["state"].to_string()).collect()
    };
    let empty = "{\"Refused\":\"Empty\"}";
    let told = states(board("maps --json").json());
    assert_eq!(told, ["\"Current\"", "\"Current\"", empty, empty]);
    let told = states(board("maps --forget 1 --json").json());
    assert_eq!(told, ["\"Current\"", "\"Forgotten\"", empty, empty]);
    board("maps --forget 2").refused(&["map slot 2: empty"]);
    board("maps --forget 4").refused(&["--forget"]);
    board("load teeth.json --place two,words-and-more-than-fit").refused(&["--place", "1 to 16"]);
    // The same numbers, stored anew, are another calibration: nobody has said that the map goes with it.
    for words in ["export calibration.json", "import calibration.json"] {
        let ran = board(words);
        assert_eq!(ran.code, 0, "{}", ran.err);
    }
    let status = board("status").quiet();
    assert!(
        status.contains("`bench-2` belongs to another calibration"),
        "{status}"
    );
}

/// The same map in the counts of another start of a board: the beacon tells the whole teeth between the two, and nothing else is
/// taken for them.
fn a_map_outlives_the_tooth_count(folder: &Path) {
    let counted = |name: &str, teeth: [f64; 2]| {
        let mut file = json_in(folder.join("teeth.json"));
        let add = |value: &mut Value, more: f64| {
            *value = match value.as_i64() {
                Some(whole) => (whole + more as i64).into(),
                None => (value.as_f64().unwrap() + more).into(),
            };
        };
        for axis in 0..2 {
            add(&mut file["anchor"]["beacon_m"][axis], teeth[axis] * PITCH_M);
            for grid in 0..2 {
                let along = usize::from(grid != axis);
                add(
                    &mut file["header"]["grids"][grid]["first_teeth"][along],
                    teeth[axis],
                );
            }
        }
        std::fs::write(folder.join(name), file.to_string()).unwrap();
    };
    counted("other.json", [5.0, -3.0]);
    counted("moved.json", [0.4, 0.0]);
    let load = |arguments: &[&str]| {
        let options = ["--sim-flash", "f.bin", "load", "--dry-run", "--json"];
        courier_in(folder, &[&options, arguments].concat())
    };
    let (first, other) = (load(&["teeth.json"]).json(), load(&["other.json"]).json());
    let ahead = |told: &Value, axis: usize| told["teeth_ahead"][axis].as_i64().unwrap();
    assert_eq!(first["map"], other["map"]);
    assert_eq!(ahead(&first, 0) - ahead(&other, 0), 5);
    assert_eq!(ahead(&first, 1) - ahead(&other, 1), -3);
    load(&["moved.json"]).refused(&[
        "teeth ahead of the map's along x",
        "wanted a whole number within 0.25",
    ]);
    load(&["teeth.json", "--from", "0,0,0"])
        .refused(&["found the beacon in 0 frames, wanted 100", "--from"]);
}

/// A survey goes over too much for its samples to tell the teeth of any place: no map, and nothing written. The motion that the help
/// names gives one.
#[test]
fn a_map_without_a_trusted_cell_is_refused_and_the_help_s_recipe_gives_one() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let record = |words: &str| {
        let ran = asked(folder, &format!("record {words} --decimation 60"));
        assert_eq!(ran.code, 0, "{}", ran.err);
    };
    record("survey --survey 22.13,25.08,0");
    asked(folder, "map survey --within 1.3 --out teeth.json")
        .refused(&["survey", "no cell", "1000"]);
    assert!(!folder.join("teeth.json").exists());
    record("beacon --under-beacon");
    let told = asked(folder, "map beacon --out teeth.json").quiet();
    println!("{told}");
    assert!(told.contains("trusted cells known to"), "{told}");
    assert!(folder.join("teeth.json").exists());
    asked(folder, "--sim record no --under-beacon=1,2")
        .refused(&["--under-beacon", "three numbers"]);
}

#[test]
fn recordings_that_tell_no_map_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "few", 100, 1.5);
    write(folder, "unturned", 400, 0.01);
    let head = "schema = 1\n[geometry]\npitch_m = 1e-3\n[electronics]\nposition_noise_m = 1e-8\n";
    std::fs::create_dir(folder.join("one")).unwrap();
    std::fs::write(folder.join("one/recording.toml"), head).unwrap();
    std::fs::write(folder.join("one/samples.csv"), "t_s,p1_m\n0,0\n1,1e-4\n").unwrap();
    std::fs::write(folder.join("other.json"), "{\"courier_tooth_map\": 7}").unwrap();
    std::fs::write(folder.join("older.json"), "{\"courier_tooth_map\": 2}").unwrap();
    let cases: [(&[&str], &[&str]); 6] = [
        (&["map", "few"], &["84 poses", "240"]),
        (
            &["map", "unturned"],
            &["rotation of", "mrad", "wanted 1.75"],
        ),
        (
            &["map", "one"],
            &["recording.toml", "span_m", "wanted both"],
        ),
        (&["map", "nowhere"], &["nowhere"]),
        (
            &["load", "other.json"],
            &["other.json", "courier_tooth_map", "found 7", "wanted 3"],
        ),
        (
            &["load", "older.json"],
            &["older.json", "found 2, wanted 3", "anew by courier map"],
        ),
    ];
    for (arguments, wanted) in cases {
        courier_in(folder, arguments).refused(wanted);
    }
}
