"""Translate the kernel, written in a small part of Python, to C99.

Whatever lies outside of that part is an error that names file and line. The C does the same arithmetic in the
same order, so results are equal bit for bit if the compiler does not contract products and sums.
"""

import textwrap
from pathlib import Path

from cca_core.codegen.binding import binding
from cca_core.codegen.kinds import TranslationError as TranslationError
from cca_core.codegen.program import Program
from cca_core.kernel import digest, sources

NOTE = "/* Made from the Python of cca_core/kernel by `make kernel`: edit that. */"
PRELUDE = """
#include "kernel.h"

#include <math.h>

/* as Python's max and min: the first of equals, and the first if the second is not a number */
static inline double real_max(double a, double b) { return b > a ? b : a; }
static inline double real_min(double a, double b) { return b < a ? b : a; }
static inline int int_max(int a, int b) { return b > a ? b : a; }
static inline int int_min(int a, int b) { return b < a ? b : a; }

/* as Python's // and % of a positive number: rounded down */
static inline int int_quotient(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }
static inline int int_rest(int a, int b) { return a - b * int_quotient(a, b); }

/* as cca_core.kernel.types.floor_within */
static inline int floor_within(double value, int low, int high)
{
    if (!(value >= low)) {
        return low;
    }
    return value >= high ? high : (int)floor(value);
}"""
HEAD = "\n\n#ifndef CCA_KERNEL_H\n#define CCA_KERNEL_H\n\n#include <stdbool.h>"

MAX_WIDTH = 110


def wrapped(line: str) -> str:
    """Break a line at its spaces; a macro must stay on one."""
    margin = line[: len(line) - len(line.lstrip())]
    if len(line) <= MAX_WIDTH or line.startswith("#"):
        return line
    return textwrap.fill(
        line.strip(),
        MAX_WIDTH,
        initial_indent=margin,
        subsequent_indent=f"{margin}    ",
        break_on_hyphens=False,
    )


def translate(folder: Path) -> dict[str, str]:
    """Translate the modules of a folder to the texts of kernel.h, kernel.c and python.c."""
    program = Program(folder)
    for path in sources(folder):
        program.add(path.stem)
    header = "\n".join([NOTE + HEAD, *map(wrapped, program.header), "", "#endif"])
    python = binding(program.kernels, program.structures, digest(folder))
    return {
        "kernel.h": header + "\n",
        "kernel.c": "\n".join([NOTE + PRELUDE, *map(wrapped, program.lines)]) + "\n",
        "python.c": "\n".join([NOTE, *python]) + "\n",
    }
