"""Simulations over the parameters of the explanations, and tables between them."""
