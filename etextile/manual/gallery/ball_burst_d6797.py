"""
Ball burst
==========

A polished ball pushed through a fabric in a ring (ASTM D6797): force over deflection up to where the first yarn breaks.
"""

import matplotlib.pyplot as plt

import etextile as et


run = et.run(et.load("ball_burst_d6797", {"fabric.coarsening": 16, "outputs.maps": []}), "out/ball_burst")
first = run.report["rupture"]["first"]
sound = run.curves["displacement_mm"] <= first["displacement_mm"]
plt.plot(run.curves["displacement_mm"][sound], run.curves["force_N"][sound], "o-")
plt.plot(first["displacement_mm"], first["force_N"], "kx", label=f"first {first['family']} yarn breaks")
plt.xlabel("deflection, mm")
plt.ylabel("force, N")
plt.legend()
plt.savefig("ball_burst.png")
