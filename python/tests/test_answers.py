"""Answers as dataclasses: all of the JSON, tables, pickles, a notebook."""

import dataclasses
import html
import json
import pickle
import subprocess
import sys
import typing

import pytest

import courier
from conftest import LOG, LOG_COLUMNS, SURVEY


@pytest.fixture(scope="module")
def answers(diagnosis, checked, stage, command, tmp_path_factory):
    file = tmp_path_factory.mktemp("answers") / "calibration.json"
    command("encoder", SURVEY, "--out", file)
    return [
        diagnosis,
        checked,
        courier.replay(stage),
        courier.replay(SURVEY, file),
        courier.isolability(),
        courier.isolability(beacon=True, turn_deg=0.0),
        courier.encoder(LOG, columns=LOG_COLUMNS, pitch_m=1.016e-3, periods_per_turn=4),
        courier.diagnose_many(["no-such-folder"], file.parent / "table"),
    ]


def unlike(answer, value, place=""):
    """Where a dataclass and the JSON that it was made of are unlike."""
    if dataclasses.is_dataclass(answer):
        fields = {field.metadata.get("key", field.name): field for field in dataclasses.fields(answer)}
        known = {key for key, field in fields.items() if not field.metadata.get("beside")}
        if not set(value) <= known:
            return [f"{place}: no field for {set(value) - known}"]
        absent = known - set(value)
        told = [f"{place}.{key}: not in the JSON" for key in absent if fields[key].default is dataclasses.MISSING]
        return told + [line for key in value for line in unlike(getattr(answer, fields[key].name), value[key], f"{place}.{key}")]
    if isinstance(answer, tuple):
        if len(answer) != len(value):
            return [f"{place}: of another length"]
        return [line for k, (one, part) in enumerate(zip(answer, value)) for line in unlike(one, part, f"{place}[{k}]")]
    return [] if answer == value else [f"{place}: {answer} for {value}"]


def test_they_hold_all_of_the_json(answers):
    for answer in answers:
        assert unlike(answer, json.loads(answer.to_json())) == [], type(answer).__name__


def test_what_is_told_apart_is_found():
    finding = courier.Finding("pitch", (1,), "a sentence")
    assert unlike(finding, {"kind": "pitch", "segments": [1], "sentence": "a sentence"}) == []
    assert unlike(finding, {"kind": "span", "segments": [1, 2], "colour": 1}) != []
    assert len(unlike(finding, {"kind": "span", "segments": [1, 2]})) == 3


def test_values_have_the_types_that_are_annotated(answers):
    def check(hint, value, place):
        arguments = typing.get_args(hint)
        if typing.get_origin(hint) is typing.Union:
            assert value is None or check(arguments[0], value, place), place
        elif typing.get_origin(hint) is tuple:
            each = arguments[:1] * len(value) if arguments[-1] is Ellipsis else arguments
            assert isinstance(value, tuple) and len(each) == len(value), place
            assert all(check(one, part, place) for one, part in zip(each, value))
        elif dataclasses.is_dataclass(hint):
            assert isinstance(value, hint), place
            for name, of_field in typing.get_type_hints(hint).items():
                if not name.startswith("_"):
                    assert check(of_field, getattr(value, name), f"{place}.{name}")
        else:
            assert isinstance(value, typing.get_origin(hint) or hint), f"{place}: {value!r} for {hint}"
        return True

    for answer in answers:
        check(type(answer), answer, type(answer).__name__)


def test_they_survive_a_pickle(answers):
    for answer in answers:
        again = pickle.loads(pickle.dumps(answer))
        assert again == answer
        assert (again.to_json(), str(again)) == (answer.to_json(), str(answer))
    assert pickle.loads(pickle.dumps(answers[0])).model == answers[0].model


def test_recordings_and_refusals_survive_a_pickle(survey):
    again = pickle.loads(pickle.dumps(survey))
    assert again.to_arrow().equals(survey.to_arrow())
    refused = courier.InputError("a.csv: found b, wanted c", file="a.csv", row=3)
    again = pickle.loads(pickle.dumps(refused))
    assert (str(again), again.file, again.column, again.row) == (str(refused), "a.csv", None, 3)


def test_tables(answers):
    for answer in answers:
        assert len(answer.to_pandas()) >= 1, type(answer).__name__
    diagnosis = answers[0]
    table = diagnosis.to_pandas()
    assert table.channel.tolist() == ["g_p", "g_x", "g_y"]
    assert table.after_rms_m.tolist() == [channel.after_rms_m for channel in diagnosis.held_out.channels]
    low, high = diagnosis.gap[0].excess_ci95_m
    assert (table.excess_ci95_m_low[0], table.excess_ci95_m_high[0]) == (low, high)
    assert courier.table(diagnosis.effects).name.tolist() == ["lateral_dependence"]


def test_a_notebook_shows_the_report(diagnosis, stage, tmp_path):
    shown = diagnosis._repr_html_()
    page = html.unescape(shown.partition('srcdoc="')[2].rpartition('"')[0])
    assert page == diagnosis.report.html and page.startswith("<!DOCTYPE html>")
    assert shown.count("<iframe") == 1 and '"' not in shown.partition('srcdoc="')[2].rpartition('"')[0]
    diagnosis.report.save(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == page
    without = courier.diagnose(stage)
    assert without.report is None and without._repr_html_() is None


def test_tables_are_imported_when_they_are_asked_for():
    program = "import sys, courier; print([name for name in ('pandas', 'pyarrow') if name in sys.modules])"
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ran.stdout == "[]\n"
