"""The examples on Ray, on a real Ray of two workers: one is killed half way, and the answer is that of one process.

Run by `cargo xtask ray`, from the project's root. COURIER_COMMAND names the command.
"""

import importlib.util
import os
import pathlib
import signal
import subprocess
import threading
import time

import pytest
import ray

import courier

SURVEY = pathlib.Path("examples/survey-lateral")
# Samples of the recordings: the survey's beginning, from what is too short to what takes two seconds.
SAMPLES = (40, 3000, 4000, 5000, 6000, 7000, 8000, 10_016)
# How often it is looked for a worker at work: for many times as long as all recordings take.
LOOKS = 600_000


@pytest.fixture(scope="module", autouse=True)
def two_workers():
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    yield
    ray.shutdown()


def example(path):
    """A script among the examples, as a module."""
    spec = importlib.util.spec_from_file_location(pathlib.Path(path).stem + "_on_ray", pathlib.Path("examples") / path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def parent(process):
    """The parent of a process, from its line in /proc; none where it has ended."""
    try:
        return int(pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])
    except (OSError, IndexError):
        return None


def is_ours(process):
    """Whether a process was started by this one, or by one that it started."""
    while process not in (None, 0, 1, os.getpid()):
        process = parent(process)
    return process == os.getpid()


def is_at_work(process, task):
    """Whether a process is a worker at such a task just now: Ray names it by that, and its parent is Ray's own program.

    What a worker starts has its name as well, until it has become another program.
    """
    try:
        name = pathlib.Path(f"/proc/{process}/cmdline").read_bytes()
        return name.startswith(b"ray::" + task) and pathlib.Path(f"/proc/{parent(process)}/comm").read_text() == "raylet\n"
    except OSError:
        return False


class Killer:
    """Kills a worker at its work, once it is half way."""

    def __init__(self, task, is_half_way):
        self.task, self.is_half_way, self.killed = task, is_half_way, None
        self.thread = threading.Thread(target=self.work)

    def work(self):
        for _ in range(LOOKS):
            time.sleep(0.001)
            if self.is_half_way() and self.kill():
                return

    def kill(self):
        for process in (int(name) for name in os.listdir("/proc") if name.isdecimal()):
            if is_at_work(process, self.task) and is_ours(process):
                # Held, so that it is still at its work when it is killed.
                os.kill(process, signal.SIGSTOP)
                if is_at_work(process, self.task):
                    os.kill(process, signal.SIGKILL)
                    self.killed = process
                    return True
                os.kill(process, signal.SIGCONT)
        return False

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.thread.join()


@pytest.fixture
def recordings(tmp_path):
    lines = (SURVEY / "samples.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    made = []
    for samples in SAMPLES:
        folder = tmp_path / f"survey-{samples}"
        folder.mkdir()
        (folder / "samples.csv").write_text("".join(lines[: samples + 1]), encoding="utf-8")
        (folder / "recording.toml").write_bytes((SURVEY / "recording.toml").read_bytes())
        made.append(str(folder))
    return [*made, str(tmp_path / "missing")]


def rows(folder):
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.glob("courier_id=*/[!.]*")}


def test_a_table_of_diagnoses(recordings, tmp_path):
    on_ray, alone = tmp_path / "on-ray", tmp_path / "alone"
    half_way = lambda: len(rows(on_ray)) >= len(recordings) // 3
    with Killer(b"diagnose", half_way) as killer:
        table = example("diagnose-on-ray/diagnose.py").table(recordings, str(on_ray))
    assert killer.killed, "no worker was at work"
    courier.diagnose_many(recordings, alone, jobs=1)
    assert rows(on_ray) == rows(alone)
    assert len(table) == len(recordings)
    assert set(table.verdict) >= {"named", "failed"}, table.verdict


def test_a_fleet(tmp_path):
    command = os.environ["COURIER_COMMAND"]
    run = lambda *words: subprocess.run([command, *map(str, words)], check=True, capture_output=True, text=True).stdout
    recordings = [tmp_path / f"c{number}" for number in (1, 2, 3)]
    for number, recording in enumerate(recordings, 1):
        words = f"--sim-courier {number} --sim-platen 5 record RECORDING --under-beacon --platen-id west --decimation 60"
        run(*(recording if word == "RECORDING" else word for word in words.split()))
    folder = tmp_path / "parts"
    folder.mkdir()
    with Killer(b"part", lambda: (folder / "2.state").exists()) as killer:
        answer = example("fleet-on-ray/fleet.py").fit(command, folder, recordings)
    assert killer.killed, "no worker was at work"
    # To the letter: the tree adds three parts in the order of one process.
    assert answer == run("fleet", *recordings, "--json")
