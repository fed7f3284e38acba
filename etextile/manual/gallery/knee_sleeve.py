"""
Knee sleeve
===========

A sleeve as wide as the leg, tight over the kneecap: pressure on the skin while the knee bends.
"""

import matplotlib.pyplot as plt

import etextile as et


changes = {"motion.flexion": "50 deg", "motion.steps": 5, "outputs.maps": []}
run = et.run(et.load("knee_sleeve", changes), "out/knee_sleeve")
run.failure_map("knee_sleeve_map.png")
plt.plot(run.curves["angle_deg"], run.curves["pressure_kPa_mean"], "o-", label="mean")
plt.plot(run.curves["angle_deg"], run.curves["pressure_kPa_max"], "s-", label="greatest")
plt.xlabel("angle of the knee, degrees")
plt.ylabel("pressure on the skin, kPa")
plt.legend()
plt.savefig("knee_sleeve.png")
