"""
Bursting strength, 50 cm2
=========================

Fabric clamped in a ring and inflated (ISO 13938): height over pressure, and where the first yarn breaks.
"""

import matplotlib.pyplot as plt

import etextile as et


case = et.load("burst_50cm2", {"fabric.coarsening": 24, "motion.steps": 14, "outputs.maps": []})
run = et.run(case, "out/burst_50cm2")
bulge, first, low, high = run.report["pressure"], *(run.report["rupture"][key] for key in ("first", "low", "high"))
plt.plot(bulge["pressure_bar"], bulge["height_mm"], "o-")
plt.axvline(first["pressure_bar"], color="k", label=f"first {first['family']} yarn breaks")
plt.axvspan(low["pressure_bar"], high["pressure_bar"], alpha=0.2, label="all yarns break early or late")
plt.xlabel("pressure, bar")
plt.ylabel("height of the bulge, mm")
plt.legend()
plt.savefig("burst_50cm2.png")
