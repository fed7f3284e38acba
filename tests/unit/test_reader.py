"""Case files: what is read, and what a person is told about everything that is wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from etextile.errors import BadInput, Problem
from loadcases import catalogue
from loadcases.reader import as_loaded, case_sha256, load_case
from loadcases.schema import Case
from loadcases.schema_body import Ellipsoid, Sphere
from wires.failure import CRITERIA


GOOD = """\
schema_version: 1
title: A case
fabric:
  size: [100, 80 mm]
  portion: quarter
wires:
  loops: {spacing: 2 cm, length: 4}
body:
  type: sphere
  radius: 15 mm
motion:
  total: 40
  steps: 20
contact:
  friction: 0.3
"""


Write = Callable[..., str]
MM = "expected a length in mm, plain or with a unit such as '30 mm'"
MU = "must be 0, a positive coefficient up to 10 or 'stick'"
BODIES = "sphere, ellipsoid, capsule, mesh, elbow, knee, own, limb or limb_mesh"
FABRICS = ", ".join(catalogue.names("fabric"))
CONTACT = "unknown key, allowed are friction, max_penetration, stick_stiffness"
TOP = (
    "unknown key, allowed are schema_version, title, description, fabric, wires, supports, body, motion, contact, "
    "effects, failure, scatter, solver, outputs, extends"
)


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    monkeypatch.chdir(tmp_path)

    def save(text: str, name: str = "case.yaml") -> str:
        (tmp_path / name).write_text(text, encoding="utf-8")
        return name

    return save


def problems(name: str | Path, *overrides: str) -> list[str]:
    with pytest.raises(BadInput) as refused:
        load_case(name, overrides=overrides)
    assert refused.value.exit_code == 2
    return [str(problem) for problem in refused.value.problems]


def only(name: str | Path, *overrides: str) -> str:
    found = problems(name, *overrides)
    assert len(found) == 1, found
    return found[0]


def changed(old: str, new: str) -> str:
    assert old in GOOD
    return GOOD.replace(old, new)


def test_a_case_is_read_into_plain_numbers(write: Write) -> None:
    case = load_case(write(GOOD)).case
    assert case.fabric.size == (100.0, 80.0)
    assert case.wires is not None
    assert case.wires.loops is not None
    assert case.wires.loops.spacing == 20.0
    assert isinstance(case.body, Sphere)
    assert case.body.radius == 15.0
    assert case.fabric.set == "estimated_mid"
    assert case.fabric.coarsening == 19.5
    assert case.contact.max_penetration == 0.02
    assert case.failure.onset == 0.07
    assert case.supports.clamped == ("x_min", "x_max")


def test_a_case_cannot_be_changed(write: Write) -> None:
    case = load_case(write(GOOD)).case
    with pytest.raises(ValueError, match="frozen"):
        case.motion.total = 3.0  # type: ignore[misc]


def test_sections_left_out_mean_nothing_is_there(write: Write) -> None:
    text = "schema_version: 1\ntitle: x\nfabric: {size: [9, 9]}\nmotion: {total: 1, steps: 1, target: x_max}\n"
    case = load_case(write(text)).case
    assert case.wires is None
    assert case.body is None
    assert case.effects == ()


KEYS = {
    "misspelt": ("friction: 0.3", "fricton: 0.3", f"15:3: contact.fricton: {CONTACT}, did you mean 'friction'?"),
    "misspelt section": ("contact:", "contct:", f"14:1: contct: {TOP}, did you mean 'contact'?"),
    "misplaced": (
        "contact:\n  friction: 0.3",
        "friction: 0.3",
        f"14:1: friction: {TOP}, did you mean 'contact.friction'?",
    ),
    "missing": (
        "title: A case\n",
        "",
        "1:1: title: this key is missing, expected: One line that names the case in reports",
    ),
    "missing below": (
        "  total: 40\n",
        "",
        "11:1: motion.total: this key is missing, expected: Largest displacement, mm, or largest load: bar for "
        "pressure, g/m2 for weight",
    ),
    "twice": (
        "  total: 40\n",
        "  total: 40\n  total: 41\n",
        "13:3: motion.total: this key stands twice, first in line 12, keep one of them",
    ),
    "section twice": (
        "contact:",
        "title: B\ncontact:",
        "14:1: title: this key stands twice, first in line 2, keep one of them",
    ),
}
NUMBERS = {
    "wrong unit": (
        "radius: 15 mm",
        "radius: 15 kg",
        f"10:11: body.radius: the unit does not fit (got '15 kg'), {MM}",
    ),
    "negative": ("radius: 15 mm", "radius: -1", "10:11: body.radius: out of range (got -1), must be above 0 mm"),
    "text": ("radius: 15 mm", "radius: yes", f"10:11: body.radius: text, not a number (got 'yes'), {MM}"),
    "boolean": ("radius: 15 mm", "radius: true", f"10:11: body.radius: not a number (got true), {MM}"),
    "null": ("radius: 15 mm", "radius: null", f"10:11: body.radius: not a number (got null), {MM}"),
    "infinite": ("total: 40", "total: .inf", f"12:10: motion.total: not a finite number (got inf), {MM}"),
    "decimal comma": (
        "total: 40",
        "total: 40,5",
        "12:10: motion.total: decimal comma (got '40,5'), write a point: '40.5'",
    ),
    "half a step": ("steps: 20", "steps: 9.5", "13:10: motion.steps: not a whole number (got 9.5), must be 1 or more"),
    "no step": ("steps: 20", "steps: 0", "13:10: motion.steps: out of range (got 0), must be 1 or more"),
    "friction below zero": ("friction: 0.3", "friction: -1", f"15:13: contact.friction: not a friction (got -1), {MU}"),
    "friction misspelt": (
        "friction: 0.3",
        "friction: stik",
        f"15:13: contact.friction: not a friction (got 'stik'), {MU}",
    ),
    "finer than yarns": (
        "portion: quarter",
        "coarsening: 0.5",
        "5:15: fabric.coarsening: out of range (got 0.5), must be at least 1",
    ),
}
CHOICES = {
    "portion": (
        "portion: quarter",
        "portion: quater",
        "5:12: fabric.portion: not allowed (got 'quater'), must be quarter, half or whole, did you mean 'quarter'?",
    ),
    "body": (
        "type: sphere",
        "type: sphear",
        f"9:9: body.type: not allowed (got 'sphear'), must be {BODIES}, did you mean 'sphere'?",
    ),
    "no body type": ("  type: sphere\n", "", f"8:1: body.type: this key is missing, must be one of {BODIES}"),
    "no list": (
        "[100, 80 mm]",
        "100",
        "4:9: fabric.size: not a list (got 100), write [a, b, ...]: "
        "Free size [length along x, width along y] of the whole specimen, mm",
    ),
    "short list": ("[100, 80 mm]", "[100]", "4:9: fabric.size: wrong number of items (got [100]), expected 2"),
    "long list": ("[100, 80 mm]", "[1, 2, 3]", "4:9: fabric.size: wrong number of items (got [1, 2, 3]), expected 2"),
    "empty list": (
        "contact:",
        "supports: {clamped: []}\ncontact:",
        "14:21: supports.clamped: wrong number of items (got []), expected at least 1",
    ),
    "edge twice": (
        "contact:",
        "supports: {clamped: [x_min, x_max, x_min]}\ncontact:",
        "14:21: supports.clamped: an edge is named twice (got ['x_min', 'x_max', 'x_min']), name each edge once",
    ),
    "map": (
        "contact:",
        "outputs: {maps: [failures]}\ncontact:",
        "14:18: outputs.maps.0: not allowed (got 'failures'), must be failure, warp_strain, weft_strain, "
        "diagonal_strain or wire_strain, did you mean 'failure'?",
    ),
    "no section": (
        "wires:\n  loops: {spacing: 2 cm, length: 4}",
        "wires: yes",
        "6:8: wires: not a section (got 'yes'), expected a mapping with the keys every_warp_yarns, first_offset, "
        "material, filaments, filament_diameter, crimp, coupons_contain_wires, loops, bond, paths, layout, "
        "layout_units, components, joined, nets",
    ),
    "bond": (
        "wires:",
        "wires:\n  bond: loose",
        "7:9: wires.bond: not allowed (got 'loose'), must be perfect or a mapping with the keys line_friction, "
        "tension_factor",
    ),
    "lines": (
        "title: A case",
        "title: |\n  A\n  B",
        "2:8: title: more than one line (got 'A\\nB\\n'), put the rest into description",
    ),
    "title": (
        "title: A case",
        "title: 12",
        "2:8: title: not a text (got 12), expected: One line that names the case in reports",
    ),
}
NAMES = {
    "newer format": (
        "schema_version: 1",
        "schema_version: 2",
        "1:17: schema_version: this format is newer than the program (got 2), update etextile, "
        "this one reads version 1",
    ),
    "strange format": (
        "schema_version: 1",
        "schema_version: one",
        "1:17: schema_version: not a known format version (got 'one'), write 1",
    ),
    "no format": (
        "schema_version: 1\n",
        "",
        "1:1: schema_version: this key is missing, expected: Version of this file format, write 1",
    ),
    "fabric": (
        "portion: quarter",
        "set: estimated_mdi",
        "5:8: fabric.set: no such fabric (got 'estimated_mdi'), shipped are "
        f"{FABRICS}, or give a path, did you mean 'estimated_mid'?",
    ),
    "wire material": (
        "wires:",
        "wires:\n  material: copper_sfot",
        "7:13: wires.material: no such wire material (got 'copper_sfot'), shipped are copper_drawn, copper_soft, "
        "or give a path, did you mean 'copper_soft'?",
    ),
    "criterion": (
        "contact:",
        "failure: {criterion: span_strian}\ncontact:",
        "14:22: failure.criterion: unknown name (got 'span_strian'), known are "
        f"{', '.join(CRITERIA)}, did you mean 'span_strain'?",
    ),
    "criterion's parameter": (
        "contact:",
        "failure: {onsett: 3 %}\ncontact:",
        "14:11: failure.onsett: unknown key for calibrated, allowed are criterion, file, cyclic, "
        f"{', '.join(item.name for item in CRITERIA['calibrated'].parameters)}, did you mean 'onset'?",
    ),
    "criterion's number": (
        "contact:",
        "failure: {scale: 3 mm}\ncontact:",
        "14:18: failure.scale: the unit does not fit (got '3 mm'), expected a plain number or a share such as '7 %'",
    ),
    "solver": (
        "contact:",
        "solver: {linear: pardisso}\ncontact:",
        "14:18: solver.linear: unknown name (got 'pardisso'), known are auto, band, pardiso, superlu, "
        "did you mean 'pardiso'?",
    ),
}
SYNTAX = {
    "tab": ("  friction", "\tfriction", "15:1: a tab in the indentation (got 'friction: 0.3'), indent with spaces"),
    "colon": (
        "title: A case",
        "title: A: case",
        "2:9: not YAML: a colon where no key can stand (got 'title: A: case'), "
        "check the indentation and quote text that holds ': '",
    ),
    "bracket": (
        "80 mm]",
        "80 mm",
        "4:9: not YAML: the bracket opened here is not closed properly (got 'size: [100, 80 mm'), "
        "check commas and the closing bracket",
    ),
    "merge key": ("contact:", "<<: {a: 1}\ncontact:", "14:1: <<: merge keys are not part of YAML 1.2, use extends"),
    "python tag": (
        "A case",
        "!!python/name:os.system x",
        "2:8: title: the tag tag:yaml.org,2002:python/name:os.system is not allowed, write a plain value",
    ),
    "circular alias": (
        "[100, 80 mm]",
        "&a [*a, 3]",
        "4:9: fabric.size.0: this alias holds itself, write the value out",
    ),
}
MISTAKES = {**KEYS, **NUMBERS, **CHOICES, **NAMES, **SYNTAX}


@pytest.mark.parametrize(("old", "new", "message"), MISTAKES.values(), ids=MISTAKES)
def test_one_clear_message_at_its_place(write: Write, old: str, new: str, message: str) -> None:
    assert only(write(changed(old, new))) == f"case.yaml:{message}"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("wires:\n  loops: {spacing: 2 cm, length: 4}", "wires:\n  loops: {spacing: 4, length: 4}",
         "7:31: wires.loops.length: the loops overlap (got 4 mm), must be below spacing, which is 4 mm"),
        ("portion: quarter", "portion: quarter\n  warp_angle: 30", "6:15: fabric.warp_angle: a quarter needs the warp"
         " along x (got 30 deg), use 0 or set fabric.portion to whole"),
        ("radius: 15 mm", "radius: 15 mm\n  position: [5, 0]", "11:13: body.position: a quarter needs the body in the"
         " centre (got [5.0, 0.0]), use [0, 0] or set fabric.portion to whole"),
        ("type: sphere\n  radius: 15 mm", "type: capsule\n  radius: 9\n  length: 9\n  rotation: [0, 0, 30]",
         "12:13: body.rotation: a quarter needs a body turned by multiples of 90 deg (got [0.0, 0.0, 30.0]),"
         " set fabric.portion to whole"),
        ("type: sphere\n  radius: 15 mm", "type: elbow", "5:12: fabric.portion: a quarter needs a body symmetric about"
         " its planes (got elbow), set fabric.portion to whole"),
        ("contact:", "supports: {clamped: [x_min]}\ncontact:", "14:21: supports.clamped: a quarter needs opposite edges"
         " alike (got x_min without x_max), clamp both or set fabric.portion to whole"),
        ("steps: 20", "steps: 20\n  target: y_max",
         "14:11: motion.target: this edge is not clamped (got 'y_max'), clamped are x_min, x_max"),
        ("steps: 20", "steps: 20\n  target: x_min", "14:11: motion.target: a quarter mirrors this edge and would move"
         " both (got 'x_min'), set fabric.portion to whole"),
        ("body:\n  type: sphere\n  radius: 15 mm\n", "", "8:1: motion.target: there is no body to move (got 'body'),"
         " give the case a body or name a clamped edge"),
        ("steps: 20", "steps: 20\n  path: [10, 0, 30]",
         "14:9: motion.path: the path reaches 30 mm but total is 40 mm, make them equal"),
        ("steps: 20", "steps: 20\n  path: [40, 40]", "14:9: motion.path: the path stands still (got [40.0, 40.0]),"
         " each entry must differ from the one before"),
        ("spacing: 2 cm, length: 4", "spacing: 300, length: 200", "7:33: wires.loops.length: loops are longer than the"
         " specimen (got 200 mm), stay below 100 mm"),
    ],
)  # fmt: skip
def test_values_that_do_not_fit_together(write: Write, old: str, new: str, message: str) -> None:
    assert only(write(changed(old, new))) == f"case.yaml:{message}"


def test_a_body_beside_the_specimen_is_refused(write: Write) -> None:
    text = changed("portion: quarter", "portion: whole").replace("radius: 15 mm", "radius: 15\n  position: [60, 0]")
    assert "the body stands beside the specimen (got [60.0, 0.0]), stay within +-50, +-40 mm" in only(write(text))


def test_all_problems_come_at_once_in_the_order_of_the_file(write: Write) -> None:
    text = GOOD.replace("title: A case\n", "").replace("quarter", "quater").replace("15 mm", "-1").replace("0.3", "-1")
    text += "solvr: {}\n"
    keys = [line.split(": ")[1] for line in problems(write(text), "motion.steps=0")]
    assert keys == ["title", "fabric.portion", "body.radius", "contact.friction", "solvr", "motion.steps"]


def test_wrong_values_do_not_hide_what_does_not_fit_together(write: Write) -> None:
    text = changed("friction: 0.3", "friction: -1").replace("portion: quarter", "portion: quarter\n  warp_angle: 30")
    found = problems(write(text))
    assert [line.split(": ")[1] for line in found] == ["fabric.warp_angle", "contact.friction"]


def test_unknown_effects_are_refused_at_their_place(write: Write) -> None:
    text = GOOD + "effects:\n  - {id: clmp_slip, limit: 12 N/mm}\n"
    assert only(write(text)).startswith("case.yaml:17:10: effects.0.id: unknown name (got 'clmp_slip'), known are")


# files that are no case


def test_files_that_are_no_case(write: Write, tmp_path: Path) -> None:
    assert only(write("")) == "case.yaml:1:1: the file is empty, expected a mapping of keys such as 'title: ...'"
    assert only(write("# nothing\n")).startswith("case.yaml:1:1: the file is empty")
    assert only(write("- a\n- b\n")).startswith("case.yaml:1:1: the file holds a list, expected a mapping")
    assert only(write("some words\n")).startswith("case.yaml:1:1: the file holds plain text, expected a mapping")
    assert only(write("a: 1\nb: 2\n")).startswith("case.yaml:1:1: not such a file: no key is known (got a, b)")
    assert only(write(GOOD + "---\n" + GOOD)).startswith("case.yaml:16:1: more than one YAML document")
    assert only(write("a: " + "[" * 1200)).startswith("case.yaml: nested too deeply")
    (tmp_path / "case.yaml").write_bytes(GOOD.replace("A case", "Ein\nPrüfling").encode("latin-1"))
    assert only("case.yaml") == "case.yaml:3:3: not UTF-8 text (got byte 0xfc), save the file with encoding UTF-8"


def test_aliases_cannot_blow_up_the_reader(write: Write) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 10)]
    assert "too much nested data" in only(write("\n".join(lines)))


def test_a_byte_order_mark_and_windows_lines_are_read(tmp_path: Path) -> None:
    path = tmp_path / "windows.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert load_case(path).case.title == "A case"


def test_yaml_1_2_is_read_not_1_1(write: Write) -> None:
    text = changed("total: 40", "total: 4e1").replace("A case", "on").replace("friction: 0.3", "friction: 03")
    case = load_case(write(text)).case
    assert case.motion.total == 40.0
    assert case.title == "on"
    assert case.contact.friction == 3.0


# where a case comes from


def test_names_of_shipped_cases_are_found_from_any_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert load_case("punch").case.motion.total == 52.5


def test_a_file_in_the_way_does_not_hide_a_shipped_case(write: Write) -> None:
    write(GOOD, "punch")
    assert load_case("punch").case.title != "A case"
    assert load_case("./punch").case.title == "A case"


def test_missing_files_and_folders(write: Write, tmp_path: Path) -> None:
    write(GOOD, "my_case.yaml")
    assert "no such case (got 'pnch')" in only("pnch")
    assert only("pnch").endswith("did you mean 'punch'?")
    assert only("my_csae.yaml").endswith("did you mean 'my_case.yaml'?")
    assert only("punch.yaml").endswith("did you mean 'punch'?")
    assert only("nowhere/case.yaml").startswith(f"no such folder (got {'nowhere'!r})")
    assert only(str(tmp_path)).startswith("this is a folder, not a case file")
    assert only(str(tmp_path)).endswith("it holds my_case.yaml")


# extends


def test_a_case_extends_another(write: Write) -> None:
    write(GOOD, "base.yaml")
    name = write("extends: base.yaml\ntitle: B\nmotion: {total: 20}\nwires: null\n")
    case = load_case(name).case
    assert (case.title, case.motion.total, case.motion.steps, case.wires) == ("B", 20.0, 20, None)


def test_a_case_extends_a_shipped_one_and_chains(write: Write) -> None:
    write("extends: punch\nmotion: {total: 30}\n", "base.yaml")
    case = load_case(write("extends: base.yaml\ntitle: Mine\n")).case
    assert (case.title, case.motion.total, case.fabric.coarsening) == ("Mine", 30.0, 19.5)


def test_what_describes_the_other_case_does_not_describe_this_one(write: Write) -> None:
    assert load_case("punch").case.description
    assert not load_case(write("extends: punch\nmotion: {total: 30}\n")).case.description
    assert load_case(write("extends: punch\ndescription: My own\n")).case.description == "My own"


def test_another_body_replaces_the_one_it_extends(write: Write) -> None:
    case = load_case(write("extends: punch\nbody: {type: ellipsoid, semi_axes: [15, 15, 10]}\n")).case
    assert isinstance(case.body, Ellipsoid)
    assert isinstance(load_case(write("extends: punch\nbody: {radius: 10}\n")).case.body, Sphere)


def test_problems_point_to_the_file_in_which_the_key_stands(write: Write) -> None:
    write(changed("friction: 0.3", "fricton: 0.3"), "base.yaml")
    found = problems(write("extends: base.yaml\nmotion: {totl: 20}\n"))
    assert [line.split(": ")[:2] for line in found] == [
        ["case.yaml:2:10", "motion.totl"],
        ["base.yaml:15:3", "contact.fricton"],
    ]


def test_a_wrong_value_that_is_replaced_is_no_problem(write: Write) -> None:
    write(changed("friction: 0.3", "friction: -1"), "base.yaml")
    assert load_case(write("extends: base.yaml\ncontact: {friction: 0}\n")).case.contact.friction == 0.0


def test_circles_and_missing_parents(write: Write) -> None:
    write("extends: case.yaml\n", "base.yaml")
    message = only(write("extends: base.yaml\n"))
    assert message.startswith("base.yaml:1:10: extends: the files extend each other in a circle (case.yaml -> base.y")
    assert only(write("extends: pnch\n")).startswith("case.yaml:1:10: extends: no such case (got 'pnch')")
    assert only(write("extends: [a]\n")).startswith("case.yaml:1:10: extends: not a path or shipped case (got ['a'])")


def test_paths_are_relative_to_the_file_they_stand_in(write: Write, tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    fabric = (catalogue.FOLDERS["fabric"] / "estimated_low.yaml").read_text(encoding="utf-8")
    write(fabric, "sub/mine.yaml")
    write(changed("portion: quarter", "set: ./mine.yaml"), "sub/base.yaml")
    case = load_case(write("extends: sub/base.yaml\n")).case
    assert Path(case.fabric.set) == tmp_path / "sub" / "mine.yaml"


def test_paths_in_overrides_are_relative_to_the_working_folder(write: Write, tmp_path: Path) -> None:
    write("solid", "arm.stl")
    text = changed("portion: quarter", "portion: whole")
    options = ["body={type: mesh, file: arm.stl}"]
    case = load_case(write(text), overrides=options).case
    assert case.body is not None
    assert case.body.model_dump()["file"] == str(tmp_path / "arm.stl")
    assert "no such file" in only("case.yaml", "body={type: mesh, file: leg.stl}")


# overrides


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("contact.fricton=0.3", f"contact.fricton: {CONTACT}, did you mean"
         " 'friction'?"),
        ("motion.total=abc", "motion.total: text, not a number (got 'abc'), expected a length in mm, plain or with a"
         " unit such as '30 mm'"),
        ("contact.friction", "not an override, write --set key.path=value such as --set contact.friction=0.3"),
        ("=3", "not an override, write --set key.path=value such as --set contact.friction=0.3"),
        ("wires=", "no value given, write null to switch something off"),
        ("title.x=1", "title: there are no keys below it (it is 'A case'), set title itself"),
        ("fabric.size.x=1", "fabric.size: not an item of the list (got 'x'), it has 2 items, counted from 0"),
        ("fabric.size.2=1", "fabric.size: wrong number of items (got [100, '80 mm', 1]), expected 2"),
        ("fabric.size.7=1", "fabric.size: not an item of the list (got '7'), it has 2 items, counted from 0"),
        ("extends=punch", "extends: extends cannot be set, give the other case itself"),
    ],
)  # fmt: skip
def test_overrides_that_are_wrong_are_named(write: Write, option: str, message: str) -> None:
    assert only(write(GOOD), option) == f"--set {option}: {message}"


def test_overrides_reach_every_place(write: Write) -> None:
    options = ["motion.total=3 cm", "wires.loops.slack=5 %", "fabric.size.1=120", "contact.friction=stick", "title='7'"]
    loaded = load_case(write(GOOD), overrides=options)
    case = loaded.case
    assert case.wires is not None
    assert case.wires.loops is not None
    assert (case.motion.total, case.wires.loops.slack, case.fabric.size) == (30.0, 0.05, (100.0, 120.0))
    assert (case.contact.friction, case.title) == ("stick", "7")
    assert loaded.overrides == tuple(options)
    assert loaded.source_text == GOOD


def test_an_override_sets_a_section_that_was_not_there(write: Write) -> None:
    name = write(changed("wires:\n  loops: {spacing: 2 cm, length: 4}\n", "wires: null\n"))
    case = load_case(name, overrides=["wires.every_warp_yarns=30"]).case
    assert case.wires is not None
    assert case.wires.every_warp_yarns == 30.0
    assert load_case(name, overrides=["wires={}"]).case.wires is not None
    assert load_case(write(GOOD), overrides=["wires=null"]).case.wires is None


def test_an_override_replaces_a_section_as_a_whole(write: Write) -> None:
    case = load_case(write(GOOD), overrides=["body={type: ellipsoid, semi_axes: [9, 9, 5]}"]).case
    assert isinstance(case.body, Ellipsoid)


# identity


def test_the_hash_is_that_of_the_effective_case(write: Write) -> None:
    plain = load_case(write(GOOD)).sha256
    assert load_case(write(GOOD.replace("15 mm", "1.5 cm") + "# a comment\n")).sha256 == plain
    assert load_case("case.yaml", overrides=["motion.total=40 mm"]).sha256 == plain
    assert load_case("case.yaml", overrides=["motion.total=41 mm"]).sha256 != plain
    assert load_case(write("extends: case.yaml\n", "child.yaml")).sha256 == plain
    assert as_loaded(load_case("case.yaml").case).sha256 == plain


def test_the_hash_follows_the_content_of_files_not_their_place(write: Write, tmp_path: Path) -> None:
    fabric = (catalogue.FOLDERS["fabric"] / "estimated_low.yaml").read_text(encoding="utf-8")
    write(fabric, "a.yaml")
    write(fabric, "b.yaml")
    write(fabric.replace("thickness: 0.35", "thickness: 0.36"), "c.yaml")
    hashes = [load_case(write(changed("portion: quarter", f"set: {name}.yaml"))).sha256 for name in "abc"]
    assert hashes[0] == hashes[1] != hashes[2]


def test_problems_found_later_are_placed_by_their_key(write: Write) -> None:
    loaded = load_case(write(GOOD), overrides=["motion.total=30"])
    with pytest.raises(BadInput) as refused, loaded.locating():
        raise BadInput([Problem("too big", key="body.radius"), Problem("too far", key="motion.total"), Problem("else")])
    assert [str(problem) for problem in refused.value.problems] == [
        "case.yaml:10:11: body.radius: too big",
        "--set motion.total=30: motion.total: too far",
        "else",
    ]


def test_cases_made_in_python_are_checked_too(write: Write) -> None:
    data = load_case(write(GOOD)).case.model_dump()
    data["fabric"]["warp_angle"] = 30.0
    with pytest.raises(ValueError, match="a quarter needs the warp along x"):
        Case.model_validate(data)
    assert case_sha256(load_case("case.yaml").case) == load_case("case.yaml").sha256


def test_what_is_wrong_with_an_option_is_not_blamed_on_the_case() -> None:
    loaded = load_case("punch")
    with pytest.raises(BadInput) as caught, loaded.locating():
        raise BadInput.of("no scheduler answers", key="--scheduler")
    assert str(caught.value) == "--scheduler: no scheduler answers"
    with pytest.raises(BadInput, match=r"punch\.yaml:\d+:\d+: motion\.total: too far"), loaded.locating():
        raise BadInput.of("too far", key="motion.total")
