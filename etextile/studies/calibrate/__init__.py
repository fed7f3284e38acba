"""Parameters from any test that a case describes: calibrate."""
