"""
Cantilever
==========

A strip that hangs over an edge (ASTM D1388): the bending stiffness by the rule of the standard beside the one put in.
"""

import matplotlib.pyplot as plt

import etextile as et


run = et.run(et.load("cantilever_d1388", {"fabric.coarsening": 39, "outputs.maps": []}), "out/cantilever")
hung = run.report["weight"]
plt.plot(hung["mass_g_m2"], hung["angle_deg"], "o-")
plt.axhline(41.5, color="k", linestyle=":", label="41.5 degrees")
plt.xlabel("mass per area, g/m2")
plt.ylabel("angle of the end below the edge, degrees")
plt.legend()
plt.savefig("cantilever.png")
print(f"0.500 N mm put in, by the rule {hung['at_standard_angle']['peirce_stiffness_Nmm']:.3f} N mm")
