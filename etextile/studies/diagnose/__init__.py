"""The diagnosis of a case against a folder of measurements, from files to files."""
