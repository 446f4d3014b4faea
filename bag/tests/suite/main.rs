//! Recordings as MCAP files and back, files that are cut or spoilt, bags that other programs wrote, a file that grows, and connections. All of it needs
//! the feature `mcap`: `cargo xtask mcap`.
#![cfg(feature = "mcap")]

mod bags;
mod live;
mod recordings;
mod serve;
