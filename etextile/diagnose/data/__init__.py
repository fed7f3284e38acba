"""Measured channels, the same quantities of a simulation, where they are compared, and their noise."""
