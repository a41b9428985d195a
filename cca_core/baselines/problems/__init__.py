"""Planning problems: sampled, verified, driven, compared."""
