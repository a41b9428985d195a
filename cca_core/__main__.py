"""``python -m cca_core`` is the command ``cca``."""

import sys

from cca_core.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
