"""Bodies of a user's own: a function in a Python file, or in an installed package, that returns a body.

    def jar(*, radius, neck=12.0):
        \"\"\"A jar lying on its side.\"\"\"
        ...
        return et.implicit_body(gap, low=(-60, -40, -40), high=(60, 40, 40))

The keywords are the dimensions a case gives (mm; deg where the name ends in `_deg`). Whatever has the methods of
`etextile.contact.body.Body` will do; `implicit_body` makes one from a signed distance alone. A package offers a
function under the entry point group `etextile.bodies`.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from etextile.contact.body import Body
from etextile.contact.implicit import Implicit, implicit_mesh
from etextile.contact.mesh import MeshBody, checked, mesh_body
from etextile.errors import BadInput, Problem, nearest
from etextile.plugins import installed, own_objects, run_file
from etextile.types import Array
from etextile.units import to_number


GROUP = "etextile.bodies"
METHODS = ("distance", "surface", "bounds", "support")
LARGEST_MM = 2000.0
SAMPLES = 64
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
"""Directions in which a body has ended, by 0.6 of its greatest extent from the middle of its box."""
STEP_MM, TOLERANCE = 1e-3, 0.05
"""Step of the differences by which a normal is checked, and the error above which it is refused."""


def own_body(*, shape: str, file: str | None = None, dimensions: Mapping[str, Any] = MappingProxyType({})) -> Body:
    """Return the body that the function `shape` makes of `dimensions`; raises BadInput for anything unusable."""
    build = body_function(shape, file)
    numbers = checked_dimensions(build, shape, dimensions)
    place = shape if file is None else Path(file).name
    try:
        body = build(**numbers)
    except BadInput as error:
        told = (
            item
            if item.file or item.key
            else replace(item, message=f"{place}: {shape}: {item.message}", key="body.shape")
            for item in error.problems
        )
        raise BadInput(told) from error
    except Exception as error:  # foreign code may raise anything
        raise BadInput.of(f"{place}: {shape} fails: {type(error).__name__}: {error}", key="body.shape") from error
    require_body(body, f"{place}: {shape}")
    return body


def implicit_body(
    gap: Implicit, *, low: Sequence[float], high: Sequence[float], edge: float = 3.0, grid_spacing: float | None = None
) -> MeshBody:
    """Return the body where `gap` is negative.

    gap: function of points (n, 3) mm to values (n,), negative inside and near the surface close to a distance in mm;
    low, high: corners of a box around the body; edge: length of the edges of its mesh, mm, details below twice that are
    lost. Raises BadInput when nothing closed lies inside the box.
    """
    bounds = np.array([low, high], dtype=float)
    if bounds.shape != (2, 3) or not np.isfinite(bounds).all() or np.any(bounds[1] <= bounds[0]):
        raise BadInput.of(f"low and high must be corners of a box, three numbers each (got {list(low)}, {list(high)})")
    cells = np.prod(np.ptp(bounds, axis=0) / edge + 5.0)
    if not edge > 0.0 or cells > 2e7:
        raise BadInput.of(f"a box of {np.ptp(bounds, axis=0)} mm has {cells:.1e} cells of {edge:g} mm, at most 2e7")
    values = np.asarray(gap(bounds))
    if values.shape != (2,):
        raise BadInput.of(f"gap must return one value per point, shape (n,) for points (n, 3) (got {values.shape})")
    vertices, faces = implicit_mesh(gap, bounds, edge=edge)
    if len(faces) < 4:
        raise BadInput.of("gap is nowhere negative inside of the box low .. high, so there is no body")
    vertices, faces, _ = checked(vertices, faces, name="the body's zero level", scale=1.0)
    return mesh_body(vertices, faces, grid_spacing=grid_spacing)


def body_function(shape: str, file: str | None) -> Callable[..., Body]:
    """Return the function `shape` of a file, or of an installed package; raises BadInput that lists what there is."""
    if file is None:
        found = {name: item for name, _, item in installed(GROUP)}
        where = f"installed packages (entry points {GROUP})"
    else:
        module = run_file(file, key="body.file")
        found = {item.__name__: item for item in own_objects(module) if inspect.isfunction(item)}
        where = Path(file).name
    if shape in found:
        function: Callable[..., Body] = found[shape]
        return function
    known = ", ".join(found) or "none"
    raise BadInput.of(f"{where}: no function {shape!r}, found: {known}{nearest(shape, found)}", key="body.shape")


def checked_dimensions(build: Callable[..., Body], shape: str, given: Mapping[str, Any]) -> dict[str, float]:
    """Return the dimensions as numbers, mm or deg; raises BadInput with all that are unknown, missing or no numbers."""
    known = {item.name: item for item in inspect.signature(build).parameters.values()}
    key = "body.dimensions"
    problems = [
        Problem(
            f"unknown dimension of {shape}, known are {', '.join(known) or 'none'}{nearest(name, known)}",
            key=f"{key}.{name}",
        )
        for name in given
        if name not in known
    ]
    lacking = [name for name, item in known.items() if item.default is inspect.Parameter.empty and name not in given]
    if lacking:
        problems.append(Problem(f"{shape} needs {', '.join(lacking)}", key=key))
    numbers = {}
    for name in set(given) & set(known):
        try:
            numbers[name] = to_number(given[name], "deg" if name.endswith("_deg") else "mm")
        except ValueError as error:
            problems.append(Problem(str(error), key=f"{key}.{name}"))
    if problems:
        raise BadInput(problems)
    return numbers


def require_body(body: Any, place: str) -> None:
    """Raise BadInput unless `body` has the methods of a body and its distance is one, with its true normal."""
    lacks = [name for name in METHODS if not callable(getattr(body, name, None))]
    if lacks:
        raise BadInput.of(f"{place} returns {type(body).__name__}, which lacks {', '.join(lacks)}", key="body.shape")
    problem = _distance_problem(body)
    if problem:
        raise BadInput.of(f"{place}: {problem}", key="body.shape")


def _distance_problem(body: Body) -> str | None:
    """Return what is wrong with the distance near the surface, checked at some points by differences."""
    bounds = np.asarray(body.bounds(), dtype=float)
    if bounds.shape != (2, 3) or not np.isfinite(bounds).all() or np.abs(bounds).max() > LARGEST_MM:
        return f"bounds() must be corners (2, 3) within {LARGEST_MM:g} mm (got {bounds.tolist()})"
    vertices = np.asarray(body.surface()[0], dtype=float)
    points = vertices[np.linspace(0, len(vertices) - 1, SAMPLES).astype(int)]
    found = body.distance(points)
    if found.gap.shape != (SAMPLES,) or found.normal.shape != (SAMPLES, 3) or found.hessian.shape != (SAMPLES, 3, 3):
        return "distance(points (n, 3)) must give gap (n,), normal (n, 3) and hessian (n, 3, 3)"
    size = float(np.ptp(bounds, axis=0).max())
    away = float(np.abs(found.gap).max())
    if not away < 0.02 * size:
        return f"a point of surface() is {away:.3g} mm away by distance()"
    outside = body.distance(points + 0.01 * size * found.normal).gap
    if not np.median(outside) > 0.0:
        return "distance() must be positive outside and negative inside"
    far = bounds.mean(axis=0) + 0.6 * size * CORNERS
    beyond = np.asarray(body.distance(far).gap)
    if not (beyond > 0.0).all():
        place = np.round(far[np.argmin(beyond > 0.0)], 3).tolist()
        return (
            f"distance() must be positive outside, and is not at {place}, far outside of bounds(): gap and normal may "
            "both have the wrong sign"
        )
    error = np.linalg.norm(found.normal - _slope(body, points), axis=1)
    worst = int(np.argmax(error))
    # an edge of the surface has no normal: a few points may stand on one
    if not np.mean(error < TOLERANCE) > 0.7:
        place = np.round(points[worst], 3).tolist()
        off = f"normal is not the gradient of gap: off by {error[worst]:.2g} at {place}"
        return f"{off} (a sharp edge there needs a radius)"
    return None


def _slope(body: Body, points: Array) -> Array:
    """Return the gradient (n, 3) of the gap by central differences."""
    steps = STEP_MM * np.eye(3)
    sides = [body.distance(points + step).gap - body.distance(points - step).gap for step in steps]
    return np.stack(sides, axis=1) / (2.0 * STEP_MM)
