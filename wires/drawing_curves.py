"""The curves of a DXF drawing as chords, and what no drawing of a fabric has: refused before it is drawn in pieces.

A curve far from the origin, of an enormous radius or with numbers that are none is cut into chords without end, so that
its own numbers are looked at first.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Any

import numpy as np

from etextile.types import Array


CHORD_MM = 0.02
"""Distance of a curve from its chords."""
FURTHEST_MM = 1e5
"""Coordinates beyond this are of no fabric."""
LARGEST_MM = 1e7
"""Radius beyond which an arc is none: over a metre it leaves its chord by less than a CHORD_MM."""
FLAT_MM = 0.01
"""A drawing lies in a plane of constant height, up to this."""
MOST_VERTICES = 5000
MOST_CONTROLS = 5000


class NoCurve(Exception):
    """An entity that cannot be drawn; the message says why."""


def points_of(entity: Any, scale: float) -> Array:
    """Return the vertices (n, 2) of a line in mm: as they were written where no piece is an arc; raises NoCurve."""
    _refuse_absurd(entity, scale)
    chain = _own_vertices(entity) if _is_straight(entity) else _chords(entity, scale)
    if len(chain) > MOST_VERTICES:
        raise NoCurve(
            f"is drawn in more than {MOST_VERTICES} pieces of {CHORD_MM} mm accuracy, at most so many are taken"
        )
    if len(chain) and np.ptp(chain[:, 2]) * scale > FLAT_MM:
        low, high = chain[:, 2].min() * scale, chain[:, 2].max() * scale
        raise NoCurve(f"leaves the plane of the drawing (z from {low:g} to {high:g} mm), draw the fabric flat")
    return np.asarray(np.round(chain[:, :2] * scale, 9) if not _is_straight(entity) else chain[:, :2] * scale)


def place_of_circle(entity: Any, scale: float) -> tuple[float, float]:
    """Return the centre of a circle in mm, also of one that was mirrored; raises NoCurve."""
    _refuse_absurd(entity, scale)
    centre = entity.ocs().to_wcs(entity.dxf.center)
    return round(float(centre.x) * scale, 9), round(float(centre.y) * scale, 9)


def place_of_point(entity: Any, scale: float) -> tuple[float, float]:
    """Return the place of a point in mm; raises NoCurve."""
    _refuse_absurd(entity, scale)
    place = entity.dxf.location
    return round(float(place.x) * scale, 9), round(float(place.y) * scale, 9)


def _is_straight(entity: Any) -> bool:
    """Tell whether an entity's own vertices are its line."""
    kind = entity.dxftype()
    flat = tuple(entity.dxf.get("extrusion", (0.0, 0.0, 1.0))) == (0.0, 0.0, 1.0)
    return kind == "LINE" or (kind == "LWPOLYLINE" and flat and not entity.has_arc)


def _own_vertices(entity: Any) -> Array:
    """Return the vertices (n, 3) of a straight line or polyline as they were written."""
    if entity.dxftype() == "LINE":
        return np.array([tuple(entity.dxf.start), tuple(entity.dxf.end)])
    own = np.array([(x, y, 0.0) for x, y in entity.get_points("xy")]).reshape(-1, 3)
    return np.concatenate([own, own[:1]]) if entity.is_closed else own


def _chords(entity: Any, scale: float) -> Array:
    """Return the vertices (n, 3) of a curve as chords within CHORD_MM, one more than MOST_VERTICES at most."""
    from ezdxf.lldxf.const import DXFError
    from ezdxf.path import make_path

    try:
        chords = make_path(entity).flattening(CHORD_MM / scale)
        return np.array([tuple(point) for point in islice(chords, MOST_VERTICES + 1)]).reshape(-1, 3)
    except (DXFError, ValueError, TypeError, IndexError, ArithmeticError, AttributeError, RecursionError) as error:
        raise NoCurve(f"cannot be drawn ({' '.join(str(error).split())[:80]}), draw it again") from None


def _refuse_absurd(entity: Any, scale: float) -> None:
    """Raise NoCurve for numbers that are none, places and radii of no fabric, and curves of too many points."""
    own = np.array(list(_numbers(entity)))
    if not np.isfinite(own).all():
        raise NoCurve("has a number that is none (nan or infinite), draw it again")
    places = np.array(list(islice(_places(entity), MOST_CONTROLS + 1))).reshape(-1, 3)
    if len(places) > MOST_CONTROLS:
        raise NoCurve(f"has more than {MOST_CONTROLS} vertices, at most so many are taken")
    if not np.isfinite(places).all():
        raise NoCurve("has a coordinate that is no number (nan or infinite), draw it again")
    furthest = scale * float(np.abs(places).max(initial=0.0))
    if entity.dxftype() not in ("ARC", "ELLIPSE", "CIRCLE") and furthest > FURTHEST_MM:
        raise NoCurve(f"reaches to {furthest:.4g} mm, no fabric is larger than {FURTHEST_MM:g} mm: is the unit right?")
    radius = scale * max(_radii(entity), default=0.0)
    if max(radius, furthest) > LARGEST_MM:
        raise NoCurve(f"has a radius or centre of {max(radius, furthest):.4g} mm, at most {LARGEST_MM:g} mm are taken")


def _numbers(entity: Any) -> Iterator[float]:
    """Yield the plain numbers of an entity: radii, angles, ratios, knots, weights, bulges."""
    for value in entity.dxf.all_existing_dxf_attribs().values():
        if isinstance(value, int | float):
            yield float(value)
    if entity.dxftype() == "SPLINE":
        yield from (float(value) for value in (*entity.knots, *entity.weights))
    yield from _bulges(entity)


def _bulges(entity: Any) -> Iterable[float]:
    """Return the bulges of a polyline: the tangent of a quarter of the angle of each arc in it."""
    if entity.dxftype() == "LWPOLYLINE":
        return [float(point[0]) for point in entity.get_points("b")]
    if entity.dxftype() == "POLYLINE":
        return [float(vertex.dxf.get("bulge", 0.0)) for vertex in entity.vertices]
    return []


def _places(entity: Any) -> Iterator[tuple[float, float, float]]:
    """Yield the places of an entity: ends, centres, vertices, control points."""
    for name, value in entity.dxf.all_existing_dxf_attribs().items():
        if name != "extrusion" and hasattr(value, "xyz"):
            yield tuple(value.xyz)
    if entity.dxftype() == "SPLINE":
        yield from (tuple(float(x) for x in point) for point in (*entity.control_points, *entity.fit_points))  # type: ignore[misc]
    elif entity.dxftype() == "LWPOLYLINE":
        yield from ((x, y, 0.0) for x, y in entity.get_points("xy"))
    elif entity.dxftype() == "POLYLINE":
        yield from (tuple(vertex.dxf.location.xyz) for vertex in entity.vertices)


def _radii(entity: Any) -> Iterator[float]:
    """Yield the radii of an entity in its own unit."""
    if entity.dxftype() in ("ARC", "CIRCLE"):
        yield abs(float(entity.dxf.radius))
    for bulge, chord in zip(_bulges(entity), _chord_lengths(entity), strict=False):
        if bulge:
            yield chord * (1.0 + bulge * bulge) / (4.0 * abs(bulge))


def _chord_lengths(entity: Any) -> Iterator[float]:
    """Yield the distance from each vertex of a polyline to the next, that from the last to the first at the end."""
    places = np.array(list(_places(entity))).reshape(-1, 3)[:, :2]
    yield from np.linalg.norm(np.roll(places, -1, axis=0) - places, axis=1).tolist()
