"""The command line: demo, roads, recorded messages, own runs, studies and reports."""

from cca_core.cli.main import main

__all__ = ["main"]
