"""One function a command. Options have the command's names, ranges and defaults, and are refused in its words."""

from __future__ import annotations

import json
import os
import pathlib
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Union, overload

from . import _native
from ._answers import Applied, Check, Constants, Diagnosis, Done, Encoder, Isolability, Replay
from ._errors import InputError
from ._made import made
from ._recording import Path, Recording, read
from ._report import Model, Report

if TYPE_CHECKING:
    import pandas

# The folder of recordings that do not say which courier they are of: the name that engines read as null.
_NO_COURIER = "__HIVE_DEFAULT_PARTITION__"

Source = Union[Recording, Path]


def _recording(source: Source) -> Recording:
    return source if isinstance(source, Recording) else read(source)


def _words(**options: Any) -> List[str]:
    """Options as words of the command line; those that were not given are left to the command."""
    words: List[str] = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if value is True:
            words.append(option)
        elif isinstance(value, (list, tuple)):
            words += [f"{option}={one}" for one in value]
        elif value is not None and value is not False:
            words.append(f"{option}={value}")
    return words


def diagnose(
    recording: Source,
    *,
    without: Sequence[str] = (),
    resolution_um: Optional[float] = None,
    report: bool = False,
    explain: bool = False,
) -> Diagnosis:
    """Where recording and simulation part, which effect does it, and how far adding it closes the gap.

    ``without`` takes effects out of the catalogue. ``resolution_um`` is what the gap is held against in the report and the text.
    With ``report`` the answer has the page that ``courier diagnose --report`` writes, which a notebook shows. With ``explain`` it has the
    twenty likeliest sets of effects, and why each is not the first, as text; that takes from seconds to minutes.

    Other threads run meanwhile. Raises :class:`courier.InputError` for a bad recording or an unknown effect.
    """
    read_recording = _recording(recording)
    words = _words(without=list(without), resolution_um=resolution_um, explain=explain) + ["--", read_recording.path]
    called = f"courier.diagnose({read_recording.path!r}) in Python"
    told, (model, page, explained) = _native.diagnose(read_recording._native, words, called if report else None)
    name = f"the model of {read_recording.path}"
    return made(
        Diagnosis,
        *told,
        model=None if model is None else Model(model, name),
        report=None if page is None else Report(page),
        explained=explained,
    )


def diagnose_many(
    recordings: Sequence[Path],
    out: Path,
    *,
    without: Sequence[str] = (),
    resolution_um: Optional[float] = None,
    jobs: Optional[int] = None,
) -> Done:
    """Diagnoses recordings into the table in the folder ``out``, a row each; :func:`courier.read_table` reads it.

    A recording that cannot be read or diagnosed has a row that says why. What has a row is not done again, and several processes may
    fill one table (docs/many-recordings.md). ``jobs`` recordings are diagnosed at once, by default as many as there are processors.
    """
    folder = os.fspath(out)
    words = _words(without=list(without), resolution_um=resolution_um, jobs=jobs, out=folder)
    return made(Done, *_native.diagnose_many(folder, words + ["--", *(os.fspath(path) for path in recordings)]))


def read_table(out: Path) -> "pandas.DataFrame":
    """The table that :func:`courier.diagnose_many` or ``courier diagnose --out`` filled, by recording and content."""
    import pandas

    rows: List[Dict[str, Any]] = []
    for part in sorted(pathlib.Path(out).glob("courier_id=*/[!.]*")):
        if part.suffix == ".parquet":
            found: List[Any] = pandas.read_parquet(part, partitioning=None).to_dict("records")
        else:
            found = [json.loads(line) for line in part.read_text(encoding="utf-8").splitlines()]
        courier_id = part.parent.name.partition("=")[2]
        rows += [{"courier_id": None if courier_id == _NO_COURIER else courier_id, **row} for row in found]
    if not rows:
        raise InputError(f"{os.fspath(out)}: found no row, wanted the folder of a table of diagnoses")
    table: "pandas.DataFrame" = pandas.DataFrame(rows).sort_values(["recording", "content"], ignore_index=True)
    return table


def check(model: Union[Model, Path], recording: Source) -> Check:
    """Applies a diagnosed model to another recording of the same courier: does the gap shrink as claimed?

    ``model`` is that of a :class:`courier.Diagnosis`, or the file that ``courier diagnose --model`` wrote.
    """
    if not isinstance(model, Model):
        name = os.fspath(model)
        try:
            model = Model(pathlib.Path(name).read_text(encoding="utf-8"), name)
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"{name}: a readable model was wanted: {error}", file=name) from error
    return made(Check, *_native.check((model.name, model.text), _recording(recording)._native))


@overload
def replay(recording: Source) -> Replay: ...


@overload
def replay(recording: Source, calibration: Path) -> Applied: ...


def replay(recording: Source, calibration: Optional[Path] = None) -> Union[Replay, Applied]:
    """Calibrates on a recording by the firmware's own code and shows what remains on stretches that were not fitted.

    With ``calibration``, a file that ``courier export`` wrote, nothing is fitted: g_p with it over the whole recording.
    """
    read_recording = _recording(recording)
    words = _words(calibration=None if calibration is None else os.fspath(calibration))
    told = _native.replay(read_recording._native, words + ["--", read_recording.path])
    return made(Replay, *told) if calibration is None else made(Applied, *told)


def isolability(
    *,
    plan: Optional[str] = None,
    poses: Optional[int] = None,
    beacon: bool = False,
    turn_deg: Optional[float] = None,
    travel_pitches: Optional[float] = None,
    noise_um: Optional[float] = None,
    lateral_mm: Optional[float] = None,
    sensor_terms: bool = False,
    seed: Optional[int] = None,
) -> Isolability:
    """What a planned motion can identify and what not, before anything moves.

    ``plan`` is ``random`` or ``optimal``, ``turn_deg`` the largest angle to either side, ``travel_pitches`` the range in x and y,
    ``noise_um`` the noise of a pose's averaged readings. With ``beacon`` the courier turns about its coordination sensor under a beacon;
    ``sensor_terms`` counts that sensor's own errors among the unknowns.
    """
    words = _words(
        plan=plan,
        poses=poses,
        beacon=beacon,
        turn_deg=turn_deg,
        travel=travel_pitches,
        noise_um=noise_um,
        lateral_mm=lateral_mm,
        sensor_terms=sensor_terms,
        seed=seed,
    )
    return made(Isolability, *_native.isolability(words))


def encoder(
    log: Source,
    *,
    columns: Optional[Mapping[str, str]] = None,
    rate_hz: Optional[float] = None,
    pitch_m: Optional[float] = None,
    periods_per_turn: Optional[int] = None,
    segment: Optional[int] = None,
    dbc: Optional[Path] = None,
    rows_of: Optional[str] = None,
) -> Encoder:
    """The errors of one encoder from its own log, without a reference.

    ``log`` is a log as ``courier convert`` reads it, or a recording, which is read where it is. ``columns`` says where a column comes from, as
    ``{"t_s": "time:ms", "q1s": "sin"}``;
    ``rate_hz`` is for logs without time, ``pitch_m`` the length of a signal period, ``periods_per_turn`` that of a shaft.
    ``dbc`` names the signals of a candump log, ``rows_of`` the messages that make the rows.
    """
    words = _words(
        column=[f"{target}={source}" for target, source in (columns or {}).items()],
        rate_hz=rate_hz,
        pitch=None if pitch_m is None else f"{pitch_m!r}m",
        periods_per_turn=periods_per_turn,
        segment=segment,
        dbc=None if dbc is None else os.fspath(dbc),
        rows_of=rows_of,
    )
    path = log.path if isinstance(log, Recording) else os.fspath(log)
    text, told, constants = _native.encoder(words + ["--", path])
    return made(Encoder, text, told, constants=Constants(*constants))
