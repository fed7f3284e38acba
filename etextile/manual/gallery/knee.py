"""
Knee
====

Thigh, shank and patella; the displacement at which every wire loses its first filament.
"""

import matplotlib.pyplot as plt

import etextile as et


run = et.run(et.load("knee", {"fabric.coarsening": 40}), "out/knee")
run.failure_map("knee_map.png")
plt.plot(run.wires["weft_mm"], run.wires["first_failure_mm"], "o")
plt.xlabel("place of the wire along the weft, mm")
plt.ylabel("displacement at its first failure, mm")
plt.savefig("knee_failures.png")
print(run.report["verdict"]["sentence"])
