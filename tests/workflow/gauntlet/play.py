"""Play the gauntlet with further measurements: `python tests/workflow/gauntlet/play.py OUT [--only NAME ...]`.

Every folder OUT/sets/NAME is diagnosed (`judge`). While the diagnosis asks for another measurement, the independent
solver makes it (`again`) from the truth that is hidden in the set, and the diagnosis goes on from there. What is found
after N further measurements goes to OUT/results_N/NAME.json.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path


sys.path.insert(0, str(Path(__file__).parent))

from again import answer
from judge import judge
from truths import truths


def play(folder, out, *, rounds, noise, options):
    """Diagnose a set and answer what it asks for, at most `rounds` times; prints one line per diagnosis."""
    name, last = folder.name, folder
    for count in range(rounds + 1):
        line = judge(last, out, options, name=name, round_number=count)
        if line:
            print(f"{count} {line}", flush=True)
        found = json.loads((out / _results(count) / f"{name}.json").read_text(encoding="utf-8"))
        if not found.get("asked") or count == rounds:
            return
        last = out / ("next" if count == 0 else f"next_{count + 1}") / name
        hidden = name.split("__")[0]
        answer(truths()[hidden], last, noise=noise, seed=1 + count)


def _results(count):
    return "results" if count == 0 else f"results_{count}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--only", nargs="*", default=("",), help="beginnings of names, in the order to be done")
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--noise", type=float, default=0.01)
    parser.add_argument("--jobs", type=int, default=1, help="processes that simulate")
    parser.add_argument("--among", nargs="*", default=(), help="effects to choose from, all by default")
    parser.add_argument("--case", default="punch")
    parser.add_argument("--set", nargs="*", default=(), dest="changes")
    parser.add_argument("--fingerprint", help="name under which runs are cached, whatever the code")
    given = parser.parse_args()
    options = {
        "case": given.case, "changes": given.changes, "fingerprint": given.fingerprint, "among": given.among,
        "workers": given.jobs,
    }  # fmt: skip
    every = sorted((given.out / "sets").iterdir())
    for folder in dict.fromkeys(folder for start in given.only for folder in every if folder.name.startswith(start)):
        play(folder, given.out, rounds=given.rounds, noise=given.noise, options=options)


if __name__ == "__main__":
    main()
