"""Compiled loops of effects: the yarn law over many virtual trusses at once."""

from __future__ import annotations

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
