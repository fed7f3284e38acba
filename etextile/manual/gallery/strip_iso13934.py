"""
Strip tension
=============

A strip of 200 x 50 mm pulled along the warp and along the weft (ISO 13934-1) up to where the first yarn breaks.
"""

import matplotlib.pyplot as plt

import etextile as et


for name, angle in (("warp", 0), ("weft", 90)):
    changes = {"fabric.warp_angle": angle, "fabric.coarsening": 39, "motion.steps": 14, "outputs.maps": []}
    run = et.run(et.load("strip_iso13934", changes), f"out/strip/{name}")
    first = run.report["rupture"]["first"]
    sound = run.curves["displacement_mm"] <= first["displacement_mm"]
    plt.plot(run.curves["displacement_mm"][sound], run.curves["force_N"][sound], "o-", label=f"along the {name}")
    plt.plot(first["displacement_mm"], first["force_N"], "kx")
plt.xlabel("extension, mm")
plt.ylabel("force, N")
plt.legend(title="x: first yarn breaks")
plt.savefig("strip.png")
