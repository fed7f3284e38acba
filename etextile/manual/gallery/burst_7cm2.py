"""
Bursting strength, 7.3 cm2
==========================

The small ring of ISO 13938 with the low, the middle and the high fabric: pressure where the first yarn breaks.
"""

import matplotlib.pyplot as plt

import etextile as et


for fabric in ("estimated_low", "estimated_mid", "estimated_high"):
    changes = {"fabric.set": fabric, "fabric.coarsening": 12, "motion.steps": 9, "outputs.maps": []}
    run = et.run(et.load("burst_7cm2", changes), f"out/burst_7cm2/{fabric}")
    bulge, first = run.report["pressure"], run.report["rupture"]["first"]
    plt.plot(bulge["pressure_bar"], bulge["height_mm"], label=f"{fabric}: {first['pressure_bar']:.1f} bar")
plt.xlabel("pressure, bar")
plt.ylabel("height of the bulge, mm")
plt.legend(title="first yarn breaks at")
plt.savefig("burst_7cm2.png")
