"""What is kept is taken only when it is whole: any change of a file makes it as if it were not there."""

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from etextile.diagnose.data.observe import Record
from etextile.diagnose.predict.simulate import load_record, save_record
from etextile.kept import code_digest, keep, recall


ARRAYS = {"a": np.arange(12.0).reshape(3, 4), "b": np.array("text"), "c": np.array([1, 2], dtype=np.int32)}


@pytest.mark.parametrize("packed", [True, False])
def test_arrays_come_back_to_the_last_bit(tmp_path: Path, packed: bool) -> None:
    path = tmp_path / "deep" / "kept.npz"
    keep(path, ARRAYS, packed=packed)
    found = recall(path, ("a", "b"))
    assert found is not None
    for name, values in ARRAYS.items():
        assert found[name].dtype == values.dtype
        assert np.array_equal(found[name], values)
    assert recall(path, ("a", "d")) is None
    assert [item.name for item in path.parent.iterdir()] == ["kept.npz"]


def record() -> Record:
    rng = np.random.default_rng(0)
    return Record(
        np.arange(3.0), np.arange(2.0), (True, False), np.arange(4.0), rng.random(4),
        rng.random((4, 6, 3)).astype(np.float32).astype(float), rng.random((4, 3)), True,
    )  # fmt: skip


def test_four_hundred_damaged_records_are_all_taken_for_missing(tmp_path: Path) -> None:
    path, rng = tmp_path / "record.npz", np.random.default_rng(5)
    save_record(record(), path)
    whole = path.read_bytes()
    same = 0
    for number in range(400):
        data = bytearray(whole)
        if number % 4 == 0:
            del data[int(rng.integers(len(data))) :]
        elif number % 4 == 1:
            data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
        elif number % 4 == 2:
            start = int(rng.integers(len(data)))
            data[start : start + 64] = bytes(min(64, len(data) - start))
        else:
            data[int(rng.integers(len(data)))] = int(rng.integers(256))
        path.write_bytes(bytes(data))
        found = load_record(path)
        if found is not None:  # a byte that no reader of zip files looks at
            same += 1
            assert np.array_equal(found.positions, record().positions)
            assert np.array_equal(found.force, record().force)
    assert same < 100


@pytest.mark.parametrize("name", ["x", "symmetry", "force", "positions", "completed"])
@pytest.mark.parametrize("other", [None, np.zeros(0), np.array("x"), np.array(np.nan), np.zeros((2, 2, 2))])
def test_records_of_another_shape_are_taken_for_missing(tmp_path: Path, name: str, other: object) -> None:
    path = tmp_path / "record.npz"
    save_record(record(), path)
    with np.load(path) as stored:
        content = {key: stored[key] for key in stored.files}
    if other is None:
        del content[name]
    else:
        content[name] = np.asarray(other)
    np.savez(path, **content)
    assert load_record(path) is None


def test_a_file_that_says_it_holds_more_than_can_be_is_not_unpacked(tmp_path: Path) -> None:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.npy", bytes(1000))
    data = stream.getvalue().replace((1000).to_bytes(4, "little"), (4_000_000_000).to_bytes(4, "little"))
    (tmp_path / "bomb.npz").write_bytes(data)
    assert recall(tmp_path / "bomb.npz", ()) is None


def test_a_link_in_its_place_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "own").write_text("kept")
    (tmp_path / "kept.npz").symlink_to("own")
    keep(tmp_path / "kept.npz", ARRAYS)
    assert (tmp_path / "own").read_text() == "kept"


def test_the_digest_of_code_changes_with_every_file_and_name(tmp_path: Path) -> None:
    (tmp_path / "part" / "deep").mkdir(parents=True)
    (tmp_path / "part" / "deep" / "a.py").write_text("x = 1\n")
    (tmp_path / "b.py").write_text("y = 1\n")
    digests = {code_digest(tmp_path, ("part", "b.py"))}
    (tmp_path / "part" / "deep" / "a.py").write_text("x = 2\n")
    digests.add(code_digest(tmp_path, ("part", "b.py")))
    (tmp_path / "part" / "deep" / "a.py").rename(tmp_path / "part" / "deep" / "c.py")
    digests.add(code_digest(tmp_path, ("part", "b.py")))
    (tmp_path / "b.py").write_text("y = 2\n")
    digests.add(code_digest(tmp_path, ("part", "b.py")))
    assert len(digests) == 4
