"""Fabric parameters from measured coupons, from files to files."""
