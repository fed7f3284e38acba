"""
Bias extension
==============

A coupon cut at 45 degrees shears; its centre is compared with a trellis of rigid yarns.
"""

import matplotlib.pyplot as plt

import etextile as et


run = et.run("bias_extension", "out/bias_extension")
coupon = run.report["coupon"]
plt.plot(coupon["strain"], coupon["centre"]["shear_angle_deg"], "o-", label="centre of the coupon")
plt.plot(coupon["strain"], coupon["trellis"]["shear_angle_deg"], label="trellis")
plt.xlabel("engineering strain of the coupon")
plt.ylabel("shear angle, degrees")
plt.legend()
plt.savefig("bias_extension.png")
