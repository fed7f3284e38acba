"""Truss laws as pure functions of strain and state."""
