"""The C that the translator makes: its form, and that of the library is the one checked in."""

from pathlib import Path

import pytest

from cca_core.codegen import translate
from cca_core.codegen.__main__ import FOLDER

TYPES = "from cca_core.kernel.types import Flag, Grid, Int, Ints, Real, Reals, floor_within\n"
TYPES = f"import math\nfrom typing import Annotated\n{TYPES}Row = Annotated[Reals, 'n']\n"


@pytest.fixture(scope="module")
def library() -> dict[str, str]:
    return translate(FOLDER)


def body(folder: Path, text: str) -> list[str]:
    """Return the lines of the last function of a module in C."""
    (folder / "case.py").write_text(TYPES + text, encoding="utf-8")
    lines = translate(folder)["kernel.c"].split("\n")
    begin = max(i for i, line in enumerate(lines) if line == "{")
    return [lines[begin - 1], *(line.strip() for line in lines[begin + 1 : -2])]


@pytest.mark.parametrize("name", ["kernel.h", "kernel.c", "python.c"])
def test_checked_in_file_is_what_is_made_now(library: dict[str, str], name: str) -> None:
    assert (FOLDER / "c" / name).read_text(encoding="utf-8") == library[name], "run `make kernel`"


def test_translation_is_deterministic(library: dict[str, str]) -> None:
    assert translate(FOLDER) == library


def test_public_function_is_in_header(library: dict[str, str]) -> None:
    assert "double cca_oriented_box_gap(" in library["kernel.h"]
    assert "squared_distance" not in library["kernel.h"]


def test_header_states_sizes_of_arrays(tmp_path: Path) -> None:
    text = '__all__ = ["f"]\nclass Work:\n    """Memory."""\n    n: Int\n'
    text += '    x: Annotated[Grid, "n", "n + 1"]\n'
    text += 'def f(w: Work, n: Int, x: Row) -> Real:\n    """Zero."""\n    return 0.0\n'
    (tmp_path / "case.py").write_text(TYPES + text, encoding="utf-8")
    header = translate(tmp_path)["kernel.h"]
    assert "/* Memory. */\ntypedef struct Work {\n    int n;\n    double *x; /* [n][n + 1] */\n" in header
    assert "/* Zero.\n   x[n] */\ndouble cca_f(const Work *w, int n, const double *x);\n" in header


def test_lines_are_short(library: dict[str, str]) -> None:
    assert max(len(line) for line in library["kernel.c"].split("\n")) <= 110


def test_arguments_that_are_only_read_are_const(tmp_path: Path) -> None:
    text = "def copy(n: Int, a: Row, b: Row) -> None:\n    for i in range(n):\n        b[i] = a[i]\n"
    head, *_ = body(tmp_path, text)
    assert head == "static void case_copy(int n, const double *a, double *b)"


def test_argument_changed_by_a_call_is_not_const(tmp_path: Path) -> None:
    text = "def fill(n: Int, a: Row) -> None:\n    a[n - 1] = 1.0\n"
    text += "def twice(n: Int, b: Row, c: Row) -> Real:\n    x = b\n    fill(n, x)\n    return c[0]\n"
    head, *lines = body(tmp_path, text)
    assert head == "static double case_twice(int n, double *b, const double *c)"
    assert lines == ["double *x = b;", "case_fill(n, x);", "return c[0];"]


@pytest.mark.parametrize(
    ("python", "c"),
    [
        ("a - (b - a)", "a - (b - a)"),
        ("(a - b) - a", "a - b - a"),
        ("a / (b * a)", "a / (b * a)"),
        ("-(a + b)", "-(a + b)"),
        ("-(-a)", "-(-a)"),
        ("(a + b) * n", "(a + b) * n"),
        ("n / k", "(double)n / k"),
        ("a / (n / k)", "a / ((double)n / k)"),
        ("float(n + k)", "(double)(n + k)"),
        ("(a if n > 1 else b) + a", "(n > 1 ? a : b) + a"),
        ("a if n > 1 else b if k > 1 else a", "n > 1 ? a : (k > 1 ? b : a)"),
        ("max(a, b, a)", "real_max(real_max(a, b), a)"),
        ("float(max(n, k) // 2 % 3)", "(double)int_rest(int_floor(int_max(n, k), 2), 3)"),
        ("math.sqrt(abs(a)) + math.pi", "sqrt(fabs(a)) + 3.141592653589793"),
        ("-math.inf", "-HUGE_VAL"),
        ("1e-9 * a", "1e-09 * a"),
        ("float(floor_within(a, 0, n - 1))", "(double)floor_within(a, 0, n - 1)"),
        ("a if 0.0 < a <= b and not (n > 1 or k == 1) else b",
         "(0.0 < a && a <= b) && !(n > 1 || k == 1) ? a : b"),
    ],
)  # fmt: skip
def test_expression_keeps_order_of_arithmetic(tmp_path: Path, python: str, c: str) -> None:
    _, line = body(tmp_path, f"def f(n: Int, k: Int, a: Real, b: Real) -> Real:\n    return {python}\n")
    assert line == f"return {c};"


def test_loop_reads_its_bounds_once(tmp_path: Path) -> None:
    text = (
        "def f(n: Int) -> Int:\n    k = 0\n    for i in range(n - 1, -1, -2):\n        k += i\n    return k\n"
    )
    assert body(tmp_path, text)[2] == "for (int i = n - 1, i_end_ = -1; i > i_end_; i -= 2) {"


def test_several_results_are_a_structure(tmp_path: Path) -> None:
    text = "def pair(a: Real) -> tuple[Real, Int]:\n    return a, 1\n"
    text += "def use(a: Real) -> Real:\n    x, k = pair(a)\n    return x * k\n"
    assert body(tmp_path, text) == [
        "static double case_use(double a)",
        "const cca_di result1_ = case_pair(a);",
        "double x = result1_.item0;",
        "int k = result1_.item1;",
        "return x * k;",
    ]


def test_private_names_of_modules_do_not_clash(tmp_path: Path) -> None:
    text = TYPES + "LIMIT = -2.0\ndef norm(a: Real) -> Real:\n    return a * LIMIT\n"
    (tmp_path / "other.py").write_text(text, encoding="utf-8")
    (tmp_path / "case.py").write_text(text, encoding="utf-8")
    source = translate(tmp_path)["kernel.c"]
    assert "#define CASE_LIMIT (-2.0)" in source
    assert "#define OTHER_LIMIT (-2.0)" in source
