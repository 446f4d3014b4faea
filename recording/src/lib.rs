//! Reader and writer of recordings: a folder of `recording.toml` and `samples.csv`, schema 1.
//!
//! [`Recording::read`] checks everything that the layout promises, so that a reader of a [`Recording`] need not:
//! values are finite and in range, time strictly increases, the tables that the columns need are there.
//! [`Writer`] applies the same checks to each row and leaves nothing behind unless it is finished.
//! Other forms of a recording live in packages of their own: they read by [`Recording::of_table`] and write by [`Writer::keeping`].
//! Not measured is NaN inside a column and `None` in a [`Row`].

mod column;
mod error;
mod existing;
mod foreign;
mod keys;
mod layout;
mod meta;
pub mod noise;
mod one_file;
mod read;
mod recording;
mod rows;
mod samples;
mod table;
mod together;
mod unfinished;
mod write;

pub use column::{COLUMNS, Column, INDEX};
pub use error::{Error, excerpt};
pub use existing::Existing;
pub use layout::{META_FILE, SAMPLES_FILE, SCHEMA};
pub use meta::{Coordination, Electronics, Geometry, Meta, Names};
pub use one_file::{check_existing_file, write_file};
pub use recording::Recording;
pub use samples::{Logged, Row, Samples, instants_between, unmodified_m};
pub use table::Table;
pub use unfinished::unfinished_file;
pub use write::{WriteFile, Writer};
