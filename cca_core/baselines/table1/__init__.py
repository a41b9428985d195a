"""The paper's Table 1 measured: ``python -m cca_core.baselines.table1`` writes docs/table1.md."""
