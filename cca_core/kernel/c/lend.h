/* What Python lends to the kernel for a call: rows, grids and workspaces. Used by python.c alone. */

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
#include <Python.h>
#include <limits.h>
#include <stdint.h>

/* behind each workspace's fields: which structure it is, and who uses it (-1: a call that changes it) */
typedef struct Owner {
    int kind;
    int users;
} Owner;

/* one buffer that is borrowed for a call */
typedef struct Lent {
    Py_buffer view;
    Owner *owner;
    int is_changed;
} Lent;

static inline int lend_count(const char *name, Py_ssize_t expected, Py_ssize_t given)
{
    if (expected != given) {
        PyErr_Format(PyExc_TypeError, "%s takes %zd arguments, was given %zd", name, expected, given);
    }
    return expected == given;
}

static inline int lend_real(PyObject *given, double *value)
{
    *value = PyFloat_AsDouble(given);
    return *value != -1.0 || PyErr_Occurred() == NULL;
}

static inline int lend_whole(PyObject *given, int *value)
{
    long number = PyLong_AsLong(given);
    if (number == -1 && PyErr_Occurred() != NULL) {
        return 0;
    }
    if (number < -INT_MAX || number > INT_MAX) {
        PyErr_SetString(PyExc_OverflowError, "a whole number must fit into 32 bits");
        return 0;
    }
    *value = (int)number;
    return 1;
}

static inline int lend_flag(PyObject *given, bool *value)
{
    int truth = PyObject_IsTrue(given);
    *value = truth == 1;
    return truth >= 0;
}

/* Borrow a row (one axis) or a grid (two), of at least so many elements or rows. */
static inline void *lend_array(const char *name, PyObject *given, Lent *lent, int *count, char type, int axes,
                               Py_ssize_t rows, Py_ssize_t columns, int is_changed)
{
    Py_buffer *view = &lent->view;
    int flags = PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | (is_changed ? PyBUF_WRITABLE : 0);
    if (PyObject_GetBuffer(given, view, flags) < 0) {
        return NULL;
    }
    lent->owner = NULL;
    (*count)++;
    if (view->format == NULL || view->format[0] != type || view->format[1] != '\0') {
        PyErr_Format(PyExc_TypeError, "%s must be an array of %s", name, type == 'd' ? "float64" : "int32");
        return NULL;
    }
    if ((uintptr_t)view->buf % (type == 'd' ? sizeof(double) : sizeof(int)) != 0) {
        PyErr_Format(PyExc_ValueError, "%s must be aligned", name);
        return NULL;
    }
    if (view->ndim != axes) {
        PyErr_Format(PyExc_ValueError, "%s must be a %s, had %d axes", name, axes == 1 ? "row" : "grid", view->ndim);
        return NULL;
    }
    if (view->shape[0] < rows) {
        PyErr_Format(PyExc_ValueError, "%s must have at least %zd %s, had %zd", name, rows,
                     axes == 1 ? "elements" : "rows", view->shape[0]);
        return NULL;
    }
    if (axes == 2 && view->shape[1] != columns) {
        PyErr_Format(PyExc_ValueError, "%s must have %zd columns, had %zd", name, columns, view->shape[1]);
        return NULL;
    }
    return view->buf;
}

/* Borrow a workspace; none but one call at a time may change it. */
static inline void *lend_workspace(const char *name, PyObject *given, Lent *lent, int *count, size_t size,
                                   int kind, int is_changed)
{
    Py_buffer *view = &lent->view;
    if (PyObject_GetBuffer(given, view, PyBUF_WRITABLE) < 0) {
        return NULL;
    }
    lent->owner = NULL;
    (*count)++;
    Owner *owner = (Owner *)(void *)((char *)view->buf + size);
    if ((size_t)view->len < size + sizeof(Owner) || owner->kind != kind) {
        PyErr_Format(PyExc_TypeError, "%s must be a workspace of its class, made by lend()", name);
        return NULL;
    }
    if (owner->users < 0 || (is_changed && owner->users > 0)) {
        PyErr_Format(PyExc_RuntimeError, "%s must not be used by two threads at once", name);
        return NULL;
    }
    owner->users = is_changed ? -1 : owner->users + 1;
    lent->owner = owner;
    lent->is_changed = is_changed;
    return view->buf;
}

static inline void lend_end(Lent *lent, int count)
{
    for (int i = 0; i < count; i++) {
        if (lent[i].owner != NULL) {
            lent[i].owner->users = lent[i].is_changed ? 0 : lent[i].owner->users - 1;
        }
        PyBuffer_Release(&lent[i].view);
    }
}

/* structures[name] = (kind, size): memory.py checks its layout with it. */
static inline int lend_describe(PyObject *structures, const char *name, int kind, size_t size)
{
    PyObject *entry = Py_BuildValue("(in)", kind, (Py_ssize_t)size);
    int failed = entry == NULL ? -1 : PyDict_SetItemString(structures, name, entry);
    Py_XDECREF(entry);
    return failed;
}

/* A tuple of new objects; one that could not be made is NULL, with its exception. */
static inline PyObject *lend_group(PyObject **items, Py_ssize_t count)
{
    PyObject *group = PyTuple_New(count);
    int failed = group == NULL;
    for (Py_ssize_t i = 0; i < count; i++) {
        failed = failed || items[i] == NULL;
        if (group == NULL) {
            Py_XDECREF(items[i]);
        } else {
            PyTuple_SetItem(group, i, items[i]);
        }
    }
    if (failed) {
        Py_XDECREF(group);
        return NULL;
    }
    return group;
}
