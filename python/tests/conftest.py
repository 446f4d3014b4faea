"""What the tests share: the command beside the wheel, and a recording that is quickly diagnosed.

COURIER_COMMAND names the command; the examples are looked for from the folder that the tests are run in, the project's root.
"""

import doctest
import os
import pathlib
import subprocess

import pytest

import courier

SURVEY = "examples/survey-lateral"
LOG = "examples/encoder-log/log.csv"
LOG_COLUMNS = {"t_s": "time:ms", "q1s": "sin", "q1c": "cos"}


class Command:
    """The command, run to its end."""

    def __init__(self, path):
        self.path = path

    def __call__(self, *words, code=0):
        ran = subprocess.run([self.path, *map(str, words)], capture_output=True, text=True, encoding="utf-8")
        assert ran.returncode == code, ran.stderr
        return ran

    def says(self, *words):
        """What it prints, without the last line's end."""
        return self(*words).stdout.removesuffix("\n")

    def refuses(self, *words):
        """The one line with which it refuses."""
        (line,) = self(*words, code=2).stderr.splitlines()
        return line.removeprefix("courier: ")


@pytest.fixture(scope="session")
def command():
    return Command(os.environ["COURIER_COMMAND"])


@pytest.fixture(scope="session")
def survey():
    return courier.read(SURVEY)


def tried(path):
    """Runs the examples of a page: how many there are, how many are wrong, and what they leave behind."""
    text = pathlib.Path(path).read_text(encoding="utf-8")
    test = doctest.DocTestParser().get_doctest(text, {}, str(path), str(path), 0)
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
    failed, _ = runner.run(test, clear_globs=False)
    return len(test.examples), failed, test.globs


@pytest.fixture(scope="session")
def page():
    """The documentation's page, run once: what it leaves is used by other tests as well, since a diagnosis takes seconds."""
    return tried("docs/python.md")


@pytest.fixture(scope="session")
def diagnosis(page):
    """Of the survey, with its report."""
    return page[2]["answer"]


@pytest.fixture(scope="session")
def checked(page):
    """The survey's model on the survey."""
    return page[2]["check"]


@pytest.fixture(scope="session")
def stage(command, tmp_path_factory):
    """One encoder on a stage: a recording that is diagnosed in a fraction of a second."""
    folder = tmp_path_factory.mktemp("stage") / "stage"
    columns = {**LOG_COLUMNS, "ref_x_m": "stage:mm"}
    words = [f"--column={target}={source}" for target, source in columns.items()]
    command("convert", LOG, folder, *words, "--pitch", "1.016mm")
    return folder


@pytest.fixture
def spoilt(tmp_path):
    """Makes a copy of the survey's first rows with a change in a file of it."""

    def make(name, change):
        for source in pathlib.Path(SURVEY).iterdir():
            lines = source.read_text(encoding="utf-8").splitlines()[:200]
            lines = change(lines) if source.name == name else lines
            (tmp_path / source.name).write_text("\n".join(lines) + "\n", encoding="utf-8")
        return tmp_path

    return make
