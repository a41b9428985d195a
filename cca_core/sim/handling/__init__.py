"""Handling tests: lane changes, ISO 3888, tracking."""
