"""The compile decorator where folders can and cannot be written."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core import caching

from etextile import compiled
from etextile.compiled import announcing, njit, private_temporary_folder


def ratio(a: float, b: float) -> float:
    return a / b


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Let temporary folders lie in tmp_path, and put numba's cache setting back afterwards."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    return tmp_path


def test_kernels_divide_by_zero_like_numpy(temporary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(temporary))
    assert njit(ratio)(1.0, 0.0) == np.inf


def test_cache_moves_to_a_private_folder_when_nothing_else_can_be_written(
    temporary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for locator in (caching.InTreeCacheLocator, caching.UserWideCacheLocator):
        monkeypatch.setattr(locator, "from_function", classmethod(lambda *_: None))
    with pytest.raises(RuntimeError, match="cannot cache"):
        numba.njit(cache=True)(ratio)
    assert njit(ratio)(3.0, 2.0) == 1.5
    folder = private_temporary_folder("etextile-numba")
    assert os.environ["NUMBA_CACHE_DIR"] == str(folder)
    assert list(folder.rglob("*.nbi"))


def test_without_any_folder_kernels_still_compile(temporary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for locator in (caching.UserProvidedCacheLocator, caching.InTreeCacheLocator, caching.UserWideCacheLocator):
        monkeypatch.setattr(locator, "from_function", classmethod(lambda *_: None))
    assert njit(ratio)(3.0, 2.0) == 1.5


def test_compiling_is_announced_once_and_reading_the_cache_is_not(
    temporary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(temporary))
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(temporary))
    said: list[str] = []
    for expected in (1, 1):
        with announcing(lambda: said.append("compiling")):
            assert njit(ratio)(3.0, 2.0) == 1.5
            assert njit(ratio)(3, 2) == 1.5
        assert len(said) == expected


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="folders have no owner here")
def test_a_folder_others_could_have_written_is_not_used(temporary: Path) -> None:
    expected = private_temporary_folder("kernels")
    assert expected == private_temporary_folder("kernels")
    assert expected.stat().st_mode & 0o077 == 0
    expected.chmod(0o777)
    other = private_temporary_folder("kernels")
    assert other != expected
    assert other.stat().st_mode & 0o077 == 0


def test_a_kernel_is_compiled_again_when_any_kernel_has_changed(
    temporary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(temporary))
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(temporary))

    def hits() -> int:
        kernel = njit(ratio)
        assert kernel(3.0, 2.0) == 1.5
        return sum(kernel.stats.cache_hits.values())

    assert [hits(), hits()] == [0, 1]
    monkeypatch.setattr(compiled, "sources", lambda: "the text of other kernels")
    assert [hits(), hits()] == [0, 1]


def test_the_text_of_the_truss_law_is_part_of_the_stamp() -> None:
    package = Path(compiled.__file__).parent
    texts = [path.read_bytes() for path in (package / "laws/powerlaw.py", package / "mechanics/kernels.py")]
    assert all(b"@njit" in text for text in texts)
    assert len(compiled.sources()) == 64
