"""Writes the logs of this folder with the programs that write such logs. See README.md for the versions and for what is beside them.

    python3 make.py TVIEW ASC2LOG MONITOR

TVIEW is tview.py of moteus-gui, ASC2LOG the program of can-utils, MONITOR the program made of monitor.cpp.
"""
import asyncio, csv, io, json, math, subprocess, sys, types
from collections import namedtuple
import numpy as np

TVIEW, ASC2LOG, MONITOR = sys.argv[1:]
ROWS = 240
t = np.arange(ROWS) / 200.0
turn = 1.5 * np.sin(2.0 * t)  # a shaft that swings over three turns
read = turn + 0.002 * np.sin(2 * np.pi * turn)  # and an encoder that reads it wrongly
sin = np.round(8000 * np.sin(2 * np.pi * read)).astype(np.int16)
cos = np.round(8000 * np.cos(2 * np.pi * read)).astype(np.int16)

# NumPy: a table with names, one without, in Fortran's order, and archives of columns.
table = np.zeros(ROWS, dtype=[("t", "<f8"), ("sin", "<i2"), ("cos", ">i2"), ("stage", "<f4")])
table["t"], table["sin"], table["cos"], table["stage"] = t, sin, cos, turn
np.save("structured.npy", table)
np.save("plain.npy", np.stack([t, sin, cos, turn], axis=1))
np.save("fortran.npy", np.asfortranarray(np.stack([t, sin, cos, turn], axis=1).astype("<f4")))
np.savez("columns.npz", t=t, sin=sin, cos=cos, stage=turn)
np.savez_compressed("compressed.npz", t=t, sin=sin, cos=cos, stage=turn)

# ODrive: its own decoder of a capture, given what a device would say.
from odrive.high_rate_capturer import HighRateCapturer, TimestampFmt

async def capture(names, values, t_fmt):
    capturer = HighRateCapturer.__new__(HighRateCapturer)
    async def nothing(_): return False
    async def buffer(): return b"", 0
    capturer.odrv = types.SimpleNamespace(read=nothing)
    capturer.type_info = [(name, None, None, None) for name in names]
    capturer._download_raw_buffer = buffer
    capturer._decode = lambda raw, place: ([list(row) for row in zip(*values)], 100)
    return await capturer.download(return_as=np.recarray, t_fmt=t_fmt)

names = ["axis0.pos_estimate", "axis0.controller.pos_setpoint"]
values = [read.astype(np.float32).tolist(), turn.astype(np.float32).tolist()]
np.save("odrive-nanoseconds.npy", asyncio.run(capture(names, values, TimestampFmt.NANOSECONDS)))
np.save("odrive-cycles.npy", asyncio.run(capture(names, values, TimestampFmt.CONTROL_CYCLE)))

# A bus: an encoder's frames and, half as often and between them, a stage's.
import can, cantools
open("bus.dbc", "w").write('''VERSION ""

BU_: Board Stage

BO_ 9 Encoder_Estimates: 8 Board
 SG_ Pos_Estimate : 0|32@1- (1,0) [0|0] "rev" Stage
 SG_ Vel_Estimate : 32|32@1- (1,0) [0|0] "rev/s" Stage

BO_ 2566844926 Raw: 8 Board
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" Stage
 SG_ Sine m0 : 15|16@0- (0.5,0) [0|0] "counts" Stage
 SG_ Cosine m0 : 31|16@0- (0.5,0) [0|0] "counts" Stage
 SG_ Temp m1 : 8|10@1+ (0.25,-40) [0|0] "degC" Stage

BO_ 16 Place: 4 Stage
 SG_ Place : 0|24@1- (0.0001,0) [0|0] "deg" Board

SIG_VALTYPE_ 9 Pos_Estimate : 1;
SIG_VALTYPE_ 9 Vel_Estimate : 1;
''')
bus = cantools.database.load_file("bus.dbc", strict=False)
frames = []
def frame(at, name, **signals):
    message = bus.get_message_by_name(name)
    frames.append(can.Message(timestamp=1764248400 + at, arbitration_id=message.frame_id, is_extended_id=message.is_extended_frame,
                              data=message.encode(signals), channel="can0"))
for row in range(ROWS):
    frame(t[row], "Encoder_Estimates", Pos_Estimate=float(read[row]), Vel_Estimate=0.0)
    frame(t[row] + 2e-4, "Raw", Page=0, Sine=int(sin[row]) / 2, Cosine=int(cos[row]) / 2)
    if row % 50 == 0:
        frame(t[row] + 4e-4, "Raw", Page=1, Temp=21.5)
    if row % 2 == 0:
        frame(t[row] + 1e-3, "Place", Place=360 * 1.5 * math.sin(2.0 * (t[row] + 1e-3)))
with can.ASCWriter("bus.asc") as log:
    for one in frames:
        log(one)
subprocess.run([ASC2LOG, "-I", "bus.asc", "-O", "can-utils.log"], check=True)
subprocess.run(["rm", "bus.asc"], check=True)

# moteus: tview's writer of logs, taken out of its program, which has a window and a bus besides.
text = open(TVIEW).read()
part = text[text.index("def flatten_dict"):text.index("class NoEditDelegate")]
from moteus.moteus import namedtuple_to_dict
own = {"json": json, "csv": csv, "io": io, "namedtuple_to_dict": namedtuple_to_dict}
exec(part, own)
Servo = namedtuple("ServoStats", ["mode", "position", "velocity", "abs_position", "motor_temp_C", "d_A"])
Stats = namedtuple("Stats", ["servo_stats_like", "sources"])
Source = namedtuple("Source", ["raw", "filtered_value"])
Motor = namedtuple("MotorPosition", ["position", "sources"])
for form, name in [("jsonl", "tview.jsonl"), ("csv", "tview.csv")]:
    manager = own["LoggingManager"]()
    manager.start_logging(name, format=form)
    for row in range(ROWS):
        at = 1764248400.25 + t[row]
        manager.log_data(1, at, "servo_stats", Servo(10, float(read[row]), 0.0, float(turn[row]), 31.5, float("nan")), None)
        if form == "jsonl" and row % 4 == 0:
            manager.log_data(1, at + 0.001, "motor_position", Motor(float(read[row]), [Source(int(sin[row]), 0.5), Source(0, 0.25)]), None)
    manager.stop_logging()

# SimpleFOC: the library's own monitor() of this motion, and of its own loop with a motor that is simulated.
rows = "".join(f"{float(place)!r} {float(shaft)!r}\n" for place, shaft in zip(turn * 2 * math.pi, read * 2 * math.pi))
for word, name in [("plain", "simplefoc.log"), ("arduino", "simplefoc-arduino.log"), ("all", "simplefoc-all.log")] + [
    (word, f"simplefoc-{word}.log") for word in ("loop", "currents", "angle", "open")
]:
    done = subprocess.run([MONITOR], input=f"{word}\n{rows}".encode(), capture_output=True, check=True)
    open(name, "wb").write(done.stdout)
