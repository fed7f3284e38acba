"""The shipped measurements of a woven nylon fabric (`data/nylon_woven`), also at angles not used for identification."""

from __future__ import annotations

from pathlib import Path

import loadcases
from etextile.identify.curves import DISPLACEMENT_FORCE, CouponSize, TensileCurve, read_curve


FOLDER = Path(loadcases.__file__).parent / "data" / "nylon_woven"
SIZE = CouponSize(width=27.0, thickness=0.067, gauge_length=97.0)
ANGLES = (0, 30, 45, 60, 90)


def load_nylon(angle: int) -> TensileCurve:
    """Return the loading curve of strips cut at `angle` degrees to the warp (0, 30, 45, 60 or 90).

    Warp is the first yarn direction of the source; engineering strain over the gauge length, stress on 27 x 0.067 mm2.
    """
    return read_curve(FOLDER / f"angle_{angle:02d}.csv", size=SIZE, columns=DISPLACEMENT_FORCE)
