"""
Woven nylon off its yarns
=========================

A strip at 45 degrees, whose yarns are cut at both edges and slip in their film, beside the measured curve.
"""

from importlib.resources import files

import matplotlib.pyplot as plt
import numpy as np

import etextile as et


case = et.load("nylon_offaxis", {"fabric.warp_angle": 45, "outputs.maps": []})
coupon = et.run(case, "out/nylon_offaxis").report["coupon"]
plt.plot(coupon["strain"], coupon["stress_MPa"], "o", label="simulated at 45 degrees")
pulled = np.loadtxt(str(files("loadcases") / "data/nylon_woven/angle_45.csv"), delimiter=",")
plt.plot(pulled[:, 0] / 97, pulled[:, 1] / (27 * 0.067), "k", label="measured, twelve strips")
plt.xlabel("engineering strain")
plt.ylabel("fabric stress, MPa")
plt.legend()
plt.savefig("nylon_offaxis.png")
