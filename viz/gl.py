"""Is there an OpenGL library? VTK does not say: without one it crashes the process.

So EGL is asked first, for what VTK will ask of it (25 ms); where it does not simply agree, a process of its own tries.

Flat maps and curves need no OpenGL and are drawn everywhere.
"""

from __future__ import annotations

import ctypes
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
_EGL_WINDOW = "vtkEGLRenderWindow"
_DEVICE_PLATFORM, _OPENGL_API = 0x313F, 0x30A2
_OFF_SCREEN_OPENGL = (0x3033, 1, 0x3040, 8, 0x3025, 8, 0x3038)
"""Surfaces of pixel buffers, OpenGL (not ES), 8 bits of depth, end of the list."""


class NoGraphics(EtextileError):
    """There is no OpenGL to draw the deformed fabric with."""


def choose_window() -> None:
    """Tell VTK to draw without a display when there is none (EGL), unless the user chose already."""
    headless = sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    if headless:
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", _EGL_WINDOW)


@cache
def available() -> bool:
    """Return whether VTK can draw here; costs about 0.4 s once where a small picture in another process must tell."""
    choose_window()
    if sys.platform != "linux" or _egl_agrees():
        return True
    try:
        probe = subprocess.run([sys.executable, "-c", _PROBE], capture_output=True, timeout=_PATIENCE_S, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return probe.returncode == 0


def _egl_agrees() -> bool:
    """Return whether VTK will use EGL, and EGL gives an OpenGL context on a device; False also when in doubt."""
    if os.environ.get("VTK_DEFAULT_OPENGL_WINDOW") != _EGL_WINDOW or "VTK_DEFAULT_EGL_DEVICE_INDEX" in os.environ:
        return False
    pointer, integer = ctypes.c_void_p, ctypes.c_int32
    try:
        egl = ctypes.CDLL("libEGL.so.1")
        egl.eglGetProcAddress.restype = egl.eglCreateContext.restype = pointer
        egl.eglCreateContext.argtypes = [pointer] * 4
        devices_of = egl.eglGetProcAddress(b"eglQueryDevicesEXT")
        display_of = egl.eglGetProcAddress(b"eglGetPlatformDisplayEXT")
        if not devices_of or not display_of:
            return False
        device, count = pointer(), integer()
        ctypes.CFUNCTYPE(integer, integer, pointer, pointer)(devices_of)(
            1, ctypes.addressof(device), ctypes.addressof(count)
        )
        display = pointer(
            ctypes.CFUNCTYPE(pointer, integer, pointer, pointer)(display_of)(_DEVICE_PLATFORM, device.value, None)
        )
        wanted, config, found = (integer * 7)(*_OFF_SCREEN_OPENGL), pointer(), integer()
        agreed = (
            count.value
            and egl.eglInitialize(display, None, None)
            and egl.eglBindAPI(_OPENGL_API)
            and egl.eglChooseConfig(display, wanted, ctypes.byref(config), integer(1), ctypes.byref(found))
            and found.value
        )
        context = egl.eglCreateContext(display, config, None, None) if agreed else None
        if context is None:
            return False
        egl.eglDestroyContext(display, pointer(context))
    except (OSError, AttributeError):
        return False
    return True


def require() -> None:
    """Raise NoGraphics with the remedy when VTK cannot draw here."""
    if not available():
        raise NoGraphics(
            f"no OpenGL library to draw the deformed fabric with: on Debian or Ubuntu run `{REMEDY}`; "
            "the flat maps and the curves do not need it"
        )
