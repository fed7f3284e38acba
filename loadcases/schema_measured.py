"""What a measured.yaml may say: the channels of a test, their files and how each is to be read."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag, field_validator, model_validator

from loadcases.schema_numbers import Count, Length, PositiveLength, Quantity, Strict
from loadcases.schema_reading import Reading


FileName = Annotated[str, Field(min_length=1, description="Name of a file in the folder.")]
NoiseForce = Annotated[float, Quantity("N", above=0.0)]
NoiseMoment = Annotated[float, Quantity("N mm", above=0.0)]
NoiseLength = Annotated[float, Quantity("mm", above=0.0)]
NoiseStrain = Annotated[float, Quantity(above=0.0)]
Stiffness = Annotated[float, Quantity("N/mm", above=0.0)]
PUNCH = ("displacement_mm", "force_N")
EDGE = ("displacement_mm", "warp0_mm", "warp_mm", "weft_mm", "height_mm")
FIELD = ("displacement_mm", "warp0_mm", "weft0_mm", "strain_warp", "strain_weft")
SLIP = ("displacement_mm", "weft0_mm", "slip_mm")
WIRES = ("displacement_mm", "angle_deg", "wire", "warp0_mm", "state")
HEIGHT = ("pressure_bar", "height_mm")
MOTION = ("pressure_bar", "displacement_mm", "warp0_mm", "weft0_mm", "warp_mm", "weft_mm", "height_mm")
MOMENT = ("angle_deg", "moment_Nmm")
BEND = ("curvature_1_per_m", "moment_Nm_per_m")
MARKS = ("angle_deg", "warp0_mm", "weft0_mm", "slip_mm")
TENSILE = ("strain", "stress_MPa", "displacement_mm", "force_N")


def _kind(value: Any) -> str:
    """Tell the two forms of an entry apart."""
    return "section" if isinstance(value, (dict, Strict)) else "name"


class PunchFile(Reading):
    """One punch record that is read in a way of its own."""

    QUANTITIES: ClassVar[tuple[str, ...]] = PUNCH

    file: FileName = Field(description="File in the folder.")


AnyPunchFile = Annotated[Annotated[FileName, Tag("name")] | Annotated[PunchFile, Tag("section")], Discriminator(_kind)]


class PunchForceFiles(Reading):
    """Force over punch displacement, one file per specimen."""

    QUANTITIES: ClassVar[tuple[str, ...]] = PUNCH

    files: tuple[AnyPunchFile, ...] = Field(
        min_length=1, description="Files displacement_mm,force_N, one per specimen."
    )
    noise: NoiseForce | None = Field(default=None, description="Standard deviation of the force, N.")


class EdgeFile(Reading):
    """Positions of points of the free edge with their noise."""

    QUANTITIES: ClassVar[tuple[str, ...]] = EDGE

    file: FileName = Field(description="File displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm.")
    noise: NoiseLength | None = Field(default=None, description="Standard deviation of the lengths, mm.")


class SlipFile(Reading):
    """Slip along the clamp line with its noise."""

    QUANTITIES: ClassVar[tuple[str, ...]] = SLIP

    file: FileName = Field(description="File displacement_mm,weft0_mm,slip_mm.")
    noise: NoiseLength | None = Field(default=None, description="Standard deviation of the lengths, mm.")


class MarkFile(Reading):
    """Slip of marks on a worn piece along the skin with its noise."""

    QUANTITIES: ClassVar[tuple[str, ...]] = MARKS

    file: FileName = Field(
        description="File angle_deg,warp0_mm,weft0_mm,slip_mm: marks on the fabric, read on a scale drawn on the skin "
        "of the straight limb; towards hand or foot is positive."
    )
    noise: NoiseLength | None = Field(default=None, description="Standard deviation of the slip, mm.")


class StrainFile(Reading):
    """A file of strains with its noise."""

    QUANTITIES: ClassVar[tuple[str, ...]] = FIELD

    file: FileName = Field(description="File displacement_mm,warp0_mm,weft0_mm,strain_warp,strain_weft.")
    noise: NoiseStrain | None = Field(default=None, description="Standard deviation of the strains.")


class WiresFile(Reading):
    """A file of wire states."""

    QUANTITIES: ClassVar[tuple[str, ...]] = WIRES

    file: FileName = Field(description="File displacement_mm (or angle_deg),wire,warp0_mm,state.")


class Size(Reading):
    """Dimensions of coupons and how their files are read."""

    QUANTITIES: ClassVar[tuple[str, ...]] = TENSILE

    width: PositiveLength | None = Field(default=None, description="Width of the coupon, mm.")
    thickness: PositiveLength | None = Field(default=None, description="Thickness of the coupon, mm.")
    gauge_length: PositiveLength | None = Field(default=None, description="Gauge length, mm.")
    strain_from: Literal["specimen", "crosshead"] | None = Field(
        default=None,
        description="Where strain was measured. Not said, or crosshead: what the machine gives is in the intervals.",
    )
    machine_stiffness: Stiffness | None = Field(
        default=None,
        description="Stiffness of frame, load cell and grips, N/mm: what they give is taken off displacement_mm.",
    )


class Specimen(Size):
    """One tensile file with dimensions of its own."""

    file: FileName = Field(description="CSV file in the folder.")


AnySpecimen = Annotated[Annotated[FileName, Tag("name")] | Annotated[Specimen, Tag("section")], Discriminator(_kind)]


class TensileFiles(Size):
    """Tensile curves by direction, in time order, loading then unloading; one file per specimen."""

    warp: tuple[AnySpecimen, ...] = Field(default=(), description="CSV files of coupons pulled along the warp.")
    weft: tuple[AnySpecimen, ...] = Field(default=(), description="CSV files of coupons pulled along the weft.")
    bias: tuple[AnySpecimen, ...] = Field(default=(), description="CSV files of coupons pulled at 45 degrees.")

    @model_validator(mode="after")
    def _some(self) -> TensileFiles:
        if not any((self.warp, self.weft, self.bias)):
            raise ValueError("no specimens, name files under warp, weft or bias")
        return self


class HeightFiles(Reading):
    """Height over pressure, one file per specimen."""

    QUANTITIES: ClassVar[tuple[str, ...]] = HEIGHT

    files: tuple[FileName, ...] = Field(min_length=1, description="Files pressure_bar,height_mm, one per specimen.")
    noise: NoiseLength | None = Field(default=None, description="Standard deviation of the height, mm.")
    diaphragm: FileName | None = Field(
        default=None,
        description="File pressure_bar,height_mm of the tester's diaphragm alone: its pressure at the same height is "
        "taken off.",
    )


class MomentFiles(Reading):
    """Moment of a joint over its angle, one file per specimen."""

    QUANTITIES: ClassVar[tuple[str, ...]] = MOMENT

    files: tuple[FileName, ...] = Field(
        min_length=1,
        description="Files angle_deg,moment_Nmm, one per specimen: the first flexion, without the bare limb's moment.",
    )
    noise: NoiseMoment | None = Field(default=None, description="Standard deviation of the moment, N mm.")


class BendFiles(Reading):
    """Bending moment per width over the curvature, one file per specimen."""

    QUANTITIES: ClassVar[tuple[str, ...]] = BEND

    files: tuple[FileName, ...] = Field(
        min_length=1,
        description="Files curvature_1_per_m,moment_Nm_per_m (moment per width), one per specimen: the first bending.",
    )
    noise: NoiseForce | None = Field(default=None, description="Standard deviation of the moment per width, N m/m.")


class FieldFiles(Reading):
    """Motion of material points, one file per specimen."""

    QUANTITIES: ClassVar[tuple[str, ...]] = MOTION

    files: tuple[FileName, ...] = Field(
        min_length=1,
        description="Files pressure_bar (or displacement_mm),warp0_mm,weft0_mm,warp_mm,weft_mm,height_mm, one per "
        "specimen: positions, not displacements.",
    )
    noise: NoiseLength | None = Field(default=None, description="Standard deviation of the positions, mm.")
    centre: tuple[Length, Length] = Field(
        default=(0.0, 0.0), description="Where the centre of the piece lies in the coordinates of the files, mm."
    )


class ClampForceFiles(Reading):
    """Force of a pulled clamp over its displacement, one file per specimen."""

    QUANTITIES: ClassVar[tuple[str, ...]] = PUNCH

    files: tuple[FileName, ...] = Field(
        min_length=1,
        description="Files displacement_mm,force_N of the loading, one per specimen. Where one starts from 0 with a "
        "force, that is its preload: what is simulated counts from there, too.",
    )
    strips: Count = Field(
        default=1, description="Strips as wide as that of the case which were pulled side by side; divides the force."
    )
    noise: NoiseForce | None = Field(default=None, description="Standard deviation of the force as read, N.")


class CyclicFiles(Reading):
    """Force of a punch or a pulled clamp over a motion there and back, one file per specimen."""

    QUANTITIES: ClassVar[tuple[str, ...]] = PUNCH

    files: tuple[FileName, ...] = Field(
        min_length=1,
        description="Files displacement_mm,force_N in time order, with unloading and reloading, one per specimen; each "
        "is run along its own turning points.",
    )
    noise: NoiseForce | None = Field(default=None, description="Standard deviation of the force, N.")


class Channels(Strict):
    """What was measured; every channel is optional, one is needed."""

    punch_force: PunchForceFiles | None = Field(default=None, description="Force over punch displacement.")
    punch_unloading: PunchForceFiles | None = Field(
        default=None, description="Force on the way back from the largest displacement, records in time order."
    )
    free_edge: EdgeFile | None = Field(default=None, description="displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm.")
    tensile: TensileFiles | None = Field(default=None, description="Tensile curves.")
    strain_field: StrainFile | None = Field(default=None, description="Strain at material points.")
    clamp_line: SlipFile | None = Field(default=None, description="displacement_mm,weft0_mm,slip_mm.")
    wires: WiresFile | None = Field(default=None, description="State of the wires.")
    pressure_height: HeightFiles | None = Field(default=None, description="Height over pressure.")
    displacement_field: FieldFiles | None = Field(default=None, description="Motion of material points.")
    clamp_force: ClampForceFiles | None = Field(
        default=None, description="Force of a pulled clamp over its displacement, at any angle to the yarns."
    )
    joint_moment: MomentFiles | None = Field(
        default=None, description="Moment over the angle of a joint in a worn piece."
    )
    mark_slip: MarkFile | None = Field(
        default=None, description="angle_deg,warp0_mm,weft0_mm,slip_mm of marks on a worn piece."
    )

    cyclic_force: CyclicFiles | None = Field(
        default=None, description="Force over a motion there and back, the whole record: for calibrate and compare."
    )
    moment_curvature: BendFiles | None = Field(
        default=None, description="Bending moment per width over the curvature of the fabric, along x of the case."
    )

    @model_validator(mode="after")
    def _some(self) -> Channels:
        if not any(getattr(self, name) for name in type(self).model_fields):
            raise ValueError(f"no channel, give at least one of {', '.join(type(self).model_fields)}")
        return self


class Test(Strict):
    """A further test: what of the case is other in it, and what was measured."""

    name: str = Field(min_length=1, description="Name of the test.")
    case: dict[str, Any] = Field(
        default_factory=dict, description="What is other than in the case: key paths and values, `body.radius: 25 mm`."
    )
    without: tuple[str, ...] = Field(
        default=(), description="Effects that cannot act in this test, such as punch_friction when it is lubricated."
    )
    channels: Channels = Field(description="What was measured.")


class MeasuredFolder(Strict):
    """The file `measured.yaml`."""

    title: str = Field(min_length=1, description="One line that names the measurements.")
    description: str = Field(default="", description="What was measured and how, free text.")
    channels: Channels | None = Field(default=None, description="What was measured in the test of the case.")
    tests: tuple[Test, ...] = Field(default=(), description="Further tests, each with its own changes of the case.")
    after: str | None = Field(
        default=None, min_length=1, description="Folder of the measurements that these tests are added to."
    )

    @field_validator("title")
    @classmethod
    def _one_line(cls, value: str) -> str:
        return " ".join(value.split())

    @model_validator(mode="after")
    def _some(self) -> MeasuredFolder:
        if self.channels is None and not self.tests:
            raise ValueError("nothing was measured, give channels or tests")
        if self.channels is not None and self.after is not None:
            raise ValueError("channels belong to the folder that `after` names, give tests")
        return self
