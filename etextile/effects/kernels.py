"""Compiled loops of effects: the yarn law over many virtual trusses at once."""

from __future__ import annotations

import math

from etextile.compiled import njit
from etextile.laws.powerlaw import dissipated_energy, respond, stored_energy
from etextile.types import Array, IntArray


@njit
def law_response(
    table: Array, law: IntArray, strain: Array, old: Array, tau: Array, slope: Array, plastic: Array
) -> None:
    """Fill tau, d tau / d eps and plastic strain (n,) at Hencky strains (n,) from plastic strains `old` (n,)."""
    for e in range(strain.shape[0]):
        tau[e], slope[e], plastic[e] = respond(table[law[e]], strain[e], old[e])


@njit
def law_energy(table: Array, law: IntArray, volume: Array, strain: Array, plastic: Array) -> tuple[float, float]:
    """Return (stored, dissipated) energy in N mm of trusses with these volumes (n,) mm3."""
    stored = 0.0
    dissipated = 0.0
    for e in range(strain.shape[0]):
        stored += volume[e] * stored_energy(table[law[e]], strain[e], plastic[e])
        dissipated += volume[e] * dissipated_energy(table[law[e]], plastic[e])
    return stored, dissipated


@njit
def law_beyond(
    table: Array, volume: Array, slack: Array, stretch: Array, old: Array, force: Array, along: Array
) -> None:
    """Fill dU/dl and d2U/dl2 (n,), N mm, at stretches (n,) > 0 beyond slack lengths (n,) in units of the first length.

    Stretches too small to be seen in the length bear in proportion; one law, the first row of the table.
    """
    for e in range(stretch.shape[0]):
        seen = max(stretch[e], 1e-9 * slack[e])
        length = slack[e] + seen
        tau, slope, _ = respond(table[0], math.log(length), old[e])
        force[e] = volume[e] * tau / length
        along[e] = volume[e] * (slope - tau) / (length * length)
        if stretch[e] < seen:
            along[e] = force[e] / seen
            force[e] = along[e] * stretch[e]
