"""
Woven nylon at 30 degrees
=========================

A direction that the fabric was not identified from, at yarn resolution: prediction and measurement
(data of Farrell et al., MIT licence; the measured strain starts with a preload, see Validation).
"""

import matplotlib.pyplot as plt

import etextile as et


run = et.run("nylon_30", "out/nylon_30")
coupon = run.report["coupon"]
plt.plot(coupon["strain"], coupon["stress_MPa"], "o-", label="simulated at 30 degrees")
plt.xlabel("engineering strain")
plt.ylabel("fabric stress, MPa")
plt.legend()
plt.savefig("nylon_30.png")
