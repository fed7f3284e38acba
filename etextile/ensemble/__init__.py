"""Scatter of inputs carried through to failure probabilities."""
