"""Recordings of the courier's position sensor, and what the `courier` command says of them.

>>> import courier
>>> replay = courier.replay("examples/survey-lateral")
>>> f"{1e6 * replay.held_out.raw_rms_m:.1f} µm before calibration, {1e6 * replay.held_out.calibrated_rms_m:.1f} after"
'14.6 µm before calibration, 0.8 after'

Every function answers as the command of its name does: same figures, same words. docs/python.md has examples.
"""

from . import _native
from ._answers import (
    Angle,
    Applied,
    AppliedParity,
    Channels,
    Check,
    Confirmation,
    ConfirmedChannel,
    Constants,
    Correction,
    Diagnosis,
    Done,
    Effect,
    Encoder,
    EncoderRemark,
    Finding,
    Fitted,
    Follows,
    Gap,
    Harmonic,
    HeldOut,
    HeldOutChannel,
    Index,
    Isolability,
    LogUnit,
    Magnitude,
    Motion,
    Needed,
    Parameter,
    Remedy,
    Replay,
    ReplayChannel,
    ReplayHeldOut,
    ReplayPosition,
    ReplayRemark,
    Share,
    Turn,
    Unexplained,
    WithoutSignal,
)
from ._commands import check, diagnose, diagnose_many, encoder, isolability, read_table, replay
from ._errors import InputError, ProgramError, RecordingWarning
from ._made import Answer, table
from ._recording import Recording, read
from ._report import Model, Report

__version__: str = _native.VERSION

__all__ = [
    "Angle",
    "Answer",
    "Applied",
    "AppliedParity",
    "Channels",
    "Check",
    "Confirmation",
    "ConfirmedChannel",
    "Constants",
    "Correction",
    "Diagnosis",
    "Done",
    "Effect",
    "Encoder",
    "EncoderRemark",
    "Finding",
    "Fitted",
    "Follows",
    "Gap",
    "Harmonic",
    "HeldOut",
    "HeldOutChannel",
    "Index",
    "InputError",
    "Isolability",
    "LogUnit",
    "Magnitude",
    "Model",
    "Motion",
    "Needed",
    "Parameter",
    "ProgramError",
    "Recording",
    "RecordingWarning",
    "Remedy",
    "Replay",
    "ReplayChannel",
    "ReplayHeldOut",
    "ReplayPosition",
    "ReplayRemark",
    "Report",
    "Share",
    "Turn",
    "Unexplained",
    "WithoutSignal",
    "check",
    "diagnose",
    "diagnose_many",
    "encoder",
    "isolability",
    "read",
    "read_table",
    "replay",
    "table",
]
