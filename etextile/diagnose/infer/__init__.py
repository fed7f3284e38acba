"""Fits and evidence: how probable an explanation is in the light of the data."""
