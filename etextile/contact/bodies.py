"""The bodies a case may name: what is listed here is what `body.type` accepts, with its builder's keywords as keys.

`BODIES` are rigid and pressed into a flat piece, `LIMBS` bend inside of a piece that is worn.
"""

from __future__ import annotations

from collections.abc import Callable

from etextile.contact.bending import Bending
from etextile.contact.body import Body
from etextile.contact.capsule import capsule
from etextile.contact.elbow import elbow
from etextile.contact.ellipsoid import ellipsoid
from etextile.contact.joints import limb
from etextile.contact.knee import knee
from etextile.contact.limb_mesh import limb_mesh
from etextile.contact.mesh import mesh
from etextile.contact.own import own_body
from etextile.contact.sphere import sphere
from etextile.registry import Registry


BODIES: Registry[Callable[..., Body]] = Registry("body")
"""Builders by name; each takes dimensions (mm, deg) as explicit keywords and raises BadInput for impossible ones."""

BODIES.register("sphere", sphere)
BODIES.register("ellipsoid", ellipsoid)
BODIES.register("capsule", capsule)
BODIES.register("mesh", mesh)
BODIES.register("elbow", elbow)
BODIES.register("knee", knee)
BODIES.register("own", own_body)

LIMBS: Registry[Callable[..., Bending]] = Registry("limb")
"""Builders of limbs by name; each returns the straight limb, raises BadInput for an impossible one."""

LIMBS.register("limb", limb)
LIMBS.register("limb_mesh", limb_mesh)
