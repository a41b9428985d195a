/* Made from the Python of cca_core/kernel by `make kernel`: edit that. */
#include "kernel.h"

#include <math.h>

/* as Python's max and min: the first of equals, and the first if the second is not a number */
static inline double real_max(double a, double b) { return b > a ? b : a; }
static inline double real_min(double a, double b) { return b < a ? b : a; }
static inline int int_max(int a, int b) { return b > a ? b : a; }
static inline int int_min(int a, int b) { return b < a ? b : a; }

/* as Python's // and % of a positive number: rounded down */
static inline int int_quotient(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }
static inline int int_rest(int a, int b) { return a - b * int_quotient(a, b); }

/* as cca_core.kernel.types.floor_within */
static inline int floor_within(double value, int low, int high)
{
    if (!(value >= low)) {
        return low;
    }
    return value >= high ? high : (int)floor(value);
}

/* box_gaps.py: Distances of oriented boxes. */

/* Length of a vector; `math.hypot` has other bits in Python than in C. */
static double box_gaps_norm(double x, double y)
{
    return sqrt(x * x + y * y);
}

/* Squared distance of a point from a box around the origin. */
static double box_gaps_squared_distance(double x, double y, double half_length, double half_width)
{
    double dx = real_max(fabs(x) - half_length, 0.0);
    double dy = real_max(fabs(y) - half_width, 0.0);
    return dx * dx + dy * dy;
}

/* Smallest squared distance of the corners of a turned box at x, y from a box around the origin. */
static double box_gaps_nearest_corner(double x, double y, double c, double s, double length, double width,
    double own_length, double own_width)
{
    double ax = c * length - s * width;
    double ay = s * length + c * width;
    double bx = c * length + s * width;
    double by = s * length - c * width;
    return real_min(real_min(real_min(box_gaps_squared_distance(x + ax, y + ay, own_length, own_width),
        box_gaps_squared_distance(x - ax, y - ay, own_length, own_width)), box_gaps_squared_distance(x + bx, y
        + by, own_length, own_width)), box_gaps_squared_distance(x - bx, y - by, own_length, own_width));
}

/* Signed distance of box b, at dx, dy from box a, from unit headings and half extents [m]. */
double cca_oriented_box_gap(double dx, double dy, double ax, double ay, double bx, double by, double length_a,
    double width_a, double length_b, double width_b)
{
    double turn_c = bx * ax + by * ay;
    double turn_s = by * ax - bx * ay;
    double c = fabs(turn_c);
    double s = fabs(turn_s);
    double x_b = dx * ax + dy * ay;
    double y_b = dy * ax - dx * ay;
    double x_a = -(dx * bx + dy * by);
    double y_a = -(dy * bx - dx * by);
    double separation = real_max(real_max(real_max(fabs(x_b) - length_a - (length_b * c + width_b * s),
        fabs(y_b) - width_a - (length_b * s + width_b * c)), fabs(x_a) - length_b - (length_a * c + width_a *
        s)), fabs(y_a) - width_b - (length_a * s + width_a * c));
    if (separation <= 0.0) {
        return separation;
    }
    double of_b = box_gaps_nearest_corner(x_b, y_b, turn_c, turn_s, length_b, width_b, length_a, width_a);
    double of_a = box_gaps_nearest_corner(x_a, y_a, turn_c, -turn_s, length_a, width_a, length_b, width_b);
    return sqrt(real_min(of_b, of_a));
}

/* Gaps of n pairs of parallel boxes from center offsets and summed half extents, and the smallest [m]. */
double cca_aligned_box_gaps(int n, const double *dx, const double *dy, double length, double width, double
    *gap)
{
    double smallest = INFINITY;
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        double along = fabs(dx[i]) - length;
        double across = fabs(dy[i]) - width;
        if (along > 0.0 && across > 0.0) {
            gap[i] = box_gaps_norm(along, across);
        } else {
            gap[i] = real_max(along, across);
        }
        smallest = real_min(smallest, gap[i]);
    }
    return smallest;
}
