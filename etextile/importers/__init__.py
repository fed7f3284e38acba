"""Files as machines write them: encoding, dialect, columns with units; found, said, and asked for where unsure."""
