"""
Failure probabilities with scatter
==================================

Fabric, wires and mounting scatter from specimen to specimen; 16 samples of a coarse punch test.
"""

import matplotlib.pyplot as plt

import etextile as et


case = et.load("punch", {"fabric.coarsening": 30, "motion.total": "35 mm", "motion.steps": 14})
scatter = et.ensemble(case, "out/scatter", samples=16, seed=1, jobs=1)
wires = scatter.data["wires"]
middle = [wire["failure_probability"] for wire in wires]
bars = [[m - wire["low"] for m, wire in zip(middle, wires)], [wire["high"] - m for m, wire in zip(middle, wires)]]
plt.errorbar([wire["wire"] for wire in wires], middle, bars, fmt="o", capsize=3)
plt.xlabel("wire, counted from the centre")
plt.ylabel("probability of a broken filament, 95 %")
plt.savefig("ensemble.png")
