//! Files of programs whose content is not read here, each with the way to have one that is.

use crate::table::Log;
use recording::Error;
use std::path::Path;

/// First bytes, what such a file is, and what to do.
const KNOWN: [(&[u8], &str, &str); 5] = [
    (
        b"SQLite format 3\0",
        "an SQLite database, as bags of ROS 2 were until Iron",
        "a bag in MCAP: `ros2 bag convert`, or rosbags-convert of the Python package rosbags",
    ),
    (
        b"#ROSBAG V2.0",
        "a bag of ROS 1",
        "a bag of ROS 2 in MCAP: rosbags-convert of the Python package rosbags",
    ),
    (
        b"\x89MCAP0\r\n",
        "an MCAP file by its first bytes",
        "a name that ends in .mcap",
    ),
    (
        b"PAR1",
        "a Parquet file by its first bytes",
        "a name that ends in .parquet",
    ),
    (
        b"\x89HDF\r\n\x1a\n",
        "an HDF5 file",
        "columns of NumPy: numpy.savez(FILE, t=…, sin=…, cos=…)",
    ),
];

/// True of any of them.
pub fn is_it(bytes: &[u8]) -> bool {
    KNOWN.iter().any(|(mark, ..)| bytes.starts_with(mark))
}

/// Refuses it.
///
/// # Errors
/// Always: what it is, and what to do.
pub fn read(file: &Path, bytes: &[u8]) -> Result<Log, Error> {
    let known = KNOWN.iter().find(|(mark, ..)| bytes.starts_with(mark));
    let (found, wanted) = known
        .map_or(("a file of another kind", "a log"), |(_, found, wanted)| {
            (*found, *wanted)
        });
    Err(Error::new(file, found, wanted))
}
