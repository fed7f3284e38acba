"""What studies found, in words of 80 columns for terminals and notebooks; functions of data, nothing prints."""
