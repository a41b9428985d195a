"""The planner in highway-env, and its own driver (IDM and MOBIL) for comparison."""
