"""Words that many parts of the code share, in the order in which numbers in files and arrays stand for them."""

from __future__ import annotations


STATES = ("intact", "plastic", "partial", "open")
"""What may be said of a wire, a loop or a piece of wire in the weave."""
INTACT, PLASTIC, PARTIAL, OPEN = range(4)

FABRIC_FAMILIES = ("warp", "weft", "diagonal")
FAMILIES = (*FABRIC_FAMILIES, "wire")
"""Truss families, in the order of the integer cell array `family` of result files."""

FORCE, EDGE, STRAIN, CLAMP = "punch_force", "free_edge", "strain_field", "clamp_line"
PULL, HEIGHT, FIELD, MOMENT = "clamp_force", "pressure_height", "displacement_field", "joint_moment"
BEND, CYCLE, SLIP = "moment_curvature", "cyclic_force", "mark_slip"
CURVES = (FORCE, PULL, HEIGHT, MOMENT, BEND)
"""Channels of one value over the load of a test, one file per specimen."""
FORCES = (FORCE, PULL, MOMENT, BEND)
"""Curves of a force or a moment: they grow in proportion with the laws of the fabric, heights do not."""
CHANNELS = (*CURVES, EDGE, STRAIN, CLAMP, FIELD, SLIP)
"""Channels of a measurement that a simulation predicts."""
CHANNEL_LABELS = {
    FORCE: "force", PULL: "force", HEIGHT: "height", MOMENT: "moment", EDGE: "free edge", STRAIN: "strain field",
    CLAMP: "clamp", FIELD: "motion", BEND: "bending moment", SLIP: "slip on the skin",
}  # fmt: skip

PORTIONS = {"whole": (False, False), "half": (True, False), "quarter": (True, True)}
"""Modelled parts of a specimen: whether x = 0 and y = 0 are planes of symmetry."""
