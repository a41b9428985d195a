"""The kernel's modules together: one program of C."""

import ast
from collections.abc import Mapping
from pathlib import Path

from cca_core.codegen.expressions import Expressions, Scope, c_size
from cca_core.codegen.functions import RESERVED, Function, changed_names, is_plain
from cca_core.codegen.kinds import (
    Array,
    Constant,
    Group,
    Kind,
    Scalar,
    Signature,
    Source,
    Structure,
    c_type,
    declare,
)

PACKAGE = "cca_core.kernel"
SIZE_PARTS = (ast.Name, ast.Constant, ast.BinOp, ast.Add, ast.Mult, ast.Load)
PRIMITIVE: dict[str, Kind] = {
    "Real": Scalar.REAL,
    "Int": Scalar.INT,
    "Flag": Scalar.FLAG,
    "Reals": Array(Scalar.REAL, ("",)),
    "Ints": Array(Scalar.INT, ("",)),
    "Grid": Array(Scalar.REAL, ("", "")),
}


class Program:
    """All that has been translated so far."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.scopes: dict[str, Scope] = {}
        self.aliases: dict[str, dict[str, Kind]] = {}  # types that a module names
        self.structures: dict[str, Structure] = {}
        self.groups: dict[str, Group] = {}
        self.kernels: dict[str, Signature] = {}  # what Python and C programs may call
        self.names: set[str] = set()  # in C
        self.header: list[str] = []
        self.lines: list[str] = []

    def add(self, name: str) -> None:
        """Translate a module, and before it those that it imports."""
        if name not in self.scopes:
            self.scopes[name] = {}
            Module(self, name).translate()


class Module:
    """Translate one module."""

    def __init__(self, program: Program, name: str) -> None:
        self.program, self.name = program, name
        self.source = Source(program.folder / f"{name}.py")
        self.scope = program.scopes[name]
        self.aliases = program.aliases[name] = {}
        self.public: set[str] = set()

    def translate(self) -> None:
        """Translate the module's statements in their order."""
        tree = ast.parse(self.source.path.read_text(encoding="utf-8"), str(self.source.path))
        for i, node in enumerate(tree.body):
            match node:
                case ast.Expr(value=ast.Constant(value=str(text))) if i == 0:
                    self.program.lines += ["", *self.source.comment(node, f"{self.name}.py: {text}")]
                case ast.Import(names=[ast.alias(name="math", asname=None)]):
                    pass
                case ast.ImportFrom(module=str(module), names=names, level=0):
                    self.imports(node, module, names)
                case ast.Assign(targets=[ast.Name(id="__all__")], value=ast.List(elts=names)):
                    self.public = {ast.literal_eval(each) for each in names}
                case ast.Assign(targets=[ast.Name(id=name)], value=ast.Subscript() as value):
                    self.check_new(node, name)
                    self.aliases[name] = self.kind(value)
                case ast.Assign(targets=[ast.Name(id=name)], value=value):
                    self.constant(node, name, value)
                case ast.ClassDef():
                    self.structure(node)
                case ast.FunctionDef():
                    self.function(node)
                case _:
                    self.source.fail(node, "a module holds imports, numbers, classes of fields and functions")
        for name in sorted(self.public):
            if not isinstance(self.scope.get(name), Signature | Structure):
                self.source.fail(tree.body[0], f"{name} in __all__ is neither a function nor a class")

    def imports(self, node: ast.stmt, module: str, names: list[ast.alias]) -> None:
        """Make the names of another module known."""
        if any(each.asname for each in names):
            self.source.fail(node, "a kernel imports names as they are")
        if module in ("typing", f"{PACKAGE}.types"):
            return
        if not module.startswith(f"{PACKAGE}."):
            self.source.fail(
                node, "a kernel imports math, typing and other kernels, by `from ... import name`"
            )
        other = module.removeprefix(f"{PACKAGE}.")
        self.program.add(other)
        for name in (each.name for each in names):
            if name in self.program.aliases[other]:
                self.check_new(node, name)
                self.aliases[name] = self.program.aliases[other][name]
            elif name in self.program.scopes[other]:
                self.define(node, name, self.program.scopes[other][name])
            else:
                self.source.fail(node, f"{name} is not defined in {other}.py, or the two import each other")

    def check_new(self, node: ast.AST, name: str) -> None:
        """Refuse a name that has a meaning."""
        taken = name in self.scope or name in self.aliases or name in PRIMITIVE
        if taken or name in RESERVED or not is_plain(name):
            self.source.fail(node, f"{name} is defined twice, or a word of C")

    def define(self, node: ast.AST, name: str, what: Constant | Structure | Signature) -> None:
        """Make a name known."""
        self.check_new(node, name)
        self.scope[name] = what

    def c_name(self, node: ast.AST, name: str) -> str:
        """Return a name in C, which no other module has."""
        if name in self.program.names:
            self.source.fail(node, f"{name} is a name in C of another module")
        self.program.names.add(name)
        return name

    def constant(self, node: ast.stmt, name: str, value: ast.expr) -> None:
        """Translate a number with a name."""
        term = Expressions(self.source, self.scope).term(value)
        if not isinstance(term.kind, Scalar):
            self.source.fail(node, f"{name} must be a number")
        self.check_new(node, name)
        c_name = self.c_name(node, f"{self.name}_{name}".upper())
        self.define(node, name, Constant(c_name, term.kind))
        self.program.lines.append(f"#define {c_name} {term.within(20)}")

    def structure(self, node: ast.ClassDef) -> None:
        """Translate a class of fields."""
        fields: dict[str, Scalar | Array] = {}
        for item in node.body:
            match item:
                case ast.Expr(value=ast.Constant(value=str())):
                    continue
                case ast.AnnAssign(target=ast.Name(id=name), value=None, annotation=annotation):
                    kind = self.kind(annotation)
                    if name in RESERVED or name in fields or not isinstance(kind, Scalar | Array):
                        self.source.fail(item, f"{name} is a word of C, defined twice, or no number or array")
                    fields[name] = kind
                case _:
                    self.source.fail(item, "a class of the kernel holds only fields with their types")
        if node.bases or node.decorator_list or node.name in self.program.structures:
            self.source.fail(node, f"{node.name} must have no base and a name of its own")
        structure = Structure(node.name, fields)
        for name, kind in fields.items():
            self.check_sizes(node, name, kind, fields)
        self.define(node, node.name, structure)
        self.program.structures[node.name] = structure
        lines = [f"typedef struct {node.name} {{"]
        for name, kind in fields.items():
            sizes = f" /* {kind.sizes} */" if isinstance(kind, Array) else ""
            lines.append(f"    {declare(kind, name)};{sizes}")
        comment = self.source.comment(node, ast.get_docstring(node))
        self.program.header += ["", *comment, *lines, f"}} {node.name};"]

    def check_sizes(self, node: ast.AST, name: str, kind: Kind, known: Mapping[str, Kind]) -> None:
        """Refuse an array whose sizes are not whole numbers next to it."""
        for size in kind.shape if isinstance(kind, Array) else ():
            parts = list(ast.walk(ast.parse(size or "None", mode="eval").body))
            names = [part.id for part in parts if isinstance(part, ast.Name)]
            is_sum = all(isinstance(part, SIZE_PARTS) for part in parts)
            if size in ("", "None") or not is_sum or any(known.get(each) is not Scalar.INT for each in names):
                self.source.fail(node, f"the sizes of {name} must be sums of Ints next to it, was {size!r}")

    def function(self, node: ast.FunctionDef) -> None:
        """Translate a function."""
        arguments = node.args
        if node.decorator_list or arguments.defaults or arguments.kwonlyargs or arguments.posonlyargs:
            self.source.fail(node, "a function must have plain arguments only")
        if arguments.vararg or arguments.kwarg:
            self.source.fail(node, "a function must have plain arguments only")
        kinds = {each.arg: self.kind(each.annotation, each) for each in arguments.args}
        is_public = node.name in self.public
        self.check_new(node, node.name)
        c_name = self.c_name(node, f"cca_{node.name}" if is_public else f"{self.name}_{node.name}")
        changed = frozenset(changed_names(node, self.scope) & kinds.keys())
        for name, kind in kinds.items():
            if is_public or (isinstance(kind, Array) and len(kind.shape) == 2):
                self.check_sizes(node, name, kind, kinds)
            if isinstance(kind, Array):
                kinds[name] = Array(kind.element, tuple(c_size(size) for size in kind.shape if size) or ("",))
        signature = Signature(node.name, c_name, kinds, changed, self.kind(node.returns, node))
        if isinstance(signature.returns, Group):
            self.group(signature.returns)
        function = Function(self.source, self.scope, node, signature)
        lines = function.lines()
        self.define(node, node.name, signature)  # only now: a function must not call itself
        if is_public:
            self.program.kernels[node.name] = signature
            self.program.header += function.declaration()
        else:
            lines[lines.index(function.head())] = f"static {function.head()}"
        self.program.lines += lines

    def group(self, group: Group) -> None:
        """Declare what a function returns together."""
        if group.name not in self.program.groups:
            self.program.groups[group.name] = group
            items = " ".join(f"{c_type(kind)} item{i};" for i, kind in enumerate(group.items))
            self.program.header += ["", f"typedef struct {group.name} {{ {items} }} {group.name};"]

    def kind(self, annotation: ast.expr | None, node: ast.AST | None = None) -> Kind:
        """Kind that an annotation stands for."""
        match annotation:
            case ast.Constant(value=None):
                return None
            case ast.Name(id=name) if name in PRIMITIVE:
                return PRIMITIVE[name]
            case ast.Name(id=name) if name in self.aliases:
                return self.aliases[name]
            case ast.Name(id=name):
                structure = self.scope.get(name)
                if isinstance(structure, Structure):
                    return structure
            case ast.Subscript(value=ast.Name(id="Annotated"), slice=ast.Tuple(elts=[base, *sizes])):
                array = self.kind(base)
                shape = tuple(str(size.value) for size in sizes if isinstance(size, ast.Constant))
                if isinstance(array, Array) and len(shape) == len(array.shape):
                    return Array(array.element, shape)
            case ast.Subscript(value=ast.Name(id="tuple"), slice=ast.Tuple(elts=items)):
                kinds = [self.kind(item) for item in items]
                if all(isinstance(kind, Scalar) for kind in kinds):
                    return Group(tuple(kind for kind in kinds if isinstance(kind, Scalar)))
        text = "nothing" if annotation is None else ast.unparse(annotation)
        self.source.fail(annotation or node, f"{text} is not a type of the kernel")
