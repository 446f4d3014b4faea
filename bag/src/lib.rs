//! MCAP files: a recording as one of them, what a monitor sees while it runs, and bags that other programs wrote.
//!
//! `cdr` packs and unpacks values, `definition` reads what a message is made of, `flatten` makes columns of messages, and `topic` of all
//! messages of a topic. With the feature `mcap`: `open` walks through a file, `write` and `read` have a recording, `seen` has a monitor's
//! messages, which `live` writes into a file and `serve` sends to who connects, `log` makes a log that `convert` takes.
//!
//! Messages are those of ROS 2 (definitions `ros2msg`, values in CDR), as Foxglove and PlotJuggler draw them without being told anything, and
//! numbers keep all their bits, which those of JSON need not.

mod cdr;
mod definition;
mod flatten;
#[cfg(feature = "mcap")]
mod live;
#[cfg(feature = "mcap")]
mod log;
#[cfg(feature = "mcap")]
mod open;
#[cfg(feature = "mcap")]
mod read;
#[cfg(feature = "mcap")]
mod seen;
#[cfg(feature = "mcap")]
mod serve;
mod topic;
#[cfg(feature = "mcap")]
mod write;

pub use cdr::{Packer, Unpacker};
pub use definition::{Definition, Field, Kind, Length};
pub use flatten::{Flattened, flatten};
pub use topic::{Form, Topic};

#[cfg(feature = "mcap")]
pub use live::Live;
#[cfg(feature = "mcap")]
pub use log::log;
#[cfg(feature = "mcap")]
pub use read::{is_recording, read};
#[cfg(feature = "mcap")]
pub use seen::State;
#[cfg(feature = "mcap")]
pub use serve::Server;
#[cfg(feature = "mcap")]
pub use write::{check_existing, write};

/// Name of the attachment that makes a file a recording.
#[cfg(feature = "mcap")]
const META_NAME: &str = "recording.toml";
/// Topic of a recording's samples.
#[cfg(feature = "mcap")]
const SAMPLES: &str = "/samples";
