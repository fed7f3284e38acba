"""Names of the sets in the order in which they are judged: `python tests/workflow/gauntlet/series.py [--step 8]`.

The list is that of `truths` with five draws of each null; every STEP-th name is taken, then every STEP-th from the next
start on, so that all kinds occur from the beginning and a series may end anywhere without a choice of sets.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path


sys.path.insert(0, str(Path(__file__).parent))

from truths import truths


def series(step=8, nulls=5):
    """Return (truth, draw) of every set once, in order; the step shares no factor with their number."""
    names = [(name, draw) for name in truths() for draw in range(nulls if name.startswith("null") else 1)]
    if math.gcd(step, len(names)) != 1:
        raise ValueError(f"a step of {step} does not reach all {len(names)} sets")
    return [names[step * number % len(names)] for number in range(len(names))]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--step", type=int, default=8)
    for name, draw in series(parser.parse_args().step):
        print(name, draw)


if __name__ == "__main__":
    main()
