/* Made from the Python of cca_core/kernel by `make kernel`: edit that. */
#include <stdbool.h>

#include "lend.h"

#include "kernel.h"

#ifndef CCA_C_DIGEST /* that of these files, given by who compiles them */
#define CCA_C_DIGEST none
#endif
#define TEXT(token) #token
#define TEXT_OF(macro) TEXT(macro)

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

static PyObject *call_box_gap(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("box_gap", 10, count_)) {
        return NULL;
    }
    double ax;
    double ay;
    double a_psi;
    double a_length;
    double a_width;
    double bx;
    double by;
    double b_psi;
    double b_length;
    double b_width;
    if (!lend_real(given_[0], &ax)) {
        return NULL;
    }
    if (!lend_real(given_[1], &ay)) {
        return NULL;
    }
    if (!lend_real(given_[2], &a_psi)) {
        return NULL;
    }
    if (!lend_real(given_[3], &a_length)) {
        return NULL;
    }
    if (!lend_real(given_[4], &a_width)) {
        return NULL;
    }
    if (!lend_real(given_[5], &bx)) {
        return NULL;
    }
    if (!lend_real(given_[6], &by)) {
        return NULL;
    }
    if (!lend_real(given_[7], &b_psi)) {
        return NULL;
    }
    if (!lend_real(given_[8], &b_length)) {
        return NULL;
    }
    if (!lend_real(given_[9], &b_width)) {
        return NULL;
    }
    double result_;
    result_ = cca_box_gap(ax, ay, a_psi, a_length, a_width, bx, by, b_psi, b_length, b_width);
    return PyFloat_FromDouble(result_);
}

static PyObject *call_box_gaps(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("box_gaps", 5, count_)) {
        return NULL;
    }
    int n;
    int k;
    const double *a;
    const double *b;
    double *gap;
    if (!lend_whole(given_[0], &n)) {
        return NULL;
    }
    if (!lend_whole(given_[1], &k)) {
        return NULL;
    }
    Lent lent_[3];
    int held_ = 0;
    a = lend_array("a", given_[2], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)k, 5, 0);
    if (a == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    b = lend_array("b", given_[3], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)n, 5, 0);
    if (b == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    gap = lend_array("gap", given_[4], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (gap == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_box_gaps(n, k, a, b, gap);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_relax_bands(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("relax_bands", 7, count_)) {
        return NULL;
    }
    BandBatch *q;
    BandWork *w;
    Equilibrium *e;
    int bands;
    int columns;
    double *found;
    int *codes;
    if (!lend_whole(given_[3], &bands)) {
        return NULL;
    }
    if (!lend_whole(given_[4], &columns)) {
        return NULL;
    }
    Lent lent_[5];
    int held_ = 0;
    q = lend_workspace("q", given_[0], &lent_[held_], &held_, sizeof(BandBatch), 3, 1);
    if (q == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    w = lend_workspace("w", given_[1], &lent_[held_], &held_, sizeof(BandWork), 2, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    e = lend_workspace("e", given_[2], &lent_[held_], &held_, sizeof(Equilibrium), 1, 1);
    if (e == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    found = lend_array("found", given_[5], &lent_[held_], &held_, 'd', 1, ((Py_ssize_t)bands * (Py_ssize_t)columns), 0, 1);
    if (found == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    codes = lend_array("codes", given_[6], &lent_[held_], &held_, 'i', 1, (6 * (Py_ssize_t)bands), 0, 1);
    if (codes == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_relax_bands(q, w, e, bands, columns, found, codes);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_measure_band(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("measure_band", 8, count_)) {
        return NULL;
    }
    BandBatch *q;
    BandWork *w;
    Equilibrium *e;
    int n;
    const double *u;
    int columns;
    double *found;
    int *codes;
    if (!lend_whole(given_[3], &n)) {
        return NULL;
    }
    if (!lend_whole(given_[5], &columns)) {
        return NULL;
    }
    Lent lent_[6];
    int held_ = 0;
    q = lend_workspace("q", given_[0], &lent_[held_], &held_, sizeof(BandBatch), 3, 1);
    if (q == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    w = lend_workspace("w", given_[1], &lent_[held_], &held_, sizeof(BandWork), 2, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    e = lend_workspace("e", given_[2], &lent_[held_], &held_, sizeof(Equilibrium), 1, 1);
    if (e == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    u = lend_array("u", given_[4], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (u == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    found = lend_array("found", given_[6], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)columns, 0, 1);
    if (found == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    codes = lend_array("codes", given_[7], &lent_[held_], &held_, 'i', 1, 6, 0, 1);
    if (codes == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    int result_;
    Py_BEGIN_ALLOW_THREADS
    result_ = cca_measure_band(q, w, e, n, u, columns, found, codes);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    return PyLong_FromLong(result_);
}

static PyObject *call_join_cubics(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("join_cubics", 6, count_)) {
        return NULL;
    }
    int segments;
    const double *nodes;
    const double *moments;
    double start;
    double *breaks;
    double *cubics;
    if (!lend_whole(given_[0], &segments)) {
        return NULL;
    }
    if (!lend_real(given_[3], &start)) {
        return NULL;
    }
    Lent lent_[4];
    int held_ = 0;
    nodes = lend_array("nodes", given_[1], &lent_[held_], &held_, 'd', 2, ((Py_ssize_t)segments + 1), 2, 0);
    if (nodes == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    moments = lend_array("moments", given_[2], &lent_[held_], &held_, 'd', 2, ((Py_ssize_t)segments + 1), 2, 0);
    if (moments == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    breaks = lend_array("breaks", given_[4], &lent_[held_], &held_, 'd', 1, ((Py_ssize_t)segments + 1), 0, 1);
    if (breaks == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    cubics = lend_array("cubics", given_[5], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)segments, 8, 1);
    if (cubics == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_join_cubics(segments, nodes, moments, start, breaks, cubics);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_limit_path_speed(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("limit_path_speed", 3, count_)) {
        return NULL;
    }
    Scene *w;
    int p;
    double a_y;
    if (!lend_whole(given_[1], &p)) {
        return NULL;
    }
    if (!lend_real(given_[2], &a_y)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_limit_path_speed(w, p, a_y);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_roll_out(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("roll_out", 9, count_)) {
        return NULL;
    }
    Scene *w;
    int row;
    int p;
    bool follows;
    bool passes;
    int yields;
    double braking;
    double tail;
    bool kept;
    if (!lend_whole(given_[1], &row)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &p)) {
        return NULL;
    }
    if (!lend_flag(given_[3], &follows)) {
        return NULL;
    }
    if (!lend_flag(given_[4], &passes)) {
        return NULL;
    }
    if (!lend_whole(given_[5], &yields)) {
        return NULL;
    }
    if (!lend_real(given_[6], &braking)) {
        return NULL;
    }
    if (!lend_real(given_[7], &tail)) {
        return NULL;
    }
    if (!lend_flag(given_[8], &kept)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_roll_out(w, row, p, follows, passes, yields, braking, tail, kept);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_sum_costs(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("sum_costs", 4, count_)) {
        return NULL;
    }
    Scene *w;
    int row;
    int p;
    double until;
    if (!lend_whole(given_[1], &row)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &p)) {
        return NULL;
    }
    if (!lend_real(given_[3], &until)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_sum_costs(w, row, p, until);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_set_order(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("set_order", 2, count_)) {
        return NULL;
    }
    Scene *w;
    double sign;
    if (!lend_real(given_[1], &sign)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_set_order(w, sign);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_set_following_speed(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("set_following_speed", 2, count_)) {
        return NULL;
    }
    Scene *w;
    int j;
    if (!lend_whole(given_[1], &j)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_set_following_speed(w, j);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_curve_point(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("curve_point", 2, count_)) {
        return NULL;
    }
    const Curve *curve;
    double s;
    if (!lend_real(given_[1], &s)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    curve = lend_workspace("curve", given_[0], &lent_[held_], &held_, sizeof(Curve), 5, 0);
    if (curve == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    cca_dddddd result_;
    result_ = cca_curve_point(curve, s);
    lend_end(lent_, held_);
    PyObject *items_[] = {PyFloat_FromDouble(result_.item0), PyFloat_FromDouble(result_.item1), PyFloat_FromDouble(result_.item2), PyFloat_FromDouble(result_.item3), PyFloat_FromDouble(result_.item4), PyFloat_FromDouble(result_.item5)};
    return lend_group(items_, 6);
}

static PyObject *call_curve_points(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("curve_points", 6, count_)) {
        return NULL;
    }
    const Curve *curve;
    int n;
    const double *s;
    double *position;
    double *first;
    double *second;
    if (!lend_whole(given_[1], &n)) {
        return NULL;
    }
    Lent lent_[5];
    int held_ = 0;
    curve = lend_workspace("curve", given_[0], &lent_[held_], &held_, sizeof(Curve), 5, 0);
    if (curve == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    s = lend_array("s", given_[2], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (s == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    position = lend_array("position", given_[3], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)n, 2, 1);
    if (position == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    first = lend_array("first", given_[4], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)n, 2, 1);
    if (first == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    second = lend_array("second", given_[5], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)n, 2, 1);
    if (second == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_curve_points(curve, n, s, position, first, second);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_curvature_at(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("curvature_at", 2, count_)) {
        return NULL;
    }
    const Curve *curve;
    double s;
    if (!lend_real(given_[1], &s)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    curve = lend_workspace("curve", given_[0], &lent_[held_], &held_, sizeof(Curve), 5, 0);
    if (curve == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    double result_;
    result_ = cca_curvature_at(curve, s);
    lend_end(lent_, held_);
    return PyFloat_FromDouble(result_);
}

static PyObject *call_foot_point(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("foot_point", 4, count_)) {
        return NULL;
    }
    const Curve *curve;
    double x;
    double y;
    double s_guess;
    if (!lend_real(given_[1], &x)) {
        return NULL;
    }
    if (!lend_real(given_[2], &y)) {
        return NULL;
    }
    if (!lend_real(given_[3], &s_guess)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    curve = lend_workspace("curve", given_[0], &lent_[held_], &held_, sizeof(Curve), 5, 0);
    if (curve == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    cca_dddd result_;
    result_ = cca_foot_point(curve, x, y, s_guess);
    lend_end(lent_, held_);
    PyObject *items_[] = {PyFloat_FromDouble(result_.item0), PyFloat_FromDouble(result_.item1), PyFloat_FromDouble(result_.item2), PyFloat_FromDouble(result_.item3)};
    return lend_group(items_, 4);
}

static PyObject *call_nearest_point(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("nearest_point", 4, count_)) {
        return NULL;
    }
    const Curve *curve;
    const CurveSamples *samples;
    double x;
    double y;
    if (!lend_real(given_[2], &x)) {
        return NULL;
    }
    if (!lend_real(given_[3], &y)) {
        return NULL;
    }
    Lent lent_[2];
    int held_ = 0;
    curve = lend_workspace("curve", given_[0], &lent_[held_], &held_, sizeof(Curve), 5, 0);
    if (curve == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    samples = lend_workspace("samples", given_[1], &lent_[held_], &held_, sizeof(CurveSamples), 6, 0);
    if (samples == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    cca_dd result_;
    result_ = cca_nearest_point(curve, samples, x, y);
    lend_end(lent_, held_);
    PyObject *items_[] = {PyFloat_FromDouble(result_.item0), PyFloat_FromDouble(result_.item1)};
    return lend_group(items_, 2);
}

static PyObject *call_foot_points(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("foot_points", 9, count_)) {
        return NULL;
    }
    const Curve *curve;
    int n;
    const double *x;
    const double *y;
    const double *s_guess;
    double *s;
    double *d;
    double *heading;
    double *curvature;
    if (!lend_whole(given_[1], &n)) {
        return NULL;
    }
    Lent lent_[8];
    int held_ = 0;
    curve = lend_workspace("curve", given_[0], &lent_[held_], &held_, sizeof(Curve), 5, 0);
    if (curve == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    x = lend_array("x", given_[2], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (x == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    y = lend_array("y", given_[3], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (y == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    s_guess = lend_array("s_guess", given_[4], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (s_guess == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    s = lend_array("s", given_[5], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (s == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    d = lend_array("d", given_[6], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (d == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    heading = lend_array("heading", given_[7], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (heading == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    curvature = lend_array("curvature", given_[8], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (curvature == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_foot_points(curve, n, x, y, s_guess, s, d, heading, curvature);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_nearest_points(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("nearest_points", 7, count_)) {
        return NULL;
    }
    const Curve *curve;
    const CurveSamples *samples;
    int n;
    const double *x;
    const double *y;
    double *s;
    double *d;
    if (!lend_whole(given_[2], &n)) {
        return NULL;
    }
    Lent lent_[6];
    int held_ = 0;
    curve = lend_workspace("curve", given_[0], &lent_[held_], &held_, sizeof(Curve), 5, 0);
    if (curve == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    samples = lend_workspace("samples", given_[1], &lent_[held_], &held_, sizeof(CurveSamples), 6, 0);
    if (samples == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    x = lend_array("x", given_[3], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (x == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    y = lend_array("y", given_[4], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (y == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    s = lend_array("s", given_[5], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (s == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    d = lend_array("d", given_[6], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (d == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_nearest_points(curve, samples, n, x, y, s, d);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_distances_driven(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("distances_driven", 5, count_)) {
        return NULL;
    }
    int n;
    const double *t;
    double v;
    double a_x;
    double *distance;
    if (!lend_whole(given_[0], &n)) {
        return NULL;
    }
    if (!lend_real(given_[2], &v)) {
        return NULL;
    }
    if (!lend_real(given_[3], &a_x)) {
        return NULL;
    }
    Lent lent_[2];
    int held_ = 0;
    t = lend_array("t", given_[1], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (t == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    distance = lend_array("distance", given_[4], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (distance == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_distances_driven(n, t, v, a_x, distance);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_reachable_intervals(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("reachable_intervals", 9, count_)) {
        return NULL;
    }
    int n;
    const double *v;
    const double *t;
    const double *age;
    const double *rate;
    double braking;
    double acceleration;
    double *low;
    double *high;
    if (!lend_whole(given_[0], &n)) {
        return NULL;
    }
    if (!lend_real(given_[5], &braking)) {
        return NULL;
    }
    if (!lend_real(given_[6], &acceleration)) {
        return NULL;
    }
    Lent lent_[6];
    int held_ = 0;
    v = lend_array("v", given_[1], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (v == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    t = lend_array("t", given_[2], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (t == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    age = lend_array("age", given_[3], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (age == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    rate = lend_array("rate", given_[4], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (rate == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    low = lend_array("low", given_[7], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (low == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    high = lend_array("high", given_[8], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (high == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_reachable_intervals(n, v, t, age, rate, braking, acceleration, low, high);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_occupied_intervals(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("occupied_intervals", 6, count_)) {
        return NULL;
    }
    int vehicles;
    int times;
    const double *motion;
    const double *t;
    double *rear;
    double *front;
    if (!lend_whole(given_[0], &vehicles)) {
        return NULL;
    }
    if (!lend_whole(given_[1], &times)) {
        return NULL;
    }
    Lent lent_[4];
    int held_ = 0;
    motion = lend_array("motion", given_[2], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)vehicles, 8, 0);
    if (motion == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    t = lend_array("t", given_[3], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)times, 0, 0);
    if (t == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    rear = lend_array("rear", given_[4], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)vehicles, (Py_ssize_t)times, 1);
    if (rear == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    front = lend_array("front", given_[5], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)vehicles, (Py_ssize_t)times, 1);
    if (front == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_occupied_intervals(vehicles, times, motion, t, rear, front);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_danger_zones(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("danger_zones", 6, count_)) {
        return NULL;
    }
    int vehicles;
    int times;
    const double *motion;
    const double *t;
    const double *travel;
    double *zone;
    if (!lend_whole(given_[0], &vehicles)) {
        return NULL;
    }
    if (!lend_whole(given_[1], &times)) {
        return NULL;
    }
    Lent lent_[4];
    int held_ = 0;
    motion = lend_array("motion", given_[2], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)vehicles, 8, 0);
    if (motion == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    t = lend_array("t", given_[3], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)times, 0, 0);
    if (t == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    travel = lend_array("travel", given_[4], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)times, 0, 0);
    if (travel == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    zone = lend_array("zone", given_[5], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)vehicles, 2, 1);
    if (zone == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_danger_zones(vehicles, times, motion, t, travel, zone);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_occupancy_boxes(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("occupancy_boxes", 8, count_)) {
        return NULL;
    }
    const Curve *curve;
    int n;
    const double *s;
    const double *rear;
    const double *front;
    const double *d;
    const double *half_width;
    double *boxes;
    if (!lend_whole(given_[1], &n)) {
        return NULL;
    }
    Lent lent_[7];
    int held_ = 0;
    curve = lend_workspace("curve", given_[0], &lent_[held_], &held_, sizeof(Curve), 5, 0);
    if (curve == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    s = lend_array("s", given_[2], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (s == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    rear = lend_array("rear", given_[3], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (rear == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    front = lend_array("front", given_[4], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (front == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    d = lend_array("d", given_[5], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (d == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    half_width = lend_array("half_width", given_[6], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (half_width == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    boxes = lend_array("boxes", given_[7], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)n, 5, 1);
    if (boxes == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_occupancy_boxes(curve, n, s, rear, front, d, half_width, boxes);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_vehicle_boxes(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("vehicle_boxes", 9, count_)) {
        return NULL;
    }
    const Curve *curve;
    int vehicles;
    int times;
    const double *s;
    const double *rear;
    const double *front;
    const double *d;
    const double *half_width;
    double *boxes;
    if (!lend_whole(given_[1], &vehicles)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &times)) {
        return NULL;
    }
    Lent lent_[7];
    int held_ = 0;
    curve = lend_workspace("curve", given_[0], &lent_[held_], &held_, sizeof(Curve), 5, 0);
    if (curve == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    s = lend_array("s", given_[3], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)times, 0, 0);
    if (s == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    rear = lend_array("rear", given_[4], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)vehicles, (Py_ssize_t)times, 0);
    if (rear == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    front = lend_array("front", given_[5], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)vehicles, (Py_ssize_t)times, 0);
    if (front == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    d = lend_array("d", given_[6], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)vehicles, 0, 0);
    if (d == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    half_width = lend_array("half_width", given_[7], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)vehicles, 0, 0);
    if (half_width == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    boxes = lend_array("boxes", given_[8], &lent_[held_], &held_, 'd', 2, ((Py_ssize_t)vehicles * (Py_ssize_t)times), 5, 1);
    if (boxes == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_vehicle_boxes(curve, vehicles, times, s, rear, front, d, half_width, boxes);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_locate_vehicles(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("locate_vehicles", 2, count_)) {
        return NULL;
    }
    Scene *w;
    int seen;
    if (!lend_whole(given_[1], &seen)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_locate_vehicles(w, seen);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_find_duty(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("find_duty", 4, count_)) {
        return NULL;
    }
    Scene *w;
    int row;
    int p;
    double wait;
    if (!lend_whole(given_[1], &row)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &p)) {
        return NULL;
    }
    if (!lend_real(given_[3], &wait)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    int result_;
    Py_BEGIN_ALLOW_THREADS
    result_ = cca_find_duty(w, row, p, wait);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    return PyLong_FromLong(result_);
}

static PyObject *call_has_duty(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("has_duty", 3, count_)) {
        return NULL;
    }
    const Scene *w;
    int j;
    int back;
    if (!lend_whole(given_[1], &j)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &back)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 0);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    bool result_;
    result_ = cca_has_duty(w, j, back);
    lend_end(lent_, held_);
    return PyBool_FromLong(result_);
}

static PyObject *call_merges_behind(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("merges_behind", 3, count_)) {
        return NULL;
    }
    const Scene *w;
    int row;
    int j;
    if (!lend_whole(given_[1], &row)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &j)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 0);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    int result_;
    result_ = cca_merges_behind(w, row, j);
    lend_end(lent_, held_);
    return PyLong_FromLong(result_);
}

static PyObject *call_is_behind(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("is_behind", 5, count_)) {
        return NULL;
    }
    const Scene *w;
    int row;
    int p;
    int j;
    int back;
    if (!lend_whole(given_[1], &row)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &p)) {
        return NULL;
    }
    if (!lend_whole(given_[3], &j)) {
        return NULL;
    }
    if (!lend_whole(given_[4], &back)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 0);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    bool result_;
    result_ = cca_is_behind(w, row, p, j, back);
    lend_end(lent_, held_);
    return PyBool_FromLong(result_);
}

static PyObject *call_is_established(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("is_established", 2, count_)) {
        return NULL;
    }
    const Scene *w;
    int j;
    if (!lend_whole(given_[1], &j)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 0);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    bool result_;
    result_ = cca_is_established(w, j);
    lend_end(lent_, held_);
    return PyBool_FromLong(result_);
}

static PyObject *call_zone_begin(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("zone_begin", 2, count_)) {
        return NULL;
    }
    const Scene *w;
    double since;
    if (!lend_real(given_[1], &since)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 0);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    int result_;
    result_ = cca_zone_begin(w, since);
    lend_end(lent_, held_);
    return PyLong_FromLong(result_);
}

static PyObject *call_is_in_zone_lane(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("is_in_zone_lane", 2, count_)) {
        return NULL;
    }
    const Scene *w;
    int j;
    if (!lend_whole(given_[1], &j)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 0);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    bool result_;
    result_ = cca_is_in_zone_lane(w, j);
    lend_end(lent_, held_);
    return PyBool_FromLong(result_);
}

static PyObject *call_keeps_zone(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("keeps_zone", 2, count_)) {
        return NULL;
    }
    const Scene *w;
    int j;
    if (!lend_whole(given_[1], &j)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 0);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    bool result_;
    result_ = cca_keeps_zone(w, j);
    lend_end(lent_, held_);
    return PyBool_FromLong(result_);
}

static PyObject *call_reacts(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("reacts", 4, count_)) {
        return NULL;
    }
    const Scene *w;
    int row;
    int j;
    int begin;
    if (!lend_whole(given_[1], &row)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &j)) {
        return NULL;
    }
    if (!lend_whole(given_[3], &begin)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 0);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    bool result_;
    result_ = cca_reacts(w, row, j, begin);
    lend_end(lent_, held_);
    return PyBool_FromLong(result_);
}

static PyObject *call_worst_rear_gap(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("worst_rear_gap", 4, count_)) {
        return NULL;
    }
    const Scene *w;
    int row;
    int j;
    int begin;
    if (!lend_whole(given_[1], &row)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &j)) {
        return NULL;
    }
    if (!lend_whole(given_[3], &begin)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 0);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    double result_;
    result_ = cca_worst_rear_gap(w, row, j, begin);
    lend_end(lent_, held_);
    return PyFloat_FromDouble(result_);
}

static PyObject *call_check_nominal(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("check_nominal", 8, count_)) {
        return NULL;
    }
    Scene *w;
    int row;
    int p;
    double touch;
    double met;
    double clearance;
    double wait;
    double pet;
    if (!lend_whole(given_[1], &row)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &p)) {
        return NULL;
    }
    if (!lend_real(given_[3], &touch)) {
        return NULL;
    }
    if (!lend_real(given_[4], &met)) {
        return NULL;
    }
    if (!lend_real(given_[5], &clearance)) {
        return NULL;
    }
    if (!lend_real(given_[6], &wait)) {
        return NULL;
    }
    if (!lend_real(given_[7], &pet)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_check_nominal(w, row, p, touch, met, clearance, wait, pet);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_check_worst_case(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("check_worst_case", 8, count_)) {
        return NULL;
    }
    Scene *w;
    int row;
    int p;
    double touch;
    double clearance;
    double wait;
    double x_safety;
    int which;
    if (!lend_whole(given_[1], &row)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &p)) {
        return NULL;
    }
    if (!lend_real(given_[3], &touch)) {
        return NULL;
    }
    if (!lend_real(given_[4], &clearance)) {
        return NULL;
    }
    if (!lend_real(given_[5], &wait)) {
        return NULL;
    }
    if (!lend_real(given_[6], &x_safety)) {
        return NULL;
    }
    if (!lend_whole(given_[7], &which)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    bool result_;
    Py_BEGIN_ALLOW_THREADS
    result_ = cca_check_worst_case(w, row, p, touch, clearance, wait, x_safety, which);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    return PyBool_FromLong(result_);
}

static PyObject *call_find_conflicts(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("find_conflicts", 4, count_)) {
        return NULL;
    }
    Scene *w;
    int p;
    int reach;
    double margin;
    if (!lend_whole(given_[1], &p)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &reach)) {
        return NULL;
    }
    if (!lend_real(given_[3], &margin)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_find_conflicts(w, p, reach, margin);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_find_equilibria(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("find_equilibria", 12, count_)) {
        return NULL;
    }
    Equilibrium *e;
    int bands;
    int n;
    bool bounded;
    const double *stiffness;
    const double *lower;
    const double *upper;
    const double *lower_difference;
    const double *upper_difference;
    double *u;
    int *solves;
    int *converged;
    if (!lend_whole(given_[1], &bands)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &n)) {
        return NULL;
    }
    if (!lend_flag(given_[3], &bounded)) {
        return NULL;
    }
    Lent lent_[9];
    int held_ = 0;
    e = lend_workspace("e", given_[0], &lent_[held_], &held_, sizeof(Equilibrium), 1, 1);
    if (e == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    stiffness = lend_array("stiffness", given_[4], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)bands, 5, 0);
    if (stiffness == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    lower = lend_array("lower", given_[5], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)bands, (Py_ssize_t)n, 0);
    if (lower == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    upper = lend_array("upper", given_[6], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)bands, (Py_ssize_t)n, 0);
    if (upper == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    lower_difference = lend_array("lower_difference", given_[7], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)bands, (Py_ssize_t)n, 0);
    if (lower_difference == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    upper_difference = lend_array("upper_difference", given_[8], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)bands, (Py_ssize_t)n, 0);
    if (upper_difference == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    u = lend_array("u", given_[9], &lent_[held_], &held_, 'd', 2, (Py_ssize_t)bands, (Py_ssize_t)n, 1);
    if (u == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    solves = lend_array("solves", given_[10], &lent_[held_], &held_, 'i', 1, (Py_ssize_t)bands, 0, 1);
    if (solves == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    converged = lend_array("converged", given_[11], &lent_[held_], &held_, 'i', 1, (Py_ssize_t)bands, 0, 1);
    if (converged == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_find_equilibria(e, bands, n, bounded, stiffness, lower, upper, lower_difference, upper_difference, u, solves, converged);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_find_meetings(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("find_meetings", 3, count_)) {
        return NULL;
    }
    Scene *w;
    int row;
    double rear;
    if (!lend_whole(given_[1], &row)) {
        return NULL;
    }
    if (!lend_real(given_[2], &rear)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 1);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_find_meetings(w, row, rear);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_find_span(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("find_span", 5, count_)) {
        return NULL;
    }
    const Scene *w;
    int row;
    int j;
    double clearance;
    double ttc;
    if (!lend_whole(given_[1], &row)) {
        return NULL;
    }
    if (!lend_whole(given_[2], &j)) {
        return NULL;
    }
    if (!lend_real(given_[3], &clearance)) {
        return NULL;
    }
    if (!lend_real(given_[4], &ttc)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 0);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    cca_ddd result_;
    result_ = cca_find_span(w, row, j, clearance, ttc);
    lend_end(lent_, held_);
    PyObject *items_[] = {PyFloat_FromDouble(result_.item0), PyFloat_FromDouble(result_.item1), PyFloat_FromDouble(result_.item2)};
    return lend_group(items_, 3);
}

static PyObject *call_find_obstacles(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("find_obstacles", 11, count_)) {
        return NULL;
    }
    const Scene *w;
    const Curve *curve;
    double base;
    int n;
    const double *s;
    const double *t;
    double rear;
    int group;
    int vehicles;
    int *rows;
    double *boxes;
    if (!lend_real(given_[2], &base)) {
        return NULL;
    }
    if (!lend_whole(given_[3], &n)) {
        return NULL;
    }
    if (!lend_real(given_[6], &rear)) {
        return NULL;
    }
    if (!lend_whole(given_[7], &group)) {
        return NULL;
    }
    if (!lend_whole(given_[8], &vehicles)) {
        return NULL;
    }
    Lent lent_[6];
    int held_ = 0;
    w = lend_workspace("w", given_[0], &lent_[held_], &held_, sizeof(Scene), 4, 0);
    if (w == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    curve = lend_workspace("curve", given_[1], &lent_[held_], &held_, sizeof(Curve), 5, 0);
    if (curve == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    s = lend_array("s", given_[4], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (s == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    t = lend_array("t", given_[5], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (t == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    rows = lend_array("rows", given_[9], &lent_[held_], &held_, 'i', 1, (Py_ssize_t)vehicles, 0, 1);
    if (rows == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    boxes = lend_array("boxes", given_[10], &lent_[held_], &held_, 'd', 2, ((Py_ssize_t)vehicles * (Py_ssize_t)n), 5, 1);
    if (boxes == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    int result_;
    Py_BEGIN_ALLOW_THREADS
    result_ = cca_find_obstacles(w, curve, base, n, s, t, rear, group, vehicles, rows, boxes);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    return PyLong_FromLong(result_);
}

static PyObject *call_same_direction_distances(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("same_direction_distances", 6, count_)) {
        return NULL;
    }
    int n;
    const double *v_rear;
    const double *v_front;
    const RssReaction *rear;
    const RssReaction *front;
    double *distance;
    if (!lend_whole(given_[0], &n)) {
        return NULL;
    }
    Lent lent_[5];
    int held_ = 0;
    v_rear = lend_array("v_rear", given_[1], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (v_rear == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    v_front = lend_array("v_front", given_[2], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (v_front == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    rear = lend_workspace("rear", given_[3], &lent_[held_], &held_, sizeof(RssReaction), 7, 0);
    if (rear == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    front = lend_workspace("front", given_[4], &lent_[held_], &held_, sizeof(RssReaction), 7, 0);
    if (front == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    distance = lend_array("distance", given_[5], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (distance == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_same_direction_distances(n, v_rear, v_front, rear, front, distance);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_opposite_distances(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("opposite_distances", 6, count_)) {
        return NULL;
    }
    int n;
    const double *v_correct;
    const double *v_opposite;
    const RssReaction *correct;
    const RssReaction *opposite;
    double *distance;
    if (!lend_whole(given_[0], &n)) {
        return NULL;
    }
    Lent lent_[5];
    int held_ = 0;
    v_correct = lend_array("v_correct", given_[1], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (v_correct == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    v_opposite = lend_array("v_opposite", given_[2], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (v_opposite == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    correct = lend_workspace("correct", given_[3], &lent_[held_], &held_, sizeof(RssReaction), 7, 0);
    if (correct == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    opposite = lend_workspace("opposite", given_[4], &lent_[held_], &held_, sizeof(RssReaction), 7, 0);
    if (opposite == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    distance = lend_array("distance", given_[5], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (distance == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_opposite_distances(n, v_correct, v_opposite, correct, opposite, distance);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_lateral_distances(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("lateral_distances", 6, count_)) {
        return NULL;
    }
    int n;
    const double *v_left;
    const double *v_right;
    const RssReaction *left;
    const RssReaction *right;
    double *distance;
    if (!lend_whole(given_[0], &n)) {
        return NULL;
    }
    Lent lent_[5];
    int held_ = 0;
    v_left = lend_array("v_left", given_[1], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (v_left == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    v_right = lend_array("v_right", given_[2], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (v_right == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    left = lend_workspace("left", given_[3], &lent_[held_], &held_, sizeof(RssReaction), 7, 0);
    if (left == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    right = lend_workspace("right", given_[4], &lent_[held_], &held_, sizeof(RssReaction), 7, 0);
    if (right == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    distance = lend_array("distance", given_[5], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (distance == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_lateral_distances(n, v_left, v_right, left, right, distance);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_fiala_force(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("fiala_force", 3, count_)) {
        return NULL;
    }
    double stiffness;
    double slip;
    double f_max;
    if (!lend_real(given_[0], &stiffness)) {
        return NULL;
    }
    if (!lend_real(given_[1], &slip)) {
        return NULL;
    }
    if (!lend_real(given_[2], &f_max)) {
        return NULL;
    }
    double result_;
    result_ = cca_fiala_force(stiffness, slip, f_max);
    return PyFloat_FromDouble(result_);
}

static PyObject *call_drive(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("drive", 4, count_)) {
        return NULL;
    }
    SingleTrackCar *car;
    double delta;
    double a_x;
    double dt;
    if (!lend_real(given_[1], &delta)) {
        return NULL;
    }
    if (!lend_real(given_[2], &a_x)) {
        return NULL;
    }
    if (!lend_real(given_[3], &dt)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    car = lend_workspace("car", given_[0], &lent_[held_], &held_, sizeof(SingleTrackCar), 8, 1);
    if (car == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_drive(car, delta, a_x, dt);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_arrival_times(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("arrival_times", 7, count_)) {
        return NULL;
    }
    int n;
    double v_x;
    double v_target;
    const double *distance;
    double a_max;
    double b_comfort;
    double *t;
    if (!lend_whole(given_[0], &n)) {
        return NULL;
    }
    if (!lend_real(given_[1], &v_x)) {
        return NULL;
    }
    if (!lend_real(given_[2], &v_target)) {
        return NULL;
    }
    if (!lend_real(given_[4], &a_max)) {
        return NULL;
    }
    if (!lend_real(given_[5], &b_comfort)) {
        return NULL;
    }
    Lent lent_[2];
    int held_ = 0;
    distance = lend_array("distance", given_[3], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (distance == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    t = lend_array("t", given_[6], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (t == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_arrival_times(n, v_x, v_target, distance, a_max, b_comfort, t);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_squared_speed_limits(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("squared_speed_limits", 7, count_)) {
        return NULL;
    }
    const Curve *curve;
    int n;
    double cruise;
    double a_y;
    double b_comfort;
    const double *s;
    double *squared;
    if (!lend_whole(given_[1], &n)) {
        return NULL;
    }
    if (!lend_real(given_[2], &cruise)) {
        return NULL;
    }
    if (!lend_real(given_[3], &a_y)) {
        return NULL;
    }
    if (!lend_real(given_[4], &b_comfort)) {
        return NULL;
    }
    Lent lent_[3];
    int held_ = 0;
    curve = lend_workspace("curve", given_[0], &lent_[held_], &held_, sizeof(Curve), 5, 0);
    if (curve == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    s = lend_array("s", given_[5], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (s == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    squared = lend_array("squared", given_[6], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 1);
    if (squared == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    cca_squared_speed_limits(curve, n, cruise, a_y, b_comfort, s, squared);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    Py_RETURN_NONE;
}

static PyObject *call_interpolated(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("interpolated", 4, count_)) {
        return NULL;
    }
    int n;
    const double *at;
    const double *value;
    double s;
    if (!lend_whole(given_[0], &n)) {
        return NULL;
    }
    if (!lend_real(given_[3], &s)) {
        return NULL;
    }
    Lent lent_[2];
    int held_ = 0;
    at = lend_array("at", given_[1], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (at == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    value = lend_array("value", given_[2], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (value == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    double result_;
    result_ = cca_interpolated(n, at, value, s);
    lend_end(lent_, held_);
    return PyFloat_FromDouble(result_);
}

static PyObject *call_profile_acceleration(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("profile_acceleration", 8, count_)) {
        return NULL;
    }
    int n;
    const double *at;
    const double *squared;
    double s;
    double v_x;
    double a_max;
    double b_comfort;
    double b_max;
    if (!lend_whole(given_[0], &n)) {
        return NULL;
    }
    if (!lend_real(given_[3], &s)) {
        return NULL;
    }
    if (!lend_real(given_[4], &v_x)) {
        return NULL;
    }
    if (!lend_real(given_[5], &a_max)) {
        return NULL;
    }
    if (!lend_real(given_[6], &b_comfort)) {
        return NULL;
    }
    if (!lend_real(given_[7], &b_max)) {
        return NULL;
    }
    Lent lent_[2];
    int held_ = 0;
    at = lend_array("at", given_[1], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (at == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    squared = lend_array("squared", given_[2], &lent_[held_], &held_, 'd', 1, (Py_ssize_t)n, 0, 0);
    if (squared == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    double result_;
    result_ = cca_profile_acceleration(n, at, squared, s, v_x, a_max, b_comfort, b_max);
    lend_end(lent_, held_);
    return PyFloat_FromDouble(result_);
}

static PyObject *call_front_slip(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("front_slip", 2, count_)) {
        return NULL;
    }
    const IdealCar *car;
    double fraction;
    if (!lend_real(given_[1], &fraction)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    car = lend_workspace("car", given_[0], &lent_[held_], &held_, sizeof(IdealCar), 9, 0);
    if (car == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    double result_;
    result_ = cca_front_slip(car, fraction);
    lend_end(lent_, held_);
    return PyFloat_FromDouble(result_);
}

static PyObject *call_advance(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("advance", 5, count_)) {
        return NULL;
    }
    IdealCar *car;
    double s;
    double kappa;
    double v_x;
    double dt;
    if (!lend_real(given_[1], &s)) {
        return NULL;
    }
    if (!lend_real(given_[2], &kappa)) {
        return NULL;
    }
    if (!lend_real(given_[3], &v_x)) {
        return NULL;
    }
    if (!lend_real(given_[4], &dt)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    car = lend_workspace("car", given_[0], &lent_[held_], &held_, sizeof(IdealCar), 9, 1);
    if (car == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    double result_;
    Py_BEGIN_ALLOW_THREADS
    result_ = cca_advance(car, s, kappa, v_x, dt);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    return PyFloat_FromDouble(result_);
}

static PyObject *call_find_passed(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("find_passed", 2, count_)) {
        return NULL;
    }
    IdealCar *car;
    double s;
    if (!lend_real(given_[1], &s)) {
        return NULL;
    }
    Lent lent_[1];
    int held_ = 0;
    car = lend_workspace("car", given_[0], &lent_[held_], &held_, sizeof(IdealCar), 9, 1);
    if (car == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    cca_dd result_;
    Py_BEGIN_ALLOW_THREADS
    result_ = cca_find_passed(car, s);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    PyObject *items_[] = {PyFloat_FromDouble(result_.item0), PyFloat_FromDouble(result_.item1)};
    return lend_group(items_, 2);
}

static PyObject *call_steer(PyObject *self_, PyObject *const *given_, Py_ssize_t count_)
{
    (void)self_;
    (void)given_;
    if (!lend_count("steer", 11, count_)) {
        return NULL;
    }
    Steering *law;
    IdealCar *car;
    const Curve *curve;
    double s_guess;
    double x;
    double y;
    double psi;
    double v_x;
    double v_y;
    double r;
    double dt;
    if (!lend_real(given_[3], &s_guess)) {
        return NULL;
    }
    if (!lend_real(given_[4], &x)) {
        return NULL;
    }
    if (!lend_real(given_[5], &y)) {
        return NULL;
    }
    if (!lend_real(given_[6], &psi)) {
        return NULL;
    }
    if (!lend_real(given_[7], &v_x)) {
        return NULL;
    }
    if (!lend_real(given_[8], &v_y)) {
        return NULL;
    }
    if (!lend_real(given_[9], &r)) {
        return NULL;
    }
    if (!lend_real(given_[10], &dt)) {
        return NULL;
    }
    Lent lent_[3];
    int held_ = 0;
    law = lend_workspace("law", given_[0], &lent_[held_], &held_, sizeof(Steering), 10, 1);
    if (law == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    car = lend_workspace("car", given_[1], &lent_[held_], &held_, sizeof(IdealCar), 9, 1);
    if (car == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    curve = lend_workspace("curve", given_[2], &lent_[held_], &held_, sizeof(Curve), 5, 0);
    if (curve == NULL) {
        lend_end(lent_, held_);
        return NULL;
    }
    double result_;
    Py_BEGIN_ALLOW_THREADS
    result_ = cca_steer(law, car, curve, s_guess, x, y, psi, v_x, v_y, r, dt);
    Py_END_ALLOW_THREADS
    lend_end(lent_, held_);
    return PyFloat_FromDouble(result_);
}

static PyMethodDef methods[] = {
    {"oriented_box_gap", (PyCFunction)(void (*)(void))call_oriented_box_gap, METH_FASTCALL, NULL},
    {"box_gap", (PyCFunction)(void (*)(void))call_box_gap, METH_FASTCALL, NULL},
    {"box_gaps", (PyCFunction)(void (*)(void))call_box_gaps, METH_FASTCALL, NULL},
    {"relax_bands", (PyCFunction)(void (*)(void))call_relax_bands, METH_FASTCALL, NULL},
    {"measure_band", (PyCFunction)(void (*)(void))call_measure_band, METH_FASTCALL, NULL},
    {"join_cubics", (PyCFunction)(void (*)(void))call_join_cubics, METH_FASTCALL, NULL},
    {"limit_path_speed", (PyCFunction)(void (*)(void))call_limit_path_speed, METH_FASTCALL, NULL},
    {"roll_out", (PyCFunction)(void (*)(void))call_roll_out, METH_FASTCALL, NULL},
    {"sum_costs", (PyCFunction)(void (*)(void))call_sum_costs, METH_FASTCALL, NULL},
    {"set_order", (PyCFunction)(void (*)(void))call_set_order, METH_FASTCALL, NULL},
    {"set_following_speed", (PyCFunction)(void (*)(void))call_set_following_speed, METH_FASTCALL, NULL},
    {"curve_point", (PyCFunction)(void (*)(void))call_curve_point, METH_FASTCALL, NULL},
    {"curve_points", (PyCFunction)(void (*)(void))call_curve_points, METH_FASTCALL, NULL},
    {"curvature_at", (PyCFunction)(void (*)(void))call_curvature_at, METH_FASTCALL, NULL},
    {"foot_point", (PyCFunction)(void (*)(void))call_foot_point, METH_FASTCALL, NULL},
    {"nearest_point", (PyCFunction)(void (*)(void))call_nearest_point, METH_FASTCALL, NULL},
    {"foot_points", (PyCFunction)(void (*)(void))call_foot_points, METH_FASTCALL, NULL},
    {"nearest_points", (PyCFunction)(void (*)(void))call_nearest_points, METH_FASTCALL, NULL},
    {"distances_driven", (PyCFunction)(void (*)(void))call_distances_driven, METH_FASTCALL, NULL},
    {"reachable_intervals", (PyCFunction)(void (*)(void))call_reachable_intervals, METH_FASTCALL, NULL},
    {"occupied_intervals", (PyCFunction)(void (*)(void))call_occupied_intervals, METH_FASTCALL, NULL},
    {"danger_zones", (PyCFunction)(void (*)(void))call_danger_zones, METH_FASTCALL, NULL},
    {"occupancy_boxes", (PyCFunction)(void (*)(void))call_occupancy_boxes, METH_FASTCALL, NULL},
    {"vehicle_boxes", (PyCFunction)(void (*)(void))call_vehicle_boxes, METH_FASTCALL, NULL},
    {"locate_vehicles", (PyCFunction)(void (*)(void))call_locate_vehicles, METH_FASTCALL, NULL},
    {"find_duty", (PyCFunction)(void (*)(void))call_find_duty, METH_FASTCALL, NULL},
    {"has_duty", (PyCFunction)(void (*)(void))call_has_duty, METH_FASTCALL, NULL},
    {"merges_behind", (PyCFunction)(void (*)(void))call_merges_behind, METH_FASTCALL, NULL},
    {"is_behind", (PyCFunction)(void (*)(void))call_is_behind, METH_FASTCALL, NULL},
    {"is_established", (PyCFunction)(void (*)(void))call_is_established, METH_FASTCALL, NULL},
    {"zone_begin", (PyCFunction)(void (*)(void))call_zone_begin, METH_FASTCALL, NULL},
    {"is_in_zone_lane", (PyCFunction)(void (*)(void))call_is_in_zone_lane, METH_FASTCALL, NULL},
    {"keeps_zone", (PyCFunction)(void (*)(void))call_keeps_zone, METH_FASTCALL, NULL},
    {"reacts", (PyCFunction)(void (*)(void))call_reacts, METH_FASTCALL, NULL},
    {"worst_rear_gap", (PyCFunction)(void (*)(void))call_worst_rear_gap, METH_FASTCALL, NULL},
    {"check_nominal", (PyCFunction)(void (*)(void))call_check_nominal, METH_FASTCALL, NULL},
    {"check_worst_case", (PyCFunction)(void (*)(void))call_check_worst_case, METH_FASTCALL, NULL},
    {"find_conflicts", (PyCFunction)(void (*)(void))call_find_conflicts, METH_FASTCALL, NULL},
    {"find_equilibria", (PyCFunction)(void (*)(void))call_find_equilibria, METH_FASTCALL, NULL},
    {"find_meetings", (PyCFunction)(void (*)(void))call_find_meetings, METH_FASTCALL, NULL},
    {"find_span", (PyCFunction)(void (*)(void))call_find_span, METH_FASTCALL, NULL},
    {"find_obstacles", (PyCFunction)(void (*)(void))call_find_obstacles, METH_FASTCALL, NULL},
    {"same_direction_distances", (PyCFunction)(void (*)(void))call_same_direction_distances, METH_FASTCALL, NULL},
    {"opposite_distances", (PyCFunction)(void (*)(void))call_opposite_distances, METH_FASTCALL, NULL},
    {"lateral_distances", (PyCFunction)(void (*)(void))call_lateral_distances, METH_FASTCALL, NULL},
    {"fiala_force", (PyCFunction)(void (*)(void))call_fiala_force, METH_FASTCALL, NULL},
    {"drive", (PyCFunction)(void (*)(void))call_drive, METH_FASTCALL, NULL},
    {"arrival_times", (PyCFunction)(void (*)(void))call_arrival_times, METH_FASTCALL, NULL},
    {"squared_speed_limits", (PyCFunction)(void (*)(void))call_squared_speed_limits, METH_FASTCALL, NULL},
    {"interpolated", (PyCFunction)(void (*)(void))call_interpolated, METH_FASTCALL, NULL},
    {"profile_acceleration", (PyCFunction)(void (*)(void))call_profile_acceleration, METH_FASTCALL, NULL},
    {"front_slip", (PyCFunction)(void (*)(void))call_front_slip, METH_FASTCALL, NULL},
    {"advance", (PyCFunction)(void (*)(void))call_advance, METH_FASTCALL, NULL},
    {"find_passed", (PyCFunction)(void (*)(void))call_find_passed, METH_FASTCALL, NULL},
    {"steer", (PyCFunction)(void (*)(void))call_steer, METH_FASTCALL, NULL},
    {NULL, NULL, 0, NULL},
};

static int fill(PyObject *module)
{
    PyObject *structures = PyDict_New();
    int failed = structures == NULL || PyModule_AddObjectRef(module, "structures", structures) < 0;
    failed = failed || PyModule_AddStringConstant(module, "digest", "3bdfad8143b12f7091c0188125505858a8e1381048ba949317de04a3b44a82e7") < 0;
    failed = failed || PyModule_AddStringConstant(module, "c_digest", TEXT_OF(CCA_C_DIGEST)) < 0;
    failed = failed || lend_describe(structures, "Equilibrium", 1, sizeof(Equilibrium)) < 0;
    failed = failed || lend_describe(structures, "BandWork", 2, sizeof(BandWork)) < 0;
    failed = failed || lend_describe(structures, "BandBatch", 3, sizeof(BandBatch)) < 0;
    failed = failed || lend_describe(structures, "Scene", 4, sizeof(Scene)) < 0;
    failed = failed || lend_describe(structures, "Curve", 5, sizeof(Curve)) < 0;
    failed = failed || lend_describe(structures, "CurveSamples", 6, sizeof(CurveSamples)) < 0;
    failed = failed || lend_describe(structures, "RssReaction", 7, sizeof(RssReaction)) < 0;
    failed = failed || lend_describe(structures, "SingleTrackCar", 8, sizeof(SingleTrackCar)) < 0;
    failed = failed || lend_describe(structures, "IdealCar", 9, sizeof(IdealCar)) < 0;
    failed = failed || lend_describe(structures, "Steering", 10, sizeof(Steering)) < 0;
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
