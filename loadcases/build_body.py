"""The body of a case where it stands, and whether the fabric lies over its highest point."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from etextile.errors import BadInput
from etextile.types import Array
from loadcases.schema import Case
from loadcases.schema_body import Mesh, Placed


if TYPE_CHECKING:
    from etextile.contact.body import Body


def placed_body(case: Case) -> Body | None:
    """Return the body just touching the flat fabric from below; raises BadInput when its top is beside the fabric."""
    if not isinstance(case.body, Placed):
        return None
    from etextile.contact.bodies import BODIES
    from etextile.contact.pose import place

    own = case.body.model_dump(exclude={"type", "position", "rotation", "centred"})
    body = place(
        BODIES[case.body.type](**own), case.body.position, rotation_deg=case.body.rotation, centred=case.body.centred
    )
    if isinstance(case.body, Mesh):
        _check_under_fabric(case, case.body, body.surface()[0])
    return body


def mesh_notes(case: Case) -> tuple[str, ...]:
    """Return what is to be known of a case's mesh, after all checks that need no distance grid; else nothing."""
    if not isinstance(case.body, Mesh):
        return ()
    from etextile.contact.mesh import prepared
    from etextile.contact.pose import highest, rotation_matrix

    body = case.body
    vertices, faces, repairs = prepared(Path(body.file), scale=body.scale, cap_holes=body.cap_holes)
    turned = vertices @ rotation_matrix(body.rotation).T
    shift = np.array(body.position)
    if body.centred:
        shift = shift - highest(turned).mean(axis=0)
    turned[:, :2] += shift
    top = _check_under_fabric(case, body, turned)
    size = " x ".join(f"{value:.4g}" for value in np.ptp(turned, axis=0))
    where = f"highest point at x = {top[0]:.4g}, y = {top[1]:.4g} mm"
    return (f"mesh of {len(faces)} triangles, {size} mm as it stands, {where}", *repairs)


def _check_under_fabric(case: Case, body: Mesh, vertices: Array) -> Array:
    """Return the place (2,) of the highest point; raises BadInput when the specimen does not lie over it."""
    from etextile.contact.pose import highest

    box = highest(vertices)
    half = 0.5 * np.array(case.pattern)
    middle: Array = np.round(box.mean(axis=0), 3) + 0.0
    if np.any(box[0] >= half) or np.any(box[1] <= -half):
        message = (
            f"the highest point of the body stands beside the specimen, at x = {middle[0]:.4g}, y = {middle[1]:.4g} mm "
            f"(the specimen reaches to +-{half[0]:g}, +-{half[1]:g} mm): write position: centre, or position: "
            f"[{body.position[0] - middle[0]:.4g}, {body.position[1] - middle[1]:.4g}], which puts it in the middle"
        )
        raise BadInput.of(message, key="body.position")
    return middle
