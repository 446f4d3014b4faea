"""What a diagnosis costs from Python beside the command: processor time, in turns in one run. Run by `cargo xtask ray`, from the project's root.

COURIER_COMMAND names the command, which is built in the wheel's profile.
"""

import os
import pathlib
import resource
import subprocess

import courier

SURVEY = pathlib.Path("examples/survey-lateral")
# Samples of it: two seconds of work, so that some turns find the machine quiet.
SAMPLES = 2000
# What a call from Python may cost more than the command (docs/python.md).
MOST = 1.05
# Turns of both. The least of them is what the work takes: other programs on the machine only add to it.
TURNS = 12


def seconds_of(who, work):
    """Processor time that some work takes: of this process and its threads, or of the programs that it runs."""

    def used():
        usage = resource.getrusage(who)
        return usage.ru_utime + usage.ru_stime

    before = used()
    work()
    return used() - before


def test_a_diagnosis_takes_the_commands_time(tmp_path, capsys, monkeypatch):
    # Threads that wait for each other take what the machine has left.
    monkeypatch.setenv("RAYON_NUM_THREADS", "1")
    lines = (SURVEY / "samples.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    (tmp_path / "samples.csv").write_text("".join(lines[: SAMPLES + 1]), encoding="utf-8")
    (tmp_path / "recording.toml").write_bytes((SURVEY / "recording.toml").read_bytes())
    command = [os.environ["COURIER_COMMAND"], "diagnose", str(tmp_path)]
    by_command = lambda: subprocess.run(command, check=True, capture_output=True)
    turns = [
        (
            seconds_of(resource.RUSAGE_SELF, lambda: courier.diagnose(tmp_path)),
            seconds_of(resource.RUSAGE_CHILDREN, by_command),
        )
        for _ in range(TURNS)
    ]
    python_s, command_s = (min(seconds) for seconds in zip(*turns))
    with capsys.disabled():
        print(f"\ncourier.diagnose: {python_s:.3f} s of processor time, the command: {command_s:.3f} s")
    assert python_s <= MOST * command_s, turns
