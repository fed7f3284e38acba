"""Settings that must stand before numba, MKL, matplotlib or hypothesis are imported, and nothing else."""

from __future__ import annotations

import os

import hypothesis


# Two threads at most, as the product's timings are measured; one each when the tests run side by side (pytest -n).
_threads = "1" if "PYTEST_XDIST_WORKER" in os.environ else str(min(2, os.cpu_count() or 1))
for _name in ("NUMBA_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, _threads)
os.environ.setdefault("MPLBACKEND", "Agg")

# The same examples on every run, no time limit (the first call compiles), no files outside tmp_path.
hypothesis.settings.register_profile("etextile", derandomize=True, deadline=None, database=None)
hypothesis.settings.load_profile("etextile")
