"""Reliability of conductive wires in woven electronic textiles: lattice model, contact, solver, diagnosis."""
