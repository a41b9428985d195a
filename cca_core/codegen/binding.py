"""The module of Python's stable ABI that exports every kernel."""

from collections.abc import Iterator

from cca_core.codegen.kinds import Array, Group, Kind, Scalar, Signature, Structure, declare

READ = {Scalar.REAL: "real", Scalar.INT: "whole", Scalar.FLAG: "flag"}
WRITE = {
    Scalar.REAL: "PyFloat_FromDouble({})",
    Scalar.INT: "PyLong_FromLong({})",
    Scalar.FLAG: "PyBool_FromLong({})",
}


def binding(kernels: dict[str, Signature], structures: dict[str, Structure], digest: str) -> Iterator[str]:
    """Lines of the module's source; `digest` is that of the Python it was made from."""
    kinds = {name: i + 1 for i, name in enumerate(structures)}
    yield from ("#include <stdbool.h>", '#include "lend.h"', '#include "kernel.h"')
    for kernel in kernels.values():
        yield from wrapper(kernel, kinds)
    yield from ("", "static PyMethodDef methods[] = {")
    for name in kernels:
        yield f'    {{"{name}", (PyCFunction)(void (*)(void))call_{name}, METH_FASTCALL, NULL}},'
    yield from ("    {NULL, NULL, 0, NULL},", "};", "", "static int fill(PyObject *module)", "{")
    yield f'    if (PyModule_AddStringConstant(module, "digest", "{digest}") < 0) {{'
    yield from ("        return -1;", "    }", "    PyObject *structures = PyDict_New();")
    yield '    if (structures == NULL || PyModule_AddObjectRef(module, "structures", structures) < 0) {'
    yield from (
        "        Py_XDECREF(structures);",
        "        return -1;",
        "    }",
        "    Py_DECREF(structures);",
    )
    for name, kind in kinds.items():
        yield f'    if (describe(structures, "{name}", {kind}, sizeof({name})) < 0) {{'
        yield from ("        return -1;", "    }")
    yield from ("    return 0;", "}", "")
    yield "static PyModuleDef_Slot slots[] = {{Py_mod_exec, (void *)fill}, {0, NULL}};"
    yield "static PyModuleDef definition = {"
    yield '    PyModuleDef_HEAD_INIT, "_compiled", NULL, 0, methods, slots, NULL, NULL, NULL};'
    yield from ("", "PyMODINIT_FUNC PyInit__compiled(void)", "{")
    yield from ("    return PyModuleDef_Init(&definition);", "}")


def wrapper(kernel: Signature, kinds: dict[str, int]) -> Iterator[str]:
    """Lines of the function that Python calls for a kernel."""
    arguments = kernel.arguments
    lent = [name for name, kind in arguments.items() if not isinstance(kind, Scalar)]
    yield from (
        "",
        f"static PyObject *call_{kernel.name}(PyObject *self, PyObject *const *given, Py_ssize_t count)",
    )
    yield from ("{", "    (void)self;")
    if not arguments:
        yield "    (void)given;"
    for name, kind in arguments.items():
        is_const = name not in kernel.changed and not isinstance(kind, Scalar)
        yield f"    {declare(kind, name, is_const)}{' = NULL' if name in lent else ''};"
    yield f'    if (!takes("{kernel.name}", {len(arguments)}, count)) {{'
    yield from ("        return NULL;", "    }")
    # the sizes of arrays are among the numbers
    for i, (name, kind) in enumerate(arguments.items()):
        if isinstance(kind, Scalar):
            yield f"    if (!{READ[kind]}(given[{i}], &{name})) {{"
            yield from ("        return NULL;", "    }")
    if lent:
        yield from (f"    Lent lent[{len(lent)}];", "    int held = 0;")
    for i, (name, kind) in enumerate(arguments.items()):
        if not isinstance(kind, Scalar):
            yield f"    {name} = {borrow(name, kind, i, name in kernel.changed, kinds)};"
            yield f"    if ({name} == NULL) {{"
            yield from ("        give_back(lent, held);", "        return NULL;", "    }")
    yield from call(kernel, bool(lent))
    yield "}"


def borrow(name: str, kind: Kind, i: int, is_changed: bool, kinds: dict[str, int]) -> str:
    """Expression that borrows an array or a workspace."""
    if isinstance(kind, Array):
        rows, columns = kind.shape[0], kind.shape[1] if len(kind.shape) == 2 else "-1"
        letter = "d" if kind.element is Scalar.REAL else "i"
        what = f"'{letter}', {rows}, {columns}, {int(is_changed)}"
        return f'array("{name}", given[{i}], &lent[held], &held, {what})'
    number = kinds[kind.name] if isinstance(kind, Structure) else 0
    what = f"sizeof({kind}), {number}, {int(is_changed)}"
    return f'workspace("{name}", given[{i}], &lent[held], &held, {what})'


def call(kernel: Signature, has_lent: bool) -> Iterator[str]:
    """Lines that call a kernel and make its result an object; what has arrays runs without the GIL."""
    returns, text = kernel.returns, f"{kernel.c_name}({', '.join(kernel.arguments)})"
    if returns is not None:
        kind = (
            returns.name
            if isinstance(returns, Group)
            else returns.value
            if isinstance(returns, Scalar)
            else ""
        )
        text = f"result = {text}"
        yield f"    {kind} result;"
    if has_lent:
        yield "    Py_BEGIN_ALLOW_THREADS"
    yield f"    {text};"
    if has_lent:
        yield from ("    Py_END_ALLOW_THREADS", "    give_back(lent, held);")
    if isinstance(returns, Group):
        yield f"    PyObject *group = PyTuple_New({len(returns.items)});"
        yield from ("    if (group == NULL) {", "        return NULL;", "    }")
        for i, item in enumerate(returns.items):
            yield f"    PyObject *item{i} = {WRITE[item].format(f'result.item{i}')};"
            yield f"    if (item{i} == NULL || PyTuple_SetItem(group, {i}, item{i}) < 0) {{"
            yield from ("        Py_DECREF(group);", "        return NULL;", "    }")
        yield "    return group;"
    elif isinstance(returns, Scalar):
        yield f"    return {WRITE[returns].format('result')};"
    else:
        yield "    Py_RETURN_NONE;"
