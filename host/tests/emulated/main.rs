//! The firmware's image on the emulated Cortex-M4F under every fault there is: nothing lost that was committed, no sampling
//! instant missed, the reason readable afterwards. `cargo xtask test` runs it.

mod acceptance;
mod bytes;
#[path = "../suite/common/mod.rs"]
mod common;
mod demo;
mod joint;
mod log;
mod long;
mod map;
mod parts;
mod recalibration;
mod restarts;
mod rig;
mod speed;
mod storage;
