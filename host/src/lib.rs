//! The host's side of the courier's position sensor: the `courier` command and what it is made of.
//!
//! `cli` takes the command line apart, `commands` holds one file a command, `board` is the board that a user named, `board_model`
//! turns a diagnosis into terms that a board has, `calibration_file` keeps a calibration, `capture` moves a courier until its recording answers, `compared` reads what is compared with others, `conversion` tells what became of a log, `learned` says what one encoder's own log tells, `isolability` foretells what a motion can
//! identify, `provenance` says where a report comes from, `recorder` keeps a board's samples, `noise` tells their noise, `interrupt` that the user wants no more, `trace` judges what a logic analyser saw at a board's pins, `survey` lists the motions that a diagnosis wants, `findings` tells what readings contradict, `witness` looks for it while a board calibrates, `replay` runs the firmware's
//! signal path and estimator on recordings; `kinds` are the files that commands write, `live` shows what a board says as it comes, `logs` reads logs of other programs, `many` diagnoses many recordings into a table. Packages of their
//! own, so that `cargo demo` need not build the rest: `demo`, `teeth` (the map of a platen's teeth), and what commands print with and
//! where what they write goes (`terminal`, `json`, `output`, `destination`, `recordings`).

pub mod acceptance;
pub mod board;
pub mod board_model;
pub mod calibration_file;
pub mod capture;
pub mod cli;
pub mod commands;
pub mod compared;
pub mod conversion;
pub mod findings;
pub mod interrupt;
pub mod isolability;
pub mod kinds;
pub mod learned;
pub mod live;
pub mod logs;
pub mod many;
mod monitor_file;
mod monitor_server;
pub mod provenance;
pub mod recorder;
pub mod replay;
mod seen;
pub mod survey;
pub mod trace;
pub mod witness;

pub use command_line::{destination, json, output, recordings, terminal};
pub use courier_demo as demo;
pub use tooth_map as teeth;
