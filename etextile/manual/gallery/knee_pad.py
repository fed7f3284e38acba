"""
Knee pad
========

Wires, parts on rigid lands and three nets as they were drawn (DXF): is every part still supplied?
"""

import etextile as et


changes = {"fabric.coarsening": 39, "motion.steps": 8, "outputs.maps": []}
run = et.run(et.load("knee_pad", changes), "out/knee_pad")
run.failure_map("knee_pad.png", flat=True)
print(run.report["verdict"]["sentence"])
for net in run.report["nets"]:
    print(f"{net['name']:8} {net['state']:10} lost with probability {net['loss_probability']:.3f}")
