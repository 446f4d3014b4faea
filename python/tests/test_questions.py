"""The questions of docs/many-recordings.md, asked of a table by DuckDB, against the answers that stand there."""

import pathlib
import re

import duckdb

import courier
from conftest import SURVEY

PAGE = pathlib.Path("docs/many-recordings.md")


def cell(value):
    if value is None:
        return ""
    return f"{value:.1f}" if isinstance(value, float) else str(value)


def test_the_questions_have_the_answers_of_the_page(tmp_path, monkeypatch):
    text = PAGE.read_text(encoding="utf-8")
    questions = re.findall(r"```sql\n([^`]*)```\n\n((?:\|[^\n]*\n)+)", text)
    assert len(questions) == 3
    survey = pathlib.Path(SURVEY).absolute()
    monkeypatch.chdir(tmp_path)
    courier.diagnose_many([survey, "no-such-folder"], "answers")
    for question, table in questions:
        answer = duckdb.sql(question)
        head, _, *rows = ([one.strip() for one in line.strip().strip("|").split("|")] for line in table.splitlines())
        assert head == answer.columns
        assert sorted(rows) == sorted([cell(value) for value in row] for row in answer.fetchall()), question
