/* Made from the Python of cca_core/kernel by `make kernel`: edit that. */
#include "kernel.h"

#include <float.h>
#include <math.h>

/* compile with -ffp-contract=off: a fused product and sum has other bits than Python */
#if FLT_EVAL_METHOD < 0 || FLT_EVAL_METHOD > 1 || defined(__FAST_MATH__)
#error "the kernel needs strict arithmetic of doubles"
#endif
#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

static inline double real_max(double a, double b) { return b > a ? b : a; }
static inline double real_min(double a, double b) { return b < a ? b : a; }
static inline int int_max(int a, int b) { return b > a ? b : a; }
static inline int int_min(int a, int b) { return b < a ? b : a; }
static inline int int_floor(int a, int b) { return a < 0 ? -1 - (-1 - a) / b : a / b; }
static inline int floor_within(double value, int low, int high)
{
    if (!(value >= low)) {
        return low;
    }
    return value >= high ? high : (int)floor(value);
}

/* band_batch.py: Bands of a batch one after the other: from the caller's arrays into the workspace, and
    back. */

/* band_boxes.py: Boxes of the obstacles: their places at each node, headings, radii and steps. */

/* band_workspace.py: Memory of a band in the kernel: codes, the equilibrium, one band, and a batch of
    bands. */
#define BAND_WORKSPACE_OK 0
#define BAND_WORKSPACE_INFEASIBLE 1
#define BAND_WORKSPACE_NOT_CONVERGED 2
#define BAND_WORKSPACE_UNEVEN_SPACING 3
#define BAND_WORKSPACE_TOO_LONG 4
#define BAND_WORKSPACE_INVALID_BOXES 5
#define BAND_WORKSPACE_SATISFIED 0
#define BAND_WORKSPACE_CLEARANCE 1
#define BAND_WORKSPACE_EDGE 2
#define BAND_WORKSPACE_DISPLACEMENT 3
#define BAND_WORKSPACE_CURVATURE 4
#define BAND_WORKSPACE_EMPTY_INTERVAL 5
#define BAND_WORKSPACE_BLOCKED_END 6
#define BAND_WORKSPACE_ACTIVE_SET 7
#define BAND_WORKSPACE_NO_CONSTRAINT (-1)
#define BAND_WORKSPACE_LEFT_EDGE (-2)
#define BAND_WORKSPACE_RIGHT_EDGE (-3)
#define BAND_WORKSPACE_CURVATURE_LIMIT (-4)
#define BAND_WORKSPACE_GIVEN_SIDES 0
#define BAND_WORKSPACE_BLOCKING_RIGHT 1
#define BAND_WORKSPACE_BLOCKING_LEFT 2
#define BAND_WORKSPACE_CHEAPEST_SIDES 3
#define BAND_WORKSPACE_REALS 6
#define BAND_WORKSPACE_REALS_PER_NODE 7
#define BAND_WORKSPACE_CODES 6

/* box_gaps.py: Distances of oriented boxes. */
#define BOX_GAPS_SMALL 1e-280
#define BOX_GAPS_LARGE 1e+300

/* Length of a vector whose square overflows or has lost its digits. */
static double box_gaps_scaled_norm(double x, double y)
{
    if (!(fabs(x) + fabs(y) > 0.0)) {
        return fabs(x) + fabs(y);
    }
    double scale = real_max(fabs(x), fabs(y));
    if (scale == HUGE_VAL) {
        return scale;
    }
    double a = x / scale;
    double b = y / scale;
    return scale * sqrt(a * a + b * b);
}

/* Length of a vector; `math.hypot` has other bits in Python than in C. */
static double box_gaps_norm(double x, double y)
{
    double squared = x * x + y * y;
    return BOX_GAPS_SMALL < squared && squared < BOX_GAPS_LARGE ? sqrt(squared) : box_gaps_scaled_norm(x, y);
}

/* Squared distance of a point from a box around the origin. */
static double box_gaps_squared_distance(double x, double y, double half_length, double half_width)
{
    double dx = fabs(x) - half_length;
    double dy = fabs(y) - half_width;
    if (dx > 0.0) {
        return dy > 0.0 ? dx * dx + dy * dy : dx * dx;
    }
    return dy > 0.0 ? dy * dy : 0.0;
}

/* Smaller squared distance of the two corners that protrude most towards a box around the origin. */
static double box_gaps_nearest_corner(double near_x, double side_y, double side_x, double near_y,
    double half_length, double half_width)
{
    return real_min(box_gaps_squared_distance(near_x, side_y, half_length, half_width),
        box_gaps_squared_distance(side_x, near_y, half_length, half_width));
}

/* Signed distance of box b, at dx, dy from box a, from unit headings and half extents [m]. */
double cca_oriented_box_gap(double dx, double dy, double ax, double ay, double bx, double by,
    double length_a, double width_a, double length_b, double width_b)
{
    double turn_c = bx * ax + by * ay;
    double turn_s = by * ax - bx * ay;
    double c = fabs(turn_c);
    double s = fabs(turn_s);
    double x_b = dx * ax + dy * ay;
    double y_b = dy * ax - dx * ay;
    double x_a = dx * bx + dy * by;
    double y_a = dy * bx - dx * by;
    double turn = turn_c * turn_s;
    double turn_b = turn * x_b * y_b >= 0.0 ? 1.0 : -1.0;
    double turn_a = turn * x_a * y_a >= 0.0 ? -1.0 : 1.0;
    x_b = fabs(x_b);
    y_b = fabs(y_b);
    x_a = fabs(x_a);
    y_a = fabs(y_a);
    double near_x_b = x_b - (length_b * c + width_b * s);
    double near_y_b = y_b - (length_b * s + width_b * c);
    double near_x_a = x_a - (length_a * c + width_a * s);
    double near_y_a = y_a - (length_a * s + width_a * c);
    double along_a = near_x_b - length_a;
    double across_a = near_y_b - width_a;
    double along_b = near_x_a - length_b;
    double across_b = near_y_a - width_b;
    double total = along_a + across_a + along_b + across_b;
    if (!isfinite(total)) {
        return total;
    }
    double separation = along_a;
    if (across_a > separation) {
        separation = across_a;
    }
    if (along_b > separation) {
        separation = along_b;
    }
    if (across_b > separation) {
        separation = across_b;
    }
    if (separation <= 0.0) {
        return separation;
    }
    double side_y_b = y_b - turn_b * (length_b * s - width_b * c);
    if (separation == along_a && fabs(side_y_b) <= width_a) {
        return separation;
    }
    double side_x_b = x_b - turn_b * (length_b * c - width_b * s);
    if (separation == across_a && fabs(side_x_b) <= length_a) {
        return separation;
    }
    double side_y_a = y_a - turn_a * (length_a * s - width_a * c);
    if (separation == along_b && fabs(side_y_a) <= width_b) {
        return separation;
    }
    double side_x_a = x_a - turn_a * (length_a * c - width_a * s);
    if (separation == across_b && fabs(side_x_a) <= length_b) {
        return separation;
    }
    double of_b = box_gaps_nearest_corner(near_x_b, side_y_b, side_x_b, near_y_b, length_a, width_a);
    double of_a = box_gaps_nearest_corner(near_x_a, side_y_a, side_x_a, near_y_a, length_b, width_b);
    double squared = real_min(of_b, of_a);
    if (squared < BOX_GAPS_LARGE) {
        return sqrt(squared);
    }
    double unit = 1.0 / separation;
    of_b = box_gaps_nearest_corner(near_x_b * unit, side_y_b * unit, side_x_b * unit, near_y_b * unit,
        length_a * unit, width_a * unit);
    of_a = box_gaps_nearest_corner(near_x_a * unit, side_y_a * unit, side_x_a * unit, near_y_a * unit,
        length_b * unit, width_b * unit);
    return separation * sqrt(real_min(of_b, of_a));
}

/* Signed distance of two boxes from centers, headings and full extents [m]; NaN if one is not finite. */
double cca_box_gap(double ax, double ay, double a_psi, double a_length, double a_width, double bx,
    double by, double b_psi, double b_length, double b_width)
{
    double headings = 0.0 * a_psi + 0.0 * b_psi;
    if (isnan(headings)) {
        return headings;
    }
    return cca_oriented_box_gap(bx - ax, by - ay, cos(a_psi), sin(a_psi), cos(b_psi), sin(b_psi), 0.5
        * a_length, 0.5 * a_width, 0.5 * b_length, 0.5 * b_width);
}

/* Signed distances of n boxes b from k boxes a, which repeat: x, y, heading, length, width of each. */
void cca_box_gaps(int n, int k, const double *a, const double *b, double *gap)
{
    int j = 0;
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        gap[i] = cca_box_gap(a[j * 5 + 0], a[j * 5 + 1], a[j * 5 + 2], a[j * 5 + 3], a[j * 5 + 4], b[i * 5
            + 0], b[i * 5 + 1], b[i * 5 + 2], b[i * 5 + 3], b[i * 5 + 4]);
        j += 1;
        if (j == k) {
            j = 0;
        }
    }
}

/* Return whether the boxes of an obstacle of a band are the same at all nodes. */
static bool band_boxes_are_equal(const BandBatch *q, int first, int next_quantity)
{
    const double *boxes = q->boxes;
    for (int k = 0; k < 5; k += 1) {
        int at = first + k * next_quantity;
        double value = boxes[at];
        for (int i = at + 1, i_end_ = at + q->n; i < i_end_; i += 1) {
            if (boxes[i] != value) {
                return false;
            }
        }
    }
    return true;
}

/* Return the node at which the box of a node is kept: the first one has that of a fixed obstacle. */
static int band_boxes_node_of(const BandWork *w, int o, int i)
{
    return w->is_fixed[o] != 0 ? 0 : i;
}

/* Copy the boxes of an obstacle, with headings, radii and largest step; check their numbers. */
static void band_boxes_load_boxes(const BandBatch *q, int b, BandWork *w, int o)
{
    const double *boxes = q->boxes;
    int at = (o * q->bands + b) * q->max_n;
    int next_quantity = w->m * q->bands * q->max_n;
    double x = 0.0;
    double y = 0.0;
    double psi = 0.0;
    double half_length = 0.0;
    double half_width = 0.0;
    double ahead_x = 0.0;
    double ahead_y = 0.0;
    double radius = 0.0;
    bool fixed = band_boxes_are_equal(q, at, next_quantity);
    w->is_fixed[o] = fixed ? 1 : 0;
    w->max_step[o] = 0.0;
    w->max_radius[o] = 0.0;
    for (int i = 0, i_end_ = fixed ? 1 : w->n; i < i_end_; i += 1) {
        double last_x = x;
        double last_y = y;
        x = boxes[at];
        y = boxes[at + next_quantity];
        double new_psi = boxes[at + 2 * next_quantity];
        double new_length = 0.5 * boxes[at + 3 * next_quantity];
        double new_width = 0.5 * boxes[at + 4 * next_quantity];
        at += 1;
        bool moves = i == 0 || x != last_x || y != last_y;
        bool turns = i == 0 || new_psi != psi;
        bool resizes = i == 0 || new_length != half_length || new_width != half_width;
        double turn = 0.0;
        if (moves && !(fabs(x) < HUGE_VAL && fabs(y) < HUGE_VAL)) {
            w->has_valid_boxes = false;
        }
        if (resizes) {
            half_length = new_length;
            half_width = new_width;
            radius = box_gaps_norm(half_length, half_width);
            w->max_radius[o] = real_max(w->max_radius[o], radius);
            if (!((0.0 <= half_length && half_length < HUGE_VAL) && (0.0 <= half_width && half_width
                < HUGE_VAL))) {
                w->has_valid_boxes = false;
            }
        }
        if (turns) {
            psi = new_psi;
            if (!(fabs(psi) < HUGE_VAL)) {
                w->has_valid_boxes = false;
                return;
            }
            double new_x = cos(psi);
            double new_y = sin(psi);
            turn = box_gaps_norm(new_x - ahead_x, new_y - ahead_y);
            ahead_x = new_x;
            ahead_y = new_y;
        }
        if (i > 0 && (moves || turns || resizes)) {
            w->max_step[o] = real_max(w->max_step[o], box_gaps_norm(x - last_x, y - last_y) + turn * radius);
        }
        w->box_x[o * w->max_n + i] = x;
        w->box_y[o * w->max_n + i] = y;
        w->half_length[o * w->max_n + i] = half_length;
        w->half_width[o * w->max_n + i] = half_width;
        w->box_ahead_x[o * w->max_n + i] = ahead_x;
        w->box_ahead_y[o * w->max_n + i] = ahead_y;
        w->radius[o * w->max_n + i] = radius;
    }
}

/* band_certificate.py: Certificate of a band: gaps of the ego's swept box to obstacles and edges, and
    curvature. */

/* band_gaps.py: Gaps of the ego's swept box to obstacles, between nodes too: lower bounds, tight where
    they limit. */

/* constants.py: Quantities of which kernels and the rest of the library use one value. */
#define CONSTANTS_GRAVITY 9.81
#define CONSTANTS_STALE_AGE 1.0
#define CONSTANTS_STANDSTILL_SPEED 0.5
#define CONSTANTS_TINY 1e-12
#define BAND_GAPS_CURVE_ERROR 0.002
#define BAND_GAPS_LOOSE 0.004
#define BAND_GAPS_DECISIVE 0.01
#define BAND_GAPS_PARTS 16
#define BAND_GAPS_TURN_ERROR 0.125
#define BAND_GAPS_LEVER 0.6

/* Return the gap to an obstacle with the ego at a node. */
static double band_gaps_gap_at(const BandWork *w, int o, int i)
{
    int k = band_boxes_node_of(w, o, i);
    return cca_oriented_box_gap(w->box_x[o * w->max_n + k] - w->center_x[i], w->box_y[o * w->max_n + k]
        - w->center_y[i], w->ahead_x[i], w->ahead_y[i], w->box_ahead_x[o * w->max_n + k], w->box_ahead_y[o
        * w->max_n + k], 0.5 * w->length, 0.5 * w->width, w->half_length[o * w->max_n + k], w->half_width[o
        * w->max_n + k]);
}

/* Compute the gap to an obstacle at equal parts from a node to the next, whose gaps are given. */
static void band_gaps_sample_between(BandWork *w, int o, int i, double first, double last)
{
    int j = i + 1;
    double x = w->x[i];
    double y = w->y[i];
    double cx = w->x[j] - x;
    double cy = w->y[j] - y;
    double chord = box_gaps_norm(cx, cy);
    double ax = w->ahead_x[i] * chord - cx;
    double ay = w->ahead_y[i] * chord - cy;
    double bx = cx - w->ahead_x[j] * chord;
    double by = cy - w->ahead_y[j] * chord;
    bool changes = w->is_fixed[o] == 0;
    int at = band_boxes_node_of(w, o, i);
    double box_x = w->box_x[o * w->max_n + at];
    double box_y = w->box_y[o * w->max_n + at];
    double heading_x = w->box_ahead_x[o * w->max_n + at];
    double heading_y = w->box_ahead_y[o * w->max_n + at];
    double box_length = w->half_length[o * w->max_n + at];
    double box_width = w->half_width[o * w->max_n + at];
    double length = 0.5 * w->length;
    double width = 0.5 * w->width;
    double offset = w->box_offset;
    double *parts = w->parts;
    parts[0] = first;
    parts[BAND_GAPS_PARTS] = last;
    for (int k = 1, k_end_ = BAND_GAPS_PARTS; k < k_end_; k += 1) {
        double f = k / 16.0;
        double e = 1.0 - f;
        double tx = cx + e * (1.0 - 3.0 * f) * ax + f * (2.0 - 3.0 * f) * bx;
        double ty = cy + e * (1.0 - 3.0 * f) * ay + f * (2.0 - 3.0 * f) * by;
        double speed = real_max(box_gaps_norm(tx, ty), CONSTANTS_TINY);
        tx /= speed;
        ty /= speed;
        if (changes) {
            double hx = w->box_ahead_x[o * w->max_n + i] + f * (w->box_ahead_x[o * w->max_n + j]
                - w->box_ahead_x[o * w->max_n + i]);
            double hy = w->box_ahead_y[o * w->max_n + i] + f * (w->box_ahead_y[o * w->max_n + j]
                - w->box_ahead_y[o * w->max_n + i]);
            double heading = real_max(box_gaps_norm(hx, hy), CONSTANTS_TINY);
            heading_x = hx / heading;
            heading_y = hy / heading;
            box_x = w->box_x[o * w->max_n + i] + f * (w->box_x[o * w->max_n + j] - w->box_x[o * w->max_n
                + i]);
            box_y = w->box_y[o * w->max_n + i] + f * (w->box_y[o * w->max_n + j] - w->box_y[o * w->max_n
                + i]);
            box_length = w->half_length[o * w->max_n + i] + f * (w->half_length[o * w->max_n + j]
                - w->half_length[o * w->max_n + i]);
            box_width = w->half_width[o * w->max_n + i] + f * (w->half_width[o * w->max_n + j]
                - w->half_width[o * w->max_n + i]);
        }
        double dx = box_x - (x + f * cx + f * e * (e * ax + f * bx)) - offset * tx;
        double dy = box_y - (y + f * cy + f * e * (e * ay + f * by)) - offset * ty;
        parts[k] = cca_oriented_box_gap(dx, dy, tx, ty, heading_x, heading_y, length, width, box_length,
            box_width);
    }
}

/* Return by how much the box of an obstacle turns from a node to the next [rad]. */
static double band_gaps_turn_between(const BandWork *w, int o, int i)
{
    if (w->is_fixed[o] != 0) {
        return 0.0;
    }
    int j = int_min(i + 1, w->n - 1);
    return box_gaps_norm(w->box_ahead_x[o * w->max_n + j] - w->box_ahead_x[o * w->max_n + i],
        w->box_ahead_y[o * w->max_n + j] - w->box_ahead_y[o * w->max_n + i]);
}

/* Return a lower bound of the gap to an obstacle from a node to the next, whose gaps are given. */
static double band_gaps_min_between(BandWork *w, int o, int i, double first, double last)
{
    const double *gap = w->parts;
    band_gaps_sample_between(w, o, i, first, last);
    double bound = gap[0];
    for (int k = 1, k_end_ = BAND_GAPS_PARTS + 1; k < k_end_; k += 1) {
        if (gap[k] < bound) {
            bound = gap[k];
        }
    }
    if (w->max_step[o] > 0.0) {
        double bent = w->spacing * real_max(fabs(w->curvature[i]), fabs(w->curvature[i + 1]));
        double swing = w->radius[o * w->max_n + i] * band_gaps_turn_between(w, o, i) + BAND_GAPS_LEVER
            * w->length * bent;
        bound -= BAND_GAPS_TURN_ERROR * swing;
    }
    bound = real_min(bound, gap[1] - real_max(gap[2] - gap[1], 0.0));
    bound = real_min(bound, gap[BAND_GAPS_PARTS - 1] + real_min(gap[BAND_GAPS_PARTS - 1]
        - gap[BAND_GAPS_PARTS - 2], 0.0));
    double before = gap[1] - gap[0];
    double here = gap[2] - gap[1];
    for (int k = 1, k_end_ = BAND_GAPS_PARTS - 1; k < k_end_; k += 1) {
        double after = gap[k + 2] - gap[k + 1];
        if (before < 0.0 && after > 0.0) {
            bound = real_min(bound, gap[k] + before * (here - after) / (before - after));
        }
        before = here;
        here = after;
    }
    return bound;
}

/* Return by how much a gap to a stationary obstacle changes at most from node to node. */
static double band_gaps_max_change(const BandWork *w)
{
    return w->spacing * (1.0 + BAND_GAPS_LEVER * w->length * w->max_curvature);
}

/* Compute the center of the ego's box at each node; return the longest way from node to node. */
static double band_gaps_set_centers(BandWork *w)
{
    double *center_x = w->center_x;
    double *center_y = w->center_y;
    double offset = w->box_offset;
    double longest = 0.0;
    double last_x = 0.0;
    double last_y = 0.0;
    const double *node_x = w->x;
    const double *node_y = w->y;
    const double *ahead_x = w->ahead_x;
    const double *ahead_y = w->ahead_y;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        double x = node_x[i] + offset * ahead_x[i];
        double y = node_y[i] + offset * ahead_y[i];
        center_x[i] = x;
        center_y[i] = y;
        if (i > 0) {
            double dx = x - last_x;
            double dy = y - last_y;
            double squared = dx * dx + dy * dy;
            if (squared > longest) {
                longest = squared;
            }
        }
        last_x = x;
        last_y = y;
    }
    return sqrt(longest);
}

/* Find the obstacles and nodes that may be near each other, as pairs; skip nodes that are too far. */
static void band_gaps_find_near(BandWork *w)
{
    double half = 0.5 * box_gaps_norm(w->length, w->width);
    double upper = HUGE_VAL;
    double step = band_gaps_set_centers(w);
    double change = band_gaps_max_change(w);
    const double *center_x = w->center_x;
    const double *center_y = w->center_y;
    double clearance = w->clearance;
    double half_width = 0.5 * w->width;
    w->n_pairs = 0;
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        double moves = w->max_step[o] + change;
        double travel = real_max(w->max_step[o] + step, CONSTANTS_TINY);
        int next_node = 0;
        bool changes = w->is_fixed[o] == 0;
        double x = w->box_x[o * w->max_n + 0];
        double y = w->box_y[o * w->max_n + 0];
        double radius = w->radius[o * w->max_n + 0];
        double box_width = w->half_width[o * w->max_n + 0];
        for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
            if (i < next_node) {
                continue;
            }
            if (changes) {
                x = w->box_x[o * w->max_n + i];
                y = w->box_y[o * w->max_n + i];
                radius = w->radius[o * w->max_n + i];
                box_width = w->half_width[o * w->max_n + i];
            }
            double distance = box_gaps_norm(x - center_x[i], y - center_y[i]);
            double gap = distance - (radius + half);
            upper = real_min(upper, distance - box_width);
            double near = real_max(clearance, upper - half_width) + 2.0 * moves;
            if (gap > near) {
                double excess = distance - (w->max_radius[o] + half) - near;
                next_node = i + floor_within(excess / travel, 1, w->n);
            } else {
                w->pair_obstacle[w->n_pairs] = o;
                w->pair_node[w->n_pairs] = i;
                w->bound[w->n_pairs] = gap;
                w->n_pairs += 1;
            }
        }
    }
    w->near = real_max(w->clearance, upper - 0.5 * w->width);
}

/* Sample the gaps of the pairs; drop those that have turned out to be far, as others are nearer. */
static void band_gaps_sample_near(BandWork *w)
{
    double change = band_gaps_max_change(w);
    int count = 0;
    for (int k = 0, k_end_ = w->n_pairs; k < k_end_; k += 1) {
        int o = w->pair_obstacle[k];
        int i = w->pair_node[k];
        double moves = w->max_step[o] + change;
        if (w->bound[k] > w->near + 2.0 * moves) {
            continue;
        }
        w->pair_obstacle[count] = o;
        w->pair_node[count] = i;
        w->sampled[count] = band_gaps_gap_at(w, o, i);
        double turn = w->spacing * fabs(w->curvature[i]);
        w->bulge[count] = 0.125 * w->spacing * turn + 0.5 * moves * (turn + band_gaps_turn_between(w, o, i));
        count += 1;
    }
    w->n_pairs = count;
}

/* Return whether the band is straight at the sampled nodes, and every obstacle stationary. */
static bool band_gaps_is_straight(const BandWork *w)
{
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        if (w->max_step[o] != 0.0) {
            return false;
        }
    }
    for (int k = 0, k_end_ = w->n_pairs; k < k_end_; k += 1) {
        if (w->curvature[w->pair_node[k]] != 0.0) {
            return false;
        }
    }
    return true;
}

/* Bound the gaps between sampled nodes from below, by the samples around. */
static void band_gaps_bound_between(BandWork *w)
{
    const double *sampled = w->sampled;
    double *bulge = w->bulge;
    double *bound = w->bound;
    int count = w->n_pairs;
    double error = band_gaps_is_straight(w) ? 0.0 : BAND_GAPS_CURVE_ERROR;
    for (int k = 0, k_end_ = count; k < k_end_; k += 1) {
        bulge[k] += error;
        bound[k] = sampled[k];
    }
    for (int k = 0, k_end_ = count - 1; k < k_end_; k += 1) {
        if (w->pair_node[k + 1] - w->pair_node[k] == 1) {
            bound[k] = real_min(sampled[k], sampled[k + 1]) - real_max(bulge[k], bulge[k + 1]);
        }
    }
    for (int k = 1, k_end_ = count - 2; k < k_end_; k += 1) {
        double before = sampled[k] - sampled[k - 1];
        double after = sampled[k + 2] - sampled[k + 1];
        if (before < 0.0 && after > 0.0 && w->pair_node[k + 2] - w->pair_node[k - 1] == 3) {
            double dip = sampled[k] + before * (sampled[k + 1] - sampled[k] - after) / (before - after);
            double allowance = real_max(real_max(real_max(bulge[k - 1], bulge[k]), bulge[k + 1]), bulge[k
                + 2]);
            bound[k] = real_min(bound[k], dip - allowance);
        }
    }
    double change = band_gaps_max_change(w);
    for (int k = 0, k_end_ = count - 1; k < k_end_; k += 1) {
        int i = w->pair_node[k];
        if (w->pair_node[k + 1] - i == 1 && (i == 0 || i == w->n - 2)) {
            bound[k] -= 0.5 * (w->max_step[w->pair_obstacle[k]] + change);
        }
    }
}

/* Sample closely where a bound is below the clearance, or loose where the gap at the nodes is. */
static void band_gaps_refine_between(BandWork *w)
{
    const double *sampled = w->sampled;
    double *bound = w->bound;
    int count = w->n_pairs;
    double min_sample = HUGE_VAL;
    for (int k = 0, k_end_ = count; k < k_end_; k += 1) {
        min_sample = real_min(min_sample, sampled[k]);
    }
    for (int k = 0, k_end_ = count - 1; k < k_end_; k += 1) {
        int o = w->pair_obstacle[k];
        int i = w->pair_node[k];
        if (w->pair_node[k + 1] - i != 1) {
            continue;
        }
        double min_at_nodes = real_min(sampled[k], sampled[k + 1]);
        double decisive = w->clearance;
        if (min_at_nodes < w->clearance) {
            if (!(w->max_step[o] > 0.0)) {
                continue;
            }
            decisive = min_at_nodes - BAND_GAPS_LOOSE;
        } else if (w->max_step[o] == 0.0) {
            decisive = real_max(decisive, real_min(min_sample - BAND_GAPS_LOOSE, w->clearance
                + BAND_GAPS_DECISIVE));
        }
        if (bound[k] < decisive) {
            bound[k] = band_gaps_min_between(w, o, i, sampled[k], sampled[k + 1]);
        }
    }
}

/* Bound the gaps of the pairs from each node to the next, and find the least of all. */
static void band_gaps_measure_gaps(BandWork *w)
{
    band_gaps_find_near(w);
    band_gaps_sample_near(w);
    band_gaps_bound_between(w);
    band_gaps_refine_between(w);
    w->min_gap = HUGE_VAL;
    for (int k = 0, k_end_ = w->n_pairs; k < k_end_; k += 1) {
        w->min_gap = real_min(w->min_gap, w->bound[k]);
        if (!(w->bound[k] > -HUGE_VAL)) {
            w->finite = false;
        }
    }
}

/* Return the least gap to an obstacle; infinite if it is far. */
static double band_gaps_gap_to(const BandWork *w, int o)
{
    double gap = HUGE_VAL;
    for (int k = 0, k_end_ = w->n_pairs; k < k_end_; k += 1) {
        if (w->pair_obstacle[k] == o) {
            gap = real_min(gap, w->bound[k]);
        }
    }
    return gap;
}

/* Return the lesser of the gaps to an obstacle at the pinned ends, which no deformation changes. */
static double band_gaps_end_gap(const BandWork *w, int o)
{
    int e = w->n - 1;
    double x = w->route_x[0] - w->tangent_y[0] * w->free[0] + w->box_offset * w->heading_x0;
    double y = w->route_y[0] + w->tangent_x[0] * w->free[0] + w->box_offset * w->heading_y0;
    double first = cca_oriented_box_gap(w->box_x[o * w->max_n + 0] - x, w->box_y[o * w->max_n + 0] - y,
        w->heading_x0, w->heading_y0, w->box_ahead_x[o * w->max_n + 0], w->box_ahead_y[o * w->max_n + 0], 0.5
        * w->length, 0.5 * w->width, w->half_length[o * w->max_n + 0], w->half_width[o * w->max_n + 0]);
    int k = band_boxes_node_of(w, o, e);
    x = w->route_x[e] - w->tangent_y[e] * w->free[e] + w->box_offset * w->heading_x1;
    y = w->route_y[e] + w->tangent_x[e] * w->free[e] + w->box_offset * w->heading_y1;
    double last = cca_oriented_box_gap(w->box_x[o * w->max_n + k] - x, w->box_y[o * w->max_n + k] - y,
        w->heading_x1, w->heading_y1, w->box_ahead_x[o * w->max_n + k], w->box_ahead_y[o * w->max_n + k], 0.5
        * w->length, 0.5 * w->width, w->half_length[o * w->max_n + k], w->half_width[o * w->max_n + k]);
    return real_min(first, last);
}

/* band_spline.py: The C2 cubic through the displaced nodes: unit tangents, curvature, and moments divided
    by 6. */

/* Displace the nodes of the route to their left. */
static void band_spline_displace_nodes(BandWork *w)
{
    double *x = w->x;
    double *y = w->y;
    const double *u = w->u;
    const double *route_x = w->route_x;
    const double *route_y = w->route_y;
    const double *tangent_x = w->tangent_x;
    const double *tangent_y = w->tangent_y;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        double d = u[i];
        x[i] = route_x[i] - tangent_y[i] * d;
        y[i] = route_y[i] + tangent_x[i] * d;
    }
}

/* Solve the tridiagonal system of the moments, whose ends are known, with slopes in `ahead`. */
static void band_spline_solve_moments(BandWork *w)
{
    int n = w->n;
    const double *h = w->chord;
    double *mx = w->moment_x;
    double *my = w->moment_y;
    double *diagonal = w->diagonal;
    mx[0] = w->moment_x0;
    my[0] = w->moment_y0;
    mx[n - 1] = w->moment_x1;
    my[n - 1] = w->moment_y1;
    const double *ahead_x = w->ahead_x;
    const double *ahead_y = w->ahead_y;
    double last_x = ahead_x[0];
    double last_y = ahead_y[0];
    double last_h = h[0];
    double factor = last_h;
    double x = mx[0];
    double y = my[0];
    for (int i = 1, i_end_ = n - 1; i < i_end_; i += 1) {
        double here_x = ahead_x[i];
        double here_y = ahead_y[i];
        double here_h = h[i];
        x = here_x - last_x - factor * x;
        y = here_y - last_y - factor * y;
        double pivot = 2.0 * (here_h + last_h) - (i > 1 ? factor * last_h : 0.0);
        mx[i] = x;
        my[i] = y;
        diagonal[i] = pivot;
        factor = here_h / pivot;
        last_x = here_x;
        last_y = here_y;
        last_h = here_h;
    }
    x = mx[n - 1];
    y = my[n - 1];
    for (int i = n - 2; i > 0; i -= 1) {
        double here_h = h[i];
        double pivot = diagonal[i];
        x = (mx[i] - here_h * x) / pivot;
        y = (my[i] - here_h * y) / pivot;
        mx[i] = x;
        my[i] = y;
    }
}

/* Fit the curve through the displaced nodes. */
static void band_spline_fit_spline(BandWork *w)
{
    int n = w->n;
    double *h = w->chord;
    double *ax = w->ahead_x;
    double *ay = w->ahead_y;
    const double *mx = w->moment_x;
    const double *my = w->moment_y;
    const double *x = w->x;
    const double *y = w->y;
    double here_x = x[0];
    double here_y = y[0];
    for (int i = 0, i_end_ = n - 1; i < i_end_; i += 1) {
        double next_x = x[i + 1];
        double next_y = y[i + 1];
        double dx = next_x - here_x;
        double dy = next_y - here_y;
        here_x = next_x;
        here_y = next_y;
        double chord = real_max(box_gaps_norm(dx, dy), CONSTANTS_TINY);
        h[i] = chord;
        ax[i] = dx / chord;
        ay[i] = dy / chord;
    }
    band_spline_solve_moments(w);
    ax[n - 1] = ax[n - 2] + h[n - 2] * (2.0 * mx[n - 1] + mx[n - 2]);
    ay[n - 1] = ay[n - 2] + h[n - 2] * (2.0 * my[n - 1] + my[n - 2]);
    double *curvature = w->curvature;
    here_x = mx[0];
    here_y = my[0];
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        double moment_x = here_x;
        double moment_y = here_y;
        double tx = ax[i];
        double ty = ay[i];
        if (i < n - 1) {
            double chord = h[i];
            here_x = mx[i + 1];
            here_y = my[i + 1];
            tx -= chord * (2.0 * moment_x + here_x);
            ty -= chord * (2.0 * moment_y + here_y);
        }
        double speed = real_max(sqrt(tx * tx + ty * ty), CONSTANTS_TINY);
        tx /= speed;
        ty /= speed;
        ax[i] = tx;
        ay[i] = ty;
        curvature[i] = 6.0 * (tx * moment_y - ty * moment_x) / (speed * speed);
    }
}

/* Lower the margins to the distance of one cross section of the body from the edges there. */
static void band_certificate_measure_edges_at(BandWork *w, double x, int ahead)
{
    double half = 0.5 * w->width;
    const double *ahead_x = w->ahead_x;
    const double *ahead_y = w->ahead_y;
    const double *tangent_x = w->tangent_x;
    const double *tangent_y = w->tangent_y;
    double *right_margin = w->right_margin;
    double *left_margin = w->left_margin;
    double bulge = 0.125 * (w->spacing * w->spacing);
    double bent = 0.5 * (x * x);
    int last = w->n - 1;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        double turn_cos = ahead_x[i] * tangent_x[i] + ahead_y[i] * tangent_y[i];
        double turn_sin = ahead_y[i] * tangent_x[i] - ahead_x[i] * tangent_y[i];
        double reach = half * turn_cos + bulge * fabs(w->curvature[i]);
        double middle = w->u[i] + x * turn_sin - bent * w->route_curvature[i];
        int at = int_min(int_max(i + ahead, 0), last);
        right_margin[i] = real_min(right_margin[i], middle - reach - w->right_edge[at]);
        left_margin[i] = real_min(left_margin[i], w->left_edge[at] - middle - reach);
    }
}

/* Return whether both edges keep their lateral offset. */
static bool band_certificate_has_straight_edges(const BandWork *w)
{
    for (int i = 1, i_end_ = w->n; i < i_end_; i += 1) {
        if (w->right_edge[i] != w->right_edge[0] || w->left_edge[i] != w->left_edge[0]) {
            return false;
        }
    }
    return true;
}

/* Compute the distance of the body from both edges, over its length. */
static void band_certificate_measure_edges(BandWork *w)
{
    double *right_margin = w->right_margin;
    double *left_margin = w->left_margin;
    w->min_edge_clearance = HUGE_VAL;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        right_margin[i] = HUGE_VAL;
        left_margin[i] = HUGE_VAL;
    }
    if (!w->has_edges) {
        return;
    }
    double front = w->box_offset + 0.5 * w->length;
    double rear = w->box_offset - 0.5 * w->length;
    double h = w->spacing;
    if (band_certificate_has_straight_edges(w)) {
        band_certificate_measure_edges_at(w, front, 0);
        band_certificate_measure_edges_at(w, w->box_offset, 0);
        band_certificate_measure_edges_at(w, rear, 0);
    } else {
        for (int k = -w->n, k_end_ = w->n + 1; k < k_end_; k += 1) {
            if (rear - h < k * h && k * h < front + h) {
                band_certificate_measure_edges_at(w, real_min(real_max(k * h, rear), front), k);
            }
        }
    }
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        double margin = real_min(right_margin[i], left_margin[i]);
        w->min_edge_clearance = real_min(w->min_edge_clearance, margin);
        if (!(margin > -HUGE_VAL)) {
            w->finite = false;
        }
    }
}

/* Sweep the ego's box along the displaced band. */
static void band_certificate_certify(BandWork *w)
{
    w->finite = true;
    band_spline_displace_nodes(w);
    band_spline_fit_spline(w);
    const double *u = w->u;
    const double *moment_x = w->moment_x;
    const double *moment_y = w->moment_y;
    const double *curvatures = w->curvature;
    const double *limits = w->curvature_limit;
    double sharpest = 0.0;
    double ratio = 0.0;
    double size = 0.0;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        double curvature = fabs(curvatures[i]);
        if (curvature > sharpest) {
            sharpest = curvature;
        }
        double here = curvature / limits[i];
        if (here > ratio) {
            ratio = here;
        }
        size += fabs(u[i]) + fabs(moment_x[i]) + fabs(moment_y[i]) + curvature;
    }
    w->max_curvature = sharpest;
    w->curvature_ratio = ratio;
    if (!(size < HUGE_VAL)) {
        w->finite = false;
    }
    band_gaps_measure_gaps(w);
    band_certificate_measure_edges(w);
}

/* Return the shortfall [m] of clearance or at an edge, negative if there is none. */
static double band_certificate_shortfall_of(const BandWork *w)
{
    return real_max(w->clearance - w->min_gap, -w->min_edge_clearance);
}

/* Return whether clearance, edges and curvature limit are kept. */
static bool band_certificate_is_satisfied(const BandWork *w)
{
    return w->finite && band_certificate_shortfall_of(w) <= 0.0 && w->curvature_ratio <= 1.0;
}

/* Return the violation [-] of clearance and limits; a meter counts as 5. */
static double band_certificate_violation_of(const BandWork *w)
{
    if (!w->finite) {
        return HUGE_VAL;
    }
    return 5.0 * real_max(band_certificate_shortfall_of(w), 0.0) + real_max(w->curvature_ratio - 1.0, 0.0);
}

/* band_corridor.py: Bounds of a band: road edges, and obstacles on the side on which they are passed. */
#define BAND_CORRIDOR_ALIGNED 0.02
#define BAND_CORRIDOR_PARALLEL 1e-09
#define BAND_CORRIDOR_END_SLOPE 0.5
#define BAND_CORRIDOR_MIN_DROP 1e-09

/* Compute how far obstacles overlap the ego along the route; return whether all are parallel to it. */
static bool band_corridor_measure_overlaps(BandWork *w)
{
    double reach = 0.5 * w->length;
    double clearance = w->clearance;
    double offset = w->box_offset;
    const double *route_x = w->route_x;
    const double *route_y = w->route_y;
    const double *tangent_x = w->tangent_x;
    const double *tangent_y = w->tangent_y;
    double *overlap = w->overlap;
    double max_sine = 0.0;
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        double lead = w->lead_distance[o];
        bool changes = w->is_fixed[o] == 0;
        double ax = w->box_ahead_x[o * w->max_n + 0];
        double ay = w->box_ahead_y[o * w->max_n + 0];
        double box_x = w->box_x[o * w->max_n + 0];
        double box_y = w->box_y[o * w->max_n + 0];
        double half_length = w->half_length[o * w->max_n + 0] + clearance;
        double half_width = w->half_width[o * w->max_n + 0] + clearance;
        for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
            if (changes) {
                ax = w->box_ahead_x[o * w->max_n + i];
                ay = w->box_ahead_y[o * w->max_n + i];
                box_x = w->box_x[o * w->max_n + i];
                box_y = w->box_y[o * w->max_n + i];
                half_length = w->half_length[o * w->max_n + i] + clearance;
                half_width = w->half_width[o * w->max_n + i] + clearance;
            }
            double tx = tangent_x[i];
            double ty = tangent_y[i];
            double x = (box_x - route_x[i]) * tx + (box_y - route_y[i]) * ty - offset;
            double cosine = fabs(ax * tx + ay * ty);
            double sine = fabs(ay * tx - ax * ty);
            if (sine > max_sine) {
                max_sine = sine;
            }
            double beyond = x - lead > -x ? x - lead : -x;
            overlap[o * w->max_n + i] = half_length * cosine + half_width * sine + reach - beyond;
        }
    }
    return max_sine < BAND_CORRIDOR_ALIGNED;
}

/* Compute the lateral range of an obstacle along the ego, and where the ego passes it. */
static void band_corridor_measure_range(BandWork *w, int o, int i, bool aligned)
{
    double reach = 0.5 * w->length;
    int k = band_boxes_node_of(w, o, i);
    double tx = w->tangent_x[i];
    double ty = w->tangent_y[i];
    double ax = w->box_ahead_x[o * w->max_n + k];
    double ay = w->box_ahead_y[o * w->max_n + k];
    double dx = w->box_x[o * w->max_n + k] - w->route_x[i];
    double dy = w->box_y[o * w->max_n + k] - w->route_y[i];
    double x = dx * tx + dy * ty - w->box_offset;
    double y = dy * tx - dx * ty;
    double turn_cos = ax * tx + ay * ty;
    double turn_sin = ay * tx - ax * ty;
    double cosine = fabs(turn_cos);
    double sine = fabs(turn_sin);
    double along = w->half_length[o * w->max_n + k] + w->clearance;
    double across = w->half_width[o * w->max_n + k] + w->clearance;
    double half_y = along * sine + across * cosine;
    double upper = half_y;
    double lower = half_y;
    if (!aligned && sine > BAND_CORRIDOR_PARALLEL) {
        bool counter = turn_cos * turn_sin >= 0.0;
        double ridge = counter ? along * cosine - across * sine : across * sine - along * cosine;
        double along_edge = sine / real_max(cosine, BAND_CORRIDOR_ALIGNED);
        double across_edge = cosine / real_max(sine, BAND_CORRIDOR_ALIGNED);
        double rise = counter ? along_edge : across_edge;
        double fall = counter ? across_edge : along_edge;
        double before = -reach - x;
        double behind = reach + w->lead_distance[o] - x;
        upper = half_y - real_max(ridge - behind, 0.0) * rise - real_max(before - ridge, 0.0) * fall;
        lower = half_y - real_max(ridge + before, 0.0) * rise - real_max(-behind - ridge, 0.0) * fall;
    }
    w->passing_right[o * w->max_n + i] = y - real_max(lower, -half_y) - 0.5 * w->width;
    w->passing_left[o * w->max_n + i] = y + real_max(upper, -half_y) + 0.5 * w->width;
}

/* Compute the displacements at which the ego passes obstacles; infinite where one is not alongside. */
static void band_corridor_set_passing(BandWork *w)
{
    bool aligned = band_corridor_measure_overlaps(w);
    double slope = BAND_CORRIDOR_END_SLOPE * box_gaps_norm(w->route_x[1] - w->route_x[0], w->route_y[1]
        - w->route_y[0]);
    int last = w->n - 1;
    const double *overlaps = w->overlap;
    double *passing_right = w->passing_right;
    double *passing_left = w->passing_left;
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        double overlap = overlaps[o * w->max_n + 0];
        double after = overlap;
        for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
            double before = overlap;
            overlap = after;
            if (i < last) {
                after = overlaps[o * w->max_n + i + 1];
            }
            if (before >= 0.0 || overlap >= 0.0 || after >= 0.0) {
                band_corridor_measure_range(w, o, i, aligned);
                double near = real_max(real_max(before, overlap), after);
                double relief = slope * (real_min(overlap, 0.0) / real_min(overlap - near,
                    -BAND_CORRIDOR_MIN_DROP));
                passing_right[o * w->max_n + i] += relief;
                passing_left[o * w->max_n + i] -= relief;
            } else {
                passing_right[o * w->max_n + i] = HUGE_VAL;
                passing_left[o * w->max_n + i] = -HUGE_VAL;
            }
        }
    }
}

/* Compute the bounds for the sides; return the node where they overlap most, or -1. */
static int band_corridor_set_bounds(BandWork *w)
{
    double half = 0.5 * w->width;
    double *lower = w->lower;
    double *upper = w->upper;
    const double *right_edge = w->right_edge;
    const double *left_edge = w->left_edge;
    const double *passing_right = w->passing_right;
    const double *passing_left = w->passing_left;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        lower[i] = right_edge[i] + half;
        upper[i] = left_edge[i] - half;
    }
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        if (w->passes_left[o] != 0) {
            for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
                double bound = passing_left[o * w->max_n + i];
                if (bound > lower[i]) {
                    lower[i] = bound;
                }
            }
        } else {
            for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
                double bound = passing_right[o * w->max_n + i];
                if (bound < upper[i]) {
                    upper[i] = bound;
                }
            }
        }
    }
    double worst = 0.0;
    int node = -1;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        if (lower[i] - upper[i] > worst) {
            worst = lower[i] - upper[i];
            node = i;
        }
    }
    return node;
}

/* band_relaxation.py: Relaxation of a band with given sides, and of a band whose sides follow a rule. */

/* band_frame.py: The route in the frame of each node: spacing, tangents, curvature, and how the band
    begins and ends. */

/* equilibrium.py: Equilibrium of a band against one-sided bounds, by a semi-smooth Newton iteration on
    the active set.

The energy is ``1/2 u K u`` and ``1/2 contact`` times the squared violations of the bounds: convex and
piecewise quadratic. A step that reproduces its active set is the minimum. */

/* stiffness.py: Stiffness of a band between pinned ends: internal forces, factors of its matrix,
    solutions. */

/* Take stiffnesses in units of the outermost coefficient, in which row sums keep their digits. */
static void stiffness_set_stiffness(Equilibrium *e, double rate, double bending, double tension,
    double contact, double of_curvature)
{
    double unit = rate;
    if (unit == 0.0) {
        unit = bending != 0.0 ? bending : tension;
    }
    if (!(unit > 0.0)) {
        unit = 1.0;
    }
    e->rate = rate / unit;
    e->bending = bending / unit;
    e->tension = tension / unit;
    e->contact = contact / unit;
    e->curvature_contact = of_curvature / unit;
}

/* Return the diagonal of the stiffness matrix without contacts. */
static double stiffness_row_diagonal(const Equilibrium *e)
{
    return 20.0 * e->rate + 6.0 * e->bending + 2.0 * e->tension;
}

/* Return the second difference of an inner node. */
static double stiffness_second_difference(const double *u, int i)
{
    return u[i - 1] - 2.0 * u[i] + u[i + 1];
}

/* Compute the internal forces at the nodes that are not pinned. */
static void stiffness_apply_stiffness(Equilibrium *e, const double *u, double *to)
{
    int n = e->n;
    double *bend = e->difference;
    double *moment = e->moment;
    bend[0] = 0.0;
    bend[n - 1] = 0.0;
    for (int i = 1, i_end_ = n - 1; i < i_end_; i += 1) {
        bend[i] = u[i + 1] - u[i] - (u[i] - u[i - 1]);
    }
    for (int i = 1, i_end_ = n - 1; i < i_end_; i += 1) {
        moment[i] = e->bending * bend[i] - e->rate * (bend[i + 1] - bend[i] - (bend[i] - bend[i - 1]));
    }
    double shear = e->tension * (u[2] - u[1]) - (moment[2] - moment[1]);
    for (int i = 2, i_end_ = n - 2; i < i_end_; i += 1) {
        double next_shear = e->tension * (u[i + 1] - u[i]) - (moment[i + 1] - moment[i]);
        to[i] = shear - next_shear;
        shear = next_shear;
    }
}

/* Compute LDL' of the stiffness matrix with the active set held; return whether it is definite. */
static bool stiffness_factorize(Equilibrium *e)
{
    int n = e->n;
    double *l1 = e->factor_1;
    double *l2 = e->factor_2;
    double *l3 = e->factor_3;
    double *inverse = e->inverse;
    const int *active = e->active;
    const int *sharp = e->sharp;
    double row_0 = stiffness_row_diagonal(e);
    double row_1 = -15.0 * e->rate - 4.0 * e->bending - e->tension;
    double row_2 = 6.0 * e->rate + e->bending;
    double row_3 = -e->rate;
    double contact = e->contact;
    bool definite = true;
    double inverse_1 = 0.0;
    double inverse_2 = 0.0;
    double inverse_3 = 0.0;
    double l1_1 = 0.0;
    double l1_2 = 0.0;
    double l2_1 = 0.0;
    for (int i = 2, i_end_ = n - 2; i < i_end_; i += 1) {
        double d = active[i] == 0 ? row_0 : row_0 + contact;
        double c1 = row_1;
        double c2 = row_2;
        if (e->bounded) {
            double before = sharp[i - 1] != 0 ? e->curvature_contact : 0.0;
            double here = sharp[i] != 0 ? e->curvature_contact : 0.0;
            double after = sharp[i + 1] != 0 ? e->curvature_contact : 0.0;
            d += 4.0 * here + before + after;
            c1 -= 2.0 * (before + here);
            c2 += before;
        }
        double l3_0 = row_3 * inverse_3;
        d -= row_3 * l3_0;
        c2 -= row_3 * l1_2;
        c1 -= row_3 * l2_1;
        double l2_0 = c2 * inverse_2;
        d -= c2 * l2_0;
        c1 -= c2 * l1_1;
        double l1_0 = c1 * inverse_1;
        d -= c1 * l1_0;
        if (!(d > 0.0)) {
            definite = false;
            d = 1.0;
        }
        l3[i] = l3_0;
        l2[i] = l2_0;
        l1[i] = l1_0;
        inverse_3 = inverse_2;
        inverse_2 = inverse_1;
        inverse_1 = 1.0 / d;
        inverse[i] = inverse_1;
        l1_2 = l1_1;
        l1_1 = l1_0;
        l2_1 = l2_0;
    }
    for (int i = n - 2, i_end_ = n; i < i_end_; i += 1) {
        l2[i] = 0.0;
        l3[i] = 0.0;
    }
    return definite;
}

/* Solve with the factors; the pinned ends of the result stay as they are, 0. */
static void stiffness_substitute(const Equilibrium *e, const double *force, double *to)
{
    int n = e->n;
    const double *l1 = e->factor_1;
    const double *l2 = e->factor_2;
    const double *l3 = e->factor_3;
    const double *inverse = e->inverse;
    double one = 0.0;
    double two = 0.0;
    double three = 0.0;
    for (int i = 2, i_end_ = n - 2; i < i_end_; i += 1) {
        double here = force[i] - l1[i] * one - l2[i] * two - l3[i] * three;
        to[i] = here;
        three = two;
        two = one;
        one = here;
    }
    one *= inverse[n - 3];
    two = 0.0;
    three = 0.0;
    to[n - 3] = one;
    for (int i = n - 4; i > 1; i -= 1) {
        double here = to[i] * inverse[i] - l1[i + 1] * one - l2[i + 2] * two - l3[i + 3] * three;
        to[i] = here;
        three = two;
        two = one;
        one = here;
    }
}
#define EQUILIBRIUM_FULL_STEPS 10
#define EQUILIBRIUM_DAMPED_STEPS 50
#define EQUILIBRIUM_SECANTS 12
#define EQUILIBRIUM_FLAT_SLOPE 0.001
#define EQUILIBRIUM_STIFF_ROW 100000.0
#define EQUILIBRIUM_CORRECTIONS 3
#define EQUILIBRIUM_MAX_CORRECTION 1e-05
#define EQUILIBRIUM_END_STEP 0.05

/* Return the bound that a value violates: -1 the lower one, 1 the upper one, 0 none. */
static int equilibrium_side_of(double value, double low, double high)
{
    if (value < low) {
        return -1;
    }
    if (value > high) {
        return 1;
    }
    return 0;
}

/* Return whether the band touches a node of a bound: not an end that is bounded less than the next. */
static bool equilibrium_touches_end(double before, double here, double after)
{
    bool rises_on = after - here > EQUILIBRIUM_END_STEP && before <= 0.0;
    bool falls_off = here - before < -EQUILIBRIUM_END_STEP && after <= 0.0;
    return !(rises_on || falls_off);
}

/* Take the bounds that zero violates: a stiff band touches a straight one at its first and last node. */
static void equilibrium_guess_active_set(Equilibrium *e)
{
    int n = e->n;
    int *active = e->active;
    double *violation = e->step;
    const double *lower = e->lower;
    const double *upper = e->upper;
    for (int i = 2, i_end_ = n - 2; i < i_end_; i += 1) {
        double low = lower[i];
        double high = upper[i];
        active[i] = low > 0.0 || high < 0.0 ? equilibrium_side_of(0.0, low, high) : 0;
        violation[i] = (low < 0.0 ? 0.0 : low) + (high > 0.0 ? 0.0 : high);
    }
    if (e->bounded) {
        for (int i = 1, i_end_ = n - 1; i < i_end_; i += 1) {
            e->sharp[i] = equilibrium_side_of(0.0, e->lower_difference[i], e->upper_difference[i]);
        }
    }
    if (e->rate == 0.0 && e->bending == 0.0 && !e->bounded) {
        return;
    }
    for (int i = 3, i_end_ = n - 3; i < i_end_; i += 1) {
        if (active[i] != 0) {
            double sign = -active[i] * 1.0;
            if (!equilibrium_touches_end(sign * violation[i - 1], sign * violation[i], sign * violation[i
                + 1])) {
                active[i] = 0;
            }
        }
    }
    int before = active[2];
    for (int i = 3, i_end_ = n - 3; i < i_end_; i += 1) {
        int here = active[i];
        if (here != 0 && before == here && active[i + 1] == here) {
            active[i] = 0;
        }
        before = here;
    }
}

/* Take the bounds that a displacement violates; return whether they are those before. */
static bool equilibrium_update_active_set(Equilibrium *e, const double *u)
{
    bool same = true;
    int *active = e->active;
    const double *lower = e->lower;
    const double *upper = e->upper;
    for (int i = 2, i_end_ = e->n - 2; i < i_end_; i += 1) {
        int now = 0;
        if (u[i] < lower[i]) {
            now = -1;
        } else if (u[i] > upper[i]) {
            now = 1;
        }
        if (now != active[i]) {
            same = false;
            active[i] = now;
        }
    }
    if (e->bounded) {
        for (int i = 1, i_end_ = e->n - 1; i < i_end_; i += 1) {
            int now = equilibrium_side_of(stiffness_second_difference(u, i), e->lower_difference[i],
                e->upper_difference[i]);
            if (now != e->sharp[i]) {
                same = false;
            }
            e->sharp[i] = now;
        }
    }
    return same;
}

/* Compute the forces of the bounds that are held. */
static void equilibrium_hold_active_set(Equilibrium *e)
{
    int n = e->n;
    double *force = e->force;
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        force[i] = 0.0;
    }
    for (int i = 2, i_end_ = n - 2; i < i_end_; i += 1) {
        if (e->active[i] != 0) {
            force[i] = e->contact * (e->active[i] < 0 ? e->lower[i] : e->upper[i]);
        }
    }
    if (e->bounded) {
        for (int i = 1, i_end_ = n - 1; i < i_end_; i += 1) {
            if (e->sharp[i] != 0) {
                double bound = e->sharp[i] < 0 ? e->lower_difference[i] : e->upper_difference[i];
                double push = e->curvature_contact * bound;
                force[i - 1] += push;
                force[i] -= 2.0 * push;
                force[i + 1] += push;
            }
        }
    }
}

/* Regain digits of a solution: solve for the forces that it leaves. */
static void equilibrium_refine(Equilibrium *e)
{
    int n = e->n;
    double *rest = e->residual;
    double *target = e->target;
    double *step = e->step;
    stiffness_apply_stiffness(e, target, rest);
    for (int i = 2, i_end_ = n - 2; i < i_end_; i += 1) {
        double held = e->active[i] != 0 ? e->contact * target[i] : 0.0;
        rest[i] = e->force[i] - held - rest[i];
    }
    if (e->bounded) {
        for (int i = 1, i_end_ = n - 1; i < i_end_; i += 1) {
            if (e->sharp[i] != 0) {
                double push = e->curvature_contact * stiffness_second_difference(target, i);
                rest[i - 1] -= push;
                rest[i] += 2.0 * push;
                rest[i + 1] -= push;
            }
        }
    }
    stiffness_substitute(e, rest, step);
    for (int i = 2, i_end_ = n - 2; i < i_end_; i += 1) {
        target[i] += step[i];
    }
}

/* Solve to `target` with the active set held; return whether that is the active set there. */
static bool equilibrium_solve_held(Equilibrium *e)
{
    equilibrium_hold_active_set(e);
    e->solves += 1;
    if (!stiffness_factorize(e)) {
        e->definite = false;
    }
    stiffness_substitute(e, e->force, e->target);
    if (stiffness_row_diagonal(e) > EQUILIBRIUM_STIFF_ROW * e->contact) {
        for (int turn2_ = 0, turn2__end_ = EQUILIBRIUM_CORRECTIONS; turn2_ < turn2__end_; turn2_ += 1) {
            equilibrium_refine(e);
        }
    }
    return equilibrium_update_active_set(e, e->target);
}

/* Return the slope of the energy along `step` from `u`; elastic forces change linearly. */
static double equilibrium_slope_along(const Equilibrium *e, double fraction, double at_start, double change)
{
    const double *u = e->u;
    const double *step = e->step;
    double slope = at_start + fraction * change;
    for (int i = 2, i_end_ = e->n - 2; i < i_end_; i += 1) {
        double moved = u[i] + fraction * step[i];
        if (moved < e->lower[i]) {
            slope -= e->contact * step[i] * (e->lower[i] - moved);
        } else if (moved > e->upper[i]) {
            slope += e->contact * step[i] * (moved - e->upper[i]);
        }
    }
    if (e->bounded) {
        for (int i = 1, i_end_ = e->n - 1; i < i_end_; i += 1) {
            double bend = stiffness_second_difference(step, i);
            double bent = stiffness_second_difference(u, i) + fraction * bend;
            if (bent < e->lower_difference[i]) {
                slope -= e->curvature_contact * bend * (e->lower_difference[i] - bent);
            } else if (bent > e->upper_difference[i]) {
                slope += e->curvature_contact * bend * (bent - e->upper_difference[i]);
            }
        }
    }
    return slope;
}

/* Return the fraction of `step` with the least energy: the root of its slope, by the Illinois method. */
static double equilibrium_line_search(Equilibrium *e)
{
    const double *step = e->step;
    double at_start = 0.0;
    double change = 0.0;
    stiffness_apply_stiffness(e, e->u, e->residual);
    for (int i = 2, i_end_ = e->n - 2; i < i_end_; i += 1) {
        at_start += step[i] * e->residual[i];
    }
    stiffness_apply_stiffness(e, step, e->residual);
    for (int i = 2, i_end_ = e->n - 2; i < i_end_; i += 1) {
        change += step[i] * e->residual[i];
    }
    double a = 0.0;
    double b = 1.0;
    double at_a = equilibrium_slope_along(e, a, at_start, change);
    double at_b = equilibrium_slope_along(e, b, at_start, change);
    if (at_b <= 0.0 || at_a >= 0.0) {
        return 1.0;
    }
    double flat = -EQUILIBRIUM_FLAT_SLOPE * at_a;
    for (int turn1_ = 0, turn1__end_ = EQUILIBRIUM_SECANTS; turn1_ < turn1__end_; turn1_ += 1) {
        double fraction = (a * at_b - b * at_a) / (at_b - at_a);
        double value = equilibrium_slope_along(e, fraction, at_start, change);
        if (fabs(value) < flat || b - a < 1e-06) {
            return fraction;
        }
        if (value < 0.0) {
            a = fraction;
            at_a = value;
            at_b = 0.5 * at_b;
        } else {
            b = fraction;
            at_b = value;
            at_a = 0.5 * at_a;
        }
    }
    return a;
}

/* Set what is solved for to zero at the pinned nodes. */
static void equilibrium_clear_ends(Equilibrium *e)
{
    for (int k = 0; k < 4; k += 1) {
        int i = k < 2 ? k : e->n - k + 1;
        e->u[i] = 0.0;
        e->target[i] = 0.0;
        e->step[i] = 0.0;
        e->residual[i] = 0.0;
        e->active[i] = 0;
    }
    e->sharp[0] = 0;
    e->sharp[e->n - 1] = 0;
}

/* Find the displacement `u` of least energy; return whether the active set has converged.

With `warm`, `u` and its active set are the initial guess. It takes at most 60 solves. If full steps do
not converge, a line search damps the next ones: the energy falls with every step. */
static bool equilibrium_find_equilibrium(Equilibrium *e, bool warm)
{
    int n = e->n;
    double *u = e->u;
    e->definite = true;
    equilibrium_clear_ends(e);
    if (warm) {
        equilibrium_update_active_set(e, u);
    } else {
        equilibrium_guess_active_set(e);
        for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
            u[i] = 0.0;
        }
    }
    for (int turn1_ = 0, turn1__end_ = EQUILIBRIUM_FULL_STEPS; turn1_ < turn1__end_; turn1_ += 1) {
        if (equilibrium_solve_held(e)) {
            for (int i = 2, i_end_ = n - 2; i < i_end_; i += 1) {
                u[i] = e->target[i];
            }
            return e->definite;
        }
    }
    for (int turn1_ = 0, turn1__end_ = EQUILIBRIUM_DAMPED_STEPS; turn1_ < turn1__end_; turn1_ += 1) {
        equilibrium_update_active_set(e, u);
        bool converged = equilibrium_solve_held(e);
        for (int i = 2, i_end_ = n - 2; i < i_end_; i += 1) {
            e->step[i] = e->target[i] - u[i];
        }
        double fraction = converged ? 1.0 : equilibrium_line_search(e);
        for (int i = 2, i_end_ = n - 2; i < i_end_; i += 1) {
            u[i] = converged ? e->target[i] : u[i] + fraction * e->step[i];
        }
        if (converged) {
            return e->definite;
        }
    }
    return false;
}

/* Compute the displacement without contacts from its first three nodes; return whether digits suffice. */
static bool equilibrium_respond_to_start(Equilibrium *e, double before, double start_0, double start_1,
    double *to)
{
    int n = e->n;
    double *force = e->force;
    double row_1 = -15.0 * e->rate - 4.0 * e->bending - e->tension;
    double row_2 = 6.0 * e->rate + e->bending;
    double row_3 = -e->rate;
    equilibrium_clear_ends(e);
    e->bounded = false;
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        force[i] = 0.0;
        to[i] = 0.0;
        e->active[i] = 0;
    }
    force[2] = -(row_1 * start_1 + row_2 * start_0 + row_3 * before);
    if (n > 5) {
        force[3] = -(row_2 * start_1 + row_3 * start_0);
    }
    if (n > 6) {
        force[4] = -(row_3 * start_1);
    }
    if (!stiffness_factorize(e)) {
        return false;
    }
    stiffness_substitute(e, force, to);
    double change = 0.0;
    for (int turn1_ = 0, turn1__end_ = EQUILIBRIUM_CORRECTIONS; turn1_ < turn1__end_; turn1_ += 1) {
        stiffness_apply_stiffness(e, to, e->residual);
        for (int i = 2, i_end_ = n - 2; i < i_end_; i += 1) {
            e->residual[i] = force[i] - e->residual[i];
        }
        stiffness_substitute(e, e->residual, e->target);
        change = 0.0;
        for (int i = 2, i_end_ = n - 2; i < i_end_; i += 1) {
            to[i] += e->target[i];
            change += fabs(e->target[i]);
        }
    }
    to[0] = start_0;
    to[1] = start_1;
    return change <= EQUILIBRIUM_MAX_CORRECTION * n;
}
#define BAND_FRAME_MIN_EVENNESS 0.8
#define BAND_FRAME_MIN_SPACING 1e-06
#define BAND_FRAME_MAX_SPACING 1000000.0

/* Compute spacing, tangents and curvature of the route. */
static int band_frame_measure_route(BandWork *w)
{
    int n = w->n;
    const double *x = w->route_x;
    const double *y = w->route_y;
    double total = 0.0;
    double shortest = HUGE_VAL;
    double longest = 0.0;
    double *chord = w->chord;
    double here_x = x[0];
    double here_y = y[0];
    for (int i = 0, i_end_ = n - 1; i < i_end_; i += 1) {
        double next_x = x[i + 1];
        double next_y = y[i + 1];
        double step = box_gaps_norm(next_x - here_x, next_y - here_y);
        here_x = next_x;
        here_y = next_y;
        chord[i] = step;
        total += step;
        if (step < shortest) {
            shortest = step;
        }
        if (step > longest) {
            longest = step;
        }
    }
    w->spacing = total / (n - 1);
    if (!(shortest > BAND_FRAME_MIN_EVENNESS * w->spacing && w->spacing > BAND_FRAME_MIN_EVENNESS
        * longest)) {
        return BAND_WORKSPACE_UNEVEN_SPACING;
    }
    if (!(BAND_FRAME_MIN_SPACING <= w->spacing && w->spacing <= BAND_FRAME_MAX_SPACING)) {
        return BAND_WORKSPACE_UNEVEN_SPACING;
    }
    double *tangent_x = w->tangent_x;
    double *tangent_y = w->tangent_y;
    double *curvature = w->route_curvature;
    here_x = x[0];
    here_y = y[0];
    double last_x = here_x;
    double last_y = here_y;
    double last_chord = 0.0;
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        double next_x = i < n - 1 ? x[i + 1] : here_x;
        double next_y = i < n - 1 ? y[i + 1] : here_y;
        double dx = next_x - last_x;
        double dy = next_y - last_y;
        double length = box_gaps_norm(dx, dy);
        if (!(length > 0.0)) {
            return BAND_WORKSPACE_UNEVEN_SPACING;
        }
        tangent_x[i] = dx / length;
        tangent_y[i] = dy / length;
        if (i < n - 1) {
            double here_chord = chord[i];
            if (i > 0) {
                double cross = (here_x - last_x) * (next_y - here_y) - (here_y - last_y) * (next_x - here_x);
                curvature[i] = 2.0 * cross / (last_chord * here_chord * length);
            }
            last_chord = here_chord;
        }
        last_x = here_x;
        last_y = here_y;
        here_x = next_x;
        here_y = next_y;
    }
    curvature[0] = curvature[1];
    curvature[n - 1] = curvature[n - 2];
    return BAND_WORKSPACE_OK;
}

/* Compute the stiffness of the band for its spacing. */
static void band_frame_set_elasticity(const BandWork *w, Equilibrium *e)
{
    double h = w->spacing;
    double squared = h * h;
    double rate = w->k_c / (squared * squared * h);
    double bending = w->k_b / (squared * h);
    double of_curvature = (0.25 * w->k_c + 10.0 * w->k_b) / (squared * h);
    stiffness_set_stiffness(e, rate, bending, w->k_s / h, w->k_e * h, of_curvature);
}

/* Turn the first heading as the start asks; return the curvature of the band there. */
static double band_frame_leave_route(BandWork *w, double end_curvature)
{
    double cosine = cos(-0.5 * w->spacing * end_curvature);
    double sine = sin(-0.5 * w->spacing * end_curvature);
    double tx = w->tangent_x[0] * cosine - w->tangent_y[0] * sine;
    double ty = w->tangent_x[0] * sine + w->tangent_y[0] * cosine;
    w->tangent_x[0] = tx;
    w->tangent_y[0] = ty;
    double slope = 0.5 * (w->start_1 - w->start_before) / w->spacing;
    double change = (w->start_1 - 2.0 * w->start_0 + w->start_before) / (w->spacing * w->spacing);
    double along = 1.0 - end_curvature * w->start_0;
    double speed = real_max(box_gaps_norm(along, slope), CONSTANTS_TINY);
    w->heading_x0 = (tx * along - ty * slope) / speed;
    w->heading_y0 = (tx * slope + ty * along) / speed;
    double turn = along * (change + end_curvature * along) + 2.0 * end_curvature * (slope * slope);
    return turn / (speed * speed * speed);
}

/* Compute headings and spline moments at both ends, and the response to the start alone. */
static int band_frame_set_ends(BandWork *w, Equilibrium *e)
{
    int last = w->n - 1;
    double first_curvature = 2.0 * w->route_curvature[1] - w->route_curvature[2];
    double last_curvature = 2.0 * w->route_curvature[last - 1] - w->route_curvature[last - 2];
    w->heading_x0 = w->tangent_x[0];
    w->heading_y0 = w->tangent_y[0];
    w->heading_x1 = w->tangent_x[last];
    w->heading_y1 = w->tangent_y[last];
    if (w->start_before != 0.0 || w->start_0 != 0.0 || w->start_1 != 0.0) {
        if (!equilibrium_respond_to_start(e, w->start_before, w->start_0, w->start_1, w->free)) {
            return BAND_WORKSPACE_TOO_LONG;
        }
        first_curvature = band_frame_leave_route(w, first_curvature);
    } else {
        for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
            w->free[i] = 0.0;
        }
    }
    w->moment_x0 = -first_curvature * w->heading_y0 / 6.0;
    w->moment_y0 = first_curvature * w->heading_x0 / 6.0;
    w->moment_x1 = -last_curvature * w->heading_y1 / 6.0;
    w->moment_y1 = last_curvature * w->heading_x1 / 6.0;
    return BAND_WORKSPACE_OK;
}

/* band_result.py: Result of a band: its status, the reason and the active constraint, from its
    certificate. */
#define BAND_RESULT_ROUNDING 1e-09

/* Return the obstacle with the least gap, the first of equals. */
static int band_result_nearest_obstacle(const BandWork *w)
{
    double gap = HUGE_VAL;
    int nearest = BAND_WORKSPACE_NO_CONSTRAINT;
    for (int k = 0, k_end_ = w->n_pairs; k < k_end_; k += 1) {
        if (w->bound[k] < gap) {
            gap = w->bound[k];
            nearest = w->pair_obstacle[k];
        }
    }
    return nearest;
}

/* Return the edge with the least margin, the right one of equals. */
static int band_result_closest_edge(const BandWork *w)
{
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        if (w->right_margin[i] == w->min_edge_clearance) {
            return BAND_WORKSPACE_RIGHT_EDGE;
        }
    }
    return BAND_WORKSPACE_LEFT_EDGE;
}

/* Return the largest displacement [m], without sign. */
static double band_result_largest_displacement(const BandWork *w)
{
    const double *u = w->u;
    double largest = 0.0;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        if (fabs(u[i]) > largest) {
            largest = fabs(u[i]);
        }
    }
    return largest;
}

/* Report the curvature that exceeds its limit by the largest factor. */
static void band_result_report_curvature(BandWork *w)
{
    double ratio = -1.0;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        double here = fabs(w->curvature[i]) / w->curvature_limit[i];
        if (here > ratio) {
            ratio = here;
            w->value = fabs(w->curvature[i]);
            w->limit = w->curvature_limit[i];
        }
    }
}

/* Report that a band is infeasible. */
static void band_result_fail(BandWork *w, int reason, int active)
{
    w->status = BAND_WORKSPACE_INFEASIBLE;
    w->reason = reason;
    w->active = active;
}

/* Report that the active set has not converged. */
static void band_result_report_stall(BandWork *w)
{
    w->status = BAND_WORKSPACE_NOT_CONVERGED;
    w->reason = BAND_WORKSPACE_ACTIVE_SET;
    w->active = BAND_WORKSPACE_NO_CONSTRAINT;
}

/* Compare the certificate with the limits; what is not a number satisfies none. */
static void band_result_compare(BandWork *w)
{
    double excess = w->min_gap - w->clearance;
    int nearest = band_result_nearest_obstacle(w);
    int closest = w->min_edge_clearance < excess ? band_result_closest_edge(w) : nearest;
    double displacement = band_result_largest_displacement(w);
    w->status = BAND_WORKSPACE_OK;
    w->reason = BAND_WORKSPACE_SATISFIED;
    w->active = closest;
    w->other = BAND_WORKSPACE_NO_CONSTRAINT;
    w->node = -1;
    w->value = 0.0;
    w->limit = 0.0;
    if (!(excess >= -BAND_RESULT_ROUNDING)) {
        band_result_fail(w, BAND_WORKSPACE_CLEARANCE, nearest);
    } else if (!(w->min_edge_clearance >= -BAND_RESULT_ROUNDING)) {
        band_result_fail(w, BAND_WORKSPACE_EDGE, closest);
    } else if (!(displacement <= w->max_displacement)) {
        band_result_fail(w, BAND_WORKSPACE_DISPLACEMENT, nearest);
        w->value = displacement;
    } else if (!(w->curvature_ratio <= 1.0 + BAND_RESULT_ROUNDING)) {
        band_result_fail(w, BAND_WORKSPACE_CURVATURE, BAND_WORKSPACE_CURVATURE_LIMIT);
        band_result_report_curvature(w);
    }
}

/* Report the two constraints that leave no displacement at a node; of equals the last obstacle. */
static void band_result_report_empty_interval(BandWork *w, int node)
{
    band_result_fail(w, BAND_WORKSPACE_EMPTY_INTERVAL, BAND_WORKSPACE_RIGHT_EDGE);
    w->node = node;
    w->other = BAND_WORKSPACE_LEFT_EDGE;
    double low = w->right_edge[node] + 0.5 * w->width;
    double high = w->left_edge[node] - 0.5 * w->width;
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        if (w->passes_left[o] != 0 && w->passing_left[o * w->max_n + node] >= low) {
            low = w->passing_left[o * w->max_n + node];
            w->active = o;
        }
        if (w->passes_left[o] == 0 && w->passing_right[o * w->max_n + node] <= high) {
            high = w->passing_right[o * w->max_n + node];
            w->other = o;
        }
    }
}

/* Return the nearest obstacle that is too close to a pinned end, if a bound is violated there. */
static int band_result_find_blocked_end(const BandWork *w)
{
    int e = w->n - 1;
    if ((w->lower[0] <= w->free[0] && w->free[0] <= w->upper[0]) && (w->lower[e] <= w->free[e]
        && w->free[e] <= w->upper[e])) {
        return BAND_WORKSPACE_NO_CONSTRAINT;
    }
    double gap = w->clearance - w->max_end_shortfall;
    int nearest = BAND_WORKSPACE_NO_CONSTRAINT;
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        double here = band_gaps_end_gap(w, o);
        if (here < gap) {
            gap = here;
            nearest = o;
        }
    }
    return nearest;
}

/* Report the obstacle that is too close to a pinned end, with its gap. */
static void band_result_report_blocked_end(BandWork *w, int o)
{
    band_result_fail(w, BAND_WORKSPACE_BLOCKED_END, o);
    w->value = band_gaps_gap_to(w, o);
}

/* band_tightening.py: Constraint tightening: solve, certify, move the bounds by the shortfall, solve
    again. */
#define BAND_TIGHTENING_MAX_FRACTION 0.8

/* Compute the shortfall of clearance and at the edges on both sides of each node, to `low` and `high`. */
static void band_tightening_measure_shortfalls(BandWork *w)
{
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        w->low[i] = -w->right_margin[i];
        w->high[i] = -w->left_margin[i];
    }
    for (int k = 0, k_end_ = w->n_pairs; k < k_end_; k += 1) {
        int i = w->pair_node[k];
        double shortfall = w->clearance - w->bound[k];
        if (w->passes_left[w->pair_obstacle[k]] != 0) {
            w->low[i] = real_max(w->low[i], shortfall);
        } else {
            w->high[i] = real_max(w->high[i], shortfall);
        }
    }
}

/* Move the bounds by the shortfalls, to `low` and `high`; return whether they leave a displacement. */
static bool band_tightening_tighten_positions(BandWork *w, double gain)
{
    band_tightening_measure_shortfalls(w);
    bool fits = true;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        double short_low = w->low[i];
        double short_up = w->high[i];
        w->low[i] = w->lower[i];
        w->high[i] = w->upper[i];
        if (short_low > 0.0) {
            w->low[i] = real_max(w->lower[i], w->u[i]) + (gain * short_low + w->clearance_margin);
        }
        if (short_up > 0.0) {
            w->high[i] = real_min(w->upper[i], w->u[i]) - (gain * short_up + w->clearance_margin);
        }
        if (!(w->low[i] <= w->high[i])) {
            fits = false;
        }
    }
    return fits;
}

/* Return the second difference of a displacement at any node; the band continues beyond its ends. */
static double band_tightening_bend_at(const BandWork *w, const double *u, int i)
{
    if (i == 0) {
        return w->start_before - 2.0 * u[0] + u[1];
    }
    if (i == w->n - 1) {
        return u[i - 1] - 2.0 * u[i];
    }
    return stiffness_second_difference(u, i);
}

/* Begin without bounds of the second difference. */
static void band_tightening_release_curvature(BandWork *w, Equilibrium *e)
{
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        w->lower_difference[i] = -HUGE_VAL;
        w->upper_difference[i] = HUGE_VAL;
        e->lower_difference[i] = -HUGE_VAL;
        e->upper_difference[i] = HUGE_VAL;
        e->sharp[i] = 0;
    }
}

/* Move the bounds of the second difference by the excess curvature. */
static void band_tightening_tighten_curvature(BandWork *w, Equilibrium *e)
{
    double squared = w->spacing * w->spacing;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        if (w->curvature_limit[i] == HUGE_VAL) {
            continue;
        }
        double curvature = w->curvature[i] * squared;
        double aim = (1.0 - w->curvature_margin) * (w->curvature_limit[i] * squared);
        double bend = band_tightening_bend_at(w, w->u, i);
        double of_route = curvature - bend;
        double excess = real_max(fabs(curvature) - aim, 0.0);
        double low = real_max(w->lower_difference[i], -aim - of_route);
        double high = real_min(w->upper_difference[i], aim - of_route);
        if (excess > 0.0 && curvature < 0.0) {
            low = real_max(low, bend) + excess;
        }
        if (excess > 0.0 && curvature > 0.0) {
            high = real_min(high, bend) - excess;
        }
        double middle = 0.5 * (low + high);
        w->lower_difference[i] = real_min(low, middle);
        w->upper_difference[i] = real_max(high, middle);
        double free = band_tightening_bend_at(w, w->free, i);
        e->lower_difference[i] = w->lower_difference[i] - free;
        e->upper_difference[i] = w->upper_difference[i] - free;
    }
}

/* Take the bounds relative to the response to the start, from which the equilibrium counts. */
static void band_tightening_set_relative_bounds(const BandWork *w, Equilibrium *e)
{
    const double *lower = w->lower;
    const double *upper = w->upper;
    double *relative_lower = e->lower;
    double *relative_upper = e->upper;
    const double *free = w->free;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        relative_lower[i] = lower[i] - free[i];
        relative_upper[i] = upper[i] - free[i];
    }
}

/* Solve between the bounds and certify; with `warm`, begin at the displacement so far. */
static bool band_tightening_solve_and_certify(BandWork *w, Equilibrium *e, bool warm)
{
    band_tightening_set_relative_bounds(w, e);
    double *u = w->u;
    const double *free = w->free;
    double *relative = e->u;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        relative[i] = warm ? u[i] - free[i] : 0.0;
    }
    bool converged = equilibrium_find_equilibrium(e, warm);
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        u[i] = free[i] + relative[i];
    }
    band_certificate_certify(w);
    return converged;
}

/* Take the bounds of the next round and solve, from where the last one ended. */
static bool band_tightening_solve_tighter(BandWork *w, Equilibrium *e)
{
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        w->lower[i] = w->low[i];
        w->upper[i] = w->high[i];
    }
    if (w->curvature_ratio > 1.0 && !e->bounded) {
        e->bounded = true;
        band_tightening_release_curvature(w, e);
    }
    if (e->bounded) {
        band_tightening_tighten_curvature(w, e);
    }
    return band_tightening_solve_and_certify(w, e, true);
}

/* Return the factor of a move; contact yields by a fraction of it, which is extrapolated to zero. */
static double band_tightening_gain_of(double shortfall, double last_shortfall)
{
    if (shortfall <= 0.0) {
        return 1.0;
    }
    if (!(shortfall < BAND_TIGHTENING_MAX_FRACTION * last_shortfall)) {
        return 1.0 / (1.0 - BAND_TIGHTENING_MAX_FRACTION);
    }
    return 1.0 / (1.0 - shortfall / last_shortfall);
}

/* Keep the displacement as the best so far. */
static void band_tightening_keep_displacement(BandWork *w)
{
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        w->best_u[i] = w->u[i];
    }
}

/* Move bounds until the certificate holds or there is no progress; keep the best.

Return whether the active set of the last round has converged; `first` is that of the first one. */
static bool band_tightening_tighten(BandWork *w, Equilibrium *e, bool first)
{
    double best = HUGE_VAL;
    double last_shortfall = HUGE_VAL;
    int stalls = 0;
    bool converged = first;
    band_tightening_keep_displacement(w);
    for (int turn1_ = 0, turn1__end_ = w->max_tightenings; turn1_ < turn1__end_; turn1_ += 1) {
        if (band_certificate_is_satisfied(w)) {
            break;
        }
        double violation = band_certificate_violation_of(w);
        stalls = violation < w->min_progress * best ? 0 : stalls + 1;
        if (violation < best) {
            best = violation;
            band_tightening_keep_displacement(w);
        }
        if (stalls >= w->max_stalls || e->solves >= w->max_solves) {
            break;
        }
        double shortfall = band_certificate_shortfall_of(w);
        double gain = band_tightening_gain_of(shortfall, last_shortfall);
        last_shortfall = real_max(shortfall, w->clearance_margin);
        if (!band_tightening_tighten_positions(w, gain)) {
            break;
        }
        converged = band_tightening_solve_tighter(w, e);
        if (!converged) {
            break;
        }
    }
    if (!(band_certificate_violation_of(w) <= best)) {
        for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
            w->u[i] = w->best_u[i];
        }
        band_certificate_certify(w);
    }
    return converged;
}

/* Put a band problem into the frame of each node; return a status. */
static int band_relaxation_prepare_band(BandWork *w, Equilibrium *e)
{
    e->n = w->n;
    e->solves = 0;
    w->status = w->has_valid_boxes ? band_frame_measure_route(w) : BAND_WORKSPACE_INVALID_BOXES;
    if (w->status != BAND_WORKSPACE_OK) {
        return w->status;
    }
    band_frame_set_elasticity(w, e);
    w->status = band_frame_set_ends(w, e);
    if (w->status == BAND_WORKSPACE_OK) {
        band_corridor_set_passing(w);
    }
    return w->status;
}

/* Relax a prepared band with given sides. */
static void band_relaxation_relax_with_sides(BandWork *w, Equilibrium *e)
{
    e->solves = 0;
    e->bounded = false;
    int empty = band_corridor_set_bounds(w);
    int blocked = band_result_find_blocked_end(w);
    bool solvable = empty < 0 && blocked == BAND_WORKSPACE_NO_CONSTRAINT;
    if (!solvable) {
        for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
            w->lower[i] = -HUGE_VAL;
            w->upper[i] = HUGE_VAL;
        }
    }
    bool converged = band_tightening_solve_and_certify(w, e, false);
    if (solvable) {
        converged = band_tightening_tighten(w, e, converged);
    }
    bool finite = w->finite;
    if (!finite) {
        for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
            w->u[i] = w->free[i];
        }
        band_certificate_certify(w);
    }
    band_result_compare(w);
    if (empty >= 0) {
        band_result_report_empty_interval(w, empty);
    }
    if (blocked != BAND_WORKSPACE_NO_CONSTRAINT) {
        band_result_report_blocked_end(w, blocked);
    }
    if (!(converged && finite)) {
        band_result_report_stall(w);
    }
    w->solves = e->solves;
}

/* band_sides.py: Side assignment: by a rule, or the sides whose band has the least energy. */
#define BAND_SIDES_RIGHT_COST 1e-06

/* Find the obstacles that block the route, and the side of the others; return whether any blocks. */
static bool band_sides_set_default_sides(BandWork *w)
{
    bool any_blocks = false;
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        bool on_right = false;
        bool on_left = false;
        double offset = 0.0;
        for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
            if (w->passing_right[o * w->max_n + i] < HUGE_VAL) {
                offset += w->passing_left[o * w->max_n + i] + w->passing_right[o * w->max_n + i];
                on_right = on_right || w->passing_left[o * w->max_n + i] > 0.0;
                on_left = on_left || w->passing_right[o * w->max_n + i] < 0.0;
            }
        }
        bool blocks = on_right && on_left;
        any_blocks = any_blocks || blocks;
        w->blocking[o] = blocks ? 1 : 0;
        w->passes_left[o] = blocks || offset < 0.0 ? 1 : 0;
    }
    return any_blocks;
}

/* Pass the blocking obstacles on one side. */
static void band_sides_set_blocking_sides(BandWork *w, bool left)
{
    band_sides_set_default_sides(w);
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        if (w->blocking[o] != 0) {
            w->passes_left[o] = left ? 1 : 0;
        }
    }
}

/* Find the sides that the edges leave at an obstacle, and its distance from the route. */
static void band_sides_measure_freedom(BandWork *w, int o)
{
    double half = 0.5 * w->width;
    bool no_left = false;
    bool no_right = false;
    double distance = HUGE_VAL;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        if (w->passing_right[o * w->max_n + i] < HUGE_VAL) {
            no_left = no_left || w->passing_left[o * w->max_n + i] > w->left_edge[i] - half;
            no_right = no_right || w->passing_right[o * w->max_n + i] < w->right_edge[i] + half;
            distance = real_min(distance, real_max(w->passing_right[o * w->max_n + i], -w->passing_left[o
                * w->max_n + i]));
        }
    }
    w->distance[o] = distance;
    w->is_free[o] = no_left || no_right ? 0 : 1;
    if (no_left && !no_right) {
        w->passes_left[o] = 0;
    } else if (no_right && !no_left) {
        w->passes_left[o] = 1;
    }
}

/* Choose the nearest obstacles whose sides are tried; return the number of assignments.

The sides of the others are in `default_side`. */
static int band_sides_count_assignments(BandWork *w)
{
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        band_sides_measure_freedom(w, o);
        w->default_side[o] = w->passes_left[o];
    }
    int count = 1;
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        w->rank[o] = 0;
        for (int other = 0, other_end_ = w->m; other < other_end_; other += 1) {
            bool nearer = w->distance[other] < w->distance[o];
            if (w->distance[other] == w->distance[o]) {
                nearer = other < o;
            }
            if (w->is_free[other] != 0 && nearer) {
                w->rank[o] += 1;
            }
        }
    }
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        if (w->is_free[o] != 0 && w->rank[o] >= w->max_free_sides) {
            w->is_free[o] = 0;
        }
        if (w->is_free[o] != 0) {
            count += count;
        }
    }
    return count;
}

/* Take the sides of an assignment, 0 for all on the left; return how many are passed on the right. */
static int band_sides_assign_sides(BandWork *w, int code)
{
    int rest = code;
    int right = 0;
    for (int o = w->m - 1, o_end_ = -1; o > o_end_; o -= 1) {
        w->passes_left[o] = w->default_side[o];
        if (w->is_free[o] != 0) {
            int half = int_floor(rest, 2);
            w->passes_left[o] = 1 - (rest - 2 * half);
            rest = half;
        }
        right += 1 - w->passes_left[o];
    }
    return right;
}

/* Return whether the sides are those of the previous band. */
static bool band_sides_is_former(const BandWork *w)
{
    if (!w->has_former) {
        return false;
    }
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        if (w->passes_left[o] != w->former[o]) {
            return false;
        }
    }
    return true;
}

/* Return the energy of the equilibrium, in its units. */
static double band_sides_energy_of(Equilibrium *e)
{
    double energy = 0.0;
    stiffness_apply_stiffness(e, e->u, e->residual);
    for (int i = 2, i_end_ = e->n - 2; i < i_end_; i += 1) {
        double violation = real_max(e->u[i] - e->upper[i], 0.0) - real_max(e->lower[i] - e->u[i], 0.0);
        energy += e->u[i] * e->residual[i] + e->contact * (violation * violation);
    }
    return 0.5 * energy;
}

/* Return the cost of the sides between their bounds. */
static double band_sides_cost_of(const BandWork *w, Equilibrium *e, int right)
{
    band_tightening_set_relative_bounds(w, e);
    e->bounded = false;
    equilibrium_find_equilibrium(e, false);
    double energy = band_sides_energy_of(e);
    double cost = energy * (1.0 + BAND_SIDES_RIGHT_COST * right);
    return band_sides_is_former(w) ? cost * w->side_change_fraction : cost;
}

/* Find the cheapest assignments whose bounds leave a displacement; return how many are kept. */
static int band_sides_rank_assignments(BandWork *w, Equilibrium *e, int count)
{
    int kept = 0;
    for (int code = 0, code_end_ = count; code < code_end_; code += 1) {
        int right = band_sides_assign_sides(w, code);
        int empty = band_corridor_set_bounds(w);
        if (empty >= 0) {
            continue;
        }
        double cost = band_sides_cost_of(w, e, right);
        int at = kept;
        for (int k = kept - 1, k_end_ = -1; k > k_end_; k -= 1) {
            if (!(cost < w->costs[k])) {
                break;
            }
            at = k;
        }
        if (at >= w->n_certified) {
            continue;
        }
        kept = int_min(kept + 1, w->n_certified);
        for (int k = kept - 1, k_end_ = at; k > k_end_; k -= 1) {
            w->codes[k] = w->codes[k - 1];
            w->costs[k] = w->costs[k - 1];
        }
        w->codes[at] = code;
        w->costs[at] = cost;
    }
    return kept;
}

/* Return the violation [-] of clearance and of the least curvature limit; a meter counts as 5. */
static double band_sides_violation_of_limits(const BandWork *w)
{
    double limit = HUGE_VAL;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        limit = real_min(limit, w->curvature_limit[i]);
    }
    double excess = real_max(w->max_curvature / limit - 1.0, 0.0);
    return w->finite ? 5.0 * real_max(band_certificate_shortfall_of(w), 0.0) + excess : HUGE_VAL;
}

/* Relax the cheapest assignments until one is feasible; otherwise the one of least violation. */
static void band_sides_relax_cheapest(BandWork *w, Equilibrium *e, int kept)
{
    int best = 0;
    double violation = HUGE_VAL;
    for (int k = 0, k_end_ = kept; k < k_end_; k += 1) {
        band_sides_assign_sides(w, w->codes[k]);
        band_relaxation_relax_with_sides(w, e);
        if (w->status == BAND_WORKSPACE_OK) {
            return;
        }
        double here = band_sides_violation_of_limits(w);
        if (here < violation) {
            violation = here;
            best = k;
        }
    }
    if (best < kept - 1) {
        band_sides_assign_sides(w, w->codes[best]);
        band_relaxation_relax_with_sides(w, e);
    }
}

/* Relax a prepared band with the sides of a rule. */
static void band_sides_relax_with_rule(BandWork *w, Equilibrium *e, int rule)
{
    if (rule == BAND_WORKSPACE_CHEAPEST_SIDES && band_sides_set_default_sides(w)) {
        int count = band_sides_count_assignments(w);
        int kept = count > 1 ? band_sides_rank_assignments(w, e, count) : 0;
        if (kept > 0) {
            band_sides_relax_cheapest(w, e, kept);
            return;
        }
        for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
            w->passes_left[o] = w->default_side[o];
        }
        if (count > 1) {
            band_sides_set_default_sides(w);
        }
    } else if (rule != BAND_WORKSPACE_GIVEN_SIDES && rule != BAND_WORKSPACE_CHEAPEST_SIDES) {
        band_sides_set_blocking_sides(w, rule == BAND_WORKSPACE_BLOCKING_LEFT);
    }
    band_relaxation_relax_with_sides(w, e);
}

/* Copy the problem of a band into the workspace. */
static void band_batch_load_band(const BandBatch *q, int b, BandWork *w)
{
    w->n = q->n;
    w->m = q->m;
    w->has_edges = q->has_edges;
    w->has_former = q->has_former;
    w->start_before = q->start[b * 3 + 0];
    w->start_0 = q->start[b * 3 + 1];
    w->start_1 = q->start[b * 3 + 2];
    double *right_edge = w->right_edge;
    double *left_edge = w->left_edge;
    double *route_x = w->route_x;
    double *route_y = w->route_y;
    double *limit = w->curvature_limit;
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        route_x[i] = q->nodes[b * (2 * q->max_n) + 2 * i];
        route_y[i] = q->nodes[b * (2 * q->max_n) + 2 * i + 1];
        right_edge[i] = -HUGE_VAL;
        left_edge[i] = HUGE_VAL;
        limit[i] = q->curvature_limit[b * q->max_n + i];
    }
    if (q->has_edges) {
        for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
            right_edge[i] = q->right_edge[b * q->max_n + i];
            left_edge[i] = q->left_edge[b * q->max_n + i];
        }
    }
    w->has_valid_boxes = true;
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        w->lead_distance[o] = q->lead_distance[o];
        w->passes_left[o] = q->passes_left[o * q->bands + b];
        w->former[o] = q->has_former ? q->former[o * q->bands + b] : 0;
        band_boxes_load_boxes(q, b, w, o);
    }
}

/* Copy what is found for a band into its rows of the result. */
static void band_batch_store_band(BandBatch *q, int b, const BandWork *w, int columns, double *found, int
    *codes)
{
    int n = w->n;
    int row = b * columns;
    found[row] = w->min_gap;
    found[row + 1] = w->min_edge_clearance;
    found[row + 2] = w->max_curvature;
    found[row + 3] = w->spacing;
    found[row + 4] = w->value;
    found[row + 5] = w->limit;
    int points = row + BAND_WORKSPACE_REALS;
    int moments = points + 2 * n;
    int displacement = moments + 2 * n;
    int lower = displacement + n;
    int upper = lower + n;
    const double *x = w->x;
    const double *y = w->y;
    const double *moment_x = w->moment_x;
    const double *moment_y = w->moment_y;
    const double *u = w->u;
    const double *low = w->lower;
    const double *high = w->upper;
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        found[points + 2 * i] = x[i];
        found[points + 2 * i + 1] = y[i];
        found[moments + 2 * i] = moment_x[i];
        found[moments + 2 * i + 1] = moment_y[i];
        found[displacement + i] = u[i];
        found[lower + i] = low[i];
        found[upper + i] = high[i];
    }
    for (int o = 0, o_end_ = w->m; o < o_end_; o += 1) {
        q->passes_left[o * q->bands + b] = w->passes_left[o];
    }
    codes[BAND_WORKSPACE_CODES * b + 1] = w->reason;
    codes[BAND_WORKSPACE_CODES * b + 2] = w->active;
    codes[BAND_WORKSPACE_CODES * b + 3] = w->other;
    codes[BAND_WORKSPACE_CODES * b + 4] = w->node;
    codes[BAND_WORKSPACE_CODES * b + 5] = w->solves;
}

/* Relax the bands of a batch; their status is in the first column of `codes`. */
void cca_relax_bands(BandBatch *q, BandWork *w, Equilibrium *e, int bands, int columns, double *found, int
    *codes)
{
    for (int b = 0, b_end_ = bands; b < b_end_; b += 1) {
        band_batch_load_band(q, b, w);
        int status = band_relaxation_prepare_band(w, e);
        if (status == BAND_WORKSPACE_OK) {
            band_sides_relax_with_rule(w, e, q->side_rule);
            band_batch_store_band(q, b, w, columns, found, codes);
        }
        codes[BAND_WORKSPACE_CODES * b] = w->status;
    }
}

/* Certify a displacement of the first band of a batch; return a status.

Its frame, its bounds for the given sides, and its certificate are left in the workspace. */
int cca_measure_band(BandBatch *q, BandWork *w, Equilibrium *e, int n, const double *u, int columns,
    double *found, int *codes)
{
    band_batch_load_band(q, 0, w);
    int status = band_relaxation_prepare_band(w, e);
    w->solves = 0;
    if (status == BAND_WORKSPACE_OK) {
        band_corridor_set_bounds(w);
        for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
            w->u[i] = u[i];
        }
        band_certificate_certify(w);
        band_result_compare(w);
        if (!w->finite) {
            band_result_report_stall(w);
        }
        band_batch_store_band(q, 0, w, columns, found, codes);
    }
    codes[0] = w->status;
    return status;
}

/* band_cubics.py: Cubics of the path through the nodes of a band. */

/* Compute arc lengths, and a, b, c, d of x and then of y, from nodes and spline moments / 6. */
void cca_join_cubics(int segments, const double *nodes, const double *moments, double start, double
    *breaks, double *cubics)
{
    double s = 0.0;
    breaks[0] = start;
    double x = nodes[0 * 2 + 0];
    double y = nodes[0 * 2 + 1];
    double moment_x = moments[0 * 2 + 0];
    double moment_y = moments[0 * 2 + 1];
    for (int i = 0, i_end_ = segments; i < i_end_; i += 1) {
        double next_x = nodes[(i + 1) * 2 + 0];
        double next_y = nodes[(i + 1) * 2 + 1];
        double dx = next_x - x;
        double dy = next_y - y;
        double length = box_gaps_norm(dx, dy);
        s += length;
        breaks[i + 1] = s + start;
        double squared = length * length;
        double here = squared * moment_x;
        moment_x = moments[(i + 1) * 2 + 0];
        double then = squared * moment_x;
        cubics[i * 8 + 0] = then - here;
        cubics[i * 8 + 1] = 3.0 * here;
        cubics[i * 8 + 2] = dx - (2.0 * here + then);
        cubics[i * 8 + 3] = x;
        here = squared * moment_y;
        moment_y = moments[(i + 1) * 2 + 1];
        then = squared * moment_y;
        cubics[i * 8 + 4] = then - here;
        cubics[i * 8 + 5] = 3.0 * here;
        cubics[i * 8 + 6] = dy - (2.0 * here + then);
        cubics[i * 8 + 7] = y;
        x = next_x;
        y = next_y;
    }
}

/* conflicts.py: Conflicts of a path with vehicles that cross the route: where and when their ways overlap. */

/* gap_checks.py: Gaps of the ego's motions to other vehicles, nominally and in the worst case. */

/* duties.py: Duties: which vehicles behind the ego keep their distance to it, and how far their drivers
    can. */

/* rollout.py: Motions of the ego along candidate paths: cruise, follow, yield and brake; and what they
    cost. */

/* scene.py: Scene of a decision: the route, candidate paths, other vehicles, and motions of the ego along
    the paths. */
#define SCENE_TOLERANCE 0.05

/* Index of the station before a position on the route. */
static int scene_station(int n, double at)
{
    return floor_within(at, 0, n - 2);
}

/* Value at a position, linear between stations. */
static double scene_at_station(int n, const double *row, double at)
{
    int i = scene_station(n, at);
    double f = real_min(real_max(at - i, 0.0), 1.0);
    return row[i] + f * (row[i + 1] - row[i]);
}

/* Lateral offset of a path. */
static double scene_lateral(const Scene *w, int p, double at)
{
    int i = scene_station(w->n, at);
    double f = real_min(real_max(at - i, 0.0), 1.0);
    return w->d[p * w->n + i] + f * (w->d[p * w->n + i + 1] - w->d[p * w->n + i]);
}

/* Slope of the lateral offset of a path. */
static double scene_slope(const Scene *w, int p, double at)
{
    return 0.5 * (scene_lateral(w, p, at + 1.0) - scene_lateral(w, p, at - 1.0));
}

/* Curvature that a path adds to the route's. */
static double scene_bend(const Scene *w, int p, double at)
{
    return scene_lateral(w, p, at + 1.0) - 2.0 * scene_lateral(w, p, at) + scene_lateral(w, p, at - 1.0);
}

/* Squared speed limit of route and path. */
static double scene_squared_speed(const Scene *w, int p, double at)
{
    int i = scene_station(w->n, at);
    double f = real_min(real_max(at - i, 0.0), 1.0);
    double own = w->path_cap[p * w->n + i] + f * (w->path_cap[p * w->n + i + 1] - w->path_cap[p * w->n + i]);
    return real_min(own, w->cap[i] + f * (w->cap[i + 1] - w->cap[i]));
}

/* Whether a body is wholly inside neither the ego lane nor the lane in which a path ends. */
static bool scene_is_outside(const Scene *w, int p, double d, double tolerance)
{
    double left = d + w->half_width - tolerance;
    double right = d - w->half_width + tolerance;
    if (left > w->lane_left || right < w->lane_right) {
        return left > w->end_left[p] || right < w->end_right[p];
    }
    return false;
}
#define ROLLOUT_ONCOMING (-0.5)
#define ROLLOUT_CALM 0.5
#define ROLLOUT_RELEASE 12.0
#define ROLLOUT_TIME_EPS 1e-09
#define ROLLOUT_LIMITED_STEP 2
#define ROLLOUT_ROUNDING 1e-09
#define ROLLOUT_NO_LIMIT (-1)
#define ROLLOUT_ROUTE_LIMIT (-2)
#define ROLLOUT_FIRST_STOP (-10)

/* Squared speed at which the curvature of a path needs a lateral acceleration, led down to in comfort. */
void cca_limit_path_speed(Scene *w, int p, double a_y)
{
    w->path_low[p] = w->d[p * w->n + 0];
    w->path_high[p] = w->d[p * w->n + 0];
    for (int i = 0, i_end_ = w->n; i < i_end_; i += 1) {
        w->path_cap[p * w->n + i] = 10000.0;
        w->path_low[p] = real_min(w->path_low[p], w->d[p * w->n + i]);
        w->path_high[p] = real_max(w->path_high[p], w->d[p * w->n + i]);
    }
    for (int i = 1, i_end_ = w->n - 1; i < i_end_; i += 1) {
        double added = w->d[p * w->n + i + 1] - 2.0 * w->d[p * w->n + i] + w->d[p * w->n + i - 1];
        if (fabs(added) > 1e-05) {
            w->path_cap[p * w->n + i] = real_min(a_y / real_max(fabs(added + w->kappa[i]), 1e-06), 10000.0);
        }
    }
    for (int k = 1, k_end_ = w->n; k < k_end_; k += 1) {
        int at = w->n - 1 - k;
        w->path_cap[p * w->n + at] = real_min(w->path_cap[p * w->n + at], w->path_cap[p * w->n + at + 1]
            + 2.0 * w->b_comfort);
    }
}

/* Acceleration that follows at the time gap, and keeps the distance `to_pass` more behind what stops.

It brakes harder than in comfort only as far as needed: a little harder for that distance, and when the
ego creeps not for the last of the standstill gap, at most `spare`. */
static double rollout_follow_at_gap(const Scene *w, double v, double gap, double v_lead, double final_gap,
    bool stops, double spare, double to_pass)
{
    double end = real_max(real_min(spare, w->creep_time * v), 0.01);
    double space = real_max(gap - w->standstill_gap, end);
    double lead = real_max(v_lead, 0.0);
    double need = 0.0;
    if (v_lead < ROLLOUT_ONCOMING) {
        need = (0.5 * v - v_lead) * v / space;
    } else if (v > lead) {
        need = (v - lead) * (v - lead) / (2.0 * space);
    }
    if (stops) {
        double left = real_max(final_gap - w->standstill_gap, end);
        need = real_max(need, v * v / (2.0 * left));
        if (to_pass > 0.0) {
            need = real_max(need, real_min(v * v / (2.0 * real_max(left - to_pass, 0.5 * left)), w->b_firm));
        }
    }
    double surplus = gap - to_pass - w->standstill_gap - w->time_gap * lead;
    double linear = w->b_comfort / (w->approach_rate * w->approach_rate);
    double shed = real_max(w->approach_rate * surplus, -w->opening_speed);
    double rate = w->approach_rate;
    if (surplus > linear) {
        shed = sqrt(2.0 * w->b_comfort * (surplus - 0.5 * linear));
        rate = w->b_comfort / shed;
    }
    double a = rate * real_min(lead - v, 0.0) + 2.0 * w->approach_rate * (lead + shed - v);
    a = real_max(a, -w->b_comfort);
    if (need > w->b_comfort) {
        a = real_min(a, -real_min(1.1 * need, w->b_max));
    }
    return a;
}

/* Deceleration that is needed after the reaction time if a lead vehicle brakes as hard as is assumed. */
static double rollout_needed_braking(const Scene *w, double v, double gap, double v_lead)
{
    double space = gap - v * w->react;
    double lead = real_max(v_lead, 0.0);
    if (w->b_other <= 0.0) {
        double closing = real_max(v - lead, 0.0);
        return closing * closing / (2.0 * real_max(space, 0.1));
    }
    return v * v / (2.0 * real_max(space + lead * lead / (2.0 * w->b_other), 0.1));
}

/* Acceleration that reaches a point no sooner than after a time: an even deceleration, or a stop. */
static double rollout_wait_at_point(const Scene *w, double v, double left, double wait)
{
    double early = v * wait - left;
    if (!(early > 0.0)) {
        return w->a_max;
    }
    double even = 2.0 * early / (wait * wait);
    if (left > 0.0 && even * wait <= v) {
        return -real_min(even, w->b_max);
    }
    double gap = left + w->standstill_gap;
    return rollout_follow_at_gap(w, v, gap, 0.0, gap, true, 0.0, 0.0);
}

/* Whether a vehicle is in the way of a path now or a little later. */
static bool rollout_in_path(const Scene *w, int p, int j, int k, int then)
{
    double here = scene_lateral(w, p, w->s_follow[j * w->steps + k]);
    double low = real_min(w->d_o[j * w->steps + k], w->d_o[j * w->steps + then]) - here;
    double high = real_max(w->d_o[j * w->steps + k], w->d_o[j * w->steps + then]) - here;
    double reach = w->half_w[j] + w->half_width;
    if (w->v_o[j * w->steps + 0] >= ROLLOUT_ONCOMING) {
        reach += w->blocking_gap;
    }
    return low < reach && high > -reach;
}

/* List the vehicles that may be in front of the ego in a path at some time; return their number. */
static int rollout_find_leads(Scene *w, int p)
{
    int count = 0;
    for (int j = 0, j_end_ = w->m; j < j_end_; j += 1) {
        if (w->crosses[j] != 0 || w->overtakes[p * w->max_m + j] != 0.0) {
            continue;
        }
        double reach = w->half_w[j] + w->half_width + w->blocking_gap + ROLLOUT_ROUNDING;
        if (w->d_low[j] - w->path_high[p] >= reach || w->path_low[p] - w->d_high[j] >= reach) {
            continue;
        }
        double farthest = real_max(w->s_follow[j * w->steps + 0], w->s_follow[j * w->steps + w->steps
            - 1]) + 0.5 * w->half_l[j];
        if (farthest > w->s_0 + w->offset) {
            w->leads[count] = j;
            count += 1;
        }
    }
    return count;
}

/* Drive a path: cruise, follow, yield to the first crossing vehicles, brake; `tail` after `react`. */
void cca_roll_out(Scene *w, int row, int p, bool follows, bool passes, int yields, double braking,
    double tail, bool kept)
{
    double position = w->s_0;
    double speed = w->v_0;
    double command = w->a_0;
    double actual = w->a_true;
    int later = 0;
    int leads = follows ? rollout_find_leads(w, p) : 0;
    w->limited_by[row] = ROLLOUT_NO_LIMIT;
    w->terms[row * 9 + 8] = 0.0;
    for (int k = 0, k_end_ = w->steps; k < k_end_; k += 1) {
        double risk = 0.0;
        bool ends = tail > 0.0 && w->t[k] >= w->react - ROLLOUT_TIME_EPS;
        w->s[row * w->steps + k] = position;
        w->v[row * w->steps + k] = speed;
        w->offset_at[row * w->steps + k] = scene_lateral(w, p, position);
        double h = k + 1 < w->steps ? w->t[k + 1] - w->t[k] : w->t[k] - w->t[k - 1];
        double horizon = 2.0 + speed;
        double here = sqrt(real_max(scene_squared_speed(w, p, position), 0.0));
        double cruise = real_min(real_max(here - speed, -w->b_comfort), w->a_max);
        double there = (scene_squared_speed(w, p, position + horizon) - speed * speed) / (2.0 * horizon);
        double want = real_min(cruise, real_max(there, -w->b_max));
        int limit = ROLLOUT_NO_LIMIT;
        if (want < w->a_max - 0.01 && want < -0.05) {
            limit = ROLLOUT_ROUTE_LIMIT;
        }
        double front = position + w->offset + w->half_length;
        if (follows && (!ends || k <= ROLLOUT_LIMITED_STEP)) {
            for (int turn3_ = 0, turn3__end_ = w->steps; turn3_ < turn3__end_; turn3_ += 1) {
                if (later + 1 >= w->steps || !(w->t[later] < w->t[k] + w->look)) {
                    break;
                }
                later += 1;
            }
            for (int i = 0, i_end_ = leads; i < i_end_; i += 1) {
                int j = w->leads[i];
                if (!(w->s_follow[j * w->steps + k] + 0.5 * w->half_l[j] > position + w->offset)) {
                    continue;
                }
                if (passes && !(fabs(scene_lateral(w, p, w->s_follow[j * w->steps + k]))
                    <= SCENE_TOLERANCE)) {
                    continue;
                }
                if (!rollout_in_path(w, p, j, k, later)) {
                    continue;
                }
                double now = w->s_follow[j * w->steps + 0] - w->half_l[j] - (w->s_0 + w->offset
                    + w->half_length);
                double gap = w->s_follow[j * w->steps + k] - w->half_l[j] - front;
                double to_pass = real_min(w->passing_distance[j], real_max(now - w->standstill_gap, 0.0));
                bool stops = w->stands[j] != 0;
                if (passes && !(fabs(scene_lateral(w, p, w->s_follow[j * w->steps + w->steps - 1]))
                    <= SCENE_TOLERANCE)) {
                    stops = false;
                }
                if (w->t[k] < w->risk_until && tail <= 0.0) {
                    double excess = real_min(rollout_needed_braking(w, speed, gap, w->v_follow[j
                        * w->steps + k]), 3.0 * w->b_max) / w->b_soft - 1.0;
                    risk = real_max(risk, real_max(excess, 0.0) * real_max(excess, 0.0));
                }
                double final = gap + (w->s_follow[j * w->steps + w->steps - 1] - w->s_follow[j * w->steps
                    + k]);
                double spare = 0.5 * w->standstill_gap;
                double a = rollout_follow_at_gap(w, speed, gap, w->v_follow[j * w->steps + k], final,
                    stops, spare, to_pass);
                if (a < want) {
                    want = a;
                    limit = j;
                }
            }
        }
        w->terms[row * 9 + 8] += risk * h;
        for (int j = 0, j_end_ = yields; j < j_end_; j += 1) {
            double left = w->stop_s[j] - position;
            double wait = w->stop_until[j] - w->t[k];
            if (wait > 0.0 && left > -2.0) {
                double a = rollout_wait_at_point(w, speed, left, wait);
                if (a < want) {
                    want = a;
                    limit = ROLLOUT_FIRST_STOP - j;
                }
            }
        }
        if (k <= ROLLOUT_LIMITED_STEP) {
            w->limited_by[row] = limit;
        }
        bool free = false;
        if (kept) {
            double law = want + ROLLOUT_CALM;
            want = real_min(w->a[row * w->steps + k], there < 0.0 ? real_min(cruise, real_max(there,
                -w->b_max)) : w->a_max);
            free = want <= law;
            want = real_min(want, law);
        }
        want = braking > 0.0 ? real_min(want, -braking) : want;
        if (ends) {
            want = -tail;
        }
        double side = (w->kappa[scene_station(w->n, position)] + scene_bend(w, p, position)) * speed * speed;
        double available = sqrt(real_max(w->grip * w->grip - side * side, 0.25));
        want = real_min(real_max(want, -available), available);
        if (!free || ends) {
            bool hard = want < -2.0 * w->b_comfort || ends;
            double low = command - (hard ? w->jerk_emergency : w->jerk) * h;
            double high = command + w->jerk * h;
            if (command < 0.0) {
                high = real_max(high, real_min(command + ROLLOUT_RELEASE * h, 0.5));
            }
            want = real_min(real_max(want, low), high);
        }
        command = want;
        w->a[row * w->steps + k] = command;
        double z = h / w->lag;
        actual = actual + (command - actual) * (1.0 - 1.0 / (1.0 + z + 0.5 * z * z + z * z * z / 6.0));
        double then = real_max(speed + actual * h, 0.0);
        if (then <= 0.0 && actual < 0.0) {
            actual = 0.0;
            command = real_max(command, -w->b_comfort);
        }
        position = position + 0.5 * (speed + then) * h;
        speed = then;
    }
}

/* Integrals over a time of what a motion costs, and its peak lateral acceleration. */
void cca_sum_costs(Scene *w, int row, int p, double until)
{
    for (int c = 0; c < 8; c += 1) {
        w->terms[row * 9 + c] = 0.0;
    }
    int last = 0;
    for (int k = 0, k_end_ = w->steps - 1; k < k_end_; k += 1) {
        if (!(w->t[k] < until)) {
            break;
        }
        last = k + 1;
        double h = w->t[k + 1] - w->t[k];
        double v = w->v[row * w->steps + k];
        double a = w->a[row * w->steps + k];
        double at = w->s[row * w->steps + k];
        double added = scene_bend(w, p, at) * v * v;
        double whole = added + w->kappa[scene_station(w->n, at)] * v * v;
        double d = w->offset_at[row * w->steps + k];
        w->terms[row * 9 + 0] += (a < 0.0 ? a * a : 0.3 * a * a) * h;
        w->terms[row * 9 + 1] += added * added * h;
        if (fabs(added) > 0.05) {
            w->terms[row * 9 + 2] = real_max(w->terms[row * 9 + 2], fabs(whole));
        }
        if (scene_is_outside(w, p, d, 0.0)) {
            w->terms[row * 9 + 3] += h;
        }
        double jerk = (w->a[row * w->steps + k + 1] - a) / h;
        w->terms[row * 9 + 4] += jerk * jerk * h;
    }
    w->terms[row * 9 + 5] = w->s[row * w->steps + last];
    w->terms[row * 9 + 6] = w->v[row * w->steps + last];
    w->terms[row * 9 + 7] = w->offset_at[row * w->steps + w->steps - 1];
}

/* traffic.py: Other vehicles of a scene over time: nominal motion, worst case, and order in the lane. */

/* order.py: Order of the vehicles in a lane: drivers brake behind each other, and no vehicle drives
    through another. */
#define ORDER_EAGER 1.5
#define ORDER_OVERLAP 0.2

/* Keep the nominal motion of a vehicle behind another one of its lane and direction, a meter apart. */
static void order_keep_behind(Scene *w, int j, int k, double sign)
{
    double space = w->half_l[j] + w->half_l[k];
    double apart = w->half_w[j] + w->half_w[k] - ORDER_OVERLAP;
    double begin = sign * w->s_o[j * w->steps + 0];
    if (!(sign * w->s_o[k * w->steps + 0] - begin > space) || fabs(w->d_o[j * w->steps + 0] - w->d_o[k
        * w->steps + 0]) >= apart) {
        return;
    }
    space += 1.0;
    bool drive_on = sign * w->v_o[j * w->steps + 0] >= 0.0 && sign * w->v_o[k * w->steps + 0] >= 0.0;
    if (drive_on && sign * w->s_follow[j * w->steps + w->steps - 1] <= sign * w->s_follow[k * w->steps
        + 0] - space) {
        return;
    }
    int last = w->steps - 1;
    double start = w->t[last];
    double needed = 0.0;
    for (int i = 1, i_end_ = w->steps; i < i_end_; i += 1) {
        double lack = sign * (w->s_follow[j * w->steps + i] - w->s_follow[k * w->steps + i]) + space;
        if (lack > 0.0 && !(fabs(w->d_o[j * w->steps + i] - w->d_o[k * w->steps + i]) >= apart)) {
            start = real_min(start, w->t[i] - sqrt(2.0 * lack / w->b_comfort));
            needed = real_max(needed, 2.0 * lack / (w->t[i] * w->t[i]));
        }
    }
    start = real_max(start, 0.0);
    double braking = real_max(w->b_comfort, needed);
    double farthest = begin;
    for (int i = 0, i_end_ = w->steps; i < i_end_; i += 1) {
        double late = real_max(w->t[i] - start, 0.0);
        double s = sign * w->s_follow[j * w->steps + i];
        double at = s - 0.5 * braking * (late * late);
        if (needed > 0.0) {
            double alike = s + sign * (w->s_follow[k * w->steps + i] - w->s_follow[k * w->steps + 0]
                - w->v_o[k * w->steps + 0] * w->t[i]);
            at = real_min(at, real_max(alike, s - 0.5 * ORDER_EAGER * needed * (w->t[i] * w->t[i])));
        }
        if (!(fabs(w->d_o[j * w->steps + i] - w->d_o[k * w->steps + i]) >= apart)) {
            at = real_min(at, sign * w->s_follow[k * w->steps + i] - space);
        }
        farthest = real_max(farthest, at);
        w->s_follow[j * w->steps + i] = sign * farthest;
    }
}

/* Keep the vehicles of one direction behind each other, the first one first. */
void cca_set_order(Scene *w, double sign)
{
    int count = 0;
    for (int j = 0, j_end_ = w->m; j < j_end_; j += 1) {
        if (w->crosses[j] != 0 || w->assumed[j] != 0 || !(sign * w->v_o[j * w->steps + 0] >
            -CONSTANTS_STANDSTILL_SPEED)) {
            continue;
        }
        int at = count;
        for (int turn2_ = 0, turn2__end_ = count; turn2_ < turn2__end_; turn2_ += 1) {
            if (!(sign * w->s_o[w->order[at - 1] * w->steps + 0] < sign * w->s_o[j * w->steps + 0])) {
                break;
            }
            w->order[at] = w->order[at - 1];
            at -= 1;
        }
        w->order[at] = j;
        count += 1;
    }
    for (int i = 0, i_end_ = count; i < i_end_; i += 1) {
        for (int k = 0, k_end_ = i; k < k_end_; k += 1) {
            order_keep_behind(w, w->order[i], w->order[k], sign);
        }
    }
}

/* Speed of a vehicle that stays behind others; second order for unequal steps. */
void cca_set_following_speed(Scene *w, int j)
{
    int last = w->steps - 1;
    w->v_follow[j * w->steps + 0] = (w->s_follow[j * w->steps + 1] - w->s_follow[j * w->steps + 0])
        / (w->t[1] - w->t[0]);
    w->v_follow[j * w->steps + last] = (w->s_follow[j * w->steps + last] - w->s_follow[j * w->steps + last
        - 1]) / (w->t[last] - w->t[last - 1]);
    for (int i = 1, i_end_ = last; i < i_end_; i += 1) {
        double h = w->t[i] - w->t[i - 1];
        double g = w->t[i + 1] - w->t[i];
        double before = (w->s_follow[j * w->steps + i] - w->s_follow[j * w->steps + i - 1]) / h;
        double after = (w->s_follow[j * w->steps + i + 1] - w->s_follow[j * w->steps + i]) / g;
        w->v_follow[j * w->steps + i] = (g * before + h * after) / (h + g);
    }
    w->stands[j] = fabs(w->v_follow[j * w->steps + last]) < CONSTANTS_STANDSTILL_SPEED ? 1 : 0;
}

/* reach.py: Where other vehicles may be: distances, reachable and occupied intervals, danger zones,
    occupancy boxes. */

/* curve.py: A path of cubics over arc length, straight beyond both ends, and foot points of positions on
    it. */
#define CURVE_MAX_ITERATIONS 12
#define CURVE_STEP_TOLERANCE 1e-09
#define CURVE_BISECTIONS 50
#define CURVE_SMALLEST_SPEED 1e-90
#define CURVE_FAR 50.0
#define CURVE_MAX_HALVINGS 32

/* Segment in which an arc length on the path lies. */
static int curve_segment_at(const Curve *curve, double s)
{
    int low = 1;
    int high = curve->segments;
    for (int turn1_ = 0, turn1__end_ = CURVE_MAX_HALVINGS; turn1_ < turn1__end_; turn1_ += 1) {
        if (low >= high) {
            break;
        }
        int middle = int_floor(low + high, 2);
        if (s < curve->breaks[middle]) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return low - 1;
}

/* Position x, y [m], first and second derivative by arc length. */
cca_dddddd cca_curve_point(const Curve *curve, double s)
{
    double on = real_min(real_max(s, curve->breaks[0]), curve->breaks[curve->segments]);
    int i = curve_segment_at(curve, on);
    const double *powers = curve->powers;
    double t = on - curve->breaks[i];
    double x = ((powers[i * 8 + 0] * t + powers[i * 8 + 2]) * t + powers[i * 8 + 4]) * t + powers[i * 8 + 6];
    double y = ((powers[i * 8 + 1] * t + powers[i * 8 + 3]) * t + powers[i * 8 + 5]) * t + powers[i * 8 + 7];
    double dx = (3.0 * powers[i * 8 + 0] * t + 2.0 * powers[i * 8 + 2]) * t + powers[i * 8 + 4];
    double dy = (3.0 * powers[i * 8 + 1] * t + 2.0 * powers[i * 8 + 3]) * t + powers[i * 8 + 5];
    if (s == on) {
        return (cca_dddddd){x, y, dx, dy, 6.0 * powers[i * 8 + 0] * t + 2.0 * powers[i * 8 + 2], 6.0
            * powers[i * 8 + 1] * t + 2.0 * powers[i * 8 + 3]};
    }
    return (cca_dddddd){x + (s - on) * dx, y + (s - on) * dy, dx, dy, 0.0, 0.0};
}

/* Positions, first and second derivatives at n arc lengths. */
void cca_curve_points(const Curve *curve, int n, const double *s, double *position, double *first, double
    *second)
{
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        const cca_dddddd result1_ = cca_curve_point(curve, s[i]);
        position[i * 2 + 0] = result1_.item0;
        position[i * 2 + 1] = result1_.item1;
        first[i * 2 + 0] = result1_.item2;
        first[i * 2 + 1] = result1_.item3;
        second[i * 2 + 0] = result1_.item4;
        second[i * 2 + 1] = result1_.item5;
    }
}

/* Signed curvature from derivatives [1/m]. */
static double curve_curvature_of(double dx, double dy, double ddx, double ddy)
{
    double speed = real_max(box_gaps_norm(dx, dy), CURVE_SMALLEST_SPEED);
    return (dx * ddy - dy * ddx) / (speed * speed * speed);
}

/* Signed curvature at an arc length [1/m]. */
double cca_curvature_at(const Curve *curve, double s)
{
    const cca_dddddd result1_ = cca_curve_point(curve, s);
    double dx = result1_.item2;
    double dy = result1_.item3;
    double ddx = result1_.item4;
    double ddy = result1_.item5;
    return curve_curvature_of(dx, dy, ddx, ddy);
}

/* Foot point by Newton's method from an initial guess: s, d [m], heading [rad] and curvature [1/m]. */
cca_dddd cca_foot_point(const Curve *curve, double x, double y, double s_guess)
{
    double s = s_guess;
    const cca_dddddd result1_ = cca_curve_point(curve, s);
    double px = result1_.item0;
    double py = result1_.item1;
    double dx = result1_.item2;
    double dy = result1_.item3;
    double ddx = result1_.item4;
    double ddy = result1_.item5;
    for (int turn1_ = 0, turn1__end_ = CURVE_MAX_ITERATIONS; turn1_ < turn1__end_; turn1_ += 1) {
        double speed2 = dx * dx + dy * dy;
        double out = (px - x) * dx + (py - y) * dy;
        double bend = (px - x) * ddx + (py - y) * ddy;
        double step = out / real_max(real_max(speed2 + bend, 0.2 * speed2), CURVE_SMALLEST_SPEED);
        if (-CURVE_STEP_TOLERANCE < step && step < CURVE_STEP_TOLERANCE) {
            break;
        }
        s -= step;
        const cca_dddddd result2_ = cca_curve_point(curve, s);
        px = result2_.item0;
        py = result2_.item1;
        dx = result2_.item2;
        dy = result2_.item3;
        ddx = result2_.item4;
        ddy = result2_.item5;
    }
    double d = (dx * (y - py) - dy * (x - px)) / real_max(box_gaps_norm(dx, dy), CURVE_SMALLEST_SPEED);
    return (cca_dddd){s, d, atan2(dy, dx), curve_curvature_of(dx, dy, ddx, ddy)};
}

/* Foot point s, d next to a sample; where Newton leaves the sample's interval, by bisection in it. */
static cca_dd curve_foot_point_at_sample(const Curve *curve, const CurveSamples *samples, double x,
    double y, int i)
{
    int last = samples->count - 1;
    double low = samples->s[int_max(i - 1, 0)];
    double high = samples->s[int_min(i + 1, last)];
    const cca_dddd result1_ = cca_foot_point(curve, x, y, samples->s[i]);
    double s = result1_.item0;
    double d = result1_.item1;
    if ((low <= s && s <= high) || (i == 0 && s < low) || (i == last && s > high)) {
        return (cca_dd){s, d};
    }
    for (int turn1_ = 0, turn1__end_ = CURVE_BISECTIONS; turn1_ < turn1__end_; turn1_ += 1) {
        double middle = 0.5 * (low + high);
        const cca_dddddd result2_ = cca_curve_point(curve, middle);
        double px = result2_.item0;
        double py = result2_.item1;
        double dx = result2_.item2;
        double dy = result2_.item3;
        if ((px - x) * dx + (py - y) * dy < 0.0) {
            low = middle;
        } else {
            high = middle;
        }
    }
    const cca_dddddd result3_ = cca_curve_point(curve, low);
    double px = result3_.item0;
    double py = result3_.item1;
    double dx = result3_.item2;
    double dy = result3_.item3;
    double side = dx * (y - py) - dy * (x - px);
    return (cca_dd){low, side < 0.0 ? -box_gaps_norm(x - px, y - py) : box_gaps_norm(x - px, y - py)};
}

/* Distance of a position from a sample [m]. */
static double curve_sample_distance(const CurveSamples *samples, double x, double y, int i)
{
    return box_gaps_norm(samples->x[i] - x, samples->y[i] - y);
}

/* Next sample that may be nearer than a distance, which this one exceeds; past the last if none is. */
static int curve_sample_after(const CurveSamples *samples, int i, double excess)
{
    return i + floor_within(excess / samples->max_gap, 1, samples->count);
}

/* Distance of a position from the nearest of a few samples [m]. */
static double curve_coarse_distance(const CurveSamples *samples, double x, double y)
{
    double distance = HUGE_VAL;
    int i = 0;
    for (int turn1_ = 0, turn1__end_ = samples->count; turn1_ < turn1__end_; turn1_ += 1) {
        distance = real_min(distance, curve_sample_distance(samples, x, y, i));
        i += samples->stride;
        if (i >= samples->count) {
            break;
        }
    }
    return distance;
}

/* Distance of a position from the nearest sample [m]; it is not above a known distance of one. */
static double curve_nearest_sample_distance(const CurveSamples *samples, double x, double y, double bound)
{
    double distance = bound;
    int i = 0;
    for (int turn1_ = 0, turn1__end_ = samples->count; turn1_ < turn1__end_; turn1_ += 1) {
        double here = curve_sample_distance(samples, x, y, i);
        distance = real_min(distance, here);
        i = curve_sample_after(samples, i, here - distance);
        if (i >= samples->count) {
            break;
        }
    }
    return distance;
}

/* Foot point s, d that is nearest on the whole path, from a distance of any sample. */
static cca_dd curve_nearest_within(const Curve *curve, const CurveSamples *samples, double x, double y,
    double bound)
{
    int n = samples->count;
    double limit = curve_nearest_sample_distance(samples, x, y, bound) + 0.5 * samples->max_gap;
    double best_s = samples->s[0];
    double best_d = HUGE_VAL;
    double smallest = HUGE_VAL;
    int i = 0;
    for (int turn1_ = 0, turn1__end_ = n; turn1_ < turn1__end_; turn1_ += 1) {
        double here = curve_sample_distance(samples, x, y, i);
        if (here <= limit) {
            double before = curve_sample_distance(samples, x, y, int_max(i - 1, 0));
            double after = curve_sample_distance(samples, x, y, int_min(i + 1, n - 1));
            if (here <= before && here <= after) {
                const cca_dd result1_ = curve_foot_point_at_sample(curve, samples, x, y, i);
                double s = result1_.item0;
                double d = result1_.item1;
                double apart = samples->s[0] <= s && s <= samples->s[n - 1] ? fabs(d) : here;
                if (apart < smallest) {
                    smallest = apart;
                    best_s = s;
                    best_d = d;
                }
            }
        }
        i = curve_sample_after(samples, i, here - limit);
        if (i >= n) {
            break;
        }
    }
    return (cca_dd){best_s, best_d};
}

/* Foot point s, d of a position that is nearest on the whole path. */
cca_dd cca_nearest_point(const Curve *curve, const CurveSamples *samples, double x, double y)
{
    return curve_nearest_within(curve, samples, x, y, curve_coarse_distance(samples, x, y));
}

/* Foot points of n positions from initial guesses. */
void cca_foot_points(const Curve *curve, int n, const double *x, const double *y, const double *s_guess,
    double *s, double *d, double *heading, double *curvature)
{
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        const cca_dddd result1_ = cca_foot_point(curve, x[i], y[i], s_guess[i]);
        s[i] = result1_.item0;
        d[i] = result1_.item1;
        heading[i] = result1_.item2;
        curvature[i] = result1_.item3;
    }
}

/* Nearest points of n positions on the whole path; those that follow each other are found sooner. */
void cca_nearest_points(const Curve *curve, const CurveSamples *samples, int n, const double *x,
    const double *y, double *s, double *d)
{
    int last = 0;
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        double few = curve_sample_distance(samples, x[i], y[i], last);
        if (i == 0 || few > CURVE_FAR) {
            few = curve_coarse_distance(samples, x[i], y[i]);
        }
        const cca_dd result1_ = curve_nearest_within(curve, samples, x[i], y[i], few);
        s[i] = result1_.item0;
        d[i] = result1_.item1;
        double along = (s[i] - samples->s[0]) / (samples->s[samples->count - 1] - samples->s[0]);
        last = floor_within(along * samples->count, 0, samples->count - 1);
    }
}
#define REACH_BELIEVED_BRAKING (-1.0)
#define REACH_SMALLEST 1e-300
#define REACH_WINDOW 15.0
#define REACH_REAR 0
#define REACH_FRONT 1
#define REACH_SPEED 2
#define REACH_AGE 3
#define REACH_RATE 4
#define REACH_BRAKING 5
#define REACH_ACCELERATION 6
#define REACH_A_X 7

/* Distance driven in a time; braking lasts until standstill, any other acceleration ends now. */
static double reach_distance_driven(double v, double a_x, double t)
{
    if (a_x >= REACH_BELIEVED_BRAKING || v <= 0.0) {
        return v * t;
    }
    double braking = real_min(real_max(t, 0.0), v / -a_x);
    return v * (braking + real_min(t, 0.0)) + 0.5 * a_x * braking * braking;
}

/* Speed when it was measured, distance that dead reckoning has counted since, time until standstill. */
static cca_ddd reach_measured_motion(double v, double age, double rate, double braking)
{
    double speed = fabs(v);
    double known = real_min(age, CONSTANTS_STALE_AGE);
    double measured = real_max(speed - rate * known, 0.0);
    double stops = braking > 0.0 ? measured / real_max(braking, REACH_SMALLEST) : HUGE_VAL;
    return (cca_ddd){measured, speed * age - 0.5 * rate * known * known, stops};
}

/* Smallest and largest displacement along the road within assumed limits. */
static cca_dd reach_reach(double v, double t, double age, double braking, double acceleration,
    double measured, double counted, double stops)
{
    double shortest = fabs(v) * t;
    double longest = shortest;
    if (t >= 0.0) {
        double since = t + age;
        double slows = real_min(since, stops);
        shortest = measured * slows - 0.5 * braking * slows * slows - counted;
        longest = measured * since + 0.5 * acceleration * since * since - counted;
    }
    double creeping = acceleration > 0.0 ? CONSTANTS_STANDSTILL_SPEED : 0.0;
    double low = v < creeping || v == 0.0 ? -longest : shortest;
    return (cca_dd){low, v > -creeping || v == 0.0 ? longest : -shortest};
}

/* Distance driven at many times. */
void cca_distances_driven(int n, const double *t, double v, double a_x, double *distance)
{
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        distance[i] = reach_distance_driven(v, a_x, t[i]);
    }
}

/* Displacements that vehicles can reach, one time for each. */
void cca_reachable_intervals(int n, const double *v, const double *t, const double *age, const double
    *rate, double braking, double acceleration, double *low, double *high)
{
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        const cca_ddd result1_ = reach_measured_motion(v[i], age[i], rate[i], braking);
        double measured = result1_.item0;
        double counted = result1_.item1;
        double stops = result1_.item2;
        const cca_dd result2_ = reach_reach(v[i], t[i], age[i], braking, acceleration, measured, counted,
            stops);
        low[i] = result2_.item0;
        high[i] = result2_.item1;
    }
}

/* Stations that the bodies of vehicles may cover at common times. */
void cca_occupied_intervals(int vehicles, int times, const double *motion, const double *t, double *rear,
    double *front)
{
    for (int k = 0, k_end_ = vehicles; k < k_end_; k += 1) {
        double begin = motion[k * 8 + REACH_REAR];
        double end = motion[k * 8 + REACH_FRONT];
        double v = motion[k * 8 + REACH_SPEED];
        double age = motion[k * 8 + REACH_AGE];
        double b = motion[k * 8 + REACH_BRAKING];
        double a = motion[k * 8 + REACH_ACCELERATION];
        bool keeps = b == 0.0 && a == 0.0;
        const cca_ddd result1_ = reach_measured_motion(v, age, motion[k * 8 + REACH_RATE], b);
        double measured = result1_.item0;
        double counted = result1_.item1;
        double stops = result1_.item2;
        for (int i = 0, i_end_ = times; i < i_end_; i += 1) {
            if (keeps) {
                double low = copysign(1.0, v) * reach_distance_driven(fabs(v), motion[k * 8 + REACH_A_X],
                    t[i]);
                rear[k * times + i] = begin + low;
                front[k * times + i] = end + low;
            } else {
                const cca_dd result2_ = reach_reach(v, t[i], age, b, a, measured, counted, stops);
                double first = result2_.item0;
                double last = result2_.item1;
                rear[k * times + i] = begin + first;
                front[k * times + i] = end + last;
            }
        }
    }
}

/* Intervals of the road in which vehicles of the adjacent lane block a maneuver, relative to the ego. */
void cca_danger_zones(int vehicles, int times, const double *motion, const double *t, const double
    *travel, double *zone)
{
    for (int k = 0, k_end_ = vehicles; k < k_end_; k += 1) {
        double v = motion[k * 8 + REACH_SPEED];
        double age = motion[k * 8 + REACH_AGE];
        double b = motion[k * 8 + REACH_BRAKING];
        double a = motion[k * 8 + REACH_ACCELERATION];
        const cca_ddd result1_ = reach_measured_motion(v, age, motion[k * 8 + REACH_RATE], b);
        double measured = result1_.item0;
        double counted = result1_.item1;
        double stops = result1_.item2;
        double low = HUGE_VAL;
        double high = -HUGE_VAL;
        for (int i = 0, i_end_ = times; i < i_end_; i += 1) {
            const cca_dd result2_ = reach_reach(v, t[i], age, b, a, measured, counted, stops);
            double first = result2_.item0;
            double last = result2_.item1;
            if (first - travel[i] <= last - travel[i]) {
                low = real_min(low, first - travel[i]);
                high = real_max(high, last - travel[i]);
            } else {
                low = -HUGE_VAL;
                high = HUGE_VAL;
            }
        }
        zone[k * 2 + 0] = motion[k * 8 + REACH_REAR] + low;
        zone[k * 2 + 1] = motion[k * 8 + REACH_FRONT] + high;
    }
}

/* Box that covers an occupied interval near a station: x, y, heading, length and width. */
static cca_ddddd reach_occupancy_box(const Curve *curve, double s, double rear, double front, double d,
    double half_width)
{
    double first = real_min(real_max(rear, s - REACH_WINDOW), front);
    double last = real_max(real_min(front, s + REACH_WINDOW), rear);
    double length = fabs(last - first);
    const cca_dddddd result1_ = cca_curve_point(curve, 0.5 * (first + last));
    double x = result1_.item0;
    double y = result1_.item1;
    double dx = result1_.item2;
    double dy = result1_.item3;
    double ddx = result1_.item4;
    double ddy = result1_.item5;
    double speed = real_max(box_gaps_norm(dx, dy), CURVE_SMALLEST_SPEED);
    double width = 2.0 * half_width + 0.25 * fabs(curve_curvature_of(dx, dy, ddx, ddy)) * length * length;
    return (cca_ddddd){x - d * dy / speed, y + d * dx / speed, atan2(dy, dx), length, width};
}

/* Boxes that cover occupied intervals near given stations. */
void cca_occupancy_boxes(const Curve *curve, int n, const double *s, const double *rear, const double
    *front, const double *d, const double *half_width, double *boxes)
{
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        const cca_ddddd result1_ = reach_occupancy_box(curve, s[i], rear[i], front[i], d[i], half_width[i]);
        boxes[i * 5 + 0] = result1_.item0;
        boxes[i * 5 + 1] = result1_.item1;
        boxes[i * 5 + 2] = result1_.item2;
        boxes[i * 5 + 3] = result1_.item3;
        boxes[i * 5 + 4] = result1_.item4;
    }
}

/* Boxes of vehicles at common times, one vehicle after another, near the stations of the ego then. */
void cca_vehicle_boxes(const Curve *curve, int vehicles, int times, const double *s, const double *rear,
    const double *front, const double *d, const double *half_width, double *boxes)
{
    for (int k = 0, k_end_ = vehicles; k < k_end_; k += 1) {
        for (int i = 0, i_end_ = times; i < i_end_; i += 1) {
            int at = k * times + i;
            const cca_ddddd result1_ = reach_occupancy_box(curve, s[i], rear[k * times + i], front[k
                * times + i], d[k], half_width[k]);
            boxes[at * 5 + 0] = result1_.item0;
            boxes[at * 5 + 1] = result1_.item1;
            boxes[at * 5 + 2] = result1_.item2;
            boxes[at * 5 + 3] = result1_.item3;
            boxes[at * 5 + 4] = result1_.item4;
        }
    }
}
#define TRAFFIC_GONE 1000000.0
#define TRAFFIC_NO_ACCELERATION 0.5
#define TRAFFIC_SPEEDING 0.5
#define TRAFFIC_ABREAST 1.5
#define TRAFFIC_ASSUMED_HALF_WIDTH 0.9
#define TRAFFIC_S 0
#define TRAFFIC_D 1
#define TRAFFIC_SPEED 2
#define TRAFFIC_HALF_L 3
#define TRAFFIC_HALF_W 4
#define TRAFFIC_NOMINAL_L 5
#define TRAFFIC_NOMINAL_W 6
#define TRAFFIC_RATE 7
#define TRAFFIC_NOMINAL_RATE 8
#define TRAFFIC_AGE 9
#define TRAFFIC_AHEAD 10
#define TRAFFIC_SIDE_SPEED 11
#define TRAFFIC_SIDE_RANGE 12
#define TRAFFIC_CROSSES 13
#define TRAFFIC_X 14
#define TRAFFIC_Y 15
#define TRAFFIC_PSI 16
#define TRAFFIC_V_X 17
#define TRAFFIC_A_X 18
#define TRAFFIC_TURN_RATE 19
#define TRAFFIC_BODY_L 20
#define TRAFFIC_BODY_W 21
#define TRAFFIC_BULGE 22
#define TRAFFIC_BEND_W 23
#define TRAFFIC_SURE_W 24
#define TRAFFIC_NOMINAL_D 25
#define TRAFFIC_LEAVES 26

/* Nominal distance and speed without sign; a reported acceleration lasts for a bounded time. */
static cca_dd traffic_travel(const Scene *w, double v, double a, double lasts, double t)
{
    if (fabs(a) < TRAFFIC_NO_ACCELERATION || (w->keeps && a > 0.0)) {
        return (cca_dd){v * t, v};
    }
    double until = a < 0.0 ? real_min(w->braking_time, v / -a) : real_min(lasts, real_max(w->v_limit - v,
        0.0) / a);
    double changing = real_min(t, until);
    double speed = v + a * changing;
    return (cca_dd){v * changing + 0.5 * a * (changing * changing) + speed * (t - changing),
        real_max(speed, 0.0)};
}

/* Mark whether a body is in an adjacent lane, or moves there from beyond. */
static void traffic_set_adjacent(Scene *w, int j, double right, double left)
{
    int last = w->steps - 1;
    bool in_left = left > w->lane_left + w->entry_tolerance && w->right[j * w->steps + last]
        < w->edge_left - w->entry_tolerance;
    bool in_right = right < w->lane_right - w->entry_tolerance && w->left[j * w->steps + last]
        > w->edge_right + w->entry_tolerance;
    w->adjacent[j] = (in_left ? 1 : 0) + (in_right ? 2 : 0);
}

/* Motion of a vehicle along the route. */
static void traffic_locate_along(Scene *w, int j)
{
    double v = w->seen[j * 27 + TRAFFIC_SPEED];
    double speed = fabs(v);
    double side = w->seen[j * 27 + TRAFFIC_SIDE_SPEED];
    double sign = copysign(1.0, v);
    for (int k = 0, k_end_ = w->steps; k < k_end_; k += 1) {
        const cca_dd result1_ = traffic_travel(w, speed, w->seen[j * 27 + TRAFFIC_NOMINAL_RATE],
            w->acceleration_time, w->t[k]);
        double distance = result1_.item0;
        double now = result1_.item1;
        w->s_o[j * w->steps + k] = w->seen[j * 27 + TRAFFIC_S] + sign * distance;
        w->v_o[j * w->steps + k] = sign * now;
        double across = copysign(real_min(fabs(side) * w->t[k], w->seen[j * 27 + TRAFFIC_SIDE_RANGE]), side);
        w->d_o[j * w->steps + k] = w->seen[j * 27 + TRAFFIC_NOMINAL_D] + (w->seen[j * 27
            + TRAFFIC_LEAVES] != 0.0 ? across : 0.0);
        w->right[j * w->steps + k] = w->seen[j * 27 + TRAFFIC_D] - w->seen[j * 27 + TRAFFIC_HALF_W]
            + real_min(across, 0.0);
        w->left[j * w->steps + k] = w->seen[j * 27 + TRAFFIC_D] + w->seen[j * 27 + TRAFFIC_HALF_W]
            + real_max(across, 0.0);
    }
    traffic_set_adjacent(w, j, w->seen[j * 27 + TRAFFIC_D] - w->seen[j * 27 + TRAFFIC_HALF_W], w->seen[j
        * 27 + TRAFFIC_D] + w->seen[j * 27 + TRAFFIC_HALF_W]);
}

/* Distance driven in the lane of a vehicle for each meter of the route: longer outside of a bend. */
static double traffic_lane_scale(const Scene *w, int j, double at)
{
    return real_max(1.0 - w->seen[j * 27 + TRAFFIC_D] * w->kappa[scene_station(w->n, at)], 0.1);
}

/* Worst case along the route of a vehicle that is overtaken, or of one that is not.

Speeds and accelerations are those in its lane, stations follow from the distance driven there. */
static void traffic_reach_along(Scene *w, int j, bool passed)
{
    double scale = traffic_lane_scale(w, j, w->seen[j * 27 + TRAFFIC_S]);
    double v = w->seen[j * 27 + TRAFFIC_SPEED] * scale;
    double rate = w->seen[j * 27 + TRAFFIC_RATE] * scale;
    double nominal = w->seen[j * 27 + TRAFFIC_NOMINAL_RATE];
    double braking = real_max(w->b_other, -rate);
    double age = w->seen[j * 27 + TRAFFIC_AGE];
    const cca_ddd result1_ = reach_measured_motion(v, age, rate, braking);
    double slowest = result1_.item0;
    double so_far = result1_.item1;
    double stops = result1_.item2;
    double stood = real_min(0.5 * slowest * real_min(stops, CONSTANTS_STALE_AGE) - so_far, 0.0) / scale;
    if (passed && rate > 0.0) {
        rate = 0.0;
        nominal = real_min(nominal, 0.0);
    }
    double acceleration = real_max(passed ? w->a_passed : w->a_other, rate);
    double rear = w->seen[j * 27 + TRAFFIC_S] - w->seen[j * 27 + TRAFFIC_HALF_L];
    double front = w->seen[j * 27 + TRAFFIC_S] + w->seen[j * 27 + TRAFFIC_HALF_L];
    const cca_ddd result2_ = reach_measured_motion(v, age, rate, braking);
    double measured = result2_.item0;
    double counted = result2_.item1;
    double fastest = real_max(w->v_limit, real_max(fabs(v), measured) + TRAFFIC_SPEEDING);
    double sum_low = 0.0;
    double sum_high = 0.0;
    double low_0 = 0.0;
    double high_0 = 0.0;
    double low_last = 0.0;
    double high_last = 0.0;
    for (int k = 0, k_end_ = w->steps; k < k_end_; k += 1) {
        double low = 0.0;
        double high = 0.0;
        if (w->keeps) {
            const cca_dd result3_ = traffic_travel(w, fabs(w->seen[j * 27 + TRAFFIC_SPEED]), nominal,
                w->acceleration_time, w->t[k]);
            double distance = result3_.item0;
            low = copysign(1.0, v) * distance;
            high = low;
        } else {
            const cca_dd result4_ = reach_reach(v, w->t[k], age, braking, acceleration, slowest, so_far,
                stops);
            low = result4_.item0;
            const cca_dd result5_ = reach_reach(v, w->t[k], age, braking, acceleration, measured, counted,
                stops);
            high = result5_.item1;
            if (k == 0) {
                low_0 = low / scale;
                high_0 = high / scale;
            } else {
                double farthest = fastest * (w->t[k] - w->t[k - 1]);
                double at_low = w->seen[j * 27 + TRAFFIC_S] + low_0 + sum_low;
                double at_high = w->seen[j * 27 + TRAFFIC_S] + high_0 + sum_high;
                sum_low += real_max(low - low_last, -farthest) / traffic_lane_scale(w, j, at_low);
                sum_high += real_min(high - high_last, farthest) / traffic_lane_scale(w, j, at_high);
            }
            low_last = low;
            high_last = high;
            low = low_0 + sum_low;
            high = high_0 + sum_high;
            if (fabs(v) < CONSTANTS_STANDSTILL_SPEED) {
                if (w->seen[j * 27 + TRAFFIC_AHEAD] > 0.0) {
                    low = real_max(low, stood);
                } else {
                    high = real_min(high, -stood);
                }
            }
        }
        if (passed) {
            if (v >= 0.0) {
                const cca_dd result6_ = traffic_travel(w, w->seen[j * 27 + TRAFFIC_SPEED], w->seen[j * 27
                    + TRAFFIC_NOMINAL_RATE], w->acceleration_time, w->t[k]);
                double distance = result6_.item0;
                high = real_max(high, distance);
            }
            w->low_passed[j * w->steps + k] = rear + low;
            w->high_passed[j * w->steps + k] = front + high;
        } else {
            w->low[j * w->steps + k] = rear + low;
            w->high[j * w->steps + k] = front + high;
        }
    }
}

/* Position and heading of a vehicle after an arc. */
static cca_ddd traffic_on_arc(const Scene *w, int j, double s, double turn)
{
    double half = 0.5 * turn;
    double chord = fabs(half) > 1e-12 ? s * (sin(half) / half) : s;
    double heading = w->seen[j * 27 + TRAFFIC_PSI] + half;
    double x = w->seen[j * 27 + TRAFFIC_X] + chord * cos(heading);
    return (cca_ddd){x, w->seen[j * 27 + TRAFFIC_Y] + chord * sin(heading), w->seen[j * 27 + TRAFFIC_PSI]
        + turn};
}

/* Largest distance of a vehicle that goes on braking for a while, and then accelerates. */
static double traffic_farthest_braking(double v, double rate, double lasts, double acceleration, double t)
{
    double braking = real_min(real_min(lasts, t), v / -rate);
    double speed = v + rate * braking;
    double then = t - braking;
    return v * braking + 0.5 * rate * braking * braking + speed * then + 0.5 * acceleration * then * then;
}

/* Motion of a vehicle in the plane: on its circle nominally, and where it can be within a time. */
static void traffic_locate_crossing(Scene *w, int j)
{
    double v = w->seen[j * 27 + TRAFFIC_V_X];
    double speed = fabs(v);
    double sign = copysign(1.0, v);
    double rate = sign * w->seen[j * 27 + TRAFFIC_A_X];
    double kappa = speed > CONSTANTS_STANDSTILL_SPEED ? w->seen[j * 27 + TRAFFIC_TURN_RATE] / v : 0.0;
    double braking = w->keeps ? 0.0 : real_max(w->b_crossing, -rate);
    double acceleration = w->keeps ? 0.0 : real_max(w->a_crossing, rate);
    double age = w->seen[j * 27 + TRAFFIC_AGE];
    const cca_ddd result1_ = reach_measured_motion(speed, age, 0.0, braking);
    double measured = result1_.item0;
    double counted = result1_.item1;
    double still = result1_.item2;
    for (int k = 0, k_end_ = w->steps; k < k_end_; k += 1) {
        w->s_o[j * w->steps + k] = w->seen[j * 27 + TRAFFIC_S];
        const cca_dd result2_ = traffic_travel(w, speed, rate, w->crossing_time, w->t[k]);
        double distance = result2_.item0;
        w->v_o[j * w->steps + k] = result2_.item1;
        w->d_o[j * w->steps + k] = w->seen[j * 27 + TRAFFIC_D];
        double s = sign * distance;
        const cca_ddd result3_ = traffic_on_arc(w, j, s, kappa * s);
        w->x_o[j * w->steps + k] = result3_.item0;
        w->y_o[j * w->steps + k] = result3_.item1;
        w->psi_o[j * w->steps + k] = result3_.item2;
        double before = real_max(w->t[k] - w->min_pet, 0.0);
        double after = w->t[k] + w->min_pet;
        const cca_dd result4_ = reach_reach(speed, before, age, braking, acceleration, measured, counted,
            still);
        double low = result4_.item0;
        const cca_dd result5_ = reach_reach(speed, after, age, braking, acceleration, measured, counted,
            still);
        double high = result5_.item1;
        if (rate < -TRAFFIC_NO_ACCELERATION && age < w->yield_time) {
            high = real_min(high, traffic_farthest_braking(speed, rate, w->yield_time - age, acceleration,
                after));
        }
        double middle = 0.5 * (low + high);
        double extent = 0.5 * (high - low);
        double turn = real_min(real_max(kappa * middle * sign, -0.5 * 3.141592653589793), 0.5
            * 3.141592653589793);
        const cca_ddd result6_ = traffic_on_arc(w, j, sign * middle, turn);
        w->x_w[j * w->steps + k] = result6_.item0;
        w->y_w[j * w->steps + k] = result6_.item1;
        w->psi_w[j * w->steps + k] = result6_.item2;
        w->half_l_w[j * w->steps + k] = w->seen[j * 27 + TRAFFIC_BODY_L] + extent;
        w->half_w_w[j * w->steps + k] = w->seen[j * 27 + TRAFFIC_BODY_W] + real_min(0.25 * fabs(kappa)
            * extent * extent, extent);
    }
    w->adjacent[j] = 0;
}

/* Motion of a vehicle that is assumed at the end of the awareness range. */
static void traffic_locate_assumed(Scene *w, int j)
{
    for (int k = 0, k_end_ = w->steps; k < k_end_; k += 1) {
        double at = w->seen[j * 27 + TRAFFIC_S] + w->seen[j * 27 + TRAFFIC_SPEED] * w->t[k];
        w->s_o[j * w->steps + k] = TRAFFIC_GONE;
        w->v_o[j * w->steps + k] = 0.0;
        w->d_o[j * w->steps + k] = 0.0;
        w->low[j * w->steps + k] = at;
        w->high[j * w->steps + k] = at;
        w->low_passed[j * w->steps + k] = at;
        w->high_passed[j * w->steps + k] = at;
        w->right[j * w->steps + k] = w->seen[j * 27 + TRAFFIC_D] - TRAFFIC_ASSUMED_HALF_WIDTH;
        w->left[j * w->steps + k] = w->seen[j * 27 + TRAFFIC_D] + TRAFFIC_ASSUMED_HALF_WIDTH;
    }
    traffic_set_adjacent(w, j, w->seen[j * 27 + TRAFFIC_D] - TRAFFIC_ASSUMED_HALF_WIDTH, w->seen[j * 27
        + TRAFFIC_D] + TRAFFIC_ASSUMED_HALF_WIDTH);
}

/* Whether a body is at least in part in a lane. */
static bool traffic_is_in(const Scene *w, int j, double right, double left)
{
    return w->seen[j * 27 + TRAFFIC_D] - w->seen[j * 27 + TRAFFIC_HALF_W] <= left && w->seen[j * 27
        + TRAFFIC_D] + w->seen[j * 27 + TRAFFIC_HALF_W] >= right;
}

/* Whether no stationary vehicle is in a lane next to a vehicle or a little ahead. */
static bool traffic_is_clear(const Scene *w, int j, int n, double right, double left)
{
    double rear = w->seen[j * 27 + TRAFFIC_S] - w->seen[j * 27 + TRAFFIC_HALF_L];
    double end = w->seen[j * 27 + TRAFFIC_S] + w->seen[j * 27 + TRAFFIC_HALF_L] + w->queue_gap;
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        bool stands = fabs(w->seen[i * 27 + TRAFFIC_SPEED]) <= CONSTANTS_STANDSTILL_SPEED;
        bool near = w->seen[i * 27 + TRAFFIC_S] - w->seen[i * 27 + TRAFFIC_HALF_L] < end && w->seen[i * 27
            + TRAFFIC_S] + w->seen[i * 27 + TRAFFIC_HALF_L] > rear;
        if (i != j && stands && near && traffic_is_in(w, i, right, left)) {
            return false;
        }
    }
    return true;
}

/* Distance kept behind a single vehicle that comes to rest next to a clear lane, for a later maneuver. */
static double traffic_distance_to_pass(const Scene *w, int j, int n)
{
    if (w->stands[j] == 0 || w->crosses[j] != 0) {
        return 0.0;
    }
    if (!traffic_is_in(w, j, w->lane_right, w->lane_left)) {
        return 0.0;
    }
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        double gap = w->seen[i * 27 + TRAFFIC_S] - w->seen[i * 27 + TRAFFIC_HALF_L] - (w->seen[j * 27
            + TRAFFIC_S] + w->seen[j * 27 + TRAFFIC_HALF_L]);
        if (i != j && (0.0 < gap && gap < w->queue_gap) && fabs(w->seen[i * 27 + TRAFFIC_D] - w->seen[j
            * 27 + TRAFFIC_D]) < TRAFFIC_ABREAST) {
            return 0.0;
        }
    }
    for (int i = 0, i_end_ = w->max_lanes; i < i_end_; i += 1) {
        if (traffic_is_clear(w, j, n, w->other_lanes[i * 2 + 0], w->other_lanes[i * 2 + 1])) {
            return w->passing_gap;
        }
    }
    return 0.0;
}

/* Predict the vehicles in `seen`, the first of which are real, the others assumed. */
void cca_locate_vehicles(Scene *w, int seen)
{
    w->crossing = 0;
    for (int j = 0, j_end_ = w->m; j < j_end_; j += 1) {
        w->half_l[j] = w->seen[j * 27 + TRAFFIC_NOMINAL_L];
        w->half_w[j] = w->seen[j * 27 + TRAFFIC_NOMINAL_W];
        w->crosses[j] = j < seen && w->seen[j * 27 + TRAFFIC_CROSSES] != 0.0 ? 1 : 0;
        w->assumed[j] = j >= seen ? 1 : 0;
        w->passing_distance[j] = 0.0;
        if (j >= seen) {
            traffic_locate_assumed(w, j);
        } else if (w->crosses[j] != 0) {
            w->crossing += 1;
            traffic_locate_crossing(w, j);
        } else {
            traffic_locate_along(w, j);
            traffic_reach_along(w, j, false);
            traffic_reach_along(w, j, true);
        }
    }
    for (int j = 0, j_end_ = w->m; j < j_end_; j += 1) {
        for (int i = 0, i_end_ = w->steps; i < i_end_; i += 1) {
            w->s_follow[j * w->steps + i] = w->s_o[j * w->steps + i];
        }
    }
    cca_set_order(w, 1.0);
    cca_set_order(w, -1.0);
    for (int j = 0, j_end_ = w->m; j < j_end_; j += 1) {
        cca_set_following_speed(w, j);
        if (w->v_o[j * w->steps + 0] < 0.0) {
            for (int i = 0, i_end_ = w->steps; i < i_end_; i += 1) {
                w->s_o[j * w->steps + i] = w->s_follow[j * w->steps + i];
                w->v_o[j * w->steps + i] = i > 0 ? w->v_follow[j * w->steps + i] : w->v_o[j * w->steps + 0];
            }
        }
        w->d_low[j] = w->d_o[j * w->steps + 0];
        w->d_high[j] = w->d_o[j * w->steps + 0];
        for (int i = 1, i_end_ = w->steps; i < i_end_; i += 1) {
            w->d_low[j] = real_min(w->d_low[j], w->d_o[j * w->steps + i]);
            w->d_high[j] = real_max(w->d_high[j], w->d_o[j * w->steps + i]);
        }
    }
    for (int j = 0, j_end_ = seen; j < j_end_; j += 1) {
        w->passing_distance[j] = traffic_distance_to_pass(w, j, seen);
    }
}
#define DUTIES_FAR 1000.0

/* Find from when on vehicles behind the ego must keep their distance; return when it is in its lane. */
int cca_find_duty(Scene *w, int row, int p, double wait)
{
    int back = 0;
    for (int k = 0, k_end_ = w->steps; k < k_end_; k += 1) {
        if (scene_is_outside(w, p, w->offset_at[row * w->steps + k], SCENE_TOLERANCE)) {
            back = int_min(k + 1, w->steps - 1);
        }
    }
    w->rear = w->s[row * w->steps + back] + w->offset - w->half_length;
    w->duty_from = back;
    for (int k = back, k_end_ = w->steps; k < k_end_; k += 1) {
        if (back > 0 && w->t[k] < w->t[back] + wait) {
            w->duty_from = k + 2;
        }
    }
    return back;
}

/* Whether a vehicle is behind the ego in its lane from `duty_from` on, for good. */
bool cca_has_duty(const Scene *w, int j, int back)
{
    if (w->crosses[j] != 0 || !(w->v_o[j * w->steps + 0] >= ROLLOUT_ONCOMING)) {
        return false;
    }
    return w->s_o[j * w->steps + back] + 0.5 * w->half_l[j] < w->rear;
}

/* First step at which a vehicle from the side is behind the ego in its way, and keeps its distance. */
int cca_merges_behind(const Scene *w, int row, int j)
{
    if (w->crosses[j] != 0 || !(w->v_o[j * w->steps + 0] >= ROLLOUT_ONCOMING)) {
        return w->steps;
    }
    double across = w->half_w[j] + w->half_width;
    for (int k = 0, k_end_ = w->steps; k < k_end_; k += 1) {
        if (fabs(w->d_o[j * w->steps + k] - w->offset_at[row * w->steps + k]) < across) {
            bool moves_in = fabs(w->d_o[j * w->steps + 0] - w->offset_at[row * w->steps + k]) >= across;
            bool behind = w->s_o[j * w->steps + k] + w->half_l[j] < w->s[row * w->steps + k] + w->offset
                - w->half_length;
            return moves_in && behind ? k : w->steps;
        }
    }
    return w->steps;
}

/* Whether a vehicle that is nominally behind cannot be alongside: far enough, or in the ego's lane. */
bool cca_is_behind(const Scene *w, int row, int p, int j, int back)
{
    double high = w->overtakes[p * w->max_m + j] != 0.0 ? w->high_passed[j * w->steps + back] : w->high[j
        * w->steps + back];
    double ahead = w->seen[j * 27 + TRAFFIC_AHEAD];
    double front = w->seen[j * 27 + TRAFFIC_HALF_L] * sqrt(real_max(1.0 - ahead * ahead, 0.0));
    double in_lane = w->half_width + real_min(w->seen[j * 27 + TRAFFIC_SURE_W], 0.0) - front
        - SCENE_TOLERANCE;
    double now = w->d_o[j * w->steps + back] - w->offset_at[row * w->steps + back];
    double reported = now - w->seen[j * 27 + TRAFFIC_SIDE_SPEED] * w->seen[j * 27 + TRAFFIC_AGE];
    return high < w->rear || (fabs(now) < in_lane && fabs(reported) < in_lane);
}

/* Whether a body is at least in part in a lane, wherever it is within its bounds.

Since its report it has moved sideways at most as reported. */
static bool duties_is_surely_in(const Scene *w, int j, double right, double left)
{
    double now = w->seen[j * 27 + TRAFFIC_D];
    double reported = now - w->seen[j * 27 + TRAFFIC_SIDE_SPEED] * w->seen[j * 27 + TRAFFIC_AGE];
    double low = real_max(now, reported) - w->seen[j * 27 + TRAFFIC_SURE_W];
    double high = real_min(now, reported) + w->seen[j * 27 + TRAFFIC_SURE_W];
    return low < left - w->entry_tolerance && high > right + w->entry_tolerance;
}

/* Whether a vehicle follows an ego outside its lane, in one of the lanes that the ego is in. */
bool cca_is_established(const Scene *w, int j)
{
    if (w->established == 0 || w->crosses[j] != 0 || !(w->v_o[j * w->steps + 0] >= ROLLOUT_ONCOMING)) {
        return false;
    }
    if (!(w->high[j * w->steps + 0] < w->s_0 + w->offset - w->half_length)) {
        return false;
    }
    if (w->established == 1) {
        return duties_is_surely_in(w, j, w->leaves ? w->lane_right : w->lane_left, w->edge_left);
    }
    return duties_is_surely_in(w, j, w->edge_right, w->leaves ? w->lane_left : w->lane_right);
}

/* Index of the first time that is not before another. */
int cca_zone_begin(const Scene *w, double since)
{
    int begin = w->steps - 1;
    for (int k = 0, k_end_ = w->steps; k < k_end_; k += 1) {
        if (w->t[k] >= since - ROLLOUT_TIME_EPS) {
            begin = int_min(begin, k);
        }
    }
    return begin;
}

/* Whether a vehicle is in the adjacent lane that the maneuver enters. */
bool cca_is_in_zone_lane(const Scene *w, int j)
{
    return w->adjacent[j] == 3 || w->adjacent[j] == w->zone_side;
}

/* Whether a vehicle is for certain in the adjacent lane that the maneuver enters, not in the ego's. */
bool cca_keeps_zone(const Scene *w, int j)
{
    double half = 0.5 * (w->seen[j * 27 + TRAFFIC_HALF_W] + w->seen[j * 27 + TRAFFIC_SURE_W]);
    if (w->zone_side == 1) {
        bool outside = w->seen[j * 27 + TRAFFIC_D] - half > w->lane_left - w->entry_tolerance;
        return outside && duties_is_surely_in(w, j, w->lane_left, w->edge_left);
    }
    bool outside = w->seen[j * 27 + TRAFFIC_D] + half < w->lane_right + w->entry_tolerance;
    return outside && duties_is_surely_in(w, j, w->edge_right, w->lane_right);
}

/* Least gap behind the ego to a driver who reacts to it from a time on, given their front and speed. */
static double duties_rear_gap(const Scene *w, int row, int begin, double front, double speed)
{
    double gap = DUTIES_FAR;
    double position = front;
    double v = speed;
    for (int k = begin, k_end_ = w->steps; k < k_end_; k += 1) {
        gap = real_min(gap, w->s[row * w->steps + k] + w->offset - w->half_length - position);
        bool has_reacted = w->t[k] - w->t[begin] >= w->rear_reaction - ROLLOUT_TIME_EPS;
        if (k + 1 == w->steps || (has_reacted && !(v > w->v[row * w->steps + k]))) {
            break;
        }
        double h = w->t[k + 1] - w->t[k];
        double then = has_reacted ? real_max(v - w->rear_braking * h, 0.0) : v;
        position = position + 0.5 * (v + then) * h;
        v = then;
    }
    return gap;
}

/* Whether a driver behind in the adjacent lane has the room to react to the ego from a time on. */
bool cca_reacts(const Scene *w, int row, int j, int begin)
{
    if (!(w->rear_reaction > 0.0) || w->crosses[j] != 0 || !cca_keeps_zone(w, j)) {
        return false;
    }
    double front = w->s_o[j * w->steps + begin] + w->half_l[j];
    if (!(w->v_o[j * w->steps + begin] >= ROLLOUT_ONCOMING) || !(front < w->s[row * w->steps + begin]
        + w->offset - w->half_length)) {
        return false;
    }
    return duties_rear_gap(w, row, begin, front, w->v_o[j * w->steps + begin]) > 0.0;
}

/* Least gap behind the ego to a vehicle of the adjacent lane, in its worst case until it reacts. */
double cca_worst_rear_gap(const Scene *w, int row, int j, int begin)
{
    double speed = w->v_o[j * w->steps + begin];
    if (begin > 0) {
        speed = (w->high[j * w->steps + begin] - w->high[j * w->steps + begin - 1]) / (w->t[begin]
            - w->t[begin - 1]);
    }
    return duties_rear_gap(w, row, begin, w->high[j * w->steps + begin], speed);
}
#define GAP_CHECKS_STANDSTILL 0.2
#define GAP_CHECKS_FAR_IN_PLANE 15.0
#define GAP_CHECKS_NEAR 12.0
#define GAP_CHECKS_ROUNDING 1e-06

/* Center of the ego's body in the plane, cosine and sine of its heading. */
static cca_dddd gap_checks_pose(const Scene *w, double at, double d, double turn)
{
    double route = scene_at_station(w->n, w->psi, at);
    double heading = route + atan2(turn, real_max(1.0 - w->kappa[scene_station(w->n, at)] * d, 0.1));
    double c = cos(heading);
    double s = sin(heading);
    double x = scene_at_station(w->n, w->x, at) - d * sin(route) + w->offset * c;
    double y = scene_at_station(w->n, w->y, at) + d * cos(route) + w->offset * s;
    return (cca_dddd){x, y, c, s};
}

/* Place the ego's body at each step of a motion: on the route, and in the plane if vehicles cross. */
static void gap_checks_set_poses(Scene *w, int row, int p)
{
    for (int k = 0, k_end_ = w->steps; k < k_end_; k += 1) {
        double at = w->s[row * w->steps + k];
        double turn = scene_slope(w, p, at);
        double kappa = w->kappa[scene_station(w->n, at)];
        w->turn[k] = turn;
        w->scale[k] = 1.0 / sqrt(1.0 + turn * turn);
        w->bends[k] = real_max(real_max(fabs(kappa), fabs(w->kappa[scene_station(w->n, at
            - GAP_CHECKS_NEAR)])), fabs(w->kappa[scene_station(w->n, at + GAP_CHECKS_NEAR)]));
        w->wide[k] = w->half_width + 0.5 * fabs(kappa) * w->half_length * w->half_length;
        if (w->crossing > 0) {
            const cca_dddd result1_ = gap_checks_pose(w, at, w->offset_at[row * w->steps + k], turn);
            w->x_e[k] = result1_.item0;
            w->y_e[k] = result1_.item1;
            w->c_e[k] = result1_.item2;
            w->s_e[k] = result1_.item3;
        }
    }
}

/* Gap of the ego's body to a rectangle in route coordinates; more than `enough` may be more. */
static double gap_checks_ego_gap(const Scene *w, int row, int k, double low, double high, double right,
    double left, double enough)
{
    double at = w->s[row * w->steps + k];
    double middle = at + w->offset;
    double reach = w->half_length + w->half_width;
    if (!(low <= middle + reach + GAP_CHECKS_NEAR)) {
        return low - middle - reach;
    }
    if (!(high >= middle - reach - GAP_CHECKS_NEAR)) {
        return middle - reach - high;
    }
    double turn = w->turn[k];
    double scale = w->scale[k];
    double aside = 0.5 * (right + left) - w->offset_at[row * w->steps + k] - w->offset * turn * scale;
    double across = fabs(aside) - (w->half_length * fabs(turn) + w->wide[k]) * scale - 0.5 * (left - right);
    if (across > enough) {
        return across;
    }
    double begin = real_max(low, middle - reach - GAP_CHECKS_NEAR);
    double end = real_max(real_min(high, middle + reach + GAP_CHECKS_NEAR), begin);
    double ahead = 0.5 * (begin + end) - at - w->offset * scale;
    return cca_oriented_box_gap(ahead, aside, scale, turn * scale, 1.0, 0.0, w->half_length, w->wide[k],
        0.5 * (end - begin), 0.5 * (left - right));
}

/* Gap of the ego's body in a motion to a box in the plane. */
static double gap_checks_plane_gap(const Scene *w, int k, double x, double y, double psi, double length,
    double width)
{
    double dx = x - w->x_e[k];
    double dy = y - w->y_e[k];
    if (!(box_gaps_norm(dx, dy) < length + width + w->half_length + w->half_width
        + GAP_CHECKS_FAR_IN_PLANE)) {
        return GAP_CHECKS_FAR_IN_PLANE;
    }
    return cca_oriented_box_gap(dx, dy, w->c_e[k], w->s_e[k], cos(psi), sin(psi), w->half_length,
        w->half_width, length, width);
}

/* Gap to a vehicle; one that crosses covers where it is within a time. */
static double gap_checks_nominal_gap(const Scene *w, int row, int j, int k, double pet, double enough)
{
    if (w->crosses[j] != 0) {
        double length = w->half_l[j] + pet * w->v_o[j * w->steps + k];
        return gap_checks_plane_gap(w, k, w->x_o[j * w->steps + k], w->y_o[j * w->steps + k], w->psi_o[j
            * w->steps + k], length, w->half_w[j]);
    }
    double s = w->s_o[j * w->steps + k];
    double d = w->d_o[j * w->steps + k];
    return gap_checks_ego_gap(w, row, k, s - w->half_l[j], s + w->half_l[j], d - w->half_w[j], d
        + w->half_w[j], enough);
}

/* Relative speed of the ego and a vehicle at a time; 0 if both drive the same way and draw apart. */
static double gap_checks_impact_speed(const Scene *w, int row, int j, int k)
{
    double v = w->v[row * w->steps + k];
    double v_o = w->v_o[j * w->steps + k];
    double ahead = w->s_o[j * w->steps + k] - w->s[row * w->steps + k] - w->offset;
    if (w->crosses[j] == 0 && v_o >= 0.0 && (v_o - v) * ahead > 0.0) {
        return 0.0;
    }
    double route = scene_at_station(w->n, w->psi, w->s[row * w->steps + k]);
    double psi = w->crosses[j] != 0 ? w->psi_o[j * w->steps + k] : route;
    return box_gaps_norm(v * cos(route) - v_o * cos(psi), v * sin(route) - v_o * sin(psi));
}

/* Least gap to the nominal motion of others beyond what is asked, and the first overlap.

Asked are `clearance` of vehicles that are passed; of others `touch`, and `met` where the ego is outside
its lane. */
void cca_check_nominal(Scene *w, int row, int p, double touch, double met, double clearance, double wait,
    double pet)
{
    int back = cca_find_duty(w, row, p, wait);
    gap_checks_set_poses(w, row, p);
    int begin = w->established != 0 ? 0 : cca_zone_begin(w, w->zone_from);
    int steps = w->steps;
    double margin = DUTIES_FAR;
    double closest = DUTIES_FAR;
    int which = -1;
    int when = steps;
    int hit = steps;
    w->impact = 0.0;
    for (int j = 0, j_end_ = w->m; j < j_end_; j += 1) {
        if (cca_is_established(w, j)) {
            continue;
        }
        bool passed = w->overtakes[p * w->max_m + j] != 0.0;
        double inside = passed ? clearance : touch;
        double outside = passed ? clearance : met;
        bool keeps_off = cca_reacts(w, row, j, begin);
        int until = cca_has_duty(w, j, back) ? w->duty_from : steps;
        until = int_min(until, cca_merges_behind(w, row, j));
        for (int k = 0, k_end_ = int_min(until, steps); k < k_end_; k += 1) {
            if (keeps_off && begin <= k && k <= back) {
                continue;
            }
            double asked = scene_is_outside(w, p, w->offset_at[row * w->steps + k], SCENE_TOLERANCE)
                ? outside : inside;
            double enough = k > 0 ? real_max(real_max(closest, asked + margin), 0.0) + GAP_CHECKS_ROUNDING
                : HUGE_VAL;
            double gap = gap_checks_nominal_gap(w, row, j, k, pet, enough);
            if (k == 0) {
                inside = real_min(inside, real_max(gap - 0.02, 0.0));
                outside = real_min(outside, real_max(gap - 0.02, 0.0));
                asked = real_min(asked, real_max(gap - 0.02, 0.0));
            }
            closest = real_min(closest, gap);
            if (!(gap - asked >= margin)) {
                margin = gap - asked;
                which = j;
                when = k;
            }
            if (gap < 0.0 && (k < hit || w->impact == 0.0)) {
                double impact = gap_checks_impact_speed(w, row, j, k);
                if (impact > 0.0 || hit == steps) {
                    hit = k;
                    which = j;
                    w->impact = impact;
                }
            }
        }
    }
    w->min_margin = margin;
    w->gap = closest;
    w->which = which;
    w->when = hit < steps ? hit : when;
}

/* Gap to where a vehicle may be in the worst case; more than `enough` may be more. */
static double gap_checks_worst_gap(const Scene *w, int row, int p, int j, int k, double enough)
{
    if (w->crosses[j] != 0) {
        return gap_checks_plane_gap(w, k, w->x_w[j * w->steps + k], w->y_w[j * w->steps + k], w->psi_w[j
            * w->steps + k], w->half_l_w[j * w->steps + k], w->half_w_w[j * w->steps + k]);
    }
    bool passed = w->overtakes[p * w->max_m + j] != 0.0;
    double low = passed ? w->low_passed[j * w->steps + k] : w->low[j * w->steps + k];
    double high = passed ? w->high_passed[j * w->steps + k] : w->high[j * w->steps + k];
    double bulge = real_max(w->seen[j * 27 + TRAFFIC_BULGE] * w->bends[k] - w->seen[j * 27
        + TRAFFIC_BEND_W], 0.0);
    return gap_checks_ego_gap(w, row, k, low - w->margin, high + w->margin, w->right[j * w->steps + k]
        - bulge, w->left[j * w->steps + k] + bulge, enough);
}

/* Least gap from one step to the next to where a vehicle along the route may be in the worst case. */
static double gap_checks_swept_gap(const Scene *w, int row, int p, int j, int k)
{
    bool passed = w->overtakes[p * w->max_m + j] != 0.0;
    double low = passed ? w->low_passed[j * w->steps + k] : w->low[j * w->steps + k];
    double high = passed ? w->high_passed[j * w->steps + k] : w->high[j * w->steps + k];
    double low_then = passed ? w->low_passed[j * w->steps + k + 1] : w->low[j * w->steps + k + 1];
    double high_then = passed ? w->high_passed[j * w->steps + k + 1] : w->high[j * w->steps + k + 1];
    double along = w->s[row * w->steps + k + 1] - w->s[row * w->steps + k];
    double across = w->offset_at[row * w->steps + k + 1] - w->offset_at[row * w->steps + k];
    double right = real_min(w->right[j * w->steps + k], w->right[j * w->steps + k + 1] - across);
    double left = real_max(w->left[j * w->steps + k], w->left[j * w->steps + k + 1] - across);
    return gap_checks_ego_gap(w, row, k, real_min(low, low_then - along), real_max(high, high_then
        - along), right, left, HUGE_VAL);
}

/* Speed at which the ego and a vehicle of the worst case close at a time. */
static double gap_checks_worst_impact(const Scene *w, int row, int j, int k)
{
    double v = w->v[row * w->steps + k];
    if (w->crosses[j] != 0) {
        return v;
    }
    int i = int_max(k, 1);
    double h = w->t[i] - w->t[i - 1];
    if (w->s_o[j * w->steps + 0] > w->s_0 + w->offset) {
        return real_max(v - (w->low[j * w->steps + i] - w->low[j * w->steps + i - 1]) / h, 0.0);
    }
    return real_max((w->high[j * w->steps + i] - w->high[j * w->steps + i - 1]) / h - v, 0.0);
}

/* Whether vehicles within the declared bounds cannot touch the ego.

`which`: 0 all vehicles; 1 those of the adjacent lane on `zone_side`; 2 all others. With `x_safety` the
ego keeps that distance along the road to vehicles of the adjacent lane until it has returned: from when
it enters that lane, or from when the maneuver begins if the vehicle comes nearer. `impact` is the closing
speed at the first overlap. */
bool cca_check_worst_case(Scene *w, int row, int p, double touch, double clearance, double wait,
    double x_safety, int which)
{
    int back = cca_find_duty(w, row, p, wait);
    gap_checks_set_poses(w, row, p);
    int steps = w->steps;
    double margin = DUTIES_FAR;
    int decides = -1;
    int when = steps;
    int hit = steps;
    w->impact = 0.0;
    int maneuver_begin = cca_zone_begin(w, w->begin_from);
    int lane_begin = cca_zone_begin(w, w->zone_from);
    for (int j = 0, j_end_ = w->m; j < j_end_; j += 1) {
        bool passed = w->overtakes[p * w->max_m + j] != 0.0;
        bool nears = w->v_o[j * w->steps + 0] < ROLLOUT_ONCOMING || w->v_o[j * w->steps + 0] > w->v_0
            || w->assumed[j] != 0;
        int begin = nears ? maneuver_begin : lane_begin;
        bool same = w->v_o[j * w->steps + 0] >= ROLLOUT_ONCOMING && w->assumed[j] == 0;
        bool ahead = same && w->s_o[j * w->steps + begin] > w->s[row * w->steps + begin] + w->offset;
        bool adjacent = !passed && cca_is_in_zone_lane(w, j);
        bool in_zone_lane = adjacent && (which == 1 || !ahead);
        if ((which == 1 && !in_zone_lane) || (which == 2 && in_zone_lane)) {
            continue;
        }
        if (w->assumed[j] != 0 && !(x_safety > 0.0)) {
            continue;
        }
        if (cca_is_established(w, j)) {
            continue;
        }
        double asked = passed ? clearance : touch;
        int until = steps;
        if (cca_has_duty(w, j, back) && cca_is_behind(w, row, p, j, back)) {
            until = w->duty_from;
        }
        if (which == 1) {
            until = int_min(until, back + 1);
        }
        for (int k = 0, k_end_ = int_min(until, steps); k < k_end_; k += 1) {
            bool zone = x_safety > 0.0 && k <= back && k >= begin;
            if (zone && in_zone_lane) {
                double middle = w->s[row * w->steps + k] + w->offset;
                double rear = ahead ? w->s_o[j * w->steps + k] - w->half_l[j] : w->low[j * w->steps + k];
                double zone_gap = real_max(rear - x_safety - (middle + w->half_length), middle
                    - w->half_length - (w->high[j * w->steps + k] + x_safety));
                bool reacts_behind = same && !ahead && w->rear_reaction > 0.0;
                if (reacts_behind) {
                    zone_gap = k == begin ? cca_worst_rear_gap(w, row, j, k) - x_safety : DUTIES_FAR;
                }
                if (!(zone_gap >= margin)) {
                    margin = zone_gap;
                    decides = j;
                    when = k;
                }
                if (which == 1 || !reacts_behind || cca_keeps_zone(w, j)) {
                    continue;
                }
            }
            if (w->assumed[j] != 0) {
                continue;
            }
            if (k > 0 && !(w->v[row * w->steps + k - 1] >= GAP_CHECKS_STANDSTILL) && w->crosses[j] == 0) {
                if (!scene_is_outside(w, p, w->offset_at[row * w->steps + k], 0.0)) {
                    continue;
                }
            }
            double enough = k > 0 ? real_max(asked + margin, 0.0) + GAP_CHECKS_ROUNDING : HUGE_VAL;
            double gap = gap_checks_worst_gap(w, row, p, j, k, enough);
            if (k == 0) {
                asked = real_min(asked, real_max(gap - 0.02, 0.0));
            }
            if (asked < touch && k + 1 < steps && w->crosses[j] == 0) {
                gap = real_min(gap, gap_checks_swept_gap(w, row, p, j, k));
            }
            if (gap < 0.0 && k < hit) {
                hit = k;
                w->impact = gap_checks_worst_impact(w, row, j, k);
            }
            if (!(gap - asked >= margin)) {
                margin = gap - asked;
                decides = j;
                when = k;
            }
        }
    }
    w->min_margin = margin;
    w->which = decides;
    w->when = when;
    return margin >= 0.0;
}
#define CONFLICTS_BLOCK 8
#define CONFLICTS_SKIPPED 1e-09

/* Place the ego's body at stations ahead on a path; return the number of their blocks. */
static int conflicts_set_blocks(Scene *w, int p, int reach)
{
    int blocks = 0;
    int first = 0;
    for (int i = 0, i_end_ = reach; i < i_end_; i += 1) {
        double at = w->s_0 + i;
        double d = scene_lateral(w, p, at);
        const cca_dddd result1_ = gap_checks_pose(w, at, d, scene_slope(w, p, at));
        w->x_p[i] = result1_.item0;
        w->y_p[i] = result1_.item1;
        w->c_p[i] = result1_.item2;
        w->s_p[i] = result1_.item3;
        if (i == first) {
            w->x_b[blocks] = scene_at_station(w->n, w->x, at + 0.5 * CONFLICTS_BLOCK);
            w->y_b[blocks] = scene_at_station(w->n, w->y, at + 0.5 * CONFLICTS_BLOCK);
            w->r_b[blocks] = 0.0;
        }
        double x = w->x_p[i] - w->x_b[blocks];
        double y = w->y_p[i] - w->y_b[blocks];
        w->r_b[blocks] = real_max(w->r_b[blocks], box_gaps_norm(x, y));
        if (i == first + CONFLICTS_BLOCK - 1) {
            blocks += 1;
            first = i + 1;
        }
    }
    return first == reach ? blocks : blocks + 1;
}

/* Extend the conflict of a vehicle by the stations over which it is at a step. */
static void conflicts_add_conflict(Scene *w, int j, int k, int first, int last, double c, double s,
    double margin)
{
    for (int i = first, i_end_ = last; i < i_end_; i += 1) {
        double at = w->s_0 + i;
        if ((w->s_enter[j] <= at && at <= w->s_exit[j]) && (w->t_enter[j] <= w->t[k] && w->t[k]
            <= w->t_exit[j])) {
            continue;
        }
        double gap = cca_oriented_box_gap(w->x_o[j * w->steps + k] - w->x_p[i], w->y_o[j * w->steps + k]
            - w->y_p[i], w->c_p[i], w->s_p[i], c, s, w->half_length, w->half_width, w->half_l[j],
            w->half_w[j]);
        if (gap < margin) {
            w->s_enter[j] = real_min(w->s_enter[j], at);
            w->s_exit[j] = real_max(w->s_exit[j], at);
            w->t_enter[j] = real_min(w->t_enter[j], w->t[k]);
            w->t_exit[j] = real_max(w->t_exit[j], w->t[k]);
        }
    }
}

/* Find the stations of a path that each crossing vehicle passes over, and when; infinite if none. */
void cca_find_conflicts(Scene *w, int p, int reach, double margin)
{
    int blocks = conflicts_set_blocks(w, p, reach);
    for (int j = 0, j_end_ = w->m; j < j_end_; j += 1) {
        w->s_enter[j] = HUGE_VAL;
        w->s_exit[j] = -HUGE_VAL;
        w->t_enter[j] = HUGE_VAL;
        w->t_exit[j] = -HUGE_VAL;
        if (w->crosses[j] == 0) {
            continue;
        }
        double size = w->half_l[j] + w->half_w[j] + w->half_length + w->half_width + margin;
        for (int b = 0, b_end_ = blocks; b < b_end_; b += 1) {
            double free_until = -HUGE_VAL;
            for (int k = 0, k_end_ = w->steps; k < k_end_; k += 1) {
                if (w->t[k] < free_until) {
                    continue;
                }
                double away = box_gaps_norm(w->x_o[j * w->steps + k] - w->x_b[b], w->y_o[j * w->steps + k]
                    - w->y_b[b]) - w->r_b[b] - size;
                if (away > 0.0) {
                    free_until = w->t[k] + away / real_max(w->v_o[j * w->steps + 0], 0.1) - CONFLICTS_SKIPPED;
                    continue;
                }
                double c = cos(w->psi_o[j * w->steps + k]);
                double s = sin(w->psi_o[j * w->steps + k]);
                conflicts_add_conflict(w, j, k, CONFLICTS_BLOCK * b, int_min(CONFLICTS_BLOCK * b
                    + CONFLICTS_BLOCK, reach), c, s, margin);
            }
        }
    }
}

/* equilibrium_batch.py: Equilibria of a batch of bands between given bounds. */

/* Find the displacement of each band; `stiffness` is that of rate, bending, tension and both contacts. */
void cca_find_equilibria(Equilibrium *e, int bands, int n, bool bounded, const double *stiffness,
    const double *lower, const double *upper, const double *lower_difference, const double *upper_difference,
    double *u, int *solves, int *converged)
{
    e->n = n;
    for (int b = 0, b_end_ = bands; b < b_end_; b += 1) {
        stiffness_set_stiffness(e, stiffness[b * 5 + 0], stiffness[b * 5 + 1], stiffness[b * 5 + 2],
            stiffness[b * 5 + 3], stiffness[b * 5 + 4]);
        e->bounded = bounded;
        e->solves = 0;
        for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
            e->lower[i] = lower[b * n + i];
            e->upper[i] = upper[b * n + i];
            e->lower_difference[i] = lower_difference[b * n + i];
            e->upper_difference[i] = upper_difference[b * n + i];
        }
        bool done = equilibrium_find_equilibrium(e, false);
        for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
            u[b * n + i] = e->u[i];
        }
        solves[b] = e->solves;
        converged[b] = done ? 1 : 0;
    }
}

/* obstacles.py: Obstacles of a band: which vehicles the ego meets, when it is alongside them, and their
    boxes. */
#define OBSTACLES_ON_ROUTE (-1)
#define OBSTACLES_AWAY (-2)
#define OBSTACLES_SPARE 0.5
#define OBSTACLES_NEAR 2.0

/* Find the step at which a motion along the route meets each vehicle ahead of `rear`. */
void cca_find_meetings(Scene *w, int row, double rear)
{
    for (int j = 0, j_end_ = w->m; j < j_end_; j += 1) {
        w->met[j] = OBSTACLES_AWAY;
        if (w->crosses[j] != 0 || w->assumed[j] != 0 || !(w->s_o[j * w->steps + 0] + w->half_l[j] > rear)) {
            continue;
        }
        double across = w->half_w[j] + w->half_width + w->blocking_gap;
        double along = w->half_l[j] + w->half_length + OBSTACLES_SPARE;
        if (fabs(w->d_o[j * w->steps + 0]) < across) {
            w->met[j] = OBSTACLES_ON_ROUTE;
        }
        for (int k = 0, k_end_ = w->steps; k < k_end_; k += 1) {
            if (fabs(w->d_o[j * w->steps + k]) < across && fabs(w->s_o[j * w->steps + k] - (w->s[row
                * w->steps + k] + w->offset)) < along) {
                w->met[j] = k;
                break;
            }
        }
    }
}

/* Length by which the ego is alongside a vehicle at a step, negative if it is not. */
static double obstacles_overlap(const Scene *w, int row, int j, int k, double reach, double lead)
{
    double center = w->s[row * w->steps + k] + w->offset;
    return real_min(w->high_passed[j * w->steps + k] - center + reach, center + reach - w->low_passed[j
        * w->steps + k] + lead);
}

/* Stations between which the ego is alongside a vehicle, and its speed at the first. */
static cca_ddd obstacles_span(const Scene *w, int row, int j, double reach, double lead)
{
    int first = -1;
    int last = -1;
    for (int k = 0, k_end_ = w->steps; k < k_end_; k += 1) {
        if (obstacles_overlap(w, row, j, k, reach, lead) >= 0.0) {
            last = k;
            if (first < 0) {
                first = k;
            }
        }
    }
    if (first < 0) {
        return (cca_ddd){HUGE_VAL, HUGE_VAL, 0.0};
    }
    double begin = w->s[row * w->steps + first];
    double v = w->v[row * w->steps + first];
    if (first > 0) {
        double depth = obstacles_overlap(w, row, j, first, reach, lead);
        double f = depth / (depth - obstacles_overlap(w, row, j, first - 1, reach, lead));
        begin -= (w->s[row * w->steps + first] - w->s[row * w->steps + first - 1]) * f;
        v -= (w->v[row * w->steps + first] - w->v[row * w->steps + first - 1]) * f;
    }
    if (last == w->steps - 1) {
        return (cca_ddd){begin, HUGE_VAL, v};
    }
    double depth = obstacles_overlap(w, row, j, last, reach, lead);
    double f = depth / (depth - obstacles_overlap(w, row, j, last + 1, reach, lead));
    return (cca_ddd){begin, w->s[row * w->steps + last] + (w->s[row * w->steps + last + 1] - w->s[row
        * w->steps + last]) * f, v};
}

/* Stations between which the ego is alongside a vehicle in its worst case, and the lead before that. */
cca_ddd cca_find_span(const Scene *w, int row, int j, double clearance, double ttc)
{
    double reach = w->half_length + clearance;
    const cca_ddd result1_ = obstacles_span(w, row, j, reach, 0.0);
    double begin = result1_.item0;
    double end = result1_.item1;
    double v = result1_.item2;
    double lead = begin < HUGE_VAL ? ttc * real_max(v - w->seen[j * 27 + TRAFFIC_SPEED], 0.0) : 0.0;
    const cca_ddd result2_ = obstacles_span(w, row, j, reach, lead);
    begin = result2_.item0;
    end = result2_.item1;
    v = result2_.item2;
    return (cca_ddd){begin, end, lead};
}

/* Step before a time, from an earlier one on. */
static int obstacles_step_at(const Scene *w, double t, int k)
{
    int step = k;
    for (int turn1_ = 0, turn1__end_ = w->steps; turn1_ < turn1__end_; turn1_ += 1) {
        if (step + 2 >= w->steps || !(w->t[step + 1] <= t)) {
            break;
        }
        step += 1;
    }
    return step;
}

/* Whether a vehicle is in the ego lane near where the ego is at some station. */
static bool obstacles_is_obstacle(const Scene *w, double base, int n, const double *s, const double *t,
    int j, double rear)
{
    if (w->crosses[j] != 0 || w->assumed[j] != 0 || !(w->seen[j * 27 + TRAFFIC_S] + w->seen[j * 27
        + TRAFFIC_HALF_L] >= rear)) {
        return false;
    }
    double d = w->seen[j * 27 + TRAFFIC_D];
    if (!(d - w->seen[j * 27 + TRAFFIC_HALF_W] <= w->lane_left && d + w->seen[j * 27 + TRAFFIC_HALF_W]
        >= w->lane_right)) {
        return false;
    }
    int k = 0;
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        k = obstacles_step_at(w, t[i], k);
        double f = real_min(real_max((t[i] - w->t[k]) / (w->t[k + 1] - w->t[k]), 0.0), 1.0);
        double at = base + w->s_o[j * w->steps + k] + f * (w->s_o[j * w->steps + k + 1] - w->s_o[j
            * w->steps + k]);
        if (fabs(at - s[i]) <= w->half_l[j] + 2.0 * w->half_length + OBSTACLES_NEAR) {
            return true;
        }
    }
    return false;
}

/* Boxes of a group in its worst case, and nominally of the others near the stations; their number. */
int cca_find_obstacles(const Scene *w, const Curve *curve, double base, int n, const double *s,
    const double *t, double rear, int group, int vehicles, int *rows, double *boxes)
{
    int count = group;
    for (int j = 0, j_end_ = w->m; j < j_end_; j += 1) {
        bool grouped = false;
        for (int i = 0, i_end_ = group; i < i_end_; i += 1) {
            grouped = grouped || rows[i] == j;
        }
        if (!grouped && count < vehicles && obstacles_is_obstacle(w, base, n, s, t, j, rear)) {
            rows[count] = j;
            count += 1;
        }
    }
    for (int c = 0, c_end_ = count; c < c_end_; c += 1) {
        int j = rows[c];
        int k = 0;
        for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
            k = obstacles_step_at(w, t[i], k);
            double f = real_min(real_max((t[i] - w->t[k]) / (w->t[k + 1] - w->t[k]), 0.0), 1.0);
            double at = w->s_o[j * w->steps + k] + f * (w->s_o[j * w->steps + k + 1] - w->s_o[j * w->steps
                + k]);
            double low = at - w->half_l[j];
            double high = at + w->half_l[j];
            if (c < group) {
                low = w->low_passed[j * w->steps + k] + f * (w->low_passed[j * w->steps + k + 1]
                    - w->low_passed[j * w->steps + k]);
                high = w->high_passed[j * w->steps + k] + f * (w->high_passed[j * w->steps + k + 1]
                    - w->high_passed[j * w->steps + k]);
            }
            double d = w->d_o[j * w->steps + k] + f * (w->d_o[j * w->steps + k + 1] - w->d_o[j * w->steps
                + k]);
            int box = c * n + i;
            const cca_ddddd result1_ = reach_occupancy_box(curve, s[i], base + low, base + high, d,
                w->half_w[j]);
            boxes[box * 5 + 0] = result1_.item0;
            boxes[box * 5 + 1] = result1_.item1;
            boxes[box * 5 + 2] = result1_.item2;
            boxes[box * 5 + 3] = result1_.item3;
            boxes[box * 5 + 4] = result1_.item4;
        }
    }
    return count;
}

/* rss.py: Safe distances of responsibility-sensitive safety (RSS). */

/* Distance of a vehicle that accelerates for its response time, up to v_max, and then brakes. */
static double rss_stopping_distance(double v, const RssReaction *reaction, double braking)
{
    double rho = reaction->response_time;
    double a = reaction->a_max;
    double top = real_max(v, real_min(v + rho * a, reaction->v_max));
    double lost = a > 0.0 ? rho - (top - v) / a : 0.0;
    return 0.5 * (v + top) * (rho - lost) + top * lost + top * top / (2.0 * braking);
}

/* Lateral distance of a vehicle that accelerates toward the other and then brakes. */
static double rss_lateral_shift(double v, const RssReaction *reaction)
{
    double rho = reaction->response_time;
    double after = v + rho * reaction->a_lateral;
    double moving = real_max(after, 0.0);
    return 0.5 * (v + after) * rho + moving * moving / (2.0 * reaction->b_lateral);
}

/* Safe distances behind vehicles that may brake fully. */
void cca_same_direction_distances(int n, const double *v_rear, const double *v_front, const RssReaction
    *rear, const RssReaction *front, double *distance)
{
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        double apart = rss_stopping_distance(v_rear[i], rear, rear->b_min) - v_front[i] * v_front[i]
            / (2.0 * front->b_max);
        distance[i] = real_max(apart, 0.0) + rear->standstill_gap;
    }
}

/* Safe distances between vehicles that approach each other. */
void cca_opposite_distances(int n, const double *v_correct, const double *v_opposite, const RssReaction
    *correct, const RssReaction *opposite, double *distance)
{
    double gap = real_max(correct->standstill_gap, opposite->standstill_gap);
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        double first = rss_stopping_distance(fabs(v_correct[i]), correct, correct->b_correct);
        distance[i] = first + rss_stopping_distance(fabs(v_opposite[i]), opposite, opposite->b_min) + gap;
    }
}

/* Safe lateral distances between vehicles alongside each other. */
void cca_lateral_distances(int n, const double *v_left, const double *v_right, const RssReaction *left,
    const RssReaction *right, double *distance)
{
    double margin = 0.5 * (left->fluctuation + right->fluctuation);
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        double apart = rss_lateral_shift(-v_left[i], left) + rss_lateral_shift(v_right[i], right);
        distance[i] = real_max(apart + margin, 0.0);
    }
}

/* single_track.py: A single-track car on tires that can slide, integrated by the classical Runge-Kutta
    scheme. */
#define SINGLE_TRACK_MIN_SLIP_SPEED 1.0
#define SINGLE_TRACK_SLOW 5.0
#define SINGLE_TRACK_MAX_STEP 0.01
#define SINGLE_TRACK_MAX_STEPS 1000
#define SINGLE_TRACK_MAX_GRIP 0.99
#define SINGLE_TRACK_MIN_SIDE 0.1
#define SINGLE_TRACK_SMALLEST_SPEED 1e-06

/* Side force for the tangent of the slip angle [N]. */
double cca_fiala_force(double stiffness, double slip, double f_max)
{
    double z = stiffness * slip / f_max;
    if (z >= 3.0 || z <= -3.0) {
        return -copysign(f_max, z);
    }
    return -f_max * z * (1.0 - fabs(z) / 3.0 + z * z / 27.0);
}

/* Rates of change of the eight states; they do not depend on the position. */
static cca_dddddddd single_track_rates(const SingleTrackCar *car, double psi, double v_x, double v_y,
    double r, double angle, double force, double delta, double a_x)
{
    double grip = car->mu * CONSTANTS_GRAVITY;
    double front = car->l_r / (car->l_f + car->l_r);
    double hardest = SINGLE_TRACK_MAX_GRIP * grip;
    double rate = real_min(real_max((delta - angle) / car->steering_lag, -car->delta_rate_max),
        car->delta_rate_max);
    double drive_rate = (real_min(real_max(a_x, -hardest), hardest) - force) / car->drive_lag;
    double c = cos(psi);
    double s = sin(psi);
    if (v_x < SINGLE_TRACK_MIN_SLIP_SPEED) {
        return (cca_dddddddd){v_x * c - v_y * s, v_x * s + v_y * c, r, force, 0.0, 0.0, rate, drive_rate};
    }
    double side = sqrt(real_max(grip * grip - force * force, SINGLE_TRACK_MIN_SIDE * grip
        * (SINGLE_TRACK_MIN_SIDE * grip)));
    double c_d = cos(angle);
    double s_d = sin(angle);
    double v_f = v_y + car->l_f * r;
    double v_r = v_y - car->l_r * r;
    double slip = (v_f * c_d - v_x * s_d) / real_max(fabs(v_x * c_d + v_f * s_d),
        SINGLE_TRACK_SMALLEST_SPEED);
    double f_f = cca_fiala_force(car->c_f, slip, car->m * car->l_r / (car->l_f + car->l_r) * side);
    double f_r = cca_fiala_force(car->c_r, v_r / v_x, car->m * car->l_f / (car->l_f + car->l_r) * side);
    double pull = car->m * front * force;
    double front_x = pull * c_d - f_f * s_d;
    double front_y = pull * s_d + f_f * c_d;
    return (cca_dddddddd){v_x * c - v_y * s, v_x * s + v_y * c, r, force * (1.0 - front) + front_x
        / car->m + v_y * r, (front_y + f_r) / car->m - v_x * r, (car->l_f * front_y - car->l_r * f_r)
        / car->inertia, rate, drive_rate};
}

/* Remove slip and reversing at low speed. */
static void single_track_roll(SingleTrackCar *car)
{
    car->v_x = real_max(car->v_x, 0.0);
    if (car->v_x == 0.0) {
        car->a_x = real_max(car->a_x, 0.0);
    }
    car->r = car->v_x * tan(car->delta) / (car->l_f + car->l_r);
    car->v_y = car->l_r * car->r;
}

/* Advance by one step of the integration. */
static void single_track_runge_kutta(SingleTrackCar *car, double delta, double a_x, double h)
{
    double psi = car->psi;
    double v = car->v_x;
    double w = car->v_y;
    double r = car->r;
    double angle = car->delta;
    double force = car->a_x;
    double m = 0.5 * h;
    const cca_dddddddd result1_ = single_track_rates(car, psi, v, w, r, angle, force, delta, a_x);
    double ax = result1_.item0;
    double ay = result1_.item1;
    double ap = result1_.item2;
    double av = result1_.item3;
    double aw = result1_.item4;
    double ar = result1_.item5;
    double aa = result1_.item6;
    double af = result1_.item7;
    const cca_dddddddd result2_ = single_track_rates(car, psi + m * ap, v + m * av, w + m * aw, r + m
        * ar, angle + m * aa, force + m * af, delta, a_x);
    double bx = result2_.item0;
    double by = result2_.item1;
    double bp = result2_.item2;
    double bv = result2_.item3;
    double bw = result2_.item4;
    double br = result2_.item5;
    double ba = result2_.item6;
    double bf = result2_.item7;
    const cca_dddddddd result3_ = single_track_rates(car, psi + m * bp, v + m * bv, w + m * bw, r + m
        * br, angle + m * ba, force + m * bf, delta, a_x);
    double cx = result3_.item0;
    double cy = result3_.item1;
    double cp = result3_.item2;
    double cv = result3_.item3;
    double cw = result3_.item4;
    double cr = result3_.item5;
    double ca = result3_.item6;
    double cf = result3_.item7;
    const cca_dddddddd result4_ = single_track_rates(car, psi + h * cp, v + h * cv, w + h * cw, r + h
        * cr, angle + h * ca, force + h * cf, delta, a_x);
    double dx = result4_.item0;
    double dy = result4_.item1;
    double dp = result4_.item2;
    double dv = result4_.item3;
    double dw = result4_.item4;
    double dr = result4_.item5;
    double da = result4_.item6;
    double df = result4_.item7;
    double sixth = h / 6.0;
    car->x += sixth * (ax + 2.0 * bx + 2.0 * cx + dx);
    car->y += sixth * (ay + 2.0 * by + 2.0 * cy + dy);
    car->psi = psi + sixth * (ap + 2.0 * bp + 2.0 * cp + dp);
    car->v_x = v + sixth * (av + 2.0 * bv + 2.0 * cv + dv);
    car->v_y = w + sixth * (aw + 2.0 * bw + 2.0 * cw + dw);
    car->r = r + sixth * (ar + 2.0 * br + 2.0 * cr + dr);
    car->delta = angle + sixth * (aa + 2.0 * ba + 2.0 * ca + da);
    car->a_x = force + sixth * (af + 2.0 * bf + 2.0 * cf + df);
}

/* Advance a moving car by a time step with a commanded angle and acceleration. */
void cca_drive(SingleTrackCar *car, double delta, double a_x, double dt)
{
    double step = car->v_x > SINGLE_TRACK_SLOW ? SINGLE_TRACK_MAX_STEP : 0.5 * SINGLE_TRACK_MAX_STEP;
    int n = 1;
    for (int turn1_ = 0, turn1__end_ = SINGLE_TRACK_MAX_STEPS; turn1_ < turn1__end_; turn1_ += 1) {
        if (n >= dt / step - 1e-09) {
            break;
        }
        n += 1;
    }
    for (int turn1_ = 0, turn1__end_ = n; turn1_ < turn1__end_; turn1_ += 1) {
        single_track_runge_kutta(car, delta, a_x, dt / n);
        if (car->v_x < SINGLE_TRACK_MIN_SLIP_SPEED) {
            single_track_roll(car);
        }
    }
    const cca_dddddddd result1_ = single_track_rates(car, car->psi, car->v_x, car->v_y, car->r,
        car->delta, car->a_x, delta, a_x);
    double v_y_dot = result1_.item4;
    car->a_y = v_y_dot + car->v_x * car->r;
}

/* speed.py: Speeds along a path, and times of arrival. */
#define SPEED_STRAIGHT 1e-09
#define SPEED_LOOKAHEAD 2.0

/* Time for a distance at a constant acceleration that is not zero [s]. */
static double speed_ramp_time(double v, double a, double distance)
{
    return (sqrt(real_max(v * v + 2.0 * a * distance, 0.0)) - v) / a;
}

/* Compute when points ahead are reached if the target speed is approached freely. */
void cca_arrival_times(int n, double v_x, double v_target, const double *distance, double a_max,
    double b_comfort, double *t)
{
    double v = real_max(v_x, CONSTANTS_STANDSTILL_SPEED);
    double target = real_max(v_target, CONSTANTS_STANDSTILL_SPEED);
    double a = target > v ? a_max : -b_comfort;
    double ramp = (target * target - v * v) / (2.0 * a);
    double t_ramp = speed_ramp_time(v, a, ramp);
    double unknown = isnan(ramp) ? ramp : 0.0;
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        if (distance[i] >= ramp) {
            t[i] = t_ramp + (distance[i] - ramp) / target;
        } else if (distance[i] > 0.0) {
            t[i] = speed_ramp_time(v, a, distance[i]) + unknown;
        } else {
            t[i] = distance[i] / v + unknown;
        }
    }
}

/* Squares of the highest speeds at stations, with standstill at the last one. */
void cca_squared_speed_limits(const Curve *curve, int n, double cruise, double a_y, double b_comfort,
    const double *s, double *squared)
{
    squared[n - 1] = 0.0;
    for (int i = n - 2, i_end_ = -1; i > i_end_; i -= 1) {
        double bend = real_max(fabs(cca_curvature_at(curve, s[i])), SPEED_STRAIGHT);
        double here = real_min(cruise * cruise, a_y / bend);
        squared[i] = real_min(here, squared[i + 1] + 2.0 * b_comfort * (s[i + 1] - s[i]));
    }
}

/* Value at a station, linear between the given ones and constant beyond. */
double cca_interpolated(int n, const double *at, const double *value, double s)
{
    if (isnan(s)) {
        return s;
    }
    int low = 0;
    int high = n;
    for (int turn1_ = 0; turn1_ < 32; turn1_ += 1) {
        if (low >= high) {
            break;
        }
        int middle = int_floor(low + high, 2);
        if (at[middle] <= s) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    if (low == 0) {
        return value[0];
    }
    if (low == n) {
        return value[n - 1];
    }
    double fraction = (s - at[low - 1]) / (at[low] - at[low - 1]);
    return value[low - 1] + fraction * (value[low] - value[low - 1]);
}

/* Acceleration along a speed profile, with its slope as feedforward. */
double cca_profile_acceleration(int n, const double *at, const double *squared, double s, double v_x,
    double a_max, double b_comfort, double b_max)
{
    double horizon = SPEED_LOOKAHEAD + real_max(v_x, 0.0);
    double here = real_max(cca_interpolated(n, at, squared, s), 0.0);
    double there = cca_interpolated(n, at, squared, s + horizon);
    double ahead = (there - v_x * v_x) / (2.0 * horizon);
    double cruise = real_min(real_max(sqrt(here) - v_x, -b_comfort), a_max);
    return real_min(cruise, real_max(ahead, -b_max));
}

/* steering.py: Preview steering: the single-track model inverted along a path, and PD control of the
    error ahead. */
#define STEERING_ROLLING_SPEED 3.0
#define STEERING_INTEGRAL_TIME 3.0
#define STEERING_INTEGRAL_LIMIT 0.02
#define STEERING_SMALL_OFFSET 0.1
#define STEERING_SIDESLIP_FRACTION 0.3
#define STEERING_MAX_STEP 0.005
#define STEERING_MAX_STEPS 1000
#define STEERING_MAX_CYCLE 5.0
#define STEERING_MAX_MOTION 100.0
#define STEERING_MAX_FRACTION 0.97
#define STEERING_MAX_GRIP 0.8
#define STEERING_MAX_JUMP 20.0
#define STEERING_TRACE 1024

/* Side force of the rear axle from its slip angle. */
static double steering_rear_force(const IdealCar *car, double v)
{
    double grip = car->mu * CONSTANTS_GRAVITY * car->m * car->l_f / (car->l_f + car->l_r);
    double z = -car->c_r * (car->v_y - car->l_r * car->r) / (v * grip);
    z = real_min(real_max(z, -3.0), 3.0);
    return grip * z * (1.0 - fabs(z) / 3.0 + z * z / 27.0);
}

/* Slip angle at which the front tires carry a fraction of their grip. */
double cca_front_slip(const IdealCar *car, double fraction)
{
    double grip = car->mu * CONSTANTS_GRAVITY * car->m * car->l_r / (car->l_f + car->l_r);
    double limited = real_min(real_max(fraction, -STEERING_MAX_FRACTION), STEERING_MAX_FRACTION);
    double slip = 3.0 * (1.0 - pow(1.0 - fabs(limited), 1.0 / 3.0)) * grip / car->c_f;
    return copysign(atan(slip), limited);
}

/* Integrate the zero dynamics over a cycle, while the curvature changes linearly. */
static void steering_integrate(IdealCar *car, double kappa, double v, double dt)
{
    int n = 1;
    for (int turn1_ = 0, turn1__end_ = STEERING_MAX_STEPS; turn1_ < turn1__end_; turn1_ += 1) {
        if (n >= dt / STEERING_MAX_STEP - 1e-09) {
            break;
        }
        n += 1;
    }
    double h = dt / n;
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        double a_y = v * v * (car->kappa + (i + 0.5) / n * (kappa - car->kappa));
        double r_dot = (car->l_f * car->m * a_y - (car->l_f + car->l_r) * steering_rear_force(car, v))
            / car->inertia;
        double v_y_dot = a_y - v * car->r;
        car->r += h * r_dot;
        car->v_y += h * v_y_dot;
    }
}

/* Set the states to the steady turn of a curvature. */
static void steering_start_steady(IdealCar *car, double kappa, double v)
{
    car->first = 0;
    car->count = 0;
    car->r = v * kappa;
    double rolling = v < STEERING_ROLLING_SPEED ? 0.0 : car->l_f * car->m * v * v / (car->c_r * (car->l_f
        + car->l_r));
    car->v_y = v * kappa * (car->l_r - rolling);
    if (!(fabs(car->r) + fabs(car->v_y) < STEERING_MAX_MOTION)) {
        car->r = 0.0;
        car->v_y = 0.0;
    }
}

/* Where entry i of the trace lies in its ring. */
static int steering_ring_index(const IdealCar *car, int i)
{
    int at = car->first + i;
    return at >= STEERING_TRACE ? at - STEERING_TRACE : at;
}

/* Move the ideal car along the path; return the steering angle that it needs there.

An input that is no number is dropped: the car stays, and the last angle is held. */
double cca_advance(IdealCar *car, double s, double kappa, double v_x, double dt)
{
    double size = fabs(s) + fabs(kappa) + fabs(v_x) + fabs(dt);
    bool finite = size < HUGE_VAL;
    car->held = !finite;
    if (!finite) {
        return car->delta;
    }
    double v = real_max(v_x, 0.0);
    bool follows = car->started && fabs(s - car->s) <= STEERING_MAX_JUMP && (0.0 <= dt && dt
        <= STEERING_MAX_CYCLE);
    if (follows && v >= STEERING_ROLLING_SPEED) {
        steering_integrate(car, kappa, v, dt);
    } else {
        steering_start_steady(car, kappa, v);
    }
    if (!(fabs(car->r) + fabs(car->v_y) < STEERING_MAX_MOTION)) {
        steering_start_steady(car, kappa, v);
    }
    car->started = true;
    car->s = s;
    car->kappa = kappa;
    if (car->count == STEERING_TRACE) {
        car->first = steering_ring_index(car, 1);
        car->count -= 1;
    }
    int last = steering_ring_index(car, car->count);
    car->trace_s[last] = s;
    car->trace_beta[last] = atan2(car->v_y, real_max(v, 0.1));
    car->trace_r[last] = car->r;
    car->count += 1;
    double delta = atan((car->l_f + car->l_r) * kappa);
    if (v >= STEERING_ROLLING_SPEED) {
        double rest = car->m * v * v * kappa - steering_rear_force(car, v);
        double grip = car->mu * CONSTANTS_GRAVITY * car->m * car->l_r / (car->l_f + car->l_r);
        delta = atan2(car->v_y + car->l_f * car->r, v) + cca_front_slip(car, rest / grip);
    }
    if (!(fabs(delta) < HUGE_VAL)) {
        car->held = true;
        return car->delta;
    }
    car->delta = delta;
    return delta;
}

/* Sideslip and yaw rate of the ideal car at a station that it has passed; older ones are dropped. */
cca_dd cca_find_passed(IdealCar *car, double s)
{
    for (int turn1_ = 0, turn1__end_ = STEERING_TRACE; turn1_ < turn1__end_; turn1_ += 1) {
        if (car->count < 2 || !(car->trace_s[steering_ring_index(car, 1)] <= s)) {
            break;
        }
        car->first = steering_ring_index(car, 1);
        car->count -= 1;
    }
    int a = steering_ring_index(car, 0);
    int b = steering_ring_index(car, 1);
    double beta = car->trace_beta[a];
    double r = car->trace_r[a];
    if (car->count > 1 && s > car->trace_s[a]) {
        double fraction = (s - car->trace_s[a]) / (car->trace_s[b] - car->trace_s[a]);
        beta += fraction * (car->trace_beta[b] - beta);
        r += fraction * (car->trace_r[b] - r);
    }
    return (cca_dd){beta, r};
}

/* Gain between two grid speeds. */
static double steering_gain_at(const double *gains, int i, double fraction)
{
    return fraction == 0.0 ? gains[i] : gains[i] + fraction * (gains[i + 1] - gains[i]);
}

/* Steering angle within the limits of lateral acceleration, angle and rate. */
static double steering_limited(const Steering *law, const IdealCar *car, double target, double v_x,
    double v_y, double r, double dt)
{
    double v = real_max(v_x, 1.0);
    double reach = car->l_f + car->l_r + real_max(law->understeer, 0.0) * v * v;
    double steady = atan(reach * law->a_y_max / (v * v));
    double motion = atan2(v_y + car->l_f * r, v);
    double slip = cca_front_slip(car, real_min(law->a_y_max / (car->mu * CONSTANTS_GRAVITY),
        STEERING_MAX_GRIP));
    double low = real_max(real_min(-steady, motion - slip), -law->delta_max);
    double high = real_min(real_max(steady, motion + slip), law->delta_max);
    double delta = real_min(real_max(target, low), high);
    if (!(-law->delta_max <= delta && delta <= law->delta_max)) {
        delta = law->delta;
    }
    if (law->started) {
        double step = law->delta_rate_max * real_max(0.0, dt);
        delta = real_min(real_max(delta, law->delta - step), law->delta + step);
    }
    return delta;
}

/* Road-wheel angle for this cycle; `law.s` becomes the station of the vehicle. */
double cca_steer(Steering *law, IdealCar *car, const Curve *curve, double s_guess, double x, double y,
    double psi, double v_x, double v_y, double r, double dt)
{
    double v = real_max(v_x, 0.0);
    const cca_dddd result1_ = cca_foot_point(curve, x, y, s_guess);
    double s = result1_.item0;
    double d = result1_.item1;
    double heading = result1_.item2;
    double kappa = result1_.item3;
    law->s = s;
    double at = s + v * (law->delay + law->steering_lag);
    double feedforward = cca_advance(car, at, cca_curvature_at(curve, at), v, dt);
    const cca_dd result2_ = cca_find_passed(car, s);
    double beta = result2_.item0;
    double passed_r = result2_.item1;
    if (v > STEERING_ROLLING_SPEED) {
        beta += STEERING_SIDESLIP_FRACTION * (atan2(v_y, v) - beta);
    }
    int i = 0;
    for (int k = 1, k_end_ = law->count; k < k_end_; k += 1) {
        if (law->speeds[k] <= v) {
            i = k;
        }
    }
    double fraction = 0.0;
    if (i < law->count - 1 && v > law->speeds[i]) {
        fraction = (v - law->speeds[i]) / (law->speeds[i + 1] - law->speeds[i]);
    }
    double k_p = steering_gain_at(law->k_p, i, fraction);
    double k_d = steering_gain_at(law->k_d, i, fraction);
    double l_s = steering_gain_at(law->l_s, i, fraction);
    double e_psi = remainder(psi - heading, 2.0 * 3.141592653589793);
    if (e_psi >= 3.141592653589793) {
        e_psi = -3.141592653589793;
    }
    double sine = sin(e_psi);
    double error = d + l_s * (sine + sin(beta));
    if (law->ahead) {
        const cca_dddd result3_ = cca_foot_point(curve, x + l_s * cos(psi), y + l_s * sin(psi), s + l_s);
        double d_ahead = result3_.item1;
        error = d_ahead + l_s * sin(beta) + 0.5 * kappa * l_s * l_s;
    }
    double rate = v * sine + v_y * cos(e_psi) + l_s * (r - passed_r);
    double target = feedforward - k_p * error - k_d * rate - law->integral;
    double delta = steering_limited(law, car, target, v_x, v_y, r, dt);
    bool small = fabs(d) < STEERING_SMALL_OFFSET && (0.0 <= dt && dt <= STEERING_MAX_CYCLE);
    if (delta == target && small && v > 1.0) {
        law->integral = real_min(real_max(law->integral + k_p * d * dt / STEERING_INTEGRAL_TIME,
            -STEERING_INTEGRAL_LIMIT), STEERING_INTEGRAL_LIMIT);
    }
    law->delta = delta;
    law->started = true;
    return delta;
}
