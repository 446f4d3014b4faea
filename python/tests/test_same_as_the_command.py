"""Every function answers as the command does, to the letter: JSON, text, model and page."""

import courier
from conftest import LOG, LOG_COLUMNS, SURVEY


def same(answer, command, *words):
    assert answer.to_json() == command.says(*words, "--json")
    assert str(answer) == command.says(*words)


def test_a_diagnosis(command, diagnosis, tmp_path):
    json, page = tmp_path / "answer.json", tmp_path / "page.html"
    text = command.says("diagnose", SURVEY, f"--json={json}", "--report", page)
    assert str(diagnosis) == text
    assert diagnosis.to_json() + "\n" == json.read_text(encoding="utf-8")
    # The page but for when it was made and by which words.
    apart = lambda text: text.partition("<dt>made</dt>")[0]
    assert "<svg" in apart(diagnosis.report.html)
    assert apart(diagnosis.report.html) == apart(page.read_text(encoding="utf-8"))
    assert f"courier.diagnose(&#39;{SURVEY}&#39;)" in diagnosis.report.html.replace("'", "&#39;")


def test_options_of_a_diagnosis(command, stage):
    answer = courier.diagnose(stage, without=["velocity_lag", "hysteresis"], resolution_um=0.01)
    same(answer, command, "diagnose", stage, "--without", "velocity_lag", "--without", "hysteresis", "--resolution-um", "0.01")


def test_the_likeliest_sets_of_effects(command, stage):
    answer = courier.diagnose(stage, explain=True)
    assert str(answer) == command.says("diagnose", stage, "--explain")
    assert str(answer) == f"{courier.diagnose(stage)}\n\n{answer.explained}"
    assert courier.diagnose(stage).explained is None


def test_a_model_and_its_check(command, stage, tmp_path):
    answer = courier.diagnose(stage)
    own, theirs = tmp_path / "own.json", tmp_path / "theirs.json"
    answer.model.save(own)
    command("diagnose", stage, "--model", theirs)
    assert own.read_bytes() == theirs.read_bytes()
    same(courier.check(own, stage), command, "check", own, stage)
    of_memory = courier.check(answer.model, courier.read(stage))
    assert of_memory.held_out == courier.check(own, stage).held_out
    assert of_memory.model == f"the model of {stage}"


def test_a_replay(command, stage):
    same(courier.replay(stage), command, "replay", stage)
    same(courier.replay(SURVEY), command, "replay", SURVEY)


def test_a_replay_of_a_calibration(command, tmp_path):
    file = tmp_path / "calibration.json"
    command("encoder", SURVEY, "--segment", "2", "--out", file)
    same(courier.replay(SURVEY, file), command, "replay", SURVEY, "--calibration", file)


def test_isolability(command):
    same(courier.isolability(), command, "isolability")
    answer = courier.isolability(
        plan="optimal",
        poses=60,
        beacon=True,
        turn_deg=1.25,
        travel_pitches=2.5,
        noise_um=0.7,
        lateral_mm=-3,
        sensor_terms=True,
        seed=7,
    )
    words = "--plan optimal --poses 60 --beacon --turn-deg 1.25 --travel 2.5 --noise-um 0.7 --lateral-mm=-3 --sensor-terms --seed 7"
    same(answer, command, "isolability", *words.split())


def test_an_encoder(command, stage):
    words = ["encoder", LOG, *(f"--column={target}={source}" for target, source in LOG_COLUMNS.items()), "--pitch", "1.016mm"]
    answer = courier.encoder(LOG, columns=LOG_COLUMNS, pitch_m=1.016e-3)
    same(answer, command, *words)
    for form in ("c", "moteus", "simplefoc"):
        assert getattr(answer.constants, form).rstrip() == command.says(*words, "--form", form).rstrip()
    same(courier.encoder(stage, periods_per_turn=25, segment=1), command, "encoder", stage, "--periods-per-turn", "25")
    same(courier.encoder(courier.read(stage), periods_per_turn=25), command, "encoder", stage, "--periods-per-turn", "25")


def test_many(command, stage, tmp_path):
    recordings = [stage, "no-such-folder", "elsewhere"]
    own, theirs = tmp_path / "own", tmp_path / "theirs"
    done = courier.diagnose_many(recordings[:2], own, jobs=2)
    assert (done.recordings, done.already, done.verdicts) == (2, 0, {"failed": 1, "named": 1})
    done = courier.diagnose_many(recordings, own)
    assert (done.already, done.verdicts) == (2, {"failed": 1})
    printed = command.says("diagnose", *recordings, "--out", theirs)
    assert printed.startswith("3 recordings: 2 failed, 1 named")
    files = lambda folder: {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*.jsonl")}
    assert files(own) == files(theirs) and len(files(own)) == 3
    table = courier.read_table(own)
    assert sorted(table.recording) == sorted(map(str, recordings))
    assert table[table.recording == str(stage)].effects.item() == "velocity_lag"
    assert table[table.verdict == "failed"].error.str.contains("found no such file").all()
