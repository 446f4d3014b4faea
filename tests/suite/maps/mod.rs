//! Tooth maps that stay: their slots on the simulated flash, and whole teeth by the beacon or by the mark.

mod crossing;
mod homing;
mod mark_tries;
mod power_cuts;
mod stored;
mod tries;

use courier_sensor::device::Device;
use courier_sensor::maps::homing::Anchor;
use courier_sensor::maps::{MapHead, MapInfo, MapStoreError, Maps, SLOT_BYTES, SLOTS};
use courier_sensor::model::{ErrorModel, TermTable};
use courier_sensor::teeth::{Grid, MapHeader, Wave};
use hal_sim::wire::flash::{Flash, PAGE_BYTES};

const OWNER: Device = Device(*b"board-000001");
/// Nodes of both fields: not a whole number of double words.
const NODES: usize = 2 * 35;

/// One page that is not ours before the slots.
fn flash(seed: u64) -> Flash {
    Flash::new(1 + SLOTS * SLOT_BYTES as usize / PAGE_BYTES, seed)
}

/// Where the slots of [`flash`] begin.
const START: u32 = PAGE_BYTES as u32;

fn maps(flash: &mut Flash) -> Maps<'_, Flash> {
    maps_at(flash, START)
}

fn maps_at(flash: &mut Flash, start: u32) -> Maps<'_, Flash> {
    Maps::new(flash, start, OWNER)
}

fn info(name: &str, mark: u32) -> MapInfo {
    MapInfo {
        device: OWNER,
        name: name.try_into().unwrap(),
        calibration: mark,
        anchor: Anchor {
            beacon_teeth: [22, -7],
            beacon_m: [0.1e-3, -0.2e-3],
            height_m: 51.0e-3,
            lever_m: [90.7e-3, 4.6e-3],
        },
        parity_m: 1.0e-6,
    }
}

fn header() -> MapHeader {
    let grid = Grid {
        first_teeth: [-3, 4],
        nodes: [5, 7],
    };
    let wave = Wave {
        own_order: 1,
        lateral_order: -1,
        coefficients_m: [[1.0e-6, -2.0e-6]; 4],
    };
    MapHeader {
        grids: [grid; 2],
        waves: [wave].into_iter().collect(),
        trusted: [u32::MAX, 7, 0].into_iter().collect(),
    }
}

fn model(mark: u32) -> ErrorModel {
    let mut model = ErrorModel::zero(TermTable::equation_9());
    model.coefficients[0][0][0] = 1.0e-9 * mark as f32;
    model
}

fn nodes(mark: u32) -> Vec<i16> {
    (0..NODES)
        .map(|n| (n * 37 % 401) as i16 - 200 + mark as i16)
        .collect()
}

/// Stores a map of a place, told apart by `mark`; its slot.
fn store(flash: &mut Flash, name: &str, mark: u32) -> Result<u8, MapStoreError> {
    store_at(flash, START, name, mark)
}

/// The same in slots that begin elsewhere.
pub fn store_at(flash: &mut Flash, start: u32, name: &str, mark: u32) -> Result<u8, MapStoreError> {
    let mut buffer = [0; 2040];
    let (info, model, header) = (info(name, mark), model(mark), header());
    let head = MapHead {
        info: &info,
        model: &model,
        header: &header,
    };
    let head = head.encode(&mut buffer).unwrap();
    let mut maps = maps_at(flash, start);
    let mut writing = maps.begin(name, head, NODES as u16)?;
    for nodes in nodes(mark).chunks(33) {
        maps.append_nodes(&mut writing, nodes)?;
    }
    maps.finish(writing)
}

/// Marks of the maps that count, by name, each with all that belongs to it.
fn current(flash: &mut Flash) -> Vec<(String, u32)> {
    current_at(flash, START)
}

/// The same in slots that begin elsewhere.
pub fn current_at(flash: &mut Flash, start: u32) -> Vec<(String, u32)> {
    let mut found: Vec<_> = (0..SLOTS as u8)
        .filter_map(|slot| {
            let found = maps_at(flash, start).current(slot)?;
            let mark = found.info.calibration;
            assert_eq!(found.info, info(&found.info.name, mark));
            assert_eq!(
                contents(flash, start, slot),
                (model(mark), header(), nodes(mark))
            );
            Some((found.info.name.to_string(), mark))
        })
        .collect();
    found.sort();
    found
}

/// Model, header and nodes of the map in a slot.
fn contents(flash: &mut Flash, start: u32, slot: u8) -> (ErrorModel, MapHeader, Vec<i16>) {
    let mut maps = maps_at(flash, start);
    let found = maps.current(slot).unwrap();
    let mut buffer = [0; 2040];
    let rest = maps.head(slot, &found, &mut buffer).unwrap();
    let mut model = ErrorModel::default();
    let rest = courier_sensor::calibration::record::read_model(rest, &mut model).unwrap();
    let (header, rest) = postcard::take_from_bytes(rest).unwrap();
    assert!(rest.is_empty());
    let mut nodes = vec![];
    let all = |piece: &[i16]| {
        nodes.extend_from_slice(piece);
        true
    };
    maps.nodes(slot, &found, all).unwrap();
    (model, header, nodes)
}
