"""Vehicles that can be driven: single track and multi-body."""
