"""Random traffic around one ego, independent of the library's own simulation.

Roads, cars, the ego's plant and the collision check are this package's own; the library gives path, road and
planner only. Equal seeds give equal drives.
"""

import os

os.environ.update({name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")})
