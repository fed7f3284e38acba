"""Make the virtual environment everything else runs in: `python3 .ci/environment.py .venv`.

Needs Python 3.11 or newer and its standard library. Brings the system packages that are missing (as root on Debian;
otherwise it prints the line to run), the pinned packages of constraints.txt and this repository, and does nothing when
nothing changed.
"""

from __future__ import annotations

import ctypes
import hashlib
import importlib
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path


ROOT = Path(__file__).resolve().parent.parent
STAMP = "etextile-environment.txt"
GL_PACKAGES = ("libegl1", "libgl1-mesa-dri")
SURFACELESS_MESA, OPENGL_API, DEFAULT_DISPLAY = 0x31DD, 0x30A2, 0


def main() -> None:
    """Bring the environment named on the command line up to date."""
    if sys.argv[1:] == ["--probe-gl"]:
        sys.exit(0 if opens_gl_context() else 1)
    venv = Path(sys.argv[1] if len(sys.argv) > 1 else ".venv").absolute()
    stamp = venv / STAMP
    if stamp.is_file() and stamp.read_text() == fingerprint(venv) and runs(venv):
        return
    provide_system_packages()
    create(venv)
    install(venv)
    stamp.write_text(fingerprint(venv))
    say(f"environment ready: {venv}")


def fingerprint(venv: Path) -> str:
    """Hash of all that decides what the environment holds; it changes when the environment must be renewed."""
    digest = hashlib.sha256(f"{ROOT}\0{venv}\0{sys.version}".encode())
    for path in (Path(__file__), ROOT / "pyproject.toml", ROOT / "constraints.txt"):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def provide_system_packages() -> None:
    """Install what Debian keeps in packages of its own, or stop with the line that does."""
    missing = missing_system_packages()
    if not missing:
        return
    line = f"apt-get update && apt-get install -y --no-install-recommends {' '.join(missing)}"
    if not shutil.which("apt-get"):
        stop(
            f"missing on this system: {' '.join(missing)} (these are Debian's names).\n"
            "Install Python's venv and ensurepip modules, EGL and Mesa's software renderer "
            "(Fedora: mesa-libEGL mesa-dri-drivers) and start again."
        )
    if os.geteuid() != 0:
        stop(
            f"missing on this system: {' '.join(missing)}. Run this line and start again:\n\n    sudo sh -c '{line}'\n"
        )
    say(f"installing system packages: {' '.join(missing)}")
    command = ["env", "DEBIAN_FRONTEND=noninteractive", "sh", "-c", line]
    apt = subprocess.run(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )
    if apt.returncode != 0:
        stop(f"{apt.stdout.decode(errors='replace')}\nfailed: {line}")
    importlib.invalidate_caches()
    if left := missing_system_packages():
        stop(f"apt-get was content, yet this does not work: {' '.join(left)} (Python: {sys.executable})")


def missing_system_packages() -> list[str]:
    """Debian's names of the packages that this system lacks."""
    venv = [] if importlib.util.find_spec("ensurepip") else [f"python3.{sys.version_info.minor}-venv"]
    return venv + ([] if draws_without_a_screen() else list(GL_PACKAGES))


def draws_without_a_screen() -> bool:
    """Whether OpenGL works without a display; asked in a child process, because a broken driver may crash."""
    if not sys.platform.startswith("linux"):
        return True
    probe = [sys.executable, __file__, "--probe-gl"]
    return subprocess.run(probe, stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode == 0


def opens_gl_context() -> bool:
    """Open an OpenGL context through EGL, as the renderer will; libEGL alone, without Mesa's drivers, cannot."""
    try:
        egl = ctypes.CDLL("libEGL.so.1")
    except OSError:
        return False
    pointer = ctypes.c_void_p
    egl.eglGetPlatformDisplay.argtypes, egl.eglGetPlatformDisplay.restype = [ctypes.c_uint, pointer, pointer], pointer
    egl.eglGetDisplay.argtypes, egl.eglGetDisplay.restype = [pointer], pointer
    egl.eglInitialize.argtypes = [pointer, pointer, pointer]
    egl.eglCreateContext.argtypes, egl.eglCreateContext.restype = [pointer, pointer, pointer, pointer], pointer
    for display in (egl.eglGetPlatformDisplay(SURFACELESS_MESA, None, None), egl.eglGetDisplay(DEFAULT_DISPLAY)):
        ready = display and egl.eglInitialize(display, None, None) and egl.eglBindAPI(OPENGL_API)
        if ready and egl.eglCreateContext(display, None, None, None):
            return True
    return False


def create(venv: Path) -> None:
    """Create the virtual environment, anew when it belongs to another Python."""
    if not runs(venv):
        say(f"creating {venv} with Python {sys.version.split()[0]}")
        run([sys.executable, "-m", "venv", "--clear", str(venv)], "the virtual environment could not be created")


def runs(venv: Path) -> bool:
    """Whether the environment's Python starts and is the version of this one."""
    python = interpreter(venv)
    if not python.exists():
        return False
    question = [python, "-c", "import sys; print(sys.version)"]
    return subprocess.run(question, capture_output=True, text=True, check=False).stdout.strip() == sys.version


def install(venv: Path) -> None:
    """Install the pinned packages, each checked against its hash, then this repository; nothing else is fetched."""
    say("installing the pinned packages (the first time a download of half a gigabyte, some minutes)")
    quiet = [] if sys.stdout.isatty() else ["--quiet"]
    pip = [str(interpreter(venv)), "-m", "pip", "--disable-pip-version-check", "--no-input"]
    pinned = ["install", *quiet, "--require-hashes", "--only-binary", ":all:", "-r", str(ROOT / "constraints.txt")]
    run([*pip, *pinned], "the pinned packages could not be installed; see pip's message above")
    itself = ["install", "--quiet", "--no-index", "--no-deps", "--no-build-isolation", "-e", str(ROOT)]
    run([*pip, *itself], "etextile itself could not be installed; see pip's message above")
    run([*pip, "check", "--quiet"], "constraints.txt does not fit pyproject.toml; renew it with `make lock`")


def interpreter(venv: Path) -> Path:
    """Path of the environment's Python."""
    return venv / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")


def run(command: list[str], failure: str) -> None:
    """Run a command without standard input and stop with `failure` when it fails."""
    if subprocess.run(command, stdin=subprocess.DEVNULL, check=False).returncode != 0:
        stop(failure)


def say(text: str) -> None:
    """Print progress at once, also into a pipe."""
    print(f"set-up: {text}", flush=True)


def stop(text: str) -> None:
    """End the set-up with a message."""
    sys.exit(f"set-up: {text}")


if __name__ == "__main__":
    if sys.version_info < (3, 11):  # noqa: UP036 (this script meets whatever Python there is)
        sys.exit(f"set-up: Python 3.11 or newer is needed, this is {sys.version.split()[0]}")
    main()
