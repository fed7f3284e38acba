"""
Elbow
=====

A bent elbow pressed into a clamped square: which wires survive, and what the worst loops went through.
"""

import etextile as et


case = et.load("elbow", {"fabric.coarsening": 30})
run = et.run(case, "out/elbow")
run.failure_map("elbow_map.png")
run.failure_map("elbow_flat.png", flat=True)
print(run.report["verdict"]["sentence"])
worst = run.loops.sort_values("max_strain", ascending=False)
print(worst[["wire", "loop", "state", "first_failure_mm", "max_strain"]].head(5).to_string(index=False))
