"""Command line and pipeline: the composition root that nobody imports."""
