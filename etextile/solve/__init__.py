"""From a model to converged increments: pattern, linear solvers, Newton, load path, trust limits."""
