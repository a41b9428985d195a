"""Errors for misuse, and the outcome of a computation.

Misuse raises. An outcome that is merely unwanted (no clear path, no convergence) is a `Status`, so that a
control loop never has to catch anything.
"""

from enum import Enum

__all__ = ["CcaError", "InfeasibleError", "InputError", "MissingExtraError", "Status"]


class CcaError(Exception):
    """Root of all errors that the library raises."""


class InputError(CcaError, ValueError):
    """An argument cannot be used; the message names it, what it must be and what it was."""


class MissingExtraError(CcaError, ImportError):
    """An optional package is absent; the message prints the pip command that installs it."""


class InfeasibleError(CcaError, RuntimeError):
    """Raised by ``require()`` when a result is not usable.

    Parameters
    ----------
    message : str
        What was asked and why it cannot be had.
    result : object, optional
        The result as far as it was reached, for inspection.
    """

    def __init__(self, message: str, result: object = None) -> None:
        super().__init__(message)
        self.result = result


class Status(Enum):
    """Outcome of a computation; only `OK` means that every promise of the result holds."""

    OK = "every promise of the result holds"
    INFEASIBLE = "no solution within the limits was found"
    NOT_CONVERGED = "the iteration ended before its tolerance"
    DEGRADED = "the wish could not be carried out safely; a safer action was taken"
    INVALID_INPUT = "an input could not be used; the safest action was taken"
