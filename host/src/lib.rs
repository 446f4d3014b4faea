//! The host's side of the courier's position sensor: the `courier` command and what it is made of.
//!
//! `cli` takes the command line apart, `commands` holds one file a command, `terminal` is all that they print with,
//! `board` reaches a board over its debug link, `board_model` turns a diagnosis into terms that a board has, `calibration_file`
//! keeps a calibration, `isolability` foretells what a motion can identify, `demo` goes through the main job on a simulated
//! courier, `recorder` keeps a board's samples, `survey` lists the motions that a diagnosis wants, `replay` runs the firmware's
//! signal path and estimator on recordings, `teeth` maps a platen's teeth; `output` writes files, `destination` recordings, `live`
//! shows what a board says as it comes.

pub mod board;
pub mod board_model;
pub mod calibration_file;
pub mod cli;
pub mod commands;
pub mod demo;
pub mod destination;
pub mod isolability;
pub mod live;
pub mod output;
pub mod recorder;
pub mod replay;
pub mod survey;
pub mod teeth;
pub mod terminal;
