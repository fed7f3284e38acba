"""The result file: one table of names and units, and the store that reads and writes it."""
