"""Names of columns with their units, as machines write them: `Force standard` over `N`, `Load (kN)`, `strain [%]`."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass, replace
from functools import lru_cache

from etextile.units import to_number


WORDS = {
    name: frozenset(words.split())
    for name, words in {
        "force": "force load kraft last charge effort fuerza forza carico kracht kuorma нагрузка усилие сила "
        "siła sila forca kuvvet yuk voima ero zatizeni obciazenie carga belastning 载荷 荷载 荷重 負荷 "
        "试验力 試験力 力 하중 힘",
        "displacement": "displacement extension crosshead traverse stroke position travel weg verformung ausdehnung "
        "verlangerung elong ext course deplacement allongement fleche desplazamiento spostamento corsa elongation "
        "deformation verplaatsing distance перемещение удлинение 位移 变位 変位 変位量 行程 伸长 伸び 变形 ストローク "
        "przemieszczenie wydłuzenie deslocamento uzama forskjutning forskydning forskyvning siirtyma posunuti posuv "
        "prodlouzeni elmozdulas 변위 신장",
        "strain": "strain dehnung elongation elong deformation deformacion deformazione rek деформация "
        "odkształcenie tojning venyma deformace 应变 变形 ひずみ 歪 변형률",
        "stress": "stress spannung contrainte sforzo esfuerzo tension spanning напряжение naprezenie tensao gerilme "
        "napeti feszultseg 应力 応力 응력",
    }.items()
}
"""How machines of several languages call what a tensile test measures, without accents; units tell the rest."""
COMPOUND = ("kraft", "weg", "dehnung", "spannung", "longation")
"""Last parts of the compound words of German (Stempelweg, Standardkraft), which mean what the last part does."""
_OTHERWISE = (
    "vorkraft preload rate speed velocity vitesse geschwindigkeit true wahre vraie energy work time zeit temps max "
    "temperature"
)
OTHERWISE = frozenset(_OTHERWISE.split())
"""Words that make another quantity of it (strain rate, true stress)."""
ELSEWHERE = ("速", "时间", "時間", "最大", "속도", "시간", "최대", "скорость", "максимальн", "время")
"""The same in scripts whose words are not told apart."""
EASTERN = re.compile(r"[\u3040-\u30ff\u4e00-\u9fff\uac00-\ud7a3]")
PLAIN = {"%": "%", "percent": "%", "pct": "%", "prozent": "%", "-": "", "1": "", "mm/mm": "", "m/m": "", "in/in": ""}
ALIASES = {
    "Nmm": "N*mm",
    "Nm": "N*m",
    "kp": "kgf",
    "gf": "gram_force",
    "MPA": "MPa",
    "cNcm": "cN*cm",
    "gfcm": "gram_force*cm",
} | dict.fromkeys(("Sec", "SEC"), "s")
ALIASES |= {
    "MM": "mm",
    "KN": "kN",
    "мм": "mm",
    "Н": "N",
    "кН": "kN",
    "МПа": "MPa",
    "毫米": "mm",
    "牛": "N",
    "牛顿": "N",
}
ALIASES |= {"千牛": "kN", "兆帕": "MPa", "с": "s", "秒": "s"}
WIDE = str.maketrans("（）［］／％，：　", "()[]/%,: ")
"""Brackets and marks of Eastern typesetting."""
MICRO = frozenset(("ustrain", "µstrain", "microstrain", "µε", "με", "um/m", "µm/m"))
"""Millionths."""
_SHORT = "m cm mm um µm μm nm in inch ft N kN mN cN daN MN lbf kgf gf MPa kPa Pa GPa hPa psi ksi bar mbar"
SHORT = frozenset((*_SHORT.split(), "percent", "pct", "deg", "rad", "Nmm", "Nm", "s"))
"""Units that may stand behind an underscore (`force_kN`)."""
RATIO = re.compile(r"(.+)_(1|N|cN|Nm|Nmm|cNcm|gfcm)_per_(m|cm|mm)")
"""Quotients that may stand behind an underscore (`moment_Nm_per_m`)."""
LAST_WORDS = SHORT - {"in", "m", "s"} | {"%"}
"""Units that may end a name without any mark (`Displacement mm`)."""


@dataclass(frozen=True)
class Label:
    """A column's head: the text, the name without the unit, the unit ('' when it has one that is a plain number)."""

    text: str
    name: str
    unit: str | None

    @property
    def shown(self) -> str:
        """Name and unit for people."""
        return repr(self.name) if self.unit is None else f"{self.name!r} in {self.unit or 'plain numbers'}"


def split_name(name: str) -> tuple[str, str | None]:
    """Return quantity and unit of `force_kN` and `curvature_1_per_m`; None for a name without a unit behind it."""
    ratio = RATIO.fullmatch(name)
    if ratio:
        over = ALIASES.get(ratio[2], ratio[2])
        return ratio[1], f"{over}/{ratio[3]}"
    stem, mark, tail = name.rpartition("_")
    return (stem, tail) if mark and stem and tail in SHORT else (name, None)


def label_of(text: str, unit_cell: str = "") -> Label:
    """Return the label of a head cell and the cell of a units row below it."""
    clean = " ".join(text.split())
    below = bare(unit_cell)
    if unit_cell and is_unit(below):
        return Label(clean, clean, below)
    return replace(_named(clean.translate(WIDE)), text=clean)


def _named(clean: str) -> Label:
    """Return the label of a name that may hold its unit."""
    for pattern in (r"(.+?)\s*[\[(<]([^\])>]*)[\])>]", r"(.+?)\s+/\s*(\S+)", r"(.+?)\s+in\s+(\S+)", r"(.+?),\s*(\S+)"):
        match = re.fullmatch(pattern, clean)
        if match and is_unit(match[2].strip()):
            return Label(clean, match[1].strip(), match[2].strip())
    match = re.fullmatch(r"(.+)\s(\S+)", clean)
    if match and match[2] in LAST_WORDS:
        return Label(clean, match[1], match[2])
    match = re.fullmatch(r"([^\s/]+)/([^\s/]+)", clean)
    if match and is_unit(match[2]) and not is_unit(match[1]):
        return Label(clean, match[1], match[2])
    stem, unit = split_name(clean)
    return Label(clean, stem, unit)


def bare(cell: str) -> str:
    """Return the unit in a cell of a units row, without its brackets."""
    return cell.translate(WIDE).strip().strip("()[]<>").strip()


@lru_cache(maxsize=512)
def is_unit(text: str) -> bool:
    """Tell whether a text is a unit (a plain number's dash and per cent included)."""
    text = text.translate(WIDE)
    if text in PLAIN or text in SHORT or text in ALIASES or text in MICRO:
        return True
    if not text or len(text) > 20 or text[0].isdigit() or " " in text:
        return False
    return any(_factor(text, target) is not None for target in ("mm", "N", "MPa", "s", "deg", "N*mm", "1/s", "1/m", ""))


@lru_cache(maxsize=512)
def _factor(unit: str, target: str) -> float | None:
    """Return the factor from a unit to the wanted one, None when they do not fit."""
    if unit in MICRO:
        return 1e-6 if target == "" else None
    spelled = unit.lower() if len(unit) > 3 and unit.isalpha() and unit.istitle() else unit
    written = PLAIN.get(unit, ALIASES.get(unit, spelled))
    wanted = ALIASES.get(target, target)
    if written == wanted:
        return 1.0
    try:
        return to_number(f"1 {written}", wanted) if written else (1.0 if not wanted else None)
    except ValueError:
        return None


def factor(unit: str, target: str) -> float | None:
    """Return what a value in `unit` is multiplied by to be in `target` ('' for plain numbers); None: does not fit."""
    return _factor(bare(unit), target)


def means(name: str, quantity: str) -> bool:
    """Tell whether a column's name is a word for force, displacement, strain or stress in one of several languages."""
    known = WORDS.get(quantity, frozenset())
    if any(part in name.lower() for part in ELSEWHERE):
        return False
    if EASTERN.search(name):
        return _ends_in(name, known, {word for words in WORDS.values() for word in words})
    flat = unicodedata.normalize("NFKD", name.replace("ß", "ss")).lower()
    flat = "".join(char for char in flat if not unicodedata.combining(char))
    words = set(re.findall(r"[^\W\d_]+", flat))
    parts = {end for word in words for end in COMPOUND if word.endswith(end)}
    return not words & OTHERWISE and bool((words | parts) & known)


def _ends_in(name: str, known: frozenset[str], every: set[str]) -> bool:
    """Tell whether the longest word within a name without spaces is one of the quantity's."""
    found = [word for word in every if EASTERN.match(word) and word in name]
    longest = max(map(len, found), default=0)
    return any(word in known for word in found if len(word) == longest)
