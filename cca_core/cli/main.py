"""Entry point: one command is chosen, imported and run."""

import io
import os
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module

from cca_core.cli.arguments import make_parser
from cca_core.errors import CcaError

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command of ``cca``.

    Parameters
    ----------
    arguments : sequence of str, optional
        Words after ``cca``; the default is those of the process.

    Returns
    -------
    code : int
        Exit code: 0, or 2 if an input is invalid or a package is missing, 130 if interrupted, 141 if the
        reader of the output has gone.

    Raises
    ------
    SystemExit
        With code 0 after ``--help``, and 2 if the words cannot be parsed.
    """
    try:
        try:
            return _run(arguments)
        finally:
            for stream in filter(None, (sys.stdout, sys.stderr)):
                stream.flush()
    except BrokenPipeError:  # such as of `cca decode log | head`
        _discard_output()
        return 141
    except OSError as error:  # such as of a full disk
        _discard_output()
        with suppress(OSError):
            sys.stderr.write(f"cca: the output cannot be written: {error.strerror}\n")
        return 2


def _run(arguments: Sequence[str] | None) -> int:
    """Run a command, and state in one line why it fails."""
    parser = make_parser()
    if not (sys.argv[1:] if arguments is None else arguments):
        parser.print_help(sys.stderr)
        raise SystemExit(2)
    given = parser.parse_args(arguments)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal may not have all signs
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("default", UserWarning)
            warnings.showwarning = _show_warning
            code = int(import_module(f"cca_core.cli.{given.command}").run(given))
        if sys.stdout is not None:  # it is None where it was closed before the start
            sys.stdout.flush()
        return code
    except CcaError as error:
        text = str(error)
    except OSError as error:
        if error.filename is None:  # the output itself
            raise
        text = f"{error.filename!r} cannot be written or read: {error.strerror}"
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        return 130
    sys.stderr.write(f"cca {given.command}: {text}\n")
    return 2


def _discard_output() -> None:
    """Let what is left go nowhere, so that the flush at the exit of Python is silent."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in filter(None, (sys.stdout, sys.stderr)):
        try:
            stream.flush()
        except OSError:
            os.dup2(nowhere, stream.fileno())


def _show_warning(
    message: Warning | str, category: object, filename: str, lineno: int, *_: object, **__: object
) -> None:
    """Write a warning without the line of code that gave it."""
    sys.stderr.write(f"warning: {message}\n")
