"""Make data sets of the gauntlet: `python tests/workflow/gauntlet/generate.py OUT [--only NAME ...] [--noise 0.01]`.

Clean truths are kept in OUT/truths and simulated once; measured folders go to OUT/sets/NAME__NOISE__SEED, what is
hidden in them to OUT/answers. With `--bare` the same fabric is simulated with nothing hidden as well
(NAME.bare.npz), from which the score sees where the gap truly is.
"""

from __future__ import annotations

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np


sys.path.insert(0, str(Path(__file__).parent))

from measure import Clean, clean, write
from mechanisms import simulate
from truths import truths


def simulated(name, truth, folder):
    """Return the clean truth, from disk when it is there."""
    path = folder / f"{name}.npz"
    if not path.exists():
        found = clean(simulate(truth), truth.laws)
        folder.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(
            path,
            **{
                key: np.asarray(value, dtype=np.float32 if key != "laws" else float)
                for key, value in vars(found).items()
            },
        )
    with np.load(path) as data:
        return Clean(**{key: data[key].astype(float) for key in data.files})


def make(name, truth, out, noise_levels, seeds, *, bare=False):
    """Simulate one truth, write its measured folders and their answers; returns what is in them."""
    try:
        found = simulated(name, truth, out / "truths")
        if bare and (truth.effects or truth.cause):
            simulated(f"{name}.bare", replace(truth, effects={}, cause=""), out / "truths")
    except RuntimeError as error:
        return [{"set": name, "error": str(error)}]
    rows = []
    for noise in noise_levels:
        for seed in range(seeds(name)):
            label = f"{name}__{100 * noise:g}__{seed}"
            number = sum(ord(letter) * 31**i for i, letter in enumerate(label)) % 2**31
            write(out / "sets" / label, found, noise=noise, seed=number)
            row = {"set": label, "effects": truth.effects, "cause": truth.cause, "noise": noise}
            row |= {"form": truth.form, "cells": truth.cells, "seed": number, "draw": seed}
            answer = out / "answers" / f"{label}.json"
            answer.parent.mkdir(parents=True, exist_ok=True)
            answer.write_text(json.dumps(row), encoding="utf-8")
            rows.append(row)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--only", nargs="*", default=())
    parser.add_argument("--noise", nargs="*", type=float, default=(0.005, 0.01, 0.02, 0.05))
    parser.add_argument("--nulls", type=int, default=5, help="noise draws of each null truth")
    parser.add_argument("--bare", action="store_true", help="simulate the fabrics with nothing hidden as well")
    parser.add_argument("--form", default="other", choices=("other", "same"))
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    chosen = {
        k: v for k, v in truths(options.form).items() if not options.only or any(k.startswith(o) for o in options.only)
    }
    with ProcessPoolExecutor(options.jobs) as pool:
        futures = {name: pool.submit(_make, name, options) for name in chosen}
        for name, future in futures.items():
            found = future.result()
            print(name, found[0].get("error", ""), flush=True)


def _make(name, options):
    return make(
        name,
        truths(options.form)[name],
        options.out,
        options.noise,
        lambda key: options.nulls if key.startswith("null") else 1,
        bare=options.bare,
    )


if __name__ == "__main__":
    main()
