/* Made from the Python of cca_core/kernel by `make kernel`: edit that. */
#include <stdbool.h>
#include "lend.h"
#include "kernel.h"

static PyObject *call_oriented_box_gap(PyObject *self, PyObject *const *given, Py_ssize_t count)
{
    (void)self;
    double dx;
    double dy;
    double ax;
    double ay;
    double bx;
    double by;
    double length_a;
    double width_a;
    double length_b;
    double width_b;
    if (!takes("oriented_box_gap", 10, count)) {
        return NULL;
    }
    if (!real(given[0], &dx)) {
        return NULL;
    }
    if (!real(given[1], &dy)) {
        return NULL;
    }
    if (!real(given[2], &ax)) {
        return NULL;
    }
    if (!real(given[3], &ay)) {
        return NULL;
    }
    if (!real(given[4], &bx)) {
        return NULL;
    }
    if (!real(given[5], &by)) {
        return NULL;
    }
    if (!real(given[6], &length_a)) {
        return NULL;
    }
    if (!real(given[7], &width_a)) {
        return NULL;
    }
    if (!real(given[8], &length_b)) {
        return NULL;
    }
    if (!real(given[9], &width_b)) {
        return NULL;
    }
    double result;
    result = cca_oriented_box_gap(dx, dy, ax, ay, bx, by, length_a, width_a, length_b, width_b);
    return PyFloat_FromDouble(result);
}

static PyObject *call_aligned_box_gaps(PyObject *self, PyObject *const *given, Py_ssize_t count)
{
    (void)self;
    int n;
    const double *dx = NULL;
    const double *dy = NULL;
    double length;
    double width;
    double *gap = NULL;
    if (!takes("aligned_box_gaps", 6, count)) {
        return NULL;
    }
    if (!whole(given[0], &n)) {
        return NULL;
    }
    if (!real(given[3], &length)) {
        return NULL;
    }
    if (!real(given[4], &width)) {
        return NULL;
    }
    Lent lent[3];
    int held = 0;
    dx = array("dx", given[1], &lent[held], &held, 'd', n, -1, 0);
    if (dx == NULL) {
        give_back(lent, held);
        return NULL;
    }
    dy = array("dy", given[2], &lent[held], &held, 'd', n, -1, 0);
    if (dy == NULL) {
        give_back(lent, held);
        return NULL;
    }
    gap = array("gap", given[5], &lent[held], &held, 'd', n, -1, 1);
    if (gap == NULL) {
        give_back(lent, held);
        return NULL;
    }
    double result;
    Py_BEGIN_ALLOW_THREADS
    result = cca_aligned_box_gaps(n, dx, dy, length, width, gap);
    Py_END_ALLOW_THREADS
    give_back(lent, held);
    return PyFloat_FromDouble(result);
}

static PyMethodDef methods[] = {
    {"oriented_box_gap", (PyCFunction)(void (*)(void))call_oriented_box_gap, METH_FASTCALL, NULL},
    {"aligned_box_gaps", (PyCFunction)(void (*)(void))call_aligned_box_gaps, METH_FASTCALL, NULL},
    {NULL, NULL, 0, NULL},
};

static int fill(PyObject *module)
{
    if (PyModule_AddStringConstant(module, "digest", "d91f819a84eb75c1cd09698e3ca34637842ff534d1f50e610be6394bfabc180e") < 0) {
        return -1;
    }
    PyObject *structures = PyDict_New();
    if (structures == NULL || PyModule_AddObjectRef(module, "structures", structures) < 0) {
        Py_XDECREF(structures);
        return -1;
    }
    Py_DECREF(structures);
    return 0;
}

static PyModuleDef_Slot slots[] = {{Py_mod_exec, (void *)fill}, {0, NULL}};
static PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_compiled", NULL, 0, methods, slots, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__compiled(void)
{
    return PyModuleDef_Init(&definition);
}
