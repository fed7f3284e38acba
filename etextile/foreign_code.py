"""Python code that a file names runs only when its user said so: `--allow-code`, a trusted folder, or the file itself.

A case, a patch or a result file of somebody else may name a Python file; reading it must not run that file. What a user
names in a call or on the command line, and what is installed as a package, is the user's own. Code is known by the hash
of its content, so that a file which changes has to be allowed anew.
"""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

from etextile.errors import BadInput


TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")

_allowed: set[str] = set()
_trusting: list[bool] = []
_never: list[str] = []
APP, SETTINGS, FOLDERS = "etextile", "config.toml", "trusted_folders"


def hash_of(content: bytes) -> str:
    """Return the SHA-256 that names a piece of code."""
    return hashlib.sha256(content).hexdigest()


def allow(hashes: Iterable[str]) -> None:
    """Let code with these SHA-256 run in this process."""
    _allowed.update(hashes)


def allow_file(path: str | Path) -> None:
    """Let a file run that the user has named; whoever loads it says what keeps it from being read."""
    place = Path(path).expanduser()
    if place.suffix == ".py" and place.is_file():
        allow([hash_of(place.read_bytes())])


@contextmanager
def trusting(yes: bool = True) -> Iterator[None]:
    """Within this context, `yes` lets all code run; what ran may do so again later."""
    _trusting.append(yes)
    try:
        yield
    finally:
        _trusting.pop()


@contextmanager
def never(verb: str) -> Iterator[None]:
    """Within this context no code runs at all, also none that was allowed; `verb` is told to the user."""
    _never.append(verb)
    try:
        yield
    finally:
        _never.pop()


def forget() -> None:
    """Take back all that was allowed in this process."""
    _allowed.clear()


def allowed() -> frozenset[str]:
    """Return what may run here, for another process that works for this one."""
    return frozenset(_allowed)


def call_with(hashes: frozenset[str], function: Callable[[TaskT], ResultT], task: TaskT) -> ResultT:
    """Run a task in a process where the same code may run as in the one that sent it."""
    allow(hashes)
    return function(task)


def require(path: Path, content: bytes, *, key: str) -> None:
    """Raise BadInput, with the hash of what would run, for Python code that nobody has allowed."""
    found = hash_of(content)
    if _never:
        message = f"{_never[-1]} runs no Python code, and this result needs {path} (sha256 {found})"
        raise BadInput.of(f"{message}; `etextile run CASE --allow-code` writes its report and maps", key=key)
    if any(_trusting):
        allow([found])
    if found in _allowed or any(path.is_relative_to(folder) for folder in trusted_folders()):
        return
    message = (
        f"Python code is not run unasked: {path} (sha256 {found}); read it, then add --allow-code (in Python "
        f"et.load(..., allow_code=True)), or trust its folder in {settings_file()}: {FOLDERS} = [{str(path.parent)!r}]"
    )
    raise BadInput.of(message, key=key)


def settings_file() -> Path:
    """Return the user's own settings file."""
    from platformdirs import user_config_path

    return user_config_path(APP, appauthor=False) / SETTINGS


def trusted_folders() -> tuple[Path, ...]:
    """Return the folders whose code the user trusts; raises BadInput for settings that cannot be read."""
    path = settings_file()
    if not path.is_file():
        return ()
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8")).get(FOLDERS, [])
    except (OSError, ValueError) as error:
        raise BadInput.of(f"not TOML ({error}), mend or remove it", file=str(path)) from error
    if not isinstance(found, list) or not all(isinstance(item, str) and Path(item).is_absolute() for item in found):
        raise BadInput.of('must be a list of absolute folders, such as ["/srv/cases"]', file=str(path), key=FOLDERS)
    return tuple(Path(item).resolve() for item in found)
