"""Code of users: Python files that a case names, and what installed packages offer as entry points.

Effects, criteria and bodies come through here, so that all are found, run and refused alike. A file runs as any import
does, once its user has allowed it (`etextile.foreign_code`).
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterator
from functools import lru_cache
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from etextile import foreign_code
from etextile.errors import BadInput
from etextile.files import read_bounded


MAX_BYTES = 4_000_000
"""More than any code of a user; what is larger is no such file."""


PREFIX = "_etextile_own_"
"""Begin of the names of modules made from users' files."""


def run_file(file: str | Path, *, key: str = "file") -> ModuleType:
    """Return the module in a Python file, run once per content.

    Raises BadInput for a file that is missing or not allowed (at `key` of the case) or fails (at its own line).
    """
    path = Path(file).expanduser().resolve()
    if path.suffix != ".py" or not path.is_file():
        raise BadInput.of(f"no such Python file (got {str(file)!r})", key=key)
    content = read_bounded(path, MAX_BYTES)
    foreign_code.require(path, content, key=key)
    return _run(path, content)


def own_objects(module: ModuleType) -> list[Any]:
    """Return classes, functions and instances that a module defines itself, not what it imports."""
    return [item for item in vars(module).values() if getattr(item, "__module__", module.__name__) == module.__name__]


def installed(group: str) -> Iterator[tuple[str, str, Any]]:
    """Yield name, place and object of every entry point of a group; raises BadInput for one that cannot be loaded."""
    for entry in entry_points(group=group):
        try:
            item = entry.load()
        except Exception as error:  # foreign code may raise anything
            message = f"{entry.name!r} of {entry.value} (group {group}) cannot be loaded: {error}"
            raise BadInput.of(f"{message}; mend or uninstall that package") from error
        yield entry.name, entry.value, item


def raised_in(error: BaseException) -> traceback.FrameSummary | None:
    """Return where in a file that `run_file` ran an error came through, the innermost place; None elsewhere."""
    own = {module.__file__ for name, module in list(sys.modules.items()) if name.startswith(PREFIX)}
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename in own]
    return frames[-1] if frames else None


@lru_cache(maxsize=64)
def _run(path: Path, content: bytes) -> ModuleType:
    """Return the module in a file of this content; nothing is kept on disk, so that no change is hidden."""
    name = f"{PREFIX}{foreign_code.hash_of(content)[:16]}"
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module  # dataclasses look their module up
    try:
        exec(compile(content, str(path), "exec"), module.__dict__)
    except SyntaxError as error:
        raise BadInput.of(f"not Python: {error.msg}", file=str(path), line=error.lineno) from error
    except Exception as error:  # foreign code may raise anything
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
        line = lines[-1] if lines else None
        raise BadInput.of(f"cannot be run: {type(error).__name__}: {error}", file=str(path), line=line) from error
    return module
