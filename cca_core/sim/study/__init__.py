"""Studies: many sampled runs, their rates and intervals."""
