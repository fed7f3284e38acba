"""
Elbow pad
=========

A panel sewn to a tight garment by its ends: what its loops feel while the elbow bends to 50 degrees.
"""

import matplotlib.pyplot as plt

import etextile as et


changes = {"motion.flexion": "50 deg", "motion.steps": 5, "outputs.maps": []}
run = et.run(et.load("elbow_pad", changes), "out/elbow_pad")
run.failure_map("elbow_pad_map.png")
worst = run.loops.sort_values("max_strain", ascending=False).iloc[0]
loop = run.loop(wire=worst["wire"], loop=worst["loop"])
plt.plot(loop["angle_deg"], 100 * loop["span_strain"], "o-", label="fabric under the worst loop")
plt.plot(loop["angle_deg"], 100 * loop["wire_strain"], "s-", label="its free wire")
plt.xlabel("angle of the elbow, degrees")
plt.ylabel("engineering strain, %")
plt.legend()
plt.savefig("elbow_pad.png")
