"""Conductive wires: layout, embedding in the lattice, histories, failure and reports."""
