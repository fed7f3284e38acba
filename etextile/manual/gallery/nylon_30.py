"""
Woven nylon at 30 degrees
=========================

A direction that the fabric was not identified from, at yarn resolution: prediction and measurement
(data of Farrell et al., MIT licence).
"""

from importlib.resources import files

import matplotlib.pyplot as plt
import numpy as np

import etextile as et


run = et.run("nylon_30", "out/nylon_30")
coupon = run.report["coupon"]
plt.plot(coupon["strain"], coupon["stress_MPa"], "o-", label="simulated at 30 degrees")
pulled = np.loadtxt(str(files("loadcases") / "data/nylon_woven/angle_30.csv"), delimiter=",")
plt.plot(pulled[:, 0] / 97, pulled[:, 1] / (27 * 0.067), "k", label="measured, twelve strips of 97 x 2.25 x 0.067 mm")
plt.xlabel("engineering strain")
plt.ylabel("fabric stress, MPa")
plt.legend()
plt.savefig("nylon_30.png")
