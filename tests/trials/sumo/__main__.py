"""The planner in SUMO's traffic: `python -m tests.trials.sumo`."""

from tests.trials.sumo.run import main

main()
