"""What the verbs print: one file per verb, plain text from report data."""
