"""A build with Parquet: recordings and tables in it. Run by `cargo xtask ray`, from the project's root."""

import shutil

import pyarrow.parquet

import courier

SURVEY = "examples/survey-lateral"


def test_an_arrow_table_of_a_recording_is_a_recording(tmp_path):
    assert courier._native.HAS_PARQUET
    recording = courier.read(SURVEY)
    file = tmp_path / "survey.parquet"
    pyarrow.parquet.write_table(recording.to_arrow(), file)
    again = courier.read(file)
    assert again.toml == recording.toml
    assert again.to_arrow().equals(recording.to_arrow())
    assert courier.replay(again).channels == courier.replay(recording).channels


def test_a_table_of_diagnoses(tmp_path):
    done = courier.diagnose_many([SURVEY, "no-such-folder"], tmp_path)
    assert done.verdicts == {"failed": 1, "named": 1}
    assert {file.suffix for file in tmp_path.glob("courier_id=*/*")} == {".parquet"}
    table = courier.read_table(tmp_path)
    assert table.verdict.tolist() == ["named", "failed"]
    assert table.courier_id.isna().tolist() == [False, True]
    assert table.answer[0] is not None and '"verdict":"named"' in table.answer[0]
    # The same recording under another path.
    copy = shutil.copytree(SURVEY, tmp_path / "copy")
    again = courier.diagnose_many([SURVEY, copy], tmp_path)
    assert (again.already, again.taken_over, again.verdicts) == (1, 1, {})
    table = courier.read_table(tmp_path).set_index("recording")
    one, other = table.loc[SURVEY], table.loc[str(copy)]
    assert one.drop("answer").equals(other.drop("answer"))
    assert one.answer.replace(SURVEY, str(copy)) == other.answer
