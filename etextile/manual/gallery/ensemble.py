"""
Failure probabilities with scatter
==================================

Fabric, wires and mounting scatter from specimen to specimen; 16 samples of a coarse punch test.
"""

import matplotlib.pyplot as plt
import numpy as np

import etextile as et


case = et.load("punch", {"fabric.coarsening": 30, "motion.total": "35 mm", "motion.steps": 14})
scatter = et.ensemble(case, "out/scatter", samples=16, seed=1, jobs=1)
wires = scatter.data["wires"]
low, middle, high = (np.array([wire[key] for wire in wires]) for key in ("low", "failure_probability", "high"))
plt.errorbar([wire["wire"] for wire in wires], middle, [middle - low, high - middle], fmt="o", capsize=3)
plt.xlabel("wire, counted from the centre")
plt.ylabel("probability of a broken filament, 95 %")
plt.savefig("ensemble.png")
