"""Entry point: one command is chosen, imported and run."""

import io
import os
import sys
import warnings
from collections.abc import Sequence
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
        sys.stdout.flush()
        return code
    except CcaError as error:
        text = str(error)
    except BrokenPipeError:  # such as of `cca decode log | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # of the flush at exit
        return 141
    except OSError as error:
        text = f"{error.filename!r} cannot be written or read: {error.strerror}"
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        return 130
    sys.stderr.write(f"cca {given.command}: {text}\n")
    return 2


def _show_warning(
    message: Warning | str, category: object, filename: str, lineno: int, *_: object, **__: object
) -> None:
    """Write a warning without the line of code that gave it."""
    sys.stderr.write(f"warning: {message}\n")
