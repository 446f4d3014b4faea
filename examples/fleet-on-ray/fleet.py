"""Fits a fleet of couriers on Ray: parts are formed where workers are free, and added as a tree.

    python fleet.py COURIER OUT RECORDING RECORDING ...

COURIER is the command, OUT a folder for parts and states that all workers see. Each part is one call of the command, so a worker that is
lost is tried again by Ray. Prints the answer as JSON.
"""

import json
import pathlib
import subprocess
import sys

import ray

MOST_STEPS = 240


def courier(command, *words):
    """Runs the command; its one line of refusal is the error."""
    ran = subprocess.run([command, "fleet", *map(str, words)], capture_output=True, text=True)
    if ran.returncode != 0:
        raise RuntimeError(ran.stderr.strip() or f"courier fleet ended with {ran.returncode}")
    return ran.stdout


@ray.remote(max_retries=3)
def part(command, recording, out, state):
    at = ["--at", state] if state else []
    courier(command, recording, "--part", out, *at)
    return out


@ray.remote(max_retries=3)
def join(command, out, *parts):
    courier(command, *parts, "--join", out)
    return out


def tree(command, folder, parts):
    """Adds parts two by two; the engine chooses where."""
    level = 0
    while len(parts) > 1:
        pairs = [parts[i : i + 2] for i in range(0, len(parts), 2)]
        parts = [
            join.remote(command, folder / f"{level}-{i}.sum", *pair) if len(pair) > 1 else pair[0]
            for i, pair in enumerate(pairs)
        ]
        level += 1
    return ray.get(parts[0])


def fit(command, folder, recordings):
    state = None
    for step in range(MOST_STEPS):
        formed = [
            part.remote(command, recording, folder / f"{i}.part", state)
            for i, recording in enumerate(recordings)
        ]
        whole = tree(command, folder, formed)
        following = folder / f"{step}.state"
        at = ["--at", state] if state else []
        progress = json.loads(courier(command, whole, "--step", following, *at, "--json"))
        if progress["is_settled"]:
            break
        state = following
    else:
        raise RuntimeError(f"not settled after {MOST_STEPS} steps")
    return courier(command, *recordings, "--at", state, "--json")


def main():
    command, folder, *recordings = sys.argv[1:]
    folder = pathlib.Path(folder).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    recordings = [pathlib.Path(recording).resolve() for recording in recordings]
    ray.init(log_to_driver=False)
    print(fit(command, folder, recordings))


if __name__ == "__main__":
    main()
