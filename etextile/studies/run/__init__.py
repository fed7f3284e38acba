"""One case: simulate, judge, report, draw."""
