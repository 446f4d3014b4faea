//! The command `courier`: every file tries one of its commands, or one habit of all of them.
//!
//! One program of many files: each further program would be linked, and its helpers compiled, once more.

mod bad_input;
mod board;
mod cases;
mod closed_loop;
mod common;
mod compare;
mod demo;
mod diagnose;
mod encoder;
mod examples;
mod forms;
mod guided;
mod isolability;
mod joint_refusals;
mod many;
mod map;
mod outputs;
mod record;
mod replay;
mod rough;
mod trace;
mod two_hosts;
mod update;
mod wires;
