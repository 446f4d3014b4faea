//! What a monitor sees, as messages of ROS 2: of a file that grows, and of a connection.

use crate::cdr::Packer;

/// What is seen of the board.
const STATE: Channel = Channel {
    topic: "/state",
    name: "courier/msg/State",
    definition: "# metres and radians; parity is g_p\nfloat64 t_s\nfloat64 x_m\nfloat64 y_m\nfloat64 theta_x_rad\nfloat64 theta_y_rad\nfloat64 parity_m\nuint32 status_bits\nstring status\n",
    pack: pack_state,
};
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
const POSE: Channel = Channel {
    topic: "/pose",
    name: "geometry_msgs/msg/PoseStamped",
    definition: concat!(
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
    pack: pack_pose,
};
/// The frame that poses are in.
const FRAME: &str = "platen";
/// Nanoseconds of a second. By definition.
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

/// One kind of message.
pub(crate) struct Channel {
    pub(crate) topic: &'static str,
    pub(crate) name: &'static str,
    /// As `ros2msg` has it.
    pub(crate) definition: &'static str,
    /// The values of a state, seen at a time in ns since 1970, in CDR.
    pub(crate) pack: fn(&State, u64, &mut Packer),
}

/// All of them. A further one is a line here.
pub(crate) const CHANNELS: [Channel; 2] = [STATE, POSE];
/// How their definitions and their values are written.
pub(crate) const ENCODINGS: [&str; 2] = ["ros2msg", "cdr"];

/// When a state was seen, ns since 1970, of a board whose time was zero at `zero_ns`.
pub(crate) fn time_ns(state: &State, zero_ns: u64) -> u64 {
    zero_ns + (state.t_s * NS).round() as u64
}

fn pack_state(state: &State, _: u64, packer: &mut Packer) {
    for value in [
        state.t_s,
        state.x_m,
        state.y_m,
        state.theta_rad[0],
        state.theta_rad[1],
        state.parity_m,
    ] {
        packer.float64(value);
    }
    packer.uint32(state.status.0);
    packer.string(state.status.1);
}

fn pack_pose(state: &State, time_ns: u64, packer: &mut Packer) {
    let second = NS as u64;
    packer.int32((time_ns / second) as i32);
    packer.uint32((time_ns % second) as u32);
    packer.string(FRAME);
    let half = 0.25 * (state.theta_rad[0] + state.theta_rad[1]);
    for value in [state.x_m, state.y_m, 0.0, 0.0, 0.0, half.sin(), half.cos()] {
        packer.float64(value);
    }
}
