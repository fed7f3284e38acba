"""Fabric parameters from tensile tests."""
