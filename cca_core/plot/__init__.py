"""Pictures of paths, bands and runs (matplotlib, extra ``plot``)."""
