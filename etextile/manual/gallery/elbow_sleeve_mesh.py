"""
Elbow sleeve on a body mesh
===========================

The sleeve of the parametric elbow on the arm of a rigged body mesh: its joint lies nearer to the outer skin.
"""

import matplotlib.pyplot as plt

import etextile as et


short = {"motion.flexion": "45 deg", "motion.steps": 9, "fabric.coarsening": 32.5, "outputs.maps": []}
for case in ("elbow_sleeve", "elbow_sleeve_mesh"):
    run = et.run(et.load(case, short), f"out/sleeve_and_mesh/{case}")
    joint = run.report["joint"]
    plt.plot(joint["angle_deg"], joint["moment_Nmm"], "o-", label=run.report["case"]["title"])
run.failure_map("elbow_sleeve_mesh_map.png")
plt.xlabel("angle of the elbow, degrees")
plt.ylabel("moment of the sleeve, N mm")
plt.legend(frameon=False)
plt.savefig("elbow_sleeve_mesh.png")
