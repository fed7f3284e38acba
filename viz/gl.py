"""Is there an OpenGL library? VTK does not say: without one it crashes the process, so a process of its own asks.

Flat maps and curves need no OpenGL and are drawn everywhere.
"""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache

from etextile.errors import EtextileError


REMEDY = "apt-get install libegl1 libgl1-mesa-dri"

_PROBE = """
from vtkmodules import vtkRenderingOpenGL2
from vtkmodules.vtkCommonCore import vtkObject
from vtkmodules.vtkRenderingCore import vtkRenderWindow
vtkObject.GlobalWarningDisplayOff()
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(8, 8)
window.Render()
raise SystemExit(0 if window.SupportsOpenGL() else 1)
"""
_PATIENCE_S = 60.0


class NoGraphics(EtextileError):
    """There is no OpenGL to draw the deformed fabric with."""


def choose_window() -> None:
    """Tell VTK to draw without a display when there is none (EGL), unless the user chose already."""
    headless = sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    if headless:
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")


@cache
def available() -> bool:
    """Return whether VTK can draw here; costs about 0.4 s once (a small picture in another process)."""
    choose_window()
    if sys.platform != "linux":
        return True
    try:
        probe = subprocess.run([sys.executable, "-c", _PROBE], capture_output=True, timeout=_PATIENCE_S, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return probe.returncode == 0


def require() -> None:
    """Raise NoGraphics with the remedy when VTK cannot draw here."""
    if not available():
        raise NoGraphics(
            f"no OpenGL library to draw the deformed fabric with: on Debian or Ubuntu run `{REMEDY}`; "
            "the flat maps and the curves do not need it"
        )
