"""Functions of the kernel's Python in C."""

import ast
from collections.abc import Iterator

from cca_core.codegen.expressions import BINARY, INT, MATH, REAL, Expressions, Scope, Term
from cca_core.codegen.kinds import Array, Group, Scalar, Signature, Source, Structure, c_type, declare

# words and macros of C, and names that the C of the kernel uses itself
RESERVED = MATH.keys() | set(
    """auto bool break case char const continue default do double else enum extern false float for goto if
    inline int long register restrict return short signed sizeof static struct switch true typedef union
    unsigned void volatile while I NULL EOF NAN INFINITY HUGE_VAL main floor fabs isfinite isnan real_max
    real_min int_max int_min int_floor int_rest floor_within abs float int math max min range""".split()
)
ORDERED = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)


class Function(Expressions):
    """Translate one function; a variable has the kind of its first assignment."""

    def __init__(self, source: Source, scope: Scope, node: ast.FunctionDef, signature: Signature) -> None:
        super().__init__(source, scope)
        self.node, self.signature = node, signature
        self.loops: list[str] = []  # variables of the loops around here
        self.variables = dict(signature.arguments)
        self.assigned = {
            n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
        }
        self.results = 0  # groups received so far
        self.depth = 0
        for name in (*self.variables, *self.assigned):
            if name in RESERVED or name in scope or not is_plain(name):
                source.fail(node, f"{name} is a word of C or in use, it must not name a variable")

    def lines(self) -> list[str]:
        """Translate the function to lines of C."""
        comment = self.source.comment(self.node, ast.get_docstring(self.node))
        body = self.node.body[1:] if comment else self.node.body
        text = self.block(body)
        if self.signature.returns is not None and not ends(body):
            self.source.fail(self.node, "a function that returns something must end with a return")
        return ["", *comment, self.head(), "{", *text, "}"]

    def declaration(self) -> list[str]:
        """Return the lines of the header: docstring, sizes of arrays, declaration."""
        arrays = [(name, kind) for name, kind in self.signature.arguments.items() if isinstance(kind, Array)]
        sizes = ", ".join(f"{name}{kind.sizes}" for name, kind in arrays)
        text = "\n   ".join(filter(None, (ast.get_docstring(self.node), sizes)))
        return ["", *self.source.comment(self.node, text or None), f"{self.head()};"]

    def head(self) -> str:
        """Declare the function."""
        signature = self.signature
        takes = ", ".join(
            declare(kind, name, isinstance(kind, Array | Structure) and name not in signature.changed)
            for name, kind in signature.arguments.items()
        )
        return f"{c_type(signature.returns)} {signature.c_name}({takes or 'void'})"

    def block(self, statements: list[ast.stmt]) -> list[str]:
        """Translate a block; what is first assigned in it is not known outside."""
        before = dict(self.variables)
        self.depth += 1
        lines: list[str] = []
        for statement in statements:
            lines += ["    " + line for line in self.statement(statement)]
        self.depth -= 1
        self.variables = before
        return lines

    def statement(self, node: ast.stmt) -> list[str]:
        """Translate a statement to lines without their margin."""
        match node:
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=ast.Call() as value):
                return self.unpacking(node, targets, self.term(value))
            case ast.Assign(targets=[target], value=value):
                self.check_flag(value)
                return [self.assignment(node, target, self.term(value))]
            case ast.AugAssign(target=target, op=op, value=value) if type(op) in BINARY:
                return [self.update(node, target, BINARY[type(op)][0], self.operand(value))]
            case ast.If(test=test, body=body, orelse=other):
                return self.branch(node, test, body, other)
            case ast.For(
                target=ast.Name(id=name), iter=ast.Call(func=ast.Name(id="range"), args=args), orelse=[]
            ):
                return self.loop(node, name, args)
            case ast.Return(value=value):
                return [self.result(node, value)]
            case ast.Expr(value=ast.Call() as call):
                return [f"{self.term(call).text};"]
            case ast.Break() | ast.Continue() if self.loops:
                return [f"{type(node).__name__.lower()};"]
            case ast.Pass():
                return []
        self.source.fail(node, f"{type(node).__name__} of this form is not part of the kernel's Python")

    def assignment(self, node: ast.stmt, target: ast.expr, term: Term) -> str:
        """Assign to a variable, a field or an element."""
        if not isinstance(target, ast.Name):
            if not isinstance(target, ast.Attribute | ast.Subscript):
                self.source.fail(node, "a value is assigned to a variable, a field or an element")
            to = self.term(target)
            self.same(node, to.kind, term.kind)
            if isinstance(to.kind, Array):
                self.source.fail(node, "the array of a field is lent, it must not be replaced")
            self.check_size(node, target)
            return f"{to.text} = {term.text};"
        name = target.id
        if name in self.signature.arguments or name in self.loops:
            self.source.fail(node, f"{name} is an argument or a loop's variable, it must not be assigned")
        if isinstance(term.kind, Array):
            if self.depth > 1 or name in self.variables:
                self.source.fail(node, f"the array {name} must be named once, outside of loops and branches")
            self.variables[name] = term.kind
            return f"{declare(term.kind, name, name not in self.changed_aliases())} = {term.text};"
        if not isinstance(term.kind, Scalar):
            self.source.fail(node, f"{name} must be a number, a Flag or an array, was {term.kind}")
        if name not in self.variables:
            self.variables[name] = term.kind
            return f"{declare(term.kind, name)} = {term.text};"
        self.same(node, self.variables[name], term.kind)
        return f"{name} = {term.text};"

    def check_size(self, node: ast.stmt, target: ast.expr) -> None:
        """Refuse to change a field that sizes an array."""
        if isinstance(target, ast.Attribute) and isinstance(target.value, ast.Name):
            structure = self.variables[target.value.id]
            if isinstance(structure, Structure) and target.attr in sizes_of(structure):
                self.source.fail(node, f"{target.attr} is the size of an array, it must not be assigned")

    def changed_aliases(self) -> set[str]:
        """Names whose memory the function changes."""
        return changed_names(self.node, self.scope)

    def unpacking(self, node: ast.stmt, targets: list[ast.expr], term: Term) -> list[str]:
        """Assign the numbers that a function returns together."""
        if not isinstance(term.kind, Group) or len(term.kind.items) != len(targets):
            self.source.fail(node, f"{len(targets)} variables do not receive {term.kind}")
        self.results += 1
        name = f"result{self.results}_"
        lines = [f"const {term.kind.name} {name} = {term.text};"]
        for i, (target, kind) in enumerate(zip(targets, term.kind.items, strict=True)):
            if isinstance(target, ast.Name) and target.id == "_":
                continue
            lines.append(self.assignment(node, target, Term(f"{name}.item{i}", kind)))
        return lines

    def update(self, node: ast.stmt, target: ast.expr, sign: str, term: Term) -> str:
        """Change a number in its memory."""
        if isinstance(target, ast.Name) and (
            target.id in self.signature.arguments or target.id in self.loops
        ):
            self.source.fail(
                node, f"{target.id} is an argument or a loop's variable, it must not be assigned"
            )
        to = self.term(target)
        if to.kind is not REAL and (to.kind, term.kind, sign in "+-*") != (INT, INT, True):
            self.source.fail(node, f"{to.kind} {sign}= {term.kind} is not part of the kernel's Python")
        if term.kind not in (REAL, INT):
            self.source.fail(node, "only numbers are added and multiplied")
        self.check_size(node, target)
        return f"{to.text} {sign}= {term.text};"

    def branch(self, node: ast.If, test: ast.expr, body: list[ast.stmt], other: list[ast.stmt]) -> list[str]:
        """Translate `if`, `elif` and `else`."""
        if any(map(lowers_flag, body)) and self.orders_reals(test):
            self.source.fail(node, "NaN passes this comparison: write `if not ...` with the opposite one")
        lines = [f"if ({self.condition(test).text}) {{", *self.block(body)]
        if len(other) == 1 and isinstance(other[0], ast.If):
            first, *rest = self.statement(other[0])
            return [*lines, f"}} else {first}", *rest]
        if other:
            lines += ["} else {", *self.block(other)]
        return [*lines, "}"]

    def loop(self, node: ast.For, name: str, given: list[ast.expr]) -> list[str]:
        """Translate a loop over whole numbers; its bounds are read once."""
        if name in self.variables:
            self.source.fail(node, f"the loop's variable {name} is in use")
        bounds = [self.operand(each) for each in given]
        if any(bound.kind is not INT for bound in bounds):
            self.source.fail(node, "a loop must run between whole numbers")
        step = ast.unparse(given[2]) if len(given) == 3 else "1"
        if not step.removeprefix("-").isdigit() or int(step) == 0:
            self.source.fail(node, "a loop's step must be a literal other than 0")
        low, high = ("0", bounds[0].text) if len(bounds) == 1 else (bounds[0].text, bounds[1].text)
        variable = f"turn{self.depth}_" if name == "_" else name
        if name != "_":
            self.variables[name] = INT
        self.loops.append(name)
        inner = self.block(node.body)
        self.loops.pop()
        self.variables.pop(name, None)  # after its loop it has no value in C
        if not high.isdigit():
            low, high = f"{low}, {variable}_end_ = {high}", f"{variable}_end_"
        sign, change = (">", f"-= {step[1:]}") if step[0] == "-" else ("<", f"+= {step}")
        return [
            f"for (int {variable} = {low}; {variable} {sign} {high}; {variable} {change}) {{",
            *inner,
            "}",
        ]

    def result(self, node: ast.Return, value: ast.expr | None) -> str:
        """Translate a return."""
        expected = self.signature.returns
        if value is None:
            self.same(node, expected, None)
            return "return;"
        if isinstance(expected, Group) and isinstance(value, ast.Tuple):
            terms = [self.operand(each) for each in value.elts]
            self.same(node, expected, Group(tuple(t.kind for t in terms if isinstance(t.kind, Scalar))))
            return f"return ({expected.name}){{{', '.join(term.text for term in terms)}}};"
        self.check_flag(value)
        term = self.term(value)
        self.same(node, expected, term.kind)
        return f"return {term.text};"

    def check_flag(self, value: ast.expr) -> None:
        """Refuse a flag that NaN raises: one from a comparison that must not hold."""
        for part in value.values if isinstance(value, ast.BoolOp) else [value]:
            match part:
                case ast.UnaryOp(op=ast.Not(), operand=operand) if self.orders_reals(operand):
                    self.source.fail(
                        value, "NaN passes this comparison: write the opposite one without `not`"
                    )

    def orders_reals(self, test: ast.expr) -> bool:
        """Return whether a condition is, or is joined of, comparisons of reals that fail for NaN."""
        if isinstance(test, ast.BoolOp):
            return any(map(self.orders_reals, test.values))
        if not isinstance(test, ast.Compare) or not any(isinstance(op, ORDERED) for op in test.ops):
            return False
        return any(self.operand(side).kind is REAL for side in (test.left, *test.comparators))


def is_plain(name: str) -> bool:
    """Return whether C takes a name, and the translator does not make it itself."""
    return name == "_" or (name.isascii() and not name.endswith("_"))


def lowers_flag(node: ast.stmt) -> bool:
    """Return whether a statement assigns or returns False."""
    value = node.value if isinstance(node, ast.Assign | ast.Return) else None
    return isinstance(value, ast.Constant) and value.value is False


def ends(body: list[ast.stmt]) -> bool:
    """Return whether a block always returns."""
    last = body[-1] if body else None
    if isinstance(last, ast.If):
        return ends(last.body) and ends(last.orelse)
    return isinstance(last, ast.Return)


def sizes_of(structure: Structure) -> set[str]:
    """Names in the sizes of a structure's arrays."""
    sizes = (size for kind in structure.fields.values() if isinstance(kind, Array) for size in kind.shape)
    return {n.id for size in sizes for n in ast.walk(ast.parse(size)) if isinstance(n, ast.Name)}


def changed_names(node: ast.FunctionDef, scope: Scope) -> set[str]:
    """Names of arguments and arrays whose memory a function changes, itself or by what it calls."""
    changed = set(directly_changed(node, scope))
    # an array that has a name of its own: `x = w.x`
    for part in reversed(list(ast.walk(node))):
        match part:
            case ast.Assign(
                targets=[ast.Name(id=alias)],
                value=ast.Attribute(value=ast.Name(id=owner)) | ast.Name(id=owner),
            ) if alias in changed:
                changed.add(owner)
    return changed


def directly_changed(node: ast.FunctionDef, scope: Scope) -> Iterator[str]:
    """Names that stand before what a function assigns."""
    for part in ast.walk(node):
        match part:
            case ast.Attribute(ctx=ast.Store()) | ast.Subscript(ctx=ast.Store()):
                yield root(part)
            case ast.Call(func=ast.Name(id=name), args=given):
                function = scope.get(name)
                if isinstance(function, Signature):
                    names = zip(function.arguments, given, strict=False)
                    yield from (root(each) for argument, each in names if argument in function.changed)


def root(node: ast.expr) -> str:
    """Name at the beginning of a.b[c]."""
    while isinstance(node, ast.Attribute | ast.Subscript):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""
