"""Studies: everything from a case to files. Nothing here prints."""
