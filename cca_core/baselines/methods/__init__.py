"""Planning methods: elastic bands, motion primitives, random trees, model predictive control, FISS."""
