"""The module of Python's stable ABI that exports every kernel."""

from collections.abc import Iterator

from cca_core.codegen.expressions import c_size
from cca_core.codegen.kinds import Array, Group, Kind, Scalar, Signature, Structure, c_type, declare

READ = {Scalar.REAL: "lend_real", Scalar.INT: "lend_whole", Scalar.FLAG: "lend_flag"}
WRITE = {
    Scalar.REAL: "PyFloat_FromDouble({})",
    Scalar.INT: "PyLong_FromLong({})",
    Scalar.FLAG: "PyBool_FromLong({})",
}
HEAD = """#include <stdbool.h>

#include "lend.h"

#include "kernel.h"

#ifndef CCA_C_DIGEST /* that of these files, given by who compiles them */
#define CCA_C_DIGEST none
#endif
#define TEXT(token) #token
#define TEXT_OF(macro) TEXT(macro)"""
# names that end in an underscore are free: no argument has one
WRAPPER = """
static PyObject *call_{name}(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{{
    (void)self_;
    (void)given_;
    if (!lend_count("{name}", {count}, count_)) {{
        return NULL;
    }}"""
MODULE = """
    {{NULL, NULL, 0, NULL}},
}};

static int fill(PyObject *module)
{{
    PyObject *structures = PyDict_New();
    int failed = structures == NULL || PyModule_AddObjectRef(module, "structures", structures) < 0;
    failed = failed || PyModule_AddStringConstant(module, "digest", "{digest}") < 0;
    failed = failed || PyModule_AddStringConstant(module, "c_digest", TEXT_OF(CCA_C_DIGEST)) < 0;
{entries}
    Py_XDECREF(structures);
    return failed ? -1 : 0;
}}

static PyModuleDef_Slot slots[] = {{{{Py_mod_exec, (void *)fill}}, {{0, NULL}}}};
static PyModuleDef definition = {{
    PyModuleDef_HEAD_INIT, "_compiled", NULL, 0, methods, slots, NULL, NULL, NULL,
}};

PyMODINIT_FUNC PyInit__compiled(void)
{{
    return PyModuleDef_Init(&definition);
}}"""
ENTRY = '    failed = failed || lend_describe(structures, "{name}", {kind}, sizeof({name})) < 0;'


def binding(kernels: dict[str, Signature], structures: dict[str, Structure], digest: str) -> Iterator[str]:
    """Lines of the module's source; `digest` is that of the Python it was made from."""
    kinds = {name: i + 1 for i, name in enumerate(structures)}
    yield HEAD
    for kernel in kernels.values():
        yield from wrapper(kernel, kinds)
    yield from ("", "static PyMethodDef methods[] = {")
    for name in kernels:
        yield f'    {{"{name}", (PyCFunction)(void (*)(void))call_{name}, METH_FASTCALL, NULL}},'
    entries = "\n".join(ENTRY.format(name=name, kind=kind) for name, kind in kinds.items())
    yield (
        MODULE.format(digest=digest, entries=entries).removeprefix("\n").replace("\n\n    Py_X", "\n    Py_X")
    )


def wrapper(kernel: Signature, kinds: dict[str, int]) -> Iterator[str]:
    """Lines of the function that Python calls for a kernel."""
    yield WRAPPER.format(name=kernel.name, count=len(kernel.arguments))
    numbers = {name for name, kind in kernel.arguments.items() if isinstance(kind, Scalar)}
    lent = len(kernel.arguments) - len(numbers)
    for name, kind in kernel.arguments.items():
        yield f"    {declare(kind, name, name not in kernel.changed | numbers)};"
    # numbers first: the sizes of arrays are among them
    for i, (name, kind) in enumerate(kernel.arguments.items()):
        if isinstance(kind, Scalar):
            yield from (f"    if (!{READ[kind]}(given_[{i}], &{name})) {{", "        return NULL;", "    }")
    if lent:
        yield from (f"    Lent lent_[{lent}];", "    int held_ = 0;")
    for i, (name, kind) in enumerate(kernel.arguments.items()):
        if not isinstance(kind, Scalar):
            yield f"    {name} = {borrow(name, kind, i, name in kernel.changed, kinds)};"
            yield f"    if ({name} == NULL) {{"
            yield from ("        lend_end(lent_, held_);", "        return NULL;", "    }")
    yield from call(kernel, lent > 0)
    yield "}"


def borrow(name: str, kind: Kind, i: int, is_changed: bool, kinds: dict[str, int]) -> str:
    """Expression that borrows an array or a workspace."""
    if isinstance(kind, Array):
        rows, *columns = (c_size(size, "(Py_ssize_t)") for size in kind.shape)
        letter = "d" if kind.element is Scalar.REAL else "i"
        what = f"'{letter}', {len(kind.shape)}, {rows}, {columns[0] if columns else 0}, {int(is_changed)}"
        return f'lend_array("{name}", given_[{i}], &lent_[held_], &held_, {what})'
    what = f"sizeof({kind}), {kinds[str(kind)]}, {int(is_changed)}"
    return f'lend_workspace("{name}", given_[{i}], &lent_[held_], &held_, {what})'


def call(kernel: Signature, has_lent: bool) -> Iterator[str]:
    """Lines that call a kernel and make its result an object.

    What fills memory may take long and runs without the GIL. A short call keeps it: getting it back from a
    busy thread would take 5 ms.
    """
    text = f"{kernel.c_name}({', '.join(kernel.arguments)});"
    if kernel.returns is not None:
        yield f"    {c_type(kernel.returns)} result_;"
        text = f"result_ = {text}"
    if kernel.changed:
        yield from ("    Py_BEGIN_ALLOW_THREADS", f"    {text}", "    Py_END_ALLOW_THREADS")
    else:
        yield f"    {text}"
    if has_lent:
        yield "    lend_end(lent_, held_);"
    if isinstance(kernel.returns, Group):
        items = [WRITE[item].format(f"result_.item{i}") for i, item in enumerate(kernel.returns.items)]
        yield f"    PyObject *items_[] = {{{', '.join(items)}}};"
        yield f"    return lend_group(items_, {len(items)});"
    elif isinstance(kernel.returns, Scalar):
        yield f"    return {WRITE[kernel.returns].format('result_')};"
    else:
        yield "    Py_RETURN_NONE;"
