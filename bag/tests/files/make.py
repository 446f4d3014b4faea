"""Writes the bags of this folder: python3 make.py, in a place with rosbags 0.11.9, mcap 1.6.0 and mcap-ros2-support 0.6.0.

One motion, a shaft that swings over three turns, 200 a second, and an encoder that reads it wrongly by 0.002 turns.
"""
import json, math, shutil
from pathlib import Path
import numpy as np
from mcap.writer import CompressionType, Writer as Mcap
from mcap_ros2.writer import Writer as McapRos2
from rosbags.rosbag2 import Writer
from rosbags.rosbag2.enums import StoragePlugin
from rosbags.typesys import Stores, get_typestore

FIRST_NS, ROWS = 1764248400_250000000, 120

def motion(t):
    turn = 1.5 * math.sin(2.0 * t)
    return turn, turn + 0.002 * math.sin(2 * math.pi * turn)

# A bag of ROS 2: joints whose order changes and whose stamps are 0.7 ms before they came, a pair, a stage half as often, a temperature.
store = get_typestore(Stores.ROS2_HUMBLE)
T = store.types
shutil.rmtree("bag", ignore_errors=True)
with Writer(Path("bag"), version=9, storage_plugin=StoragePlugin.MCAP) as bag:
    def topic(name, kind):
        connection = bag.add_connection(name, kind, typestore=store)
        return lambda at, message: bag.write(connection, at, store.serialize_cdr(message, kind))
    joints, stage = topic("/joint_states", "sensor_msgs/msg/JointState"), topic("/stage", "std_msgs/msg/Float64")
    pair, temperature = topic("/pair", "std_msgs/msg/Float64MultiArray"), topic("/temperature", "sensor_msgs/msg/Temperature")
    for row in range(ROWS):
        at = FIRST_NS + row * 5_000_000
        turn, read = motion(row / 200)
        stamp = T["builtin_interfaces/msg/Time"](sec=at // 10**9, nanosec=at % 10**9)
        header = T["std_msgs/msg/Header"](stamp=stamp, frame_id="base")
        named = [("elbow", 2 * math.pi * read), ("wrist", 9.0)]
        named = named if row % 2 == 0 else named[::-1]
        nothing = np.array([], dtype=float)
        joints(at + 700_000, T["sensor_msgs/msg/JointState"](header=header, name=[name for name, _ in named],
               position=np.array([value for _, value in named]), velocity=nothing, effort=nothing))
        if row % 2 == 0:
            stage(at + 1_000_000, T["std_msgs/msg/Float64"](data=360 * motion(row / 200 + 1e-3)[0]))
        layout = T["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
        counts = [round(8000 * math.sin(2 * math.pi * read)), round(8000 * math.cos(2 * math.pi * read))]
        pair(at, T["std_msgs/msg/Float64MultiArray"](layout=layout, data=np.array(counts, dtype=float)))
        if row % 50 == 0:
            temperature(at, T["sensor_msgs/msg/Temperature"](header=header, temperature=21.5, variance=0.0))
Path("bag/bag.mcap").rename("rosbags.mcap")
shutil.rmtree("bag")

# The same joints' values by the packages of MCAP itself, compressed by Zstandard, and as JSON, compressed by LZ4.
with open("mcap-ros2.mcap", "wb") as file:
    writer = McapRos2(file, compression=CompressionType.ZSTD)
    schema = writer.register_msgdef("own_msgs/msg/Reading", "float64 place\nint16[2] pair\nbool moving\nstring phase")
    for row in range(ROWS):
        turn, read = motion(row / 200)
        writer.write_message("/reading", schema, {"place": read, "pair": [row, -row], "moving": row > 0, "phase": "out" if row < 60 else "on"},
                             log_time=FIRST_NS + row * 5_000_000, publish_time=0)
    writer.finish()
with open("json.mcap", "wb") as file:
    writer = Mcap(file, compression=CompressionType.LZ4)
    writer.start()
    schema = writer.register_schema("Reading", "jsonschema", b"{}")
    channel = writer.register_channel("/reading", "json", schema)
    other = writer.register_channel("/image", "protobuf", schema)
    for row in range(ROWS):
        turn, read = motion(row / 200)
        at = FIRST_NS + row * 5_000_000
        writer.add_message(channel, at, json.dumps({"place": {"read": read, "true": turn}, "none": None}).encode(), at)
    writer.add_message(other, at, b"\x00", at)
    writer.finish()
