"""
How far a measurement is from a simulation
==========================================

The shipped measurement ``hidden_clamp`` was made with an effect that the case does not have; ``et.diagnose`` names it.
"""

import matplotlib.pyplot as plt

import etextile as et


found = et.compare("punch", "hidden_clamp", "out/compared", jobs=1)
for place in found.data["where"]:
    print(place["sentence"])
picture = next(found.folder.glob("*.png"))
plt.imsave("compare.png", plt.imread(picture))
