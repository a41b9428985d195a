"""Runs in SUMO are no tests, and import packages that tests do without."""

collect_ignore = ["sumo"]
