"""Errors for misuse, and the status of a result.

Misuse raises. A result that is infeasible or has not converged has a `Status`, so control loops catch
nothing.
"""

from enum import Enum

__all__ = ["CcaError", "InfeasibleError", "InputError", "MissingExtraError", "Status"]


class CcaError(Exception):
    """Base class of all errors of the library."""


class InputError(CcaError, ValueError):
    """An argument is invalid; the message names it, its condition and its value."""


class MissingExtraError(CcaError, ImportError):
    """An optional package is missing; the message contains the pip command that installs it."""


class InfeasibleError(CcaError, RuntimeError):
    """Raised by ``require()`` when a result is not usable.

    Parameters
    ----------
    message : str
        What was requested and why it is infeasible.
    result : object, optional
        Partial result, for inspection.
    """

    def __init__(self, message: str, result: object = None) -> None:
        super().__init__(message)
        self.result = result


class Status(Enum):
    """Status of a result; only `OK` guarantees its promises."""

    OK = "every promise of the result holds"
    INFEASIBLE = "no solution within the limits was found"
    NOT_CONVERGED = "the iteration ended before its tolerance"
    DEGRADED = "the requested result was not safe; a safer one was taken"
    INVALID_INPUT = "an input was invalid; the safest action was taken"
