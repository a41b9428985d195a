"""Simulate the paper's four scenarios, with and without V2V, and report the results.

The same as ``cca demo``. Writes the logs, summary.json, the figures and report.html into the folder
after ``--out``.
"""

import sys

from cca_core.cli import main

if __name__ == "__main__":
    sys.exit(main(["demo", *sys.argv[1:]]))
