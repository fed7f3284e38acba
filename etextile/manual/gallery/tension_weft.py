"""
Tension along the weft
======================

A virtual coupon of 60 x 29 mm pulled along the weft, beside the single truss that its law was identified for.
"""

import matplotlib.pyplot as plt

import etextile as et


run = et.run("tension_weft", "out/tension_weft")
coupon = run.report["coupon"]
plt.plot(coupon["strain"], coupon["stress_MPa"], "o-", label="coupon")
plt.plot(coupon["strain"], coupon["single_element_MPa"], label="single truss")
plt.xlabel("engineering strain")
plt.ylabel("fabric stress, MPa")
plt.legend()
plt.savefig("tension_weft.png")
