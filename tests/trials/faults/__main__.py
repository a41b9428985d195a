"""Run cases: ``python -m tests.trials.faults [--list] [ID or group ...]``."""

from tests.trials import faults

faults.TABLE.main(faults.__doc__.splitlines()[0])
