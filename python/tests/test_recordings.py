"""Recordings as NumPy, Arrow and pandas: the file's own values, in the recording's own memory."""

import csv
import gc
import math
import pathlib

import numpy
import pyarrow
import pytest

import courier
from conftest import SURVEY


@pytest.fixture(scope="module")
def rows():
    with open(pathlib.Path(SURVEY) / "samples.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def address(array):
    return array.__array_interface__["data"][0]


def test_columns_are_those_of_the_file(survey, rows):
    assert survey.columns == [column for column in rows[0] if any(row[column] for row in rows)]
    assert len(survey) == len(rows)
    for column in survey.columns:
        if column == "run":
            assert survey[column].tolist() == [row[column] for row in rows]
        else:
            numbers = [float(row[column]) if row[column] else math.nan for row in rows]
            numpy.testing.assert_array_equal(survey[column], numbers, strict=True)
    assert numpy.isnan(survey["psd_xp"]).any(), "nothing here is not measured"


def test_what_a_column_is_not(survey):
    assert "ref_x_m" not in survey and "q1s" in survey
    for name in ("ref_x_m", "nothing"):
        with pytest.raises(KeyError, match=name):
            survey[name]


def test_a_column_is_the_recordings_memory(survey):
    first, second = survey["q1s"], survey["q1s"]
    assert address(first) == address(second)
    assert first.dtype == numpy.float64 and first.flags.c_contiguous
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 0.0


def test_a_column_outlives_its_recording(stage):
    recording = courier.read(stage)
    column = recording["q1s"]
    before = column.copy()
    del recording
    gc.collect()
    # Memory that was given back would be taken for these.
    others = [courier.read(stage) for _ in range(3)]
    numpy.testing.assert_array_equal(column, before)
    assert all(address(other["q1s"]) != address(column) for other in others)


def test_runs(survey):
    names = [survey.run_names[number] for number in survey.run_numbers]
    assert survey["run"].tolist() == names
    assert survey.run_names[0] == names[0] and len(set(survey.run_names)) == len(survey.run_names)


def test_what_a_recording_says_of_itself(survey):
    assert survey.meta["geometry"]["pitch_m"] == 1.016e-3
    assert survey.meta["schema"] == 1
    assert survey.path == SURVEY
    assert survey.toml == (pathlib.Path(SURVEY) / "recording.toml").read_text(encoding="utf-8")
    assert "10016 samples" in repr(survey)


def test_arrow(survey):
    table = survey.to_arrow()
    assert table.column_names == survey.columns and table.num_rows == len(survey)
    assert table.schema.metadata[b"recording.toml"].decode() == survey.toml
    whole = table["q1s"].chunk(0)
    assert whole.null_count == 0
    assert whole.buffers()[1].address == address(survey["q1s"]), "it was copied"
    missing = numpy.isnan(survey["psd_xp"])
    assert table["psd_xp"].is_null().to_pylist() == missing.tolist()
    assert table["psd_xp"].drop_null().to_pylist() == survey["psd_xp"][~missing].tolist()
    assert pyarrow.types.is_dictionary(table["run"].type)
    assert table["run"].to_pylist() == survey["run"].tolist()


def test_pandas(survey):
    table = survey.to_pandas()
    assert list(table.columns) == survey.columns
    numpy.testing.assert_array_equal(table["n3"], survey["n3"])
    assert table["run"].dtype == "category" and table["run"].tolist() == survey["run"].tolist()
