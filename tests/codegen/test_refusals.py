"""What is outside of the kernel's Python is refused with file and line."""

import re
from pathlib import Path

import pytest

from cca_core.codegen import TranslationError, translate

HEAD = """
import math
from typing import Annotated

from cca_core.kernel.types import Flag, Grid, Int, Ints, Real, Reals, floor_within

Row = Annotated[Reals, "n"]
LIMIT = 3.0


class Work:
    n: Int
    done: Flag
    value: Real
    x: Row
    grid: Annotated[Grid, "n", "n"]
    marks: Annotated[Ints, "n"]


def change(w: Work) -> Real:
    w.value = 1.0
    return 2.0


def pair(a: Real) -> tuple[Real, Int]:
    return a, 1


"""
BODIES = {
    "constant_as_variable": ("y = LIMIT\nLIMIT = 2.0\nreturn y", "LIMIT is a word of C or in use"),
    "class_as_variable": ("Work = 2.0\nreturn Work", "Work is a word of C or in use"),
    "builtin_as_variable": ("max = a\nreturn max", "max is a word of C"),
    "foreign_letter": ("δ = a\nreturn δ", "δ is a word of C"),
    "negated_part": ("w.done = n > 1 or not a > 1.0\nreturn a", "NaN passes"),
    "use_before_assignment": ("return y", "y is not known here"),
    "one_branch_only": ("if a > 0.0:\n    y = 1.0\nreturn y", "y is assigned in an inner block only"),
    "both_branches_only": ("if a > 0.0:\n    y = 1.0\nelse:\n    y = 2.0\nreturn y", "inner block only"),
    "loop_only": ("for i in range(n):\n    y = a\nreturn y", "inner block only"),
    "loop_variable_after_loop": (
        "for i in range(n):\n    pass\nreturn float(i)",
        "i is assigned in an inner",
    ),
    "word_of_c": ("long = a\nreturn long", "long is a word of C"),
    "function_of_libm": ("sin = a\nreturn sin", "sin is a word of C"),
    "name_of_function": ("change = a\nreturn change", "change is a word of C or in use"),
    "trailing_underscore": ("turn1_ = a\nreturn turn1_", "turn1_ is a word of C"),
    "int_of_real": ("return float(int(a))", "use floor_within"),
    "math_floor": ("return float(math.floor(a))", "use floor_within"),
    "round": ("return round(a)", "use floor_within"),
    "hypot": ("return math.hypot(a, a)", r"math.hypot\(Real, Real\)"),
    "real_bound": ("for i in range(a):\n    pass\nreturn a", "between whole numbers"),
    "divided_bound": ("for i in range(n / 2):\n    pass\nreturn a", "between whole numbers"),
    "variable_step": ("for i in range(0, n, n):\n    pass\nreturn a", "step must be a literal"),
    "zero_step": ("for i in range(0, n, 0):\n    pass\nreturn a", "step must be a literal"),
    "while": ("while a > 0.0:\n    pass\nreturn a", "While"),
    "for_in_row": ("for y in w.x:\n    pass\nreturn a", "For"),
    "for_else": ("for i in range(n):\n    pass\nelse:\n    pass\nreturn a", "For"),
    "assigned_loop_variable": ("for i in range(n):\n    i = 2\nreturn a", "must not be assigned"),
    "used_loop_variable": ("i = 1\nfor i in range(n):\n    pass\nreturn a", "in use"),
    "assigned_argument": ("a = 1.0\nreturn a", "argument"),
    "updated_argument": ("a += 1.0\nreturn a", "argument"),
    "nan_lowers_flag": ("ok = True\nif a > 1.0:\n    ok = False\nreturn 1.0 if ok else 0.0", "NaN passes"),
    "nan_lowers_field": ("if a > 1.0 or n > 1:\n    w.done = False\nreturn a", "NaN passes"),
    "nan_in_elif": ("if n > 1:\n    pass\nelif a > 1.0:\n    w.done = False\nreturn a", "NaN passes"),
    "negated_comparison": ("w.done = not a > 1.0\nreturn a", "NaN passes"),
    "other_kind": ("y = 1.0\ny = 1\nreturn y", "Int where Real belongs"),
    "int_for_real_field": ("w.value = 0\nreturn a", "Int where Real belongs"),
    "int_returned": ("return 1", "Int where Real belongs"),
    "nothing_returned": ("return", "None where Real"),
    "no_return": ("y = a", "must end with a return"),
    "return_in_one_branch": ("if a > 0.0:\n    return a", "must end with a return"),
    "number_as_condition": ("if n:\n    return a\nreturn a", "condition must be"),
    "flag_added": ("return a + (a > 1.0)", "only numbers"),
    "flags_compared": ("if w.done == True:\n    return a\nreturn a", "only numbers are compared"),
    "kinds_of_choice": ("return 1 if a > 0.0 else 2.0", "Real where Int belongs"),
    "negative_index": ("return w.x[-1]", "index from the end"),
    "real_index": ("return w.x[a]", "index must be an Int"),
    "flag_index": ("return w.x[w.done]", "index must be an Int"),
    "row_with_two_indices": ("return w.x[0, 0]", "a row has one index"),
    "grid_with_one_index": ("return w.grid[0]", "a grid has two"),
    "slice": ("y = w.x[1:2]\nreturn a", "not part"),
    "unknown_field": ("return w.y", "has no field y"),
    "field_of_number": ("return a.real", "has no field real"),
    "assigned_array": ("w.x = w.x\nreturn a", "must not be replaced"),
    "assigned_size": ("w.n = 3\nreturn a", "size of an array"),
    "updated_size": ("w.n += 3\nreturn a", "size of an array"),
    "array_in_branch": ("if a > 0.0:\n    y = w.x\nreturn a", "named once"),
    "array_twice": ("y = w.x\ny = w.x\nreturn a", "named once"),
    "array_updated": ("w.x += 1.0\nreturn a", "not part"),
    "power": ("return a**2", "not part"),
    "int_power": ("return a * (n**2)", "not part"),
    "quotient_by_variable": ("return float(n // n)", "positive literal"),
    "quotient_by_zero": ("return float(n // 0)", "positive literal"),
    "real_quotient": ("return a // 2", "positive literal"),
    "real_rest": ("return a % 2", "positive literal"),
    "bits": ("return float(n & 1)", "not part"),
    "chained_call": ("return 1.0 if 0.0 < change(w) < 1.0 else a", "between two comparisons"),
    "is": ("return 1.0 if a is a else 2.0", "compared by"),
    "changing_operand": ("return w.value + change(w)", "must not be an operand"),
    "changing_argument": ("return max(a, change(w))", "must not be an operand"),
    "wrong_argument": ("return change(a)", "takes Work, was given Real"),
    "int_argument": ("y, k = pair(n)\nreturn y", "takes Real, was given Int"),
    "missing_argument": ("return change()", "takes 1 arguments, was given 0"),
    "keyword_argument": ("return change(w=w)", "not part"),
    "unknown_function": ("return late(w)", "not a function defined before"),
    "recursion": ("return subject(n, a, w)", "not a function defined before"),
    "group_as_number": ("y = pair(a)\nreturn a", "must be a number"),
    "short_unpacking": ("x, y, z = pair(a)\nreturn a", "3 variables do not receive"),
    "unpacked_number": ("x, y = change(w)\nreturn a", "2 variables do not receive"),
    "unpacked_values": ("x, y = 1.0, 2.0\nreturn x", "must be a number|not part"),
    "two_targets": ("x = y = 1.0\nreturn x", "Assign of this form"),
    "starred": ("return max(*w.x)", "not part"),
    "string": ("return 'a'", "not part"),
    "list": ("y = [a]\nreturn a", "not part"),
    "walrus": ("if (y := a) > 0.0:\n    return y\nreturn a", "not part|inner"),
    "large_int": ("return a * 4294967296", "does not fit"),
    "large_real": ("return 1e999", "math.inf"),
    "nan": ("return math.nan", "no field nan"),
    "try": ("try:\n    return a\nfinally:\n    pass", "Try"),
    "raise": ("raise ValueError", "Raise"),
    "assert": ("assert a > 0.0\nreturn a", "Assert"),
    "nested_function": ("def f() -> Real:\n    return a\nreturn a", "FunctionDef"),
    "annotated_variable": ("y: Real = a\nreturn y", "AnnAssign"),
    "delete": ("del a\nreturn 1.0", "Delete"),
    "value_alone": ("a\nreturn a", "Expr"),
    "break_outside": ("if a > 0.0:\n    break\nreturn a", "outside|Break"),
    "abs_of_int": ("return float(abs(n))", r"abs\(Int\)"),
    "mixed_max": ("return max(a, n)", r"max\(Real, Int\)"),
    "one_argument_max": ("return max(a)", r"max\(Real\)"),
}
MODULES = {
    "global": ("values = [1.0]", "not part"),
    "expression": ("print(1)", "a module holds"),
    "import": ("import numpy", "a module holds"),
    "import_as": ("import math as m", "a module holds"),
    "foreign_import": ("from numpy import sin", "a kernel imports"),
    "library_import": ("from cca_core.geometry import box_gap", "a kernel imports"),
    "flag_with_value": ("class Other:\n    n: Int = 3", "only fields"),
    "method": ("class Other:\n    def f(self) -> Real:\n        return 1.0", "only fields"),
    "base_class": ("class Other(Work):\n    k: Int", "no base"),
    "word_as_field": ("class Other:\n    double: Real", "word of C"),
    "field_twice": ("class Other:\n    k: Real\n    k: Int", "defined twice"),
    "class_in_class": ("class Other:\n    w: Work", "no number or array"),
    "missing_size": ('class Other:\n    x: Annotated[Reals, "k"]', "must be sums"),
    "real_size": ('class Other:\n    k: Real\n    x: Annotated[Reals, "k"]', "must be sums"),
    "field_without_size": ("class Other:\n    x: Reals", "must be sums"),
    "difference_as_size": ('class Other:\n    n: Int\n    x: Annotated[Reals, "n - 1"]', "must be sums"),
    "call_as_size": ('class Other:\n    n: Int\n    x: Annotated[Reals, "abs(n)"]', "must be sums"),
    "import_as_other": ("from cca_core.kernel.types import Int as Whole", "as they are"),
    "alias_twice": ('Row = Annotated[Reals, "n"]', "defined twice"),
    "constant_twice": ("LIMIT = 4.0", "defined twice"),
    "comment_begin": ('def f(a: Real) -> Real:\n    """Begin /* here."""\n    return a', "comment of C"),
    "unknown_type": ("def f(a: float) -> Real:\n    return a", "float is not a type"),
    "no_type": ("def f(a) -> Real:\n    return a", "nothing is not a type"),
    "no_return_type": ("def f(a: Real):\n    return a", "nothing is not a type"),
    "default": ("def f(a: Real = 1.0) -> Real:\n    return a", "plain arguments"),
    "keyword_only": ("def f(*, a: Real) -> Real:\n    return a", "plain arguments"),
    "positional_only": ("def f(a: Real, /) -> Real:\n    return a", "plain arguments"),
    "decorator": ("@staticmethod\ndef f(a: Real) -> Real:\n    return a", "plain arguments"),
    "twice": ("def change(a: Real) -> Real:\n    return a", "defined twice"),
    "word_as_function": ("def register(a: Real) -> Real:\n    return a", "word of C"),
    "word_as_argument": ("def f(register: Real) -> Real:\n    return register", "word of C"),
    "comment_end": ('def f(a: Real) -> Real:\n    """End */ here."""\n    return a', "comment of C"),
    "constant_of_text": ("NAME = 'a'", "not part"),
    "public_without_size": ('__all__ = ["f"]\ndef f(x: Reals) -> Real:\n    return x[0]', "must be sums"),
    "public_but_missing": ('__all__ = ["late"]', "late in __all__"),
    "async": ("async def f(a: Real) -> Real:\n    return a", "a module holds"),
}


def refused(folder: Path, text: str) -> str:
    """Return the message about a module."""
    (folder / "case.py").write_text(text, encoding="utf-8")
    with pytest.raises(TranslationError) as caught:
        translate(folder)
    return str(caught.value)


@pytest.mark.parametrize("name", BODIES)
def test_body_is_refused_with_line(name: str, tmp_path: Path) -> None:
    body, message = BODIES[name]
    begin = HEAD + "def subject(n: Int, a: Real, w: Work) -> Real:\n"
    text = begin + "".join(f"    {line}\n" for line in body.split("\n"))
    found = re.fullmatch(r"case\.py:(\d+): (.+)", refused(tmp_path, text))
    assert found is not None
    assert begin.count("\n") <= int(found[1]) <= text.count("\n")
    assert re.search(message, found[2]), found[2]


@pytest.mark.parametrize("name", MODULES)
def test_module_is_refused_with_line(name: str, tmp_path: Path) -> None:
    text, message = MODULES[name]
    found = re.fullmatch(r"case\.py:(\d+): (.+)", refused(tmp_path, HEAD + text + "\n"))
    assert found is not None
    assert int(found[1]) > 0
    assert re.search(message, found[2]), found[2]


def test_kernels_of_two_modules_have_other_names(tmp_path: Path) -> None:
    text = '__all__ = ["f"]\nfrom cca_core.kernel.types import Real\ndef f(a: Real) -> Real:\n    return a\n'
    (tmp_path / "other.py").write_text(text, encoding="utf-8")
    assert "cca_f is a name in C of another module" in refused(tmp_path, text)


def test_text_of_a_module_does_not_end_a_comment(tmp_path: Path) -> None:
    assert "comment of C" in refused(tmp_path, '"""One */ two."""\n')


def test_imported_name_must_be_new(tmp_path: Path) -> None:
    (tmp_path / "other.py").write_text("LIMIT = 2.0\n", encoding="utf-8")
    text = "LIMIT = 3.0\nfrom cca_core.kernel.other import LIMIT\n"
    assert "LIMIT is defined twice" in refused(tmp_path, text)


def test_modules_do_not_import_each_other(tmp_path: Path) -> None:
    (tmp_path / "other.py").write_text("from cca_core.kernel.case import f\n", encoding="utf-8")
    assert "import each other" in refused(tmp_path, "from cca_core.kernel.other import g\n")
