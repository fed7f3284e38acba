"""Drawings: what is written reads back to the same model, and every wrong one is named with file and place."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from ezdxf.filemanagement import new, readfile

import etextile as et
from etextile.app.cli import main
from etextile.errors import BadInput
from etextile.results.wire_layout import KINDS, WireLayout
from loadcases.build_paths import drawn_wires
from loadcases.build_wires import wire_layout
from loadcases.fabric import load_fabric
from loadcases.reader import load_case
from wires.drawing_files import read_drawing


DRAWN = """\
schema_version: 1
title: Drawn
extends: elbow
motion: {total: 10 mm, steps: 1}
wires:
  loops: null
  paths:
    - {name: VCC, along: warp, at: -12 mm, from: -60 mm, to: 60 mm, loops: [0, {at: 20, length: 6, slack: 4 %}]}
    - {name: GND, along: weft, at: 33.3, loops: {spacing: 15 mm, length: 5 mm, component: 2 mm}}
    - {name: slack, path: [[-50, 30], [-40, 35.5], [-30, 30], [10, 30]], loops: [[-10, 30]]}
    - {name: straight but laid, path: [[-50, 50], [50, 50]]}
  components:
    - {name: LED1, at: [10, -12], connects: [VCC]}
    - {name: loose, at: [33.3, 4], size: [4, 2], rigid: false}
"""


def layout_of(path: Path) -> WireLayout:
    case = load_case(path).case
    found = wire_layout(case, load_fabric(case.fabric.set))
    assert found is not None
    return found


def assert_same(first: WireLayout, second: WireLayout) -> None:
    for item in fields(WireLayout):
        a, b = getattr(first, item.name), getattr(second, item.name)
        if isinstance(a, np.ndarray) and a.dtype.kind == "f":
            np.testing.assert_allclose(b, a, atol=1e-9, rtol=0.0, err_msg=item.name)
        elif isinstance(a, np.ndarray):
            np.testing.assert_array_equal(b, a, err_msg=item.name)
        else:
            assert b == a, item.name


@pytest.mark.parametrize("suffix", [".dxf", ".csv"])
def test_a_drawing_that_is_written_reads_back_to_the_same_wires_loops_and_parts(suffix: str, tmp_path: Path) -> None:
    first, again = tmp_path / "first.yaml", tmp_path / "again.yaml"
    first.write_text(DRAWN)
    et.layout(str(first), tmp_path / f"drawing{suffix}")
    head = DRAWN[: DRAWN.index("  paths:")]
    again.write_text(f"{head}  layout: drawing{suffix}\n")
    assert_same(layout_of(first), layout_of(again))
    assert [KINDS[kind] for kind in layout_of(again).kind] == ["warp", "weft", "laid", "laid"]
    before, after = (drawn_wires(load_case(path).case) for path in (first, again))
    assert before.parts[0].connects == ("VCC",)
    assert [(p.name, p.at, p.size, p.connects, p.rigid) for p in after.parts] == [
        (p.name, p.at, p.size, p.connects, p.rigid) for p in before.parts
    ]
    assert after.terminals == before.terminals


@pytest.mark.parametrize("suffix", [".dxf", ".csv"])
@pytest.mark.parametrize("portion", ["whole", "quarter"])
def test_the_comb_is_written_as_drawn_wires_of_the_whole_specimen(suffix: str, portion: str, tmp_path: Path) -> None:
    et.layout(et.load("punch", {"fabric.portion": portion}), tmp_path / f"comb{suffix}")
    case = tmp_path / "case.yaml"
    case.write_text(f"schema_version: 1\nextends: punch\nwires: {{layout: comb{suffix}}}\nfabric: {{portion: whole}}\n")
    comb = wire_layout(load_case("punch", overrides=["fabric.portion=whole"]).case, load_fabric("estimated_mid"))
    assert comb is not None
    assert_same(comb, layout_of(case))


def test_a_drawing_in_inches_is_the_drawing_in_mm(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(f"{DRAWN[: DRAWN.index('  paths:')]}  layout: a.csv\n")
    (tmp_path / "a.csv").write_text("kind,name,x_in,y_in,length_in\nwire,A,-2,0.5,\nwire,A,2,0.5,\nloop,A,1,0.5,0.2\n")
    layout = layout_of(tmp_path / "a.yaml")
    assert (layout.start_mm[0], layout.end_mm[0], layout.weft_mm[0]) == pytest.approx((-50.8, 50.8, 12.7))
    assert (layout.loop_warp_mm[0], layout.loop_span_mm[0]) == pytest.approx((25.4, 5.08))


def test_a_line_in_a_thousand_pieces_in_any_order_is_one_wire(tmp_path: Path) -> None:
    """A meander as programs export it: pieces shuffled, every other one turned round."""
    document = new("R2010", units=4)
    x = np.linspace(-40.0, 40.0, 1001)
    places = np.stack([x, 5.0 + np.sin(x)], axis=1)
    rng = np.random.default_rng(3)
    for k in rng.permutation(1000).tolist():
        ends = (places[k], places[k + 1])[:: 1 if k % 2 else -1]
        document.modelspace().add_line(*ends, dxfattribs={"layer": "A" if k % 3 else "a"})
    document.saveas(tmp_path / "layout.dxf")
    drawn = read_drawing(tmp_path / "layout.dxf", slack=0.02)
    (wire,) = drawn.wires
    np.testing.assert_allclose(wire.points[:: 1 if wire.points[0][0] < 0.0 else -1], places, atol=1e-9)


def test_the_hash_of_a_case_follows_what_its_drawing_holds(tmp_path: Path) -> None:
    text = "kind,name,x_mm,y_mm\nwire,A,-20,5\nwire,A,20,5\n"
    found = []
    for folder, content in (("a", text), ("b", text), ("c", text.replace("20,5", "21,5"))):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "case.yaml").write_text("schema_version: 1\nextends: elbow\nwires: {layout: d.csv}\n")
        (tmp_path / folder / "d.csv").write_text(content)
        found.append(load_case(tmp_path / folder / "case.yaml").sha256)
    assert found[0] == found[1] != found[2]


def test_a_drawing_is_not_overwritten_unless_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "layout.dxf"
    assert main(["layout", "elbow", "-o", str(file)]) == 0
    before = file.read_bytes()
    assert main(["layout", "elbow", "-o", str(file)]) == 2
    assert "--force" in capsys.readouterr().err
    assert file.read_bytes() == before
    assert main(["layout", "elbow", "-o", str(file), "--force"]) == 0
    assert main(["layout", "elbow", "-o", str(tmp_path / "layout.svg")]) == 2
    assert "svg" in capsys.readouterr().err


def test_names_that_a_layer_cannot_have_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(DRAWN.replace("name: slack", "name: 'a/b'").replace("name: LED1", "name: vcc"))
    with pytest.raises(BadInput, match="layer") as caught:
        et.layout(str(tmp_path / "a.yaml"), tmp_path / "out.dxf")
    assert len(caught.value.problems) == 2
    assert not (tmp_path / "out.dxf").exists()
    et.layout(str(tmp_path / "a.yaml"), tmp_path / "out.csv")


def test_the_layout_of_a_case_is_listed_by_name(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(DRAWN)
    for command in (["layout"], ["list", "layout"]):
        assert main([*command, str(tmp_path / "a.yaml")]) == 0
        text = capsys.readouterr().out
        assert "VCC" in text
        assert "1 of 4 mm, slack 2 %; 1 of 6 mm, slack 4 %" in text
        assert "LED1" in text
        assert "loose" in text


HEAD = "kind,name,x_mm,y_mm,length_mm,slack,rigid_mm,size_x_mm,size_y_mm,connects,held\n"
GOOD = "wire,A,-20,5\nwire,A,20,5\nwire,B,-20,9\nwire,B,20,9\npart,P,0,5\npart,Q,9,5\n"
WRONG_TABLES = {
    "no unit": ("kind,name,x,y\nwire,A,-20,5\n", 1, "do not say their unit"),
    "a name twice": (f"{HEAD}{GOOD}wire,A,-20,30\nwire,A,20,30\n", 8, "a second wire named 'A'"),
    "a part twice": (f"{HEAD}{GOOD}part,P,-9,5\n", 8, "a second part named 'P'"),
    "one end": (f"{HEAD}{GOOD}wire,C,-20,30\n", 8, "1 vertex"),
    "part beside its wires": (f"{HEAD}{GOOD}part,R,0,40\n", 8, "lies on no wire"),
    "part of no wire": (f"{HEAD}{GOOD}part,R,4,5,,,,3,3,VDD\n", 8, "connects no such wire"),
    "outside": (f"{HEAD}{GOOD}wire,C,-200,30\nwire,C,20,30\n", 8, "leaves the piece"),
    "part outside": (f"{HEAD}{GOOD}part,R,79.5,5\n", 8, "leaves the piece"),
    "self-crossing": (f"{HEAD}wire,A,0,0\nwire,A,9,0\nwire,A,9,9\nwire,A,4,-9\n", 2, "crosses itself at (6.5, 0)"),
    "no length": (f"{HEAD}{GOOD}wire,C,3,30\nwire,C,3,30\n", 8, "has no length"),
    "on another": (f"{HEAD}{GOOD}wire,C,0,5\nwire,C,30,5\n", 8, "lies on wire 'A' over 20 mm"),
    "no number": (f"{HEAD}{GOOD}wire,C,zero,30\n", 8, "column x is no number (got 'zero')"),
    "digits of another script": (f"{HEAD}{GOOD}wire,C,٣,30\n", 8, "column x is no number"),
    "a name that does not show": (f"{HEAD}{GOOD}wire,C\u202e,0,30\nwire,C\u202e,9,30\n", 8, "do not show"),
    "a name too long": (f"{HEAD}{GOOD}wire,{'C' * 200},0,30\nwire,{'C' * 200},9,30\n", 8, "128 bytes"),
    "a cell without end": (f"{HEAD}{GOOD}wire,C,{'1' * 200_000},30\n", 8, "is no row"),
    "huge": (f"{HEAD}{GOOD}wire,C,1e300,30\nwire,C,0,30\n", 8, "leaves the piece"),
    "too many vertices": (
        HEAD + "".join(f"wire,C,{-70 + 0.02 * k},{30 + k % 2}\n" for k in range(6000)),
        2,
        "has 6000 vertices",
    ),
    "loop beside its wire": (f"{HEAD}{GOOD}loop,A,0,30\n", 8, "25 mm beside wire 'A'"),
    "loop over the end": (f"{HEAD}{GOOD}loop,A,19,5\n", 8, "leaves wire 'A'"),
    "two names in one": (f"{HEAD}{GOOD}part,R,4,9,,,,3,3,A B\n", 8, "(got 'A B'), separate names by ;"),
    "slack below zero": (f"{HEAD}{GOOD}loop,A,9,5,4,-0.02\n", 8, "a slack of -0.02, a share of its length from 0 to 1"),
    "slack in per cent": (f"{HEAD}{GOOD}loop,A,9,5,4,2\n", 8, "a slack of 2"),
    "loop without length": (f"{HEAD}{GOOD}loop,A,9,5,0\n", 8, "a length of 0 mm, which must be above 0"),
    "land below zero": (f"{HEAD}{GOOD}part,R,0,9,,,,-3,3\n", 8, "a land of -3 x 3 mm, which must be above 0"),
    "back over itself": (f"{HEAD}{GOOD}wire,C,-9,20\nwire,C,9,20\nwire,C,0,20\n", 8, "runs back over itself"),
    "unknown kind": (f"{HEAD}{GOOD}hole,A,0,5\n", 8, "unknown kind of row (got 'hole')"),
}


def test_a_column_that_stands_twice_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "layout.csv").write_text("kind,name,x_mm,x_cm,y_mm\nwire,A,-10,-1,3\nwire,A,10,1,3\n")
    assert "layout.csv:1: column x stands 2 times, keep one" in complaint(tmp_path, capsys, "layout: layout.csv")


def complaint(folder: Path, capsys: pytest.CaptureFixture[str], wires: str, *, size: str = "") -> str:
    """Return the one line that `check` says about a case with these wires."""
    case = folder / "case.yaml"
    case.write_text(f"schema_version: 1\nextends: elbow\ntitle: Wrong\n{size}wires: {{{wires}}}\n")
    assert main(["check", str(case)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = captured.err.splitlines()
    assert len(lines) == 1
    return lines[0]


@pytest.mark.parametrize("what", WRONG_TABLES)
def test_a_wrong_table_gets_one_message_with_file_and_line(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text, line, message = WRONG_TABLES[what]
    (tmp_path / "layout.csv").write_text(text)
    said = complaint(tmp_path, capsys, "layout: layout.csv")
    assert f"layout.csv:{line}:" in said
    assert message in said


def test_a_net_without_a_path_between_its_parts_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "layout.csv").write_text(f"{HEAD}{GOOD}wire,C,-20,30\nwire,C,20,30\npart,R,0,30\n")
    said = complaint(tmp_path, capsys, "layout: layout.csv, nets: [{name: N, wires: [A, B], parts: [P, R]}]")
    assert "case.yaml:4:" in said
    assert "N" in said


def drawing(path: Path, *, unit: int = 4) -> None:
    """Write a good drawing of one wire and a part."""
    document = new("R2010", units=unit)
    space = document.modelspace()
    space.add_lwpolyline([(-20, 5), (20, 5)], dxfattribs={"layer": "A"})
    space.add_point((0, 5), dxfattribs={"layer": "P"})
    document.saveas(path)


def more_of(path: Path, what: str) -> None:
    """Spoil the drawing."""
    document = readfile(path)
    space = document.modelspace()
    if what == "open ends":
        space.add_line((25, 5), (30, 5), dxfattribs={"layer": "A"})
    elif what == "no length":
        space.add_line((3, 30), (3, 30), dxfattribs={"layer": "C"})
    elif what == "two parts":
        space.add_point((9, 5), dxfattribs={"layer": "P"})
    elif what == "outside":
        space.add_lwpolyline([(-20, 300), (20, 300)], dxfattribs={"layer": "C"})
    elif what == "loop alone":
        space.add_circle((0, 30), 2.0, dxfattribs={"layer": "C"})
    elif what == "block":
        document.blocks.new("X")
        space.add_blockref("X", (0, 0), dxfattribs={"layer": "C"})
    elif what == "doubled":
        space.add_lwpolyline([(-5, 5), (5, 5)], dxfattribs={"layer": "C"})
    elif what == "part without wire":
        space.add_point((9, 50), dxfattribs={"layer": "R"})
    elif what == "nan":
        space.add_line((float("nan"), 30), (9, 30), dxfattribs={"layer": "C"})
    elif what == "far away":
        space.add_spline([(0, 30), (1e8, 30), (9, 40)], dxfattribs={"layer": "C"})
    elif what == "enormous arc":
        space.add_arc((0, 1e9), 1e9, 269.0, 271.0, dxfattribs={"layer": "C"})
    elif what == "out of the plane":
        space.add_line((-9, 30, 0), (9, 30, 40), dxfattribs={"layer": "C"})
    elif what == "a surface":
        space.add_polymesh((3, 3), dxfattribs={"layer": "C"})
    elif what == "self-crossing":
        space.add_lwpolyline([(0, 20), (9, 20), (9, 29), (4, 11)], dxfattribs={"layer": "C"})
    document.saveas(path)


WRONG_DRAWINGS = {
    "open ends": "LINE #{handle} on layer A: wire 'A' has open ends: a gap of 5 mm",
    "no length": "LINE #{handle} on layer C: a line of wire 'C' has no length",
    "two parts": "POINT #{handle} on layer P: a second part named 'P'",
    "outside": "LWPOLYLINE #{handle} on layer C: wire 'C' leaves the piece",
    "loop alone": "CIRCLE #{handle} on layer C: layer 'C' holds loops (circles), but no line of a wire",
    "block": "INSERT #{handle} on layer C: cannot be read",
    "doubled": "LWPOLYLINE #{handle} on layer C: wire 'C' lies on wire 'A' over 10 mm",
    "nan": "LINE #{handle} on layer C: the line on layer 'C' has a coordinate that is no number",
    "far away": "SPLINE #{handle} on layer C: the line on layer 'C' reaches to 1e+08 mm",
    "enormous arc": "ARC #{handle} on layer C: the line on layer 'C' has a radius or centre of 1e+09 mm",
    "out of the plane": "LINE #{handle} on layer C: the line on layer 'C' leaves the plane of the drawing",
    "a surface": "POLYLINE #{handle} on layer C: cannot be read",
    "part without wire": "POINT #{handle} on layer R: part 'R' lies on no wire",
    "self-crossing": "LWPOLYLINE #{handle} on layer C: wire 'C' crosses itself at (6.5, 20) mm",
}


@pytest.mark.parametrize("what", WRONG_DRAWINGS)
def test_a_wrong_drawing_gets_one_message_with_file_and_entity(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "layout.dxf"
    drawing(file)
    more_of(file, what)
    handle = list(readfile(file).modelspace())[-1].dxf.handle
    said = complaint(tmp_path, capsys, "layout: layout.dxf")
    assert "layout.dxf" in said
    kind_and_layer, _, message = WRONG_DRAWINGS[what].format(handle=handle).partition(": ")
    assert kind_and_layer in said
    assert message in said


@pytest.mark.parametrize(
    ("unit", "wires", "message"),
    [
        (0, "layout: layout.dxf", "does not say its unit"),
        (4, "layout: layout.dxf, layout_units: in", "wires.layout_units says in"),
        (7, "layout: layout.dxf", "is in unit 7"),
    ],
)
def test_units_are_never_guessed(
    unit: int, wires: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drawing(tmp_path / "layout.dxf", unit=unit)
    said = complaint(tmp_path, capsys, wires)
    assert "layout.dxf" in said
    assert message in said


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("layout.dxf", b"hello", "not a DXF file that can be read"),
        ("layout.dxf", b"", "not a DXF file that can be read"),
        ("layout.csv", b"", "empty"),
        ("layout.csv", b"\xff\xfe\x00k", "not UTF-8"),
        ("layout.pdf", b"%PDF-1.4", "not a drawing (got '.pdf')"),
        ("other.csv", b"", "no such drawing"),
    ],
)
def test_files_that_are_no_drawings_are_named(
    name: str, content: bytes, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_bytes(content)
    said = complaint(tmp_path, capsys, f"layout: {name.replace('other', 'layout')}")
    assert message in said
