from tests.support.paper_runs import alone, hostile, run

__all__ = ["alone", "hostile", "run"]
