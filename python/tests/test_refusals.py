"""What is refused, in the command's own line; and what is warned of."""

import pathlib

import pytest

import courier
from conftest import LOG, SURVEY


def other_cell(row, column, text):
    def change(lines):
        place = lines[0].split(",").index(column)
        cells = lines[row - 1].split(",")
        cells[place] = text
        return lines[: row - 1] + [",".join(cells)] + lines[row:]

    return change


def test_a_cell(command, spoilt):
    folder = spoilt("samples.csv", other_cell(42, "q2c", "many"))
    with pytest.raises(courier.InputError) as refused:
        courier.read(folder)
    assert str(refused.value) == command.refuses("replay", folder)
    assert pathlib.Path(refused.value.file) == folder / "samples.csv"
    assert (refused.value.column, refused.value.row) == ("q2c", 42)
    with pytest.raises(courier.InputError, match="row 42, column q2c"):
        courier.diagnose(folder)


def test_a_key(command, spoilt):
    folder = spoilt("recording.toml", lambda lines: [line for line in lines if not line.startswith("pitch_m")])
    with pytest.raises(courier.InputError) as refused:
        courier.read(folder)
    assert str(refused.value) == command.refuses("replay", folder)
    assert "pitch_m" in refused.value.column and refused.value.row is None


def test_what_is_not_there(command):
    for call, words in [
        (lambda: courier.read("no-such-folder"), ["replay", "no-such-folder"]),
        (lambda: courier.encoder("no-such.csv"), ["encoder", "no-such.csv"]),
        (lambda: courier.replay(SURVEY, "no-such.json"), ["replay", SURVEY, "--calibration", "no-such.json"]),
    ]:
        with pytest.raises(courier.InputError) as refused:
            call()
        assert str(refused.value) == command.refuses(*words)


def test_options(command):
    for call, words in [
        (lambda: courier.diagnose(SURVEY, without=["dust"]), ["diagnose", SURVEY, "--without", "dust"]),
        (lambda: courier.diagnose(SURVEY, resolution_um=0), ["diagnose", SURVEY, "--resolution-um", "0"]),
        (lambda: courier.isolability(turn_deg=9), ["isolability", "--turn-deg", "9"]),
        (lambda: courier.isolability(poses=0), ["isolability", "--poses", "0"]),
        (lambda: courier.isolability(plan="good"), ["isolability", "--plan", "good"]),
        (lambda: courier.encoder(LOG, segment=5), ["encoder", LOG, "--segment", "5"]),
        (lambda: courier.encoder(LOG, dbc="none.dbc"), ["encoder", LOG, "--dbc", "none.dbc"]),
        (lambda: courier.encoder(LOG, columns={"q1s": "none"}), ["encoder", LOG, "--column", "q1s=none"]),
    ]:
        with pytest.raises(courier.InputError) as refused:
            call()
        assert str(refused.value) == command.refuses(*words)


def test_a_path_is_no_option(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, call in [("replay", lambda: courier.replay("--beacon")), ("encoder", lambda: courier.encoder("--beacon"))]:
        with pytest.raises(courier.InputError, match="^--beacon: ") as refused:
            call()
        assert str(refused.value) == command.refuses(name, "--", "--beacon")


def test_a_model(tmp_path):
    for text, wanted in [("no model", "a model by `courier diagnose --model` was wanted"), ('{"schema": 2}', "model.json: ")]:
        path = tmp_path / "model.json"
        path.write_text(text)
        with pytest.raises(courier.InputError, match=wanted):
            courier.check(path, SURVEY)
    with pytest.raises(courier.InputError, match="none.json: a readable model was wanted"):
        courier.check(tmp_path / "none.json", SURVEY)


def test_a_table_that_is_none(tmp_path):
    with pytest.raises(courier.InputError, match="found no row"):
        courier.read_table(tmp_path)


def test_a_warning_is_of_the_callers_line(command, spoilt):
    folder = spoilt("samples.csv", lambda lines: [lines[0] + ",colour"] + [line + ",7" for line in lines[1:]])
    with pytest.warns(courier.RecordingWarning, match="colour") as warned:
        courier.read(folder)
    (warning,) = warned
    assert warning.filename == __file__
    printed = command("encoder", folder, code=2).stderr.splitlines()
    assert f"courier: warning: {warning.message}" in printed
