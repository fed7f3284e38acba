"""Missing effects as transformations of the model, one file each."""
