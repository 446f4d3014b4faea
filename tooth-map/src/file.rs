//! A map as a file on the host: JSON.

use super::estimate::Mapped;
use anyhow::{Context, Result, ensure};
use courier_sensor::teeth::MapHeader;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Version of the file. Until 2 waves had their phases where the outputs are before fields and waves move them. By definition of
/// the file's layout.
const VERSION: u64 = 3;
/// The key that tells a map from other JSON.
const KEY: &str = "courier_tooth_map";

/// The file's one object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapFile {
    courier_tooth_map: u64,
    /// What the map leaves open.
    gauge: String,
    /// The map, its keys beside these.
    #[serde(flatten)]
    pub map: Mapped,
}

impl MapFile {
    /// For writing.
    pub fn new(map: Mapped) -> Self {
        Self {
            courier_tooth_map: VERSION,
            gauge: "each field's mean is zero; its slope along the measured direction, a scale, is the prior's: the one that displaces teeth least".into(),
            map,
        }
    }

    /// The lattices in the counts of a board that is so many teeth ahead of the recording's.
    pub fn header_for(&self, teeth_ahead: [i32; 2]) -> MapHeader {
        let mut header = self.map.header.clone();
        header.move_by(teeth_ahead);
        header
    }

    /// Whether a file's text claims to be a map.
    pub fn is_one(value: &serde_json::Value) -> bool {
        value.get(KEY).is_some()
    }

    /// From a file's JSON.
    ///
    /// # Errors
    /// Another version, a part missing, numbers that cannot be used.
    pub fn from_json(path: &Path, value: serde_json::Value) -> Result<Self> {
        let place = path.display();
        let version = value.get(KEY).and_then(serde_json::Value::as_u64);
        let wanted = match version {
            Some(older) if older < VERSION => {
                "3: waves mean something else since; make the map anew by courier map"
            }
            _ => "3",
        };
        ensure!(
            version == Some(VERSION),
            "{place}: key {KEY}, found {}, wanted {wanted}",
            version.map_or("none".to_owned(), |version| version.to_string())
        );
        let file: Self = serde_json::from_value(value)
            .with_context(|| format!("{place}: wanted a tooth map"))?;
        let Mapped {
            model,
            header,
            nodes_nm,
            ..
        } = &file.map;
        model.validate().with_context(|| place.to_string())?;
        header.validate().with_context(|| place.to_string())?;
        let (found, wanted) = (nodes_nm.len(), header.nodes());
        ensure!(
            found == wanted,
            "{place}: nodes_nm: found {found} nodes, wanted {wanted}"
        );
        Ok(file)
    }
}
