"""The library in recorded scenarios, and a brute force over speed profiles on the same route."""
