"""Other people's methods on the same problems, to compare with."""

from cca_core.baselines.steering import LqrSteering, PurePursuit, Stanley

__all__ = ["LqrSteering", "PurePursuit", "Stanley"]
