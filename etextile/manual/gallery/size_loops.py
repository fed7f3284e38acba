"""
How much slack each loop needs
==============================

One simulation without a change, then the slack that keeps every loop's probability of a broken filament under 1 %.
"""

import etextile as et


case = et.load("elbow", {"fabric.coarsening": 40, "motion.total": "30 mm"})
sized = et.size_loops(case, "out/sized", target=0.01)
for key, value in sized.data.items():
    if not isinstance(value, list | dict):
        print(f"{key}: {value}")
