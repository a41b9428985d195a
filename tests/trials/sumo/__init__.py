"""The planner in SUMO's traffic, and SUMO's own driver for comparison."""

import os

os.environ.update({name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")})
