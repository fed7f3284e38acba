"""
Coated polyester, inflated
==========================

The height of a circle of 100 mm radius beside the specimen that stays lowest of the three it was fitted to.
"""

from importlib.resources import files

import matplotlib.pyplot as plt
import numpy as np

import etextile as et


run = et.run(et.load("bulge_valmex", {"fabric.coarsening": 20, "outputs.maps": []}), "out/bulge_valmex")
bulge = run.report["pressure"]
plt.plot(bulge["pressure_bar"], bulge["height_mm"], "o-", label="simulated")
path = files("loadcases") / "data/valmex_heights/specimen_0.csv"
plt.plot(*np.loadtxt(str(path), delimiter=",", skiprows=1).T, "k", label="measured, specimen 0")
plt.xlabel("pressure, bar")
plt.ylabel("height, mm")
plt.legend()
plt.savefig("bulge_valmex.png")
