"""What the commands answer: names, units and words are those of their JSON.

Lengths are in metres, angles in radians and times in seconds, unless a name says otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, Optional, Sequence, Tuple

from ._made import BESIDE, Answer, cells_of
from ._report import Model, Report


@dataclass(frozen=True)
class Finding:
    """A wire, unit or stated value that cannot be right."""

    kind: str
    segments: Tuple[int, ...]
    sentence: str
    stated: Optional[float] = None
    found: Optional[float] = None
    unit: str = ""
    alternatives: Tuple[Tuple["Finding", ...], ...] = field(default=(), metadata={"key": "or"})


@dataclass(frozen=True)
class Fitted:
    """A stated length beside the same by the data, and how far off that may be."""

    name: str
    stated_m: float
    found_m: float
    error_m: float


@dataclass(frozen=True)
class WithoutSignal:
    """Where a segment (1 to 4) gave no signal."""

    segment: int
    samples: int
    place_m: Tuple[float, float]


@dataclass(frozen=True)
class Gap:
    """A channel's residual in the recording and in the simulation, rms; the excess is negative where the recording is the quieter one."""

    channel: str
    samples: int
    real_rms_m: float
    simulated_rms_m: float
    excess_rms_m: float
    excess_ci95_m: Tuple[float, float]


@dataclass(frozen=True)
class Share:
    """Share of the squared excess over one coordinate."""

    channel: str
    coordinate: str
    share: float


@dataclass(frozen=True)
class Magnitude:
    """An amount in its unit, with its standard deviation where that is told."""

    name: str
    value: float
    unit: str
    deviation: Optional[float] = None


@dataclass(frozen=True)
class Effect:
    """A named effect."""

    name: str
    probability: float
    aliases: Tuple[str, ...]
    break_alias: Optional[str]
    magnitude: Tuple[Magnitude, ...]
    share: float
    gap_after_alone_m: float
    total_rms_m: Optional[float] = None
    total_deviation_m: Optional[float] = None


@dataclass(frozen=True)
class HeldOutChannel:
    """A channel's residual on readings that were not fitted."""

    channel: str
    before_rms_m: float
    after_rms_m: float
    after_ci95_m: Tuple[float, float]
    floor_rms_m: float


@dataclass(frozen=True)
class HeldOut:
    """The residual over the simulator's own scatter (1.0 is the floor), and by channel."""

    whitened_before: float
    whitened_after: float
    channels: Tuple[HeldOutChannel, ...]


@dataclass(frozen=True)
class Follows:
    """How what is left follows a logged column: the error's change for one unit of it, rms."""

    column: str
    of: str
    over_teeth: bool
    per_unit_m: float
    deviation_m: float


@dataclass(frozen=True)
class Correction:
    """What shapes without a name over some coordinates leave of a gap that no effect explains."""

    coordinates: Tuple[str, ...]
    whitened_after: float
    channels: Tuple[HeldOutChannel, ...]


@dataclass(frozen=True)
class Unexplained:
    """What nothing named explains."""

    share: float
    where: Tuple[Share, ...]
    follows: Tuple[Follows, ...] = ()
    correction: Optional[Correction] = None


@dataclass(frozen=True)
class Diagnosis(Answer):
    """The answer of :func:`courier.diagnose`. A notebook shows its report where one was asked for.

    ``verdict`` is ``no_gap``, ``named``, ``alias``, ``unknown`` or ``insufficient_data``.
    """

    schema: int
    recording: str
    verdict: str
    gap: Tuple[Gap, ...]
    where: Tuple[Share, ...]
    effects: Tuple[Effect, ...]
    held_out: HeldOut
    unexplained: Unexplained
    notes: Tuple[str, ...] = ()
    findings: Tuple[Finding, ...] = ()
    geometry: Tuple[Fitted, ...] = ()
    without_signal: Tuple[WithoutSignal, ...] = ()
    model: Optional[Model] = field(default=None, compare=False, metadata=BESIDE)
    report: Optional[Report] = field(default=None, repr=False, compare=False, metadata=BESIDE)
    explained: Optional[str] = field(default=None, repr=False, compare=False, metadata=BESIDE)

    def _rows(self) -> Sequence[Any]:
        """A row a channel: the gap, and what is left of it."""
        held = {one.channel: cells_of(one) for one in self.held_out.channels}
        return [{**cells_of(gap), **held.get(gap.channel, {})} for gap in self.gap]

    def _repr_html_(self) -> Optional[str]:
        return None if self.report is None else self.report._repr_html_()


@dataclass(frozen=True)
class ConfirmedChannel:
    """What was claimed of a channel beside what came."""

    channel: str
    claimed_rms_m: float
    came_rms_m: float
    probability: float
    probability_at_best: float
    confirmed: bool


@dataclass(frozen=True)
class Confirmation:
    """Whether what came is what the model claims."""

    confirmed: bool
    probability: float
    within: float
    channels: Tuple[ConfirmedChannel, ...]


@dataclass(frozen=True)
class Check(Answer):
    """The answer of :func:`courier.check`."""

    schema: int
    recording: str
    model: str
    held_out: HeldOut
    confirmation: Confirmation
    notes: Tuple[str, ...] = ()

    _main = "held_out.channels"


@dataclass(frozen=True)
class ReplayHeldOut:
    """Residual of held-out samples over all channels, rms."""

    raw_rms_m: float
    calibrated_rms_m: float
    batch_f64_rms_m: float


@dataclass(frozen=True)
class ReplayChannel:
    """A channel's figures; ``coefficients_m`` are the offset, then eight coefficients of each segment."""

    channel: str
    fitted: int
    held_out: int
    raw_rms_m: float
    calibrated_rms_m: float
    batch_f64_rms_m: float
    unknowns: int
    condition_number: float
    coefficients_m: Tuple[float, ...]
    reference_phase_rms_m: Optional[float] = None


@dataclass(frozen=True)
class ReplayPosition:
    """Position against the reference, rms about the mean."""

    axis: str
    samples: int
    raw_rms_m: float
    calibrated_rms_m: float


@dataclass(frozen=True)
class ReplayRemark:
    """What looks wrong about a channel's figures."""

    channel: str
    of_the_pitch: bool
    text: str


@dataclass(frozen=True)
class Replay(Answer):
    """The answer of :func:`courier.replay`."""

    recording: str
    held_out: ReplayHeldOut
    channels: Tuple[ReplayChannel, ...]
    position: Tuple[ReplayPosition, ...] = ()
    remarks: Tuple[ReplayRemark, ...] = ()
    findings: Tuple[Finding, ...] = ()

    _main = "channels"


@dataclass(frozen=True)
class AppliedParity:
    """g_p with a board's calibration, rms about the mean."""

    samples: int
    raw_rms_m: float
    calibrated_rms_m: float


@dataclass(frozen=True)
class Applied(Answer):
    """The answer of :func:`courier.replay` with a calibration: nothing was fitted."""

    recording: str
    calibration: str
    g_p: AppliedParity
    remarks: Tuple[ReplayRemark, ...] = ()
    findings: Tuple[Finding, ...] = ()

    def _rows(self) -> Sequence[Any]:
        return [self.g_p]


@dataclass(frozen=True)
class Motion:
    """A planned motion."""

    poses: int
    travel_m: float
    turn_rad: float
    beacon: bool
    chosen: bool
    seed: int


@dataclass(frozen=True)
class Parameter:
    """An unknown and how well it will be known, in its unit; no deviation where the poses do not determine it."""

    name: str
    unit: str
    deviation: Optional[float]
    deviation_with_prior: float
    prior: float
    rests_on: str


@dataclass(frozen=True)
class Angle:
    """How far two groups of unknowns are apart: 90 degrees is independent, 0 is the same."""

    group: str
    other: str
    angle_deg: float


@dataclass(frozen=True)
class Remedy:
    """What another motion would do for a group."""

    group: str
    change: str
    angle_deg: float
    angle_after_deg: float
    deviation: Optional[float]
    deviation_after: Optional[float]


@dataclass(frozen=True)
class Needed:
    """How many poses the coefficients need."""

    coefficients_m: float
    reference_m: float
    poses: Optional[int]
    least_of_any_motion: int


@dataclass(frozen=True)
class Isolability(Answer):
    """The answer of :func:`courier.isolability`."""

    motion: Motion
    condition_number: Optional[float]
    undetermined_directions: int
    gauge: Tuple[str, ...]
    parameters: Tuple[Parameter, ...]
    angles: Tuple[Angle, ...]
    remedies: Tuple[Remedy, ...]
    needed: Optional[Needed]

    _main = "parameters"


@dataclass(frozen=True)
class Channels:
    """Offset, gain and angle of an encoder's two channels, by the radius."""

    amplitude_counts: float
    offset_counts: Tuple[float, float]
    offset_deviation_counts: Tuple[float, float]
    gain: float
    gain_deviation: float
    angle_rad: float
    angle_deviation_rad: float
    radius_orders: Tuple[Tuple[float, float], Tuple[float, float]]


@dataclass(frozen=True)
class Harmonic:
    """An order n of the angle's error: ``sine_m sin(n phi) + cosine_m cos(n phi)`` is added to the position."""

    order: int
    sine_m: float
    cosine_m: float
    deviation_m: float
    applied: bool
    ripple_m: Optional[float]
    reversing_m: Optional[float]


@dataclass(frozen=True)
class Index:
    """Where turns begin, by the index: whole periods of the recording's count, how far behind it the index is, and how well that is known."""

    zero_periods: int
    after_periods: float
    spread_periods: float
    passes: int


@dataclass(frozen=True)
class Turn:
    """Orders of the whole turn, each a sine and a cosine in periods of the signal."""

    periods: int
    orders: Tuple[Tuple[float, float], ...]
    before_turns: float
    after_turns: float
    stretches: int
    index: Optional[Index]


@dataclass(frozen=True)
class LogUnit:
    """How counts came from the log's values: of sine and cosine the value that is zero, and counts a unit."""

    centre: Tuple[float, float]
    scale: float


@dataclass(frozen=True)
class EncoderRemark:
    """What cannot be told, and the motion or option that would tell it."""

    what: str
    tell: str


@dataclass(frozen=True)
class Constants:
    """The same for other programs: a function in C, commands for moteus, a table for SimpleFOC."""

    c: str = field(repr=False)
    moteus: str = field(repr=False)
    simplefoc: str = field(repr=False)


@dataclass(frozen=True)
class Encoder(Answer):
    """The answer of :func:`courier.encoder`."""

    log: str
    samples: int
    pitch_m: float
    unit: LogUnit
    stretches: int
    stretch_periods: float
    speeds_hz: Tuple[float, float]
    ripple_speed_hz: float
    noise_m: float
    channels: Optional[Channels]
    offsets: Optional[Tuple[float, float]]
    harmonics: Tuple[Harmonic, ...]
    turn: Optional[Turn]
    remarks: Tuple[EncoderRemark, ...]
    constants: Optional[Constants] = field(default=None, compare=False, metadata=BESIDE)

    _main = "harmonics"


@dataclass(frozen=True)
class Done(Answer):
    """What :func:`courier.diagnose_many` did: how many rows were there, how many were taken over from another path of the same recording, and
    how many were written by verdict."""

    recordings: int
    already: int
    taken_over: int
    verdicts: Dict[str, int]
    not_reached: int

    def _rows(self) -> Sequence[Any]:
        return [{"verdict": verdict, "recordings": count} for verdict, count in self.verdicts.items()]
