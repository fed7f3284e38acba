"""One place for how everything looks: colours, markers, fonts and number formats of all maps and plots.

The four states of a loop run from light to dark and each has its own marker, so that they are told apart in grey print
and by colour-blind readers. Strain is a ramp of blues from light to dark in equal steps of lightness: unstrained fabric
looks like cloth, no state shares a hue with it, and in grey print it is a plain ramp.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


if TYPE_CHECKING:
    from matplotlib.axis import Axis
    from matplotlib.colors import Colormap, Normalize


@dataclass(frozen=True)
class StateStyle:
    """How a state is drawn: fill colour, matplotlib marker, marker size relative to the others, and its legend text."""

    name: str
    colour: str
    marker: str
    scale: float
    label: str


STATES = (
    StateStyle("intact", "#ffffff", "o", 0.9, "intact"),
    StateStyle("plastic", "#f2b632", "s", 0.95, "plastic, conducts"),
    StateStyle("partial", "#d5502a", "^", 1.25, "partly broken"),
    StateStyle("open", "#3b0a3f", "X", 1.35, "open circuit"),
)
"""In the order of `etextile.vocabulary.STATES`."""

FOLDED = StateStyle("folded", "#c3cad2", "D", 0.9, "in folds: undetermined")
"""How a page draws a loop that stands in a fold and had not failed before: neither whole nor broken."""
EDGE = "#1a1a1a"
TEXT = "#1f2328"
QUIET = "#6b7280"
FAINT = "#d9dde3"
BODY = "#a9adb3"
FABRIC = "#f3f1ec"
CONTACT = "#dcd6c8"
WIRE = "#20242a"
SOUND_WIRE = "#8d949d"
"""Wires with nothing worse than intact loops: white would be lost on light fabric."""
CLAMP = "#4b5158"
STRAIN_RAMP = ("#edf5f7", "#b5dff0", "#86c7e6", "#61add7", "#4b92c1", "#4378a4", "#405e82", "#334667", "#242f4f")
"""Strain from none to most: equal steps of CIE lightness from 96 to 20, hue from 225 to 285 degrees."""

PROBABILITY_RAMP = tuple(look.colour for look in STATES)
"""Probability from 0 to 1, placed evenly in lightness: the colours of the four states."""

SERIES = ("#1f4e79", "#d5502a", "#5b8c5a", "#8a5fa8", "#b8860b", "#4aa3a3")
"""Colours of curves, dark enough for grey print; used with different line styles."""

DASHES: tuple[str | tuple[float, tuple[float, ...]], ...] = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (1, 1)))

_FONT: Any = {
    "text.parse_math": False,
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 10.0,
    "axes.titlesize": 12.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 10.0,
    "axes.labelsize": 10.0,
    "axes.labelcolor": TEXT,
    "axes.edgecolor": QUIET,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "text.color": TEXT,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "xtick.labelcolor": TEXT,
    "ytick.labelcolor": TEXT,
    "legend.frameon": False,
    "legend.fontsize": 9.5,
    "grid.color": FAINT,
    "grid.linewidth": 0.7,
    "hatch.linewidth": 0.7,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.hashsalt": "etextile",
}


@contextmanager
def drawing() -> Iterator[None]:
    """Draw with the fonts and lines of the project; matplotlib's own settings are as before afterwards.

    Letters that the font of the pictures does not have are drawn as boxes without a warning; pages show them.
    """
    import matplotlib as mpl

    with mpl.rc_context(_FONT), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


def plain_decades(axis: Axis) -> None:
    """Write the numbers of a logarithmic axis as numbers: pictures read no formulas, which matplotlib would set."""
    from matplotlib.ticker import FuncFormatter, LogFormatter

    axis.set_major_formatter(
        FuncFormatter(lambda value, _: f"{value:,.0f}".replace(",", " ") if value >= 1.0 else f"{value:g}")
    )
    axis.set_minor_formatter(LogFormatter(labelOnlyBase=False, minor_thresholds=(1.0, 0.4)))


def strain_colours() -> Colormap:
    """Return the colour map of all strains."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("etextile strain", STRAIN_RAMP, N=512)


def probability_colours() -> Colormap:
    """Return the colour map of probabilities, even in lightness between the colours of the states."""
    from matplotlib.colors import LinearSegmentedColormap

    lightness = np.array([luminance(colour) for colour in PROBABILITY_RAMP])
    places = (lightness[0] - lightness) / (lightness[0] - lightness[-1])
    stops = list(zip(places.tolist(), PROBABILITY_RAMP, strict=True))
    return LinearSegmentedColormap.from_list("etextile probability", stops, N=512)


def probability_ramp() -> list[str]:
    """Return the colours of the probabilities 0, 1/16, ... 1, as text."""
    from matplotlib.colors import to_hex

    return [to_hex(probability_colours()(share)) for share in np.linspace(0.0, 1.0, 17)]


def strain_scale(values: ArrayLike) -> Normalize:
    """Return the colour scale of a strain: from 0 to the largest value, rounded up to 1, 2 or 5 of its power of ten."""
    from matplotlib.colors import Normalize

    return Normalize(0.0, round_up(float(np.max(np.asarray(values, dtype=np.float64), initial=0.0))))


def round_up(value: float) -> float:
    """Return the next of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten that is not less; 0.01 for none."""
    if value <= 0.0:
        return 0.01
    power = 10.0 ** np.floor(np.log10(value))
    steps = np.array([1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0])
    return float(power * steps[np.searchsorted(steps, value / power - 1e-9)])


def contrast(ink: str, ground: str) -> float:
    """Return the contrast of two colours after WCAG 2, from 1 to 21; letters of a page need 4.5 (level AA)."""
    light, dark = sorted((_share_of_light(ink), _share_of_light(ground)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def _share_of_light(colour: str | tuple[float, float, float]) -> float:
    """Return the relative luminance Y (0 to 1) of a colour."""
    from matplotlib.colors import to_rgb

    rgb: NDArray[np.float64] = np.asarray(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


def luminance(colour: str | tuple[float, float, float]) -> float:
    """Return the CIE lightness L* (0 to 100) of a colour: what is left of it in grey print."""
    y = _share_of_light(colour)
    return 116.0 * y ** (1 / 3) - 16.0 if y > 0.008856 else 903.3 * y


def outline(look: StateStyle) -> str:
    """Return the colour of a marker's edge: dark around light markers, white around dark ones."""
    return EDGE if luminance(look.colour) > 40.0 else "#ffffff"


def wire_colour(state: int) -> str:
    """Return the colour of a wire by the state of its worst loop."""
    return SOUND_WIRE if state == 0 else STATES[state].colour
