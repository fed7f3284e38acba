"""Random numbers of an ensemble: one row of unit numbers per sample, from the seed alone.

Sobol points are scrambled and taken from the start of the sequence, so that row k is the same in every ensemble of that
seed and a larger ensemble contains the smaller one. A Latin hypercube belongs to its number of samples.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from etextile.ensemble.inputs import COLUMNS, normal
from etextile.types import Array


Method = Literal["sobol", "lhs"]
METHODS: tuple[Method, ...] = ("sobol", "lhs")


def unit_rows(count: int, *, seed: int, method: Method = "sobol") -> Array:
    """Return unit numbers (count, len(COLUMNS)) in [0, 1)."""
    from scipy.stats import qmc  # takes a second to import, which workers need not spend

    generator = np.random.default_rng(seed)
    if method == "lhs":
        return np.asarray(qmc.LatinHypercube(len(COLUMNS), seed=generator).random(count))
    powers = max(int(np.ceil(np.log2(max(count, 1)))), 0)
    return np.asarray(qmc.Sobol(len(COLUMNS), scramble=True, seed=generator).random_base2(powers)[:count])


def local_normal(count: int, *, seed: int, sample: int, place: int, reach: float) -> Array:
    """Return normal numbers (count,), cut off at +-reach, of the loops at a place (a wire) in a sample.

    They depend on seed, sample and place alone; more loops leave the first ones as they are.
    """
    units = np.random.default_rng([seed, sample, place]).random(count)
    return np.array([normal(unit, reach) for unit in units])
