"""Sphinx extensions of the manual: formulas without a network, commands that are run, tables made from the code."""
