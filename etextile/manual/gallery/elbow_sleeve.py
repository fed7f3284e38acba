"""
Elbow sleeve
============

A sleeve put on an arm that bends: moment and folds over the angle, and where its wires stand at 60 degrees.
"""

import matplotlib.pyplot as plt

import etextile as et


changes = {"motion.flexion": "60 deg", "motion.steps": 6, "outputs.maps": []}
run = et.run(et.load("elbow_sleeve", changes), "out/elbow_sleeve")
run.failure_map("elbow_sleeve_map.png")
joint = run.report["joint"]
plt.plot(joint["angle_deg"], joint["moment_Nmm"], "o-")
plt.xlabel("angle of the elbow, degrees")
plt.ylabel("moment of the sleeve, N mm")
plt.savefig("elbow_sleeve.png")
