"""The woven fabric as a lattice: densities, areas, coarsening, pieces and supports."""
