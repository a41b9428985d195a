"""Expressions of the kernel's Python in C."""

import ast
import math
from typing import NamedTuple

from cca_core.codegen.kinds import Array, Constant, Kind, Scalar, Signature, Source, Structure

REAL, INT, FLAG = Scalar.REAL, Scalar.INT, Scalar.FLAG
# functions that C's libm and Python's math have in common, bit for bit on one machine
MATH = dict.fromkeys(("sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "exp", "log"), 1)
MATH |= dict.fromkeys(("atan2", "copysign", "fmod", "pow", "remainder"), 2)
CHECKS = {"isfinite": "isfinite", "isnan": "isnan"}
# ranks of C's operators: what binds less is put into brackets
ATOM, PREFIX, PRODUCT, SUM, ORDER, ALL, ANY, CHOICE = 20, 14, 13, 12, 10, 5, 4, 3
BINARY = {ast.Add: ("+", SUM), ast.Sub: ("-", SUM), ast.Mult: ("*", PRODUCT), ast.Div: ("/", PRODUCT)}
COMPARE = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}

Scope = dict[str, Constant | Structure | Signature]


class Term(NamedTuple):
    """Expression in C."""

    text: str
    kind: Kind
    rank: int = ATOM

    def within(self, rank: int) -> str:
        """Text in brackets where it binds less than what is around it."""
        return f"({self.text})" if self.rank < rank else self.text


class Expressions:
    """Translate the expressions of one function."""

    def __init__(self, source: Source, scope: Scope) -> None:
        self.source, self.scope = source, scope
        self.variables: dict[str, Kind] = {}
        self.assigned: set[str] = set()  # anywhere in the function
        self.is_inner = False  # in an operation, whose operands C evaluates in any order

    def term(self, node: ast.expr) -> Term:
        """Translate an expression."""
        match node:
            case ast.Constant(value=bool() as value):
                return Term("true" if value else "false", FLAG)
            case ast.Constant(value=int() | float() as value):
                return self.number(node, value)
            case ast.Name(id=name):
                return self.named(node, name)
            case ast.Attribute(value=ast.Name(id="math"), attr="inf" | "pi" as name):
                return Term({"inf": "HUGE_VAL", "pi": repr(math.pi)}[name], REAL)
            case ast.Attribute(value=ast.Name(id=owner), attr=name):
                return self.field(node, owner, name)
            case ast.Subscript(value=value, slice=at):
                return self.element(node, self.term(value), at)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self.negative(node, self.operand(operand))
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return Term(f"!{self.condition(operand).within(PREFIX)}", FLAG, PREFIX)
            case ast.BinOp(left=left, op=op, right=right):
                return self.operation(node, self.operand(left), op, self.operand(right))
            case ast.BoolOp(op=op, values=values):
                sign, rank = (" && ", ALL) if isinstance(op, ast.And) else (" || ", ANY)
                return Term(sign.join(self.condition(v).within(ALL + 1) for v in values), FLAG, rank)
            case ast.Compare(left=left, ops=ops, comparators=others):
                return self.comparison(node, ops, [left, *others])
            case ast.IfExp(test=test, body=body, orelse=other):
                is_so, a, b = self.condition(test), self.term(body), self.term(other)
                self.same(node, a.kind, b.kind)
                text = f"{is_so.within(CHOICE + 1)} ? {a.within(CHOICE + 1)} : {b.within(CHOICE + 1)}"
                return Term(text, a.kind, CHOICE)
            case ast.Call(func=ast.Name() | ast.Attribute() as function, args=given, keywords=[]):
                return self.call(node, ast.unparse(function), [self.operand(each) for each in given])
        self.source.fail(node, f"{ast.unparse(node)} is not part of the kernel's Python")

    def operand(self, node: ast.expr) -> Term:
        """Translate a part of an operation."""
        before, self.is_inner = self.is_inner, True
        term = self.term(node)
        self.is_inner = before
        return term

    def condition(self, node: ast.expr) -> Term:
        """Translate a flag."""
        term = self.term(node)
        if term.kind is not FLAG:
            self.source.fail(node, f"a condition must be a comparison or a Flag, was {term.kind}")
        return term

    def same(self, node: ast.AST, expected: Kind, kind: Kind) -> None:
        """Refuse a value of another kind; a whole number is no real one here, as its digits would differ."""
        if expected != kind:
            self.source.fail(node, f"{kind} where {expected} belongs (a real zero is 0.0)")

    def number(self, node: ast.expr, value: int | float) -> Term:
        """Translate a literal."""
        if isinstance(value, int) and not -(2**31) < value < 2**31:
            self.source.fail(node, f"{value} does not fit into an Int")
        if not math.isfinite(value):
            self.source.fail(node, "an infinite number is math.inf")
        return Term(repr(value), INT if type(value) is int else REAL)

    def named(self, node: ast.expr, name: str) -> Term:
        """Translate a variable or a constant."""
        if name in self.variables:
            return Term(name, self.variables[name])
        if name in self.assigned:
            self.source.fail(node, f"{name} is assigned in an inner block only, assign it before")
        found = self.scope.get(name)
        if isinstance(found, Constant):
            return Term(found.c_name, found.kind)
        self.source.fail(node, f"{name} is not known here")

    def field(self, node: ast.expr, owner: str, name: str) -> Term:
        """Translate a field of a structure."""
        kind = self.variables.get(owner)
        if not isinstance(kind, Structure) or name not in kind.fields:
            self.source.fail(node, f"{owner} has no field {name}")
        return Term(f"{owner}->{name}", in_structure(kind.fields[name], owner, kind))

    def element(self, node: ast.expr, of: Term, at: ast.expr) -> Term:
        """Translate an element of a row or a grid."""
        indices = at.elts if isinstance(at, ast.Tuple) else [at]
        if not isinstance(of.kind, Array) or len(indices) != max(len(of.kind.shape), 1):
            self.source.fail(node, "a row has one index, a grid has two")
        terms = [self.operand(index) for index in indices]
        if any(term.kind is not INT for term in terms):
            self.source.fail(node, "an index must be an Int")
        if any(term.text.startswith("-") for term in terms):
            self.source.fail(node, "an index from the end means something else in C")
        if len(terms) == 1:
            return Term(f"{of.text}[{terms[0].text}]", of.kind.element)
        row, column = terms
        text = f"{of.text}[{row.within(PRODUCT)} * {of.kind.shape[1]} + {column.within(SUM)}]"
        return Term(text, of.kind.element)

    def negative(self, node: ast.expr, term: Term) -> Term:
        """Translate a number with its sign changed."""
        if term.kind not in (REAL, INT):
            self.source.fail(node, "only a number has a sign")
        return Term(f"-{term.within(PREFIX + 1)}", term.kind, PREFIX)

    def operation(self, node: ast.expr, a: Term, op: ast.operator, b: Term) -> Term:
        """Translate an operation on two numbers."""
        if a.kind not in (REAL, INT) or b.kind not in (REAL, INT):
            self.source.fail(node, "only numbers are added and multiplied")
        is_whole = a.kind is INT and b.kind is INT
        if isinstance(op, ast.FloorDiv | ast.Mod):
            if not is_whole or not b.text.isdigit() or b.text == "0":
                self.source.fail(node, "// and % take an Int and a positive literal")
            name = "int_floor" if isinstance(op, ast.FloorDiv) else "int_rest"
            return Term(f"{name}({a.text}, {b.text})", INT)
        if type(op) not in BINARY:
            self.source.fail(node, f"{ast.unparse(node)} is not part of the kernel's Python")
        sign, rank = BINARY[type(op)]
        left, right = a.within(rank), b.within(rank + 1)
        if is_whole and sign == "/":
            left, is_whole = f"(double){a.within(PREFIX)}", False
        return Term(f"{left} {sign} {right}", INT if is_whole else REAL, rank)

    def comparison(self, node: ast.expr, ops: list[ast.cmpop], sides: list[ast.expr]) -> Term:
        """Translate a comparison of numbers, which may have several sides."""
        if any(type(op) not in COMPARE for op in ops):
            self.source.fail(node, "numbers are compared by < <= > >= == !=")
        if any(isinstance(part, ast.Call) for side in sides[1:-1] for part in ast.walk(side)):
            self.source.fail(node, "a call must not stand between two comparisons")
        terms = [self.operand(side) for side in sides]
        if any(term.kind not in (REAL, INT) for term in terms):
            self.source.fail(node, "only numbers are compared")
        texts = [term.within(ORDER + 1) for term in terms]
        pairs = [f"{a} {COMPARE[type(op)]} {b}" for a, op, b in zip(texts, ops, texts[1:], strict=False)]
        return Term(" && ".join(pairs), FLAG, ORDER if len(pairs) == 1 else ALL)

    def call(self, node: ast.expr, name: str, given: list[Term]) -> Term:
        """Translate a call."""
        kinds = [term.kind for term in given]
        texts = ", ".join(term.text for term in given)
        function = self.scope.get(name)
        if isinstance(function, Signature):
            return self.known_call(node, function, given)
        if name in ("max", "min") and len(kinds) > 1 and len(set(kinds)) == 1 and kinds[0] in (REAL, INT):
            prefix = "real" if kinds[0] is REAL else "int"
            text = given[0].text
            for term in given[1:]:
                text = f"{prefix}_{name}({text}, {term.text})"
            return Term(text, kinds[0])
        if name == "abs" and kinds == [REAL]:
            return Term(f"fabs({texts})", REAL)
        if name == "float" and kinds == [INT]:
            return Term(f"(double){given[0].within(PREFIX)}", REAL, PREFIX)
        if name == "floor_within" and kinds == [REAL, INT, INT]:
            return Term(f"floor_within({texts})", INT)
        if name in ("int", "round", "math.floor", "math.ceil", "math.trunc"):
            self.source.fail(node, f"{name} has no value for NaN in C, use floor_within(value, low, high)")
        short = name.removeprefix("math.")
        if short != name and kinds == [REAL] * MATH.get(short, -1):
            return Term(f"{short}({texts})", REAL)
        if short != name and short in CHECKS and kinds == [REAL]:
            return Term(f"{CHECKS[short]}({texts})", FLAG)
        self.source.fail(node, f"{name}({', '.join(map(str, kinds))}) is not a function defined before")

    def known_call(self, node: ast.expr, function: Signature, given: list[Term]) -> Term:
        """Translate a call of a function of the kernel."""
        expected = list(function.arguments.values())
        if len(expected) != len(given):
            self.source.fail(node, f"{function.name} takes {len(expected)} arguments, was given {len(given)}")
        if function.changed and self.is_inner:
            self.source.fail(node, f"{function.name} changes its arguments, so it must not be an operand")
        for want, term in zip(expected, given, strict=True):
            if not alike(want, term.kind):
                self.source.fail(node, f"{function.name} takes {want}, was given {term.kind}")
        return Term(f"{function.c_name}({', '.join(term.text for term in given)})", function.returns)


def alike(expected: Kind, given: Kind) -> bool:
    """Return whether a value may be given for an argument; the sizes of arrays are the caller's duty."""
    if isinstance(expected, Array) and isinstance(given, Array):
        return expected.element is given.element and len(expected.shape) == len(given.shape)
    return expected == given


def in_structure(kind: Scalar | Array, owner: str, structure: Structure) -> Scalar | Array:
    """Kind of a field whose sizes are fields of the same structure."""
    if isinstance(kind, Scalar):
        return kind
    return Array(kind.element, tuple(c_size(size, f"{owner}->") for size in kind.shape))


def c_size(size: str, prefix: str = "") -> str:
    """Size in C: names get a prefix, sums are put into brackets."""
    tree = ast.parse(size, mode="eval").body
    for part in ast.walk(tree):
        if isinstance(part, ast.Name):
            part.id = prefix + part.id
    text = ast.unparse(tree)
    return text if isinstance(tree, ast.Name | ast.Constant) else f"({text})"
