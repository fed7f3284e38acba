"""
A loop's strain over displacement
=================================

Load a case, change it, run it, plot what one loop went through, save a failure map.
"""

import matplotlib.pyplot as plt

import etextile as et


case = et.load("punch", {"motion.total": "25 mm", "motion.steps": 10})
run = et.run(case, "out/notebook")
loop = run.loop(wire=2, loop=1)
plt.plot(loop["displacement_mm"], loop["span_strain"], label="fabric under the loop")
plt.plot(loop["displacement_mm"], loop["wire_strain"], label="free wire")
plt.xlabel("punch displacement, mm")
plt.ylabel("engineering strain")
plt.legend()
plt.savefig("notebook_loop.png")
run.failure_map("notebook_map.png", step=-1)
