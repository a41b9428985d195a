"""CommonRoad files: read, drive."""
