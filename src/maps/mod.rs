//! Tooth maps that stay: stored in flash by place, and given their place in the tooth count anew after each start, by the beacon.
//!
//! `record` (what is stored) -> `store` (slots, power cuts) -> `homing` (whole teeth by equation (11)) -> `fit` (does the map fit this
//! platen?). `mark` and `crossing`: whole teeth by a reference mark instead. Pure: flash, frames and numbers in, values out. [`crate::app::homing`] runs it.

pub mod crossing;
pub mod fit;
pub mod homing;
pub mod mark;
mod record;
mod store;

pub use record::{
    HEADER_BYTES, MAGIC, MAX_HEAD_BYTES, MapHead, MapInfo, MapRecordError, Name, VERSION,
};
pub use store::{
    Found, MOST_PLACES, MapSlot, MapSlotState, MapStoreError, Maps, SLOT_BYTES, SLOTS, Writing,
};
