//! A recording that takes part: its names, its poses to fit and its poses held out.

use crate::key::{Name, Platen};
use anyhow::{Context, Result, ensure};
use courier_sensor::teeth::Grid;
use recording::Recording;
use tooth_map::{Setup, TeethPose, check_turn, lattices, poses_of, split};

/// Fewest poses to fit.
const FEWEST: usize = 100;

/// One recording of one courier over one platen under a beacon.
#[derive(Clone, Debug)]
pub struct Member {
    /// The recording's own name, such as its folder's: no two are alike.
    pub recording: Name,
    /// The courier's name.
    pub courier: Name,
    /// The platen and the beacon.
    pub platen: Platen,
    /// Geometry as entered and stated noise.
    pub setup: Setup,
    /// Lattices of both fields over all poses, in the recording's own tooth counts.
    pub grids: [Grid; 2],
    /// Poses to fit.
    pub poses: Vec<TeethPose>,
    /// Poses held out.
    pub held_out: Vec<TeethPose>,
}

impl Member {
    /// Takes a recording's poses.
    ///
    /// # Errors
    /// It states no courier or platen, holds too few poses under a beacon, or does not turn.
    pub fn of(name: &str, recording: &Recording) -> Result<Self> {
        let names = &recording.meta.names;
        let stated = |key: &str, value: &str, how: &str| -> Result<()> {
            ensure!(
                !value.is_empty(),
                "{name}: recording.toml: {key}: found none, wanted {how}"
            );
            Ok(())
        };
        stated(
            "courier_id",
            &names.courier_id,
            "the courier's name: `courier record` states its board's number",
        )?;
        stated(
            "platen_id",
            &names.platen_id,
            "the platen's name: `courier record --platen-id NAME`, or a line in the file",
        )?;
        let (setup, poses) = poses_of(recording).with_context(|| name.to_owned())?;
        let platen = Platen {
            platen_id: names.platen_id.clone(),
            beacon_id: names.beacon_id.clone(),
        };
        Self::of_poses(name, &names.courier_id, platen, setup, &poses)
    }

    /// From poses.
    ///
    /// # Errors
    /// Too few of them, over too large an area, or none turned.
    pub fn of_poses(
        name: &str,
        courier: &str,
        platen: Platen,
        setup: Setup,
        all: &[TeethPose],
    ) -> Result<Self> {
        let (poses, held_out) = split(all);
        ensure!(
            poses.len() >= FEWEST,
            "{name}: found {} poses to fit, wanted {FEWEST} or more under a beacon",
            poses.len()
        );
        check_turn(&setup, &poses).with_context(|| name.to_owned())?;
        let grids = lattices(&setup, all).with_context(|| name.to_owned())?;
        Ok(Self {
            recording: name.into(),
            courier: courier.into(),
            platen,
            setup,
            grids,
            poses,
            held_out,
        })
    }
}
