"""Words that many parts of the code share, in the order in which numbers in files and arrays stand for them."""

from __future__ import annotations


STATES = ("intact", "plastic", "partial", "open")
"""What may be said of a wire, a loop or a piece of wire in the weave."""
INTACT, PLASTIC, PARTIAL, OPEN = range(4)

FABRIC_FAMILIES = ("warp", "weft", "diagonal")
FAMILIES = (*FABRIC_FAMILIES, "wire")
"""Truss families, in the order of the integer cell array `family` of result files."""

FORCE, EDGE, STRAIN, CLAMP = "punch_force", "free_edge", "strain_field", "clamp_line"
CHANNELS = (FORCE, EDGE, STRAIN, CLAMP)
"""Channels of a measurement that a simulation predicts."""
HEIGHT, FIELD, MOMENT = "pressure_height", "displacement_field", "joint_moment"
SURFACE_CHANNELS = (HEIGHT, FIELD, MOMENT)
"""Channels of any piece under a load, compared point by point and not in the diagnosis of a punch test."""
CHANNEL_LABELS = {FORCE: "force", EDGE: "free edge", STRAIN: "strain field", CLAMP: "clamp"}

PORTIONS = {"whole": (False, False), "half": (True, False), "quarter": (True, True)}
"""Modelled parts of a specimen: whether x = 0 and y = 0 are planes of symmetry."""
