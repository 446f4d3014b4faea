//! Recordings through Parquet files: whole, spoilt, and of other programs.

mod foreign;
mod made;
mod round_trip;
mod spoilt;
