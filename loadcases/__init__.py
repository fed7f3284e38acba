"""Load cases: schema, strict reader, build, and the shipped cases."""
