"""Failure criteria, one per file; `wires.failure` registers them under the names used in case files."""
