"""Rigid bodies as signed distance functions, their motion and the contact laws."""
