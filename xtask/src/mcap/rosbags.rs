//! Values of a ROS 2 bag beside those of another reader: the package rosbags writes a bag of drawn numbers, and reads it.

use crate::arm;
use crate::parquet::courier;
use crate::python::environment;
use anyhow::{Context, Result};
use std::path::Path;
use std::process::Command;

/// Six kinds of messages, 150 of each.
const WRITES: &str = r#"
import random
from pathlib import Path
import numpy as np
from rosbags.rosbag2 import Writer
from rosbags.rosbag2.enums import StoragePlugin
from rosbags.typesys import Stores, get_typestore
random.seed(7)
store = get_typestore(Stores.ROS2_HUMBLE)
T = store.types
numbers = lambda count: np.array([random.gauss(0.0, 1e-3) for _ in range(count)])
with Writer(Path('rosbag'), version=9, storage_plugin=StoragePlugin.MCAP) as bag:
    def topic(name, kind):
        connection = bag.add_connection(name, kind, typestore=store)
        return lambda at, message: bag.write(connection, at, store.serialize_cdr(message, kind))
    imu, double, single, pair = (topic('/imu', 'sensor_msgs/msg/Imu'), topic('/double', 'std_msgs/msg/Float64'),
        topic('/single', 'std_msgs/msg/Float32'), topic('/pair', 'std_msgs/msg/Float64MultiArray'))
    whole, joints = topic('/whole', 'std_msgs/msg/Int32'), topic('/joints', 'sensor_msgs/msg/JointState')
    for row in range(150):
        at = 1764248400_250000000 + row * 5_000_000
        header = T['std_msgs/msg/Header'](stamp=T['builtin_interfaces/msg/Time'](sec=at // 10**9, nanosec=at % 10**9), frame_id='base' * (row % 4))
        vector = lambda: T['geometry_msgs/msg/Vector3'](*numbers(3))
        imu(at, T['sensor_msgs/msg/Imu'](header=header, orientation=T['geometry_msgs/msg/Quaternion'](*numbers(4)), orientation_covariance=numbers(9),
            angular_velocity=vector(), angular_velocity_covariance=numbers(9), linear_acceleration=vector(), linear_acceleration_covariance=numbers(9)))
        double(at, T['std_msgs/msg/Float64'](data=float(numbers(1)[0])))
        single(at, T['std_msgs/msg/Float32'](data=float(np.float32(numbers(1)[0]))))
        whole(at, T['std_msgs/msg/Int32'](data=random.randrange(-999, 1000)))
        pair(at, T['std_msgs/msg/Float64MultiArray'](layout=T['std_msgs/msg/MultiArrayLayout'](dim=[], data_offset=0), data=numbers(3)))
        names = ['elbow', 'wrist', 'hand'][:: 1 if row % 2 else -1]
        joints(at, T['sensor_msgs/msg/JointState'](header=header, name=names, position=numbers(3), velocity=numbers(3), effort=np.array([])))
"#;

/// Each value is the same, bit for bit; the whole numbers are taken for micrometres.
const READS: &str = r#"
import csv
from pathlib import Path
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore
store = get_typestore(Stores.ROS2_HUMBLE)
values = {name: [] for name in ('imu', 'acceleration', 'double', 'single', 'pair', 'whole', 'joints')}
with Reader(Path('rosbag')) as bag:
    for connection, _, data in bag.messages():
        message, of = store.deserialize_cdr(data, connection.msgtype), connection.topic[1:]
        if of == 'imu':
            values['imu'].append(message.angular_velocity.z)
            values['acceleration'].append(message.linear_acceleration.x)
        elif of == 'pair':
            values[of].append(message.data[1])
        elif of == 'joints':
            values[of].append(message.position[message.name.index('wrist')])
        else:
            values[of].append(message.data * (1e-6 if of == 'whole' else 1.0))
for name, wanted in values.items():
    with open(f'ros-{name}/samples.csv') as file:
        found = [float(row['p1_m']) for row in csv.DictReader(file)]
    assert len(found) == 150 and found == [float(value) for value in wanted], (name, found[:3], wanted[:3])
"#;

/// What is taken of each, and the folder that it goes to.
const TAKEN: [(&str, &str); 7] = [
    ("ros-imu", "/imu.angular_velocity.z"),
    ("ros-acceleration", "/imu.linear_acceleration.x"),
    ("ros-double", "/double.data"),
    ("ros-single", "/single.data"),
    ("ros-pair", "/pair.data[1]"),
    ("ros-whole", "/whole.data:um"),
    ("ros-joints", "position[wrist]"),
];

/// By the package rosbags; what cannot be had is skipped, and that is said.
pub fn with_rosbags(command: &Path, folder: &Path) -> Result<()> {
    let Some(python) = environment(folder, "rosbags", &["rosbags"])? else {
        return Ok(());
    };
    let run = |script: &str| {
        arm::run(
            Command::new(&python)
                .args(["-c", script])
                .current_dir(folder),
        )
    };
    run(WRITES).context("rosbags writes")?;
    for (to, column) in TAKEN {
        let line = format!("convert rosbag/rosbag.mcap {to} --column p1_m={column} --pitch 1mm");
        courier(command, folder, &line)?;
    }
    run(READS).context("rosbags reads")
}
