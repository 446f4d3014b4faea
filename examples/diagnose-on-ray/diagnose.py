"""Diagnoses many recordings on Ray: a task a recording, which writes a row of the table.

    python diagnose.py OUT RECORDING RECORDING ...

OUT is the table's folder, which all workers see. A worker that is lost takes its one recording with it, and Ray tries that again; a run
that was ended goes on where it was, since what has a row is not diagnosed again. Prints how many recordings have which verdict.
"""

import pathlib
import sys

import courier
import ray


@ray.remote(max_retries=3)
def diagnose(recording, out):
    return courier.diagnose_many([recording], out, jobs=1).verdicts


def table(recordings, out):
    """Fills the table and reads it. What cannot be read or diagnosed is a row that says why."""
    ray.get([diagnose.remote(recording, out) for recording in recordings])
    return courier.read_table(out)


def main():
    out, *recordings = (str(pathlib.Path(word).resolve()) for word in sys.argv[1:])
    ray.init(log_to_driver=False)
    print(table(recordings, out).verdict.value_counts().to_string())


if __name__ == "__main__":
    main()
