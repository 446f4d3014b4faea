//! What a monitor sees, written while it runs: each second is whole on the disk before the next begins.

use crate::cdr::Packer;
use mcap::records::MessageHeader;
use mcap::{McapResult, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;

/// Name and definition of what is seen of the board.
const STATE: (&str, &str) = (
    "courier/msg/State",
    "# metres and radians; parity is g_p\nfloat64 t_s\nfloat64 x_m\nfloat64 y_m\nfloat64 theta_x_rad\nfloat64 theta_y_rad\nfloat64 parity_m\nuint32 status_bits\nstring status\n",
);
/// What parts a type's definition from the next one's: a line as ROS 2's own tools write it, and PlotJuggler wants eight of them at least.
macro_rules! then_type {
    ($name:literal) => {
        concat!(
            "================================================================================\nMSG: ",
            $name,
            "\n"
        )
    };
}

/// A pose as the views of ROS 2's tools draw it.
const POSE: (&str, &str) = (
    "geometry_msgs/msg/PoseStamped",
    concat!(
        "std_msgs/Header header\nPose pose\n",
        then_type!("std_msgs/Header"),
        "builtin_interfaces/Time stamp\nstring frame_id\n",
        then_type!("builtin_interfaces/Time"),
        "int32 sec\nuint32 nanosec\n",
        then_type!("geometry_msgs/Pose"),
        "Point position\nQuaternion orientation\n",
        then_type!("geometry_msgs/Point"),
        "float64 x\nfloat64 y\nfloat64 z\n",
        then_type!("geometry_msgs/Quaternion"),
        "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
    ),
);
/// The frame that poses are in.
const FRAME: &str = "platen";
/// After so long a time what is written is made whole: a cut loses less than that.
const FLUSH_S: f64 = 1.0;
const NS: f64 = 1e9;

/// A state of the board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<'a> {
    /// Time since the board's start, s.
    pub t_s: f64,
    /// x, m.
    pub x_m: f64,
    /// y, m.
    pub y_m: f64,
    /// The angle by each pair, rad.
    pub theta_rad: [f64; 2],
    /// g_p, m.
    pub parity_m: f64,
    /// The status' bits, and their names.
    pub status: (u32, &'a str),
}

/// A file that grows.
pub struct Live {
    writer: Writer<BufWriter<File>>,
    packer: Packer,
    channels: [u16; 2],
    /// Time zero of the board, ns since 1970.
    zero_ns: u64,
    flushed_s: f64,
    sequence: u32,
}

impl Live {
    /// Begins a file. `zero_ns` is when the board's time was zero, ns since 1970.
    ///
    /// # Errors
    /// A failure to write.
    pub fn begin(file: File, zero_ns: u64) -> McapResult<Self> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("courier ", env!("CARGO_PKG_VERSION")));
        let mut writer = options.create(BufWriter::new(file))?;
        let mut channel = |topic: &str, (name, text): (&str, &str)| {
            let schema = writer.add_schema(name, "ros2msg", text.as_bytes())?;
            writer.add_channel(schema, topic, "cdr", &BTreeMap::new())
        };
        let channels = [channel("/state", STATE)?, channel("/pose", POSE)?];
        // Not made whole yet: a chunk without messages has the time 0, and what draws the file would begin in 1970.
        Ok(Self {
            writer,
            packer: Packer::default(),
            channels,
            zero_ns,
            flushed_s: f64::NEG_INFINITY,
            sequence: 0,
        })
    }

    /// Adds a state.
    ///
    /// # Errors
    /// A failure to write.
    pub fn push(&mut self, state: &State) -> McapResult<()> {
        let log_time = self.zero_ns + (state.t_s * NS).round() as u64;
        self.packer.clear();
        for value in [
            state.t_s,
            state.x_m,
            state.y_m,
            state.theta_rad[0],
            state.theta_rad[1],
            state.parity_m,
        ] {
            self.packer.float64(value);
        }
        self.packer.uint32(state.status.0);
        self.packer.string(state.status.1);
        self.put(0, log_time)?;
        self.packer.clear();
        let second = NS as u64;
        self.packer.int32((log_time / second) as i32);
        self.packer.uint32((log_time % second) as u32);
        self.packer.string(FRAME);
        let half = 0.25 * (state.theta_rad[0] + state.theta_rad[1]);
        for value in [state.x_m, state.y_m, 0.0, 0.0, 0.0, half.sin(), half.cos()] {
            self.packer.float64(value);
        }
        self.put(1, log_time)?;
        self.sequence = self.sequence.wrapping_add(1);
        if state.t_s >= self.flushed_s + FLUSH_S {
            self.writer.flush()?;
            self.flushed_s = state.t_s;
        }
        Ok(())
    }

    fn put(&mut self, channel: usize, log_time: u64) -> McapResult<()> {
        let header = MessageHeader {
            channel_id: self.channels[channel],
            sequence: self.sequence,
            log_time,
            publish_time: log_time,
        };
        self.writer
            .write_to_known_channel(&header, self.packer.bytes())
    }

    /// Ends the file with its index.
    ///
    /// # Errors
    /// A failure to write.
    pub fn end(mut self) -> McapResult<()> {
        self.writer.finish().map(drop)
    }
}
