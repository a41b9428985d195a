/* Made from the Python of cca_core/kernel by `make kernel`: edit that. */
#include <stdbool.h>

#include "lend.h"

#include "kernel.h"

static PyObject *call_oriented_box_gap(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("oriented_box_gap", 10, count_)) {
        return NULL;
    }
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
    if (!lend_real(given_[0], &dx)) {
        return NULL;
    }
    if (!lend_real(given_[1], &dy)) {
        return NULL;
    }
    if (!lend_real(given_[2], &ax)) {
        return NULL;
    }
    if (!lend_real(given_[3], &ay)) {
        return NULL;
    }
    if (!lend_real(given_[4], &bx)) {
        return NULL;
    }
    if (!lend_real(given_[5], &by)) {
        return NULL;
    }
    if (!lend_real(given_[6], &length_a)) {
        return NULL;
    }
    if (!lend_real(given_[7], &width_a)) {
        return NULL;
    }
    if (!lend_real(given_[8], &length_b)) {
        return NULL;
    }
    if (!lend_real(given_[9], &width_b)) {
        return NULL;
    }
    double result_;
    result_ = cca_oriented_box_gap(dx, dy, ax, ay, bx, by, length_a, width_a, length_b, width_b);
    return PyFloat_FromDouble(result_);
}

static PyObject *call_aligned_box_gaps(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("aligned_box_gaps", 6, count_)) {
        return NULL;
    }
    int n;
    const double *dx;
    const double *dy;
    double length;
    double width;
    double *gap;
    if (!lend_whole(given_[0], &n)) {
        return NULL;
    }
    if (!lend_real(given_[3], &length)) {
        return NULL;
    }
    if (!lend_real(given_[4], &width)) {
        return NULL;
    }
    Lent lent_[3];
    int held_ = 0;
    dx = lend_array("dx", given_[1], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (dx == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    dy = lend_array("dy", given_[2], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (dy == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    gap = lend_array("gap", given_[5], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (gap == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    double result_;
    Py_BEGIN_ALLOW_THREADS
    result_ = cca_aligned_box_gaps(n, dx, dy, length, width, gap);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    return PyFloat_FromDouble(result_);
}

static PyMethodDef methods[] = {
    {"oriented_box_gap", (PyCFunction)(void (*)(void))call_oriented_box_gap, METH_FASTCALL, NULL},
    {"aligned_box_gaps", (PyCFunction)(void (*)(void))call_aligned_box_gaps, METH_FASTCALL, NULL},
    {NULL, NULL, 0, NULL},
};

static int fill(PyObject *module)
{
    PyObject *structures = PyDict_New();
    int failed = structures == NULL || PyModule_AddObjectRef(module, "structures", structures) < 0;
    failed = failed || PyModule_AddStringConstant(module, "digest", "d91f819a84eb75c1cd09698e3ca34637842ff534d1f50e610be6394bfabc180e") < 0;
    Py_XDECREF(structures);
    return failed ? -1 : 0;
}

static PyModuleDef_Slot slots[] = {{Py_mod_exec, (void *)fill}, {0, NULL}};
static PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_compiled", NULL, 0, methods, slots, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__compiled(void)
{
    return PyModuleDef_Init(&definition);
}
