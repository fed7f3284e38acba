"""Many runs of one case over its scatter, and designs compared on the same samples."""
