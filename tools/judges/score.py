#!/usr/bin/env python3
"""Diagnoses a judge's set and scores the answers.

A set is what `make.py` of a judge wrote: cases of two recordings each and truth.json. Every first recording is diagnosed with
nothing but itself, what is named is checked on the second, and only then is the truth read. What is there already is not diagnosed again."""

import argparse
import json
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

# They take another course on the second recording.
COURSES = {"quadrature_drift", "thermal_drift", "outlier_bursts", "cycle_slip", "beacon_vibration"}
# A claim is confirmed within this share of itself.
WITHIN = 0.10
NAMED = ("named", "alias")


def read(path):
    return json.loads(path.read_text())


def run(command):
    """None, or the one line that says what is wrong."""
    done = subprocess.run(command, capture_output=True, text=True)
    return None if done.returncode == 0 else f"exit {done.returncode}: {done.stderr.strip().splitlines()[-1:]}"


def tell(courier, folder, out, case):
    """Diagnoses one case and checks what it names."""
    answer, model, check = (out / f"{case}.{part}.json" for part in ("answer", "model", "check"))
    if not answer.exists():
        wrong = run([courier, "diagnose", folder / case / "first", "--json", answer, "--model", model])
        if wrong:
            return f"{case}: diagnose: {wrong}"
    if read(answer)["verdict"] in NAMED and not check.exists():
        wrong = run([courier, "check", model, folder / case / "second", "--json", check])
        if wrong:
            return f"{case}: check: {wrong}"
    return None


class Score:
    """Counts of what was right, of how many."""

    def __init__(self):
        self.counts = {}

    def add(self, name, right):
        count, of = self.counts.get(name, (0, 0))
        self.counts[name] = (count + bool(right), of + 1)

    def case(self, truth, answer, check):
        """Scores one case and returns its line."""
        verdict, kind, true = answer["verdict"], truth["kind"], truth["effects"]
        names = [effect["name"] for effect in answer["effects"]]
        named = verdict in NAMED
        places = [place["coordinate"] for place in answer["where"]]
        right = {
            "one": named and names[:1] == true,
            "two": named and sorted(names) == sorted(true),
            "none": not named,
            "unlisted": verdict == "unknown" and any(re.search(p, places[0], re.I) for p in truth["places"] if places),
        }[kind]
        self.add({"none": "none: no alarm"}.get(kind, kind), right)
        # Of an alias set the likeliest is what is answered.
        told = names[:1] if verdict == "alias" else names
        self.add("a wrong name", named and not set(told) <= set(true))
        after = answer["held_out"]["whitened_after"]
        line = f"{truth['case']} {kind:8} {truth['form']:9} {'ok  ' if right else 'MISS'} {verdict} {names}, true {true or truth['unlisted']}; {after:.2f} claimed"
        if check:
            came = check["held_out"]["whitened_after"]
            holds = abs(came / after - 1) <= WITHIN
            line += f", {came:.2f} came" + ("" if holds else " CLAIM")
            if right:
                self.add("a claim within 10 %", holds)
                if not set(true) & COURSES:
                    self.add("the same, courses in time aside", holds)
        return line + ("" if named else f"; {places[:3]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("courier", type=Path, help="the built command, target/release/courier")
    parser.add_argument("set", type=Path, help="folder that make.py wrote")
    parser.add_argument("out", type=Path, help="folder for answers, models and checks")
    arguments = parser.parse_args()
    for needed in (arguments.courier, arguments.set / "truth.json"):
        if not needed.is_file():
            parser.error(f"{needed}: not found, wanted the built command and a set of make.py's")
    arguments.out.mkdir(parents=True, exist_ok=True)
    cases = sorted(folder.name for folder in arguments.set.iterdir() if folder.is_dir())
    with ThreadPoolExecutor(2) as pool:
        for wrong in pool.map(lambda case: tell(arguments.courier, arguments.set, arguments.out, case), cases):
            if wrong:
                print(wrong, file=sys.stderr)
    score = Score()
    for truth in read(arguments.set / "truth.json"):
        answer, check = (arguments.out / f"{truth['case']}.{part}.json" for part in ("answer", "check"))
        if answer.exists():
            print(score.case(truth, read(answer), read(check) if check.exists() else None))
    for name, (count, of) in score.counts.items():
        print(f"{name}: {count} of {of}")


if __name__ == "__main__":
    main()
