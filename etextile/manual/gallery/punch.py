"""
Punch test
==========

A sphere of 30 mm diameter is pressed into the fabric of the paper; without friction and sticking to it.
"""

import matplotlib.pyplot as plt

import etextile as et


for friction in (0, "stick"):
    run = et.run(et.load("punch", {"contact.friction": friction}), f"out/punch_{friction}")
    plt.plot(run.curves["displacement_mm"], run.curves["force_N"], label=f"friction {friction}")
plt.xlabel("punch displacement, mm")
plt.ylabel("punch force, N")
plt.legend()
plt.savefig("punch_force.png")
run.failure_map("punch_map.png")
print(run.report["verdict"]["sentence"])
