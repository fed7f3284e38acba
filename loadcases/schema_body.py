"""Bodies of the case file: one model per shape, told apart by `type`, dimensions in mm and angles in deg."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, WithJsonSchema, model_validator

from etextile.contact.joints import JOINTS
from etextile.contact.limb import SKIN_LENGTH
from loadcases.schema_numbers import Angle, Length, NonNegativeLength, Positive, PositiveLength, Quantity, Strict


if TYPE_CHECKING:
    from etextile.contact.limb_recipe import UnbakedLimb

GRID_SPACING = "Spacing of the distance grid, mm; null takes it from the size of the body."
POSITION = {
    "anyOf": [{"type": "array", "minItems": 2, "maxItems": 2}, {"const": "centre"}],
    "unit": "mm",
}
ANGLE_XYZ = "Rotation of the body about the fixed x, y and z axes, applied in this order, deg."


class Placed(Strict):
    """What all bodies share: where they stand under the flat fabric and how they are turned."""

    position: Annotated[tuple[Length, Length], WithJsonSchema(POSITION)] = Field(
        default=(0.0, 0.0),
        description="Place [x, y] of the body's reference point in the specimen plane (of a mesh: the file's origin), "
        "mm; or centre: the highest point over the middle of the specimen.",
    )
    centred: bool = Field(
        default=False, description="The highest point, not the reference point, stands at position (position: centre)."
    )
    rotation: tuple[Angle, Angle, Angle] = Field(default=(0.0, 0.0, 0.0), description=ANGLE_XYZ)

    @model_validator(mode="before")
    @classmethod
    def _centre(cls, value: Any) -> Any:
        if isinstance(value, dict) and value.get("position") in ("centre", "center"):
            return {**value, "position": (0.0, 0.0), "centred": True}
        return value


class Sphere(Placed):
    """A ball, exact."""

    type: Literal["sphere"] = Field(description="A ball.")
    radius: PositiveLength = Field(description="Radius, mm.")


class Ellipsoid(Placed):
    """An ellipsoid, exact."""

    type: Literal["ellipsoid"] = Field(description="An ellipsoid.")
    semi_axes: tuple[PositiveLength, PositiveLength, PositiveLength] = Field(
        description="Half lengths [a, b, c] along the body's own x, y and z axes, mm."
    )


class Capsule(Placed):
    """A cylinder with round ends, axis along x, exact."""

    type: Literal["capsule"] = Field(description="A cylinder with hemispherical ends, axis along x.")
    radius: PositiveLength = Field(description="Radius, mm.")
    length: PositiveLength = Field(description="Length of the straight part, mm.")


class Mesh(Placed):
    """A closed triangle mesh from a file."""

    type: Literal["mesh"] = Field(description="A closed triangle surface from a file (STL, OBJ, PLY, 3MF).")
    file: str = Field(description="Mesh file, relative to the case file.", min_length=1)
    scale: Positive = Field(default=1.0, description="Factor from the file's length unit to mm (1000 for metres).")
    cap_holes: bool = Field(default=False, description="Close planar holes, such as the ends of a scanned limb.")
    grid_spacing: PositiveLength | None = Field(default=None, description=GRID_SPACING)


class Elbow(Placed):
    """A bent elbow: upper arm and forearm meeting in a hard tip (dimensions and sources: etextile.contact.elbow)."""

    type: Literal["elbow"] = Field(description="Upper arm and forearm meeting in the hard tip of the elbow.")
    tip_radius: PositiveLength = Field(default=15.0, description="Radius of the hard tip (olecranon), mm.")
    flexion: Annotated[float, Quantity("deg", at_least=60.0, at_most=150.0)] = Field(
        default=100.0, description="Flexion angle, 0 for a straight arm, deg."
    )
    breadth: PositiveLength = Field(default=72.0, description="Breadth over the epicondyles, mm.")
    upper_arm_girth: PositiveLength = Field(default=344.0, description="Girth of the flexed upper arm, mm.")
    forearm_girth: PositiveLength = Field(default=282.0, description="Girth of the forearm, mm.")
    arm_length: PositiveLength = Field(default=140.0, description="Length of the arms from the joint, mm.")
    grid_spacing: PositiveLength | None = Field(default=None, description=GRID_SPACING)


class Knee(Placed):
    """A bent knee: thigh and shank with a patella (dimensions and sources: etextile.contact.knee)."""

    type: Literal["knee"] = Field(description="Thigh and shank with a patella.")
    flexion: Annotated[float, Quantity("deg", at_least=60.0, at_most=140.0)] = Field(
        default=90.0, description="Flexion angle, 0 for a straight leg, deg."
    )
    breadth: PositiveLength = Field(default=98.0, description="Breadth over the condyles, mm.")
    thigh_girth: PositiveLength = Field(default=480.0, description="Girth of the thigh near the knee, mm.")
    calf_girth: PositiveLength = Field(default=372.0, description="Girth of the calf, mm.")
    patella_width: PositiveLength = Field(default=44.8, description="Width of the patella, mm.")
    patella_height: PositiveLength = Field(default=34.4, description="Height of the patella, mm.")
    patella_thickness: PositiveLength = Field(default=22.4, description="Thickness of the patella, mm.")
    leg_length: PositiveLength = Field(default=180.0, description="Length of the legs from the joint, mm.")
    grid_spacing: PositiveLength | None = Field(default=None, description=GRID_SPACING)


class Own(Placed):
    """A body of the user's own, from a function in a Python file or an installed package."""

    type: Literal["own"] = Field(description="A body that a function of the user's returns.")
    shape: str = Field(description="Name of the function.", min_length=1)
    file: str | None = Field(default=None, description="Python file it stands in; null for an installed package.")
    dimensions: dict[str, float | str] = Field(
        default={}, description="Its keywords: lengths, mm; angles where the name ends in _deg."
    )


class Limb(Strict):
    """A limb that bends at a joint, the hinge in the origin along y (dimensions: etextile.contact.joints)."""

    type: Literal["limb"] = Field(description="A limb that bends at a joint, for a tube or a panel that is worn.")
    joint: Literal["elbow", "knee"] = Field(description="The joint, whose dimensions stand in where none are given.")
    joint_girth: PositiveLength | None = Field(default=None, description="Girth at the joint, straight, mm.")
    upper_girth: PositiveLength | None = Field(default=None, description="Girth where the upper segment ends, mm.")
    lower_girth: PositiveLength | None = Field(default=None, description="Girth where the lower segment ends, mm.")
    segment_length: PositiveLength | None = Field(default=None, description="Length of the segments, mm.")
    tip_radius: PositiveLength | None = Field(default=None, description="Radius of the hard tip, mm.")
    tip_height: NonNegativeLength | None = Field(
        default=None, description="How far the tip stands out over the joint, mm; 0 for none."
    )
    skin_length: PositiveLength = Field(
        default=SKIN_LENGTH, description="Length of the skin that stretches over the joint, mm."
    )

    @property
    def girth(self) -> float:
        """Girth at the joint, straight, mm."""
        return JOINTS[self.joint].joint_girth if self.joint_girth is None else self.joint_girth

    @property
    def length(self) -> float:
        """Length of the segments, mm."""
        return JOINTS[self.joint].segment_length if self.segment_length is None else self.segment_length


class LimbMesh(Strict):
    """A limb cut from a body mesh that bends by its own rig and weights, for a tube or a panel that is worn."""

    type: Literal["limb_mesh"] = Field(description="A limb of a rigged body mesh, bent by skinning.")
    file: str = Field(description="Mesh of the body (OBJ), relative to the case file.", min_length=1)
    rig: str = Field(description="Its bones (JSON): {bone: {head, tail, parent}}.", min_length=1)
    weights: str = Field(description="Its weights (JSON): {bone: [[vertex, weight], ...]}.", min_length=1)
    joint: str = Field(
        description="elbow_left, elbow_right, knee_left, knee_right, or the bone beyond the joint.", min_length=1
    )
    group: str | None = Field(default=None, description="Group of the mesh that is the skin; null for all of it.")
    scale: Positive = Field(default=1.0, description="Factor from the file's length unit to mm (1000 for metres).")
    axis: tuple[float, float, float] | None = Field(
        default=None,
        description="Axis of the hinge in coordinates of the file, right-handed for flexion; null takes the normal of "
        "the plane of the two bones.",
    )
    skinning: Literal["linear", "dual_quaternion"] = Field(
        default="linear",
        description="linear blend skinning, whose joint collapses, or dual_quaternion, whose does not.",
    )
    joint_girth: PositiveLength | None = Field(
        default=None, description="Girth at the joint, straight, to which the mesh is scaled, mm; null: as it is."
    )
    segment_length: PositiveLength | None = Field(
        default=None, description="Length at which both segments are cut, mm; null: 0.7 of the shorter bone."
    )
    skin_length: PositiveLength | None = Field(
        default=None, description="Length of the skin that stretches over the joint, mm; null: as the weights fade."
    )
    grid_spacing: PositiveLength | None = Field(default=None, description=GRID_SPACING)

    def measured(self) -> UnbakedLimb:
        """Return what the files hold, without the distance grids; raises BadInput where they cannot be used."""
        from etextile.contact.limb_recipe import LimbRecipe, unbaked

        return unbaked(LimbRecipe(**self.model_dump(exclude={"type", "skin_length", "grid_spacing"})))

    @property
    def girth(self) -> float:
        """Girth at the joint, straight, mm: as given, else measured on the mesh."""
        return self.measured().girth if self.joint_girth is None else self.joint_girth

    @property
    def length(self) -> float:
        """Length of the segments, mm: as given, else from the bones of the mesh."""
        return self.measured().length if self.segment_length is None else self.segment_length


Body = Annotated[
    Sphere | Ellipsoid | Capsule | Mesh | Elbow | Knee | Own | Limb | LimbMesh, Field(discriminator="type")
]
BODIES: tuple[type[Placed], ...] = (Sphere, Ellipsoid, Capsule, Mesh, Elbow, Knee, Own)
LIMBS = (Limb, LimbMesh)
"""Bodies that bend inside of a worn piece."""
