"""
Tension along the warp
======================

A virtual coupon of 60 x 29 mm pulled along the warp, beside the single truss that its law was identified for.
"""

import matplotlib.pyplot as plt

import etextile as et


run = et.run("tension_warp", "out/tension_warp")
coupon = run.report["coupon"]
plt.plot(coupon["strain"], coupon["stress_MPa"], "o-", label="coupon")
plt.plot(coupon["strain"], coupon["single_element_MPa"], label="single truss")
plt.xlabel("engineering strain")
plt.ylabel("fabric stress, MPa")
plt.legend()
plt.savefig("tension_warp.png")
