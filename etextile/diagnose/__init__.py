"""Where simulation and measurement disagree, and the effect that explains it."""
