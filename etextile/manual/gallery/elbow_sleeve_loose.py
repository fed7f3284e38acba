"""
A sleeve that lasts
===================

A loose sleeve bent and stretched: most of the moment of the way out is not there on the way back.
"""

import matplotlib.pyplot as plt

import etextile as et


changes = {"motion.flexion": "60 deg", "motion.path": ["60 deg", "30 deg"], "motion.steps": 6, "outputs.maps": []}
run = et.run(et.load("elbow_sleeve_loose", changes), "out/elbow_sleeve_loose")
run.failure_map("elbow_sleeve_loose_map.png")
plt.plot(run.curves["angle_deg"], run.curves["moment_Nmm"], "o-")
plt.xlabel("angle of the elbow, degrees")
plt.ylabel("moment of the sleeve, N mm")
plt.savefig("elbow_sleeve_loose.png")
