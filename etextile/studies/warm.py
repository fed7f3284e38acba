"""What workers need, imported once by the server that they are forked from (`etextile.process`); it solves nothing.

Beside samples and the runs of a diagnosis these are modules that come late: bodies, and what numba loads before its
first kernel, which takes a third of all the time.
"""

from __future__ import annotations

from importlib import import_module

from numba.core.registry import cpu_target


MODULES = (
    "etextile.studies.ensemble.sample",
    "etextile.diagnose.predict.simulate",
    "etextile.contact.bodies",
    "etextile.contact.mesh",
    "etextile.contact.own",
    "etextile.contact.sphere",
    "wires.share",
    "scipy.linalg",
)
for name in MODULES:
    import_module(name)
cpu_target.typing_context.refresh()
cpu_target.target_context.refresh()
