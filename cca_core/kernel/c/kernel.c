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
    double along_a = fabs(x_b) - length_a - (length_b * c + width_b * s);
    double across_a = fabs(y_b) - width_a - (length_b * s + width_b * c);
    double along_b = fabs(x_a) - length_b - (length_a * c + width_a * s);
    double across_b = fabs(y_a) - width_b - (length_a * s + width_a * c);
    double separation = real_max(real_max(real_max(along_a, across_a), along_b), across_b);
    if (!isfinite(along_a + across_a + along_b + across_b)) {
        return along_a + across_a + along_b + across_b;
    }
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
    double smallest = HUGE_VAL;
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

/* Signed distance of two boxes from centers, headings and full extents [m]; NaN if one is not finite. */
double cca_box_gap(double ax, double ay, double a_psi, double a_length, double a_width, double bx, double by,
    double b_psi, double b_length, double b_width)
{
    double headings = 0.0 * a_psi + 0.0 * b_psi;
    if (isnan(headings)) {
        return headings;
    }
    return cca_oriented_box_gap(bx - ax, by - ay, cos(a_psi), sin(a_psi), cos(b_psi), sin(b_psi), 0.5 *
        a_length, 0.5 * a_width, 0.5 * b_length, 0.5 * b_width);
}

/* Signed distances of n boxes b from k boxes a, which repeat: x, y, heading, length, width of each. */
void cca_box_gaps(int n, int k, const double *a, const double *b, double *gap)
{
    int j = 0;
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        gap[i] = cca_box_gap(a[j * 5 + 0], a[j * 5 + 1], a[j * 5 + 2], a[j * 5 + 3], a[j * 5 + 4], b[i * 5 +
            0], b[i * 5 + 1], b[i * 5 + 2], b[i * 5 + 3], b[i * 5 + 4]);
        j += 1;
        if (j == k) {
            j = 0;
        }
    }
}

/* constants.py: Quantities of which kernels and the rest of the library use one value. */
#define CONSTANTS_GRAVITY 9.81
#define CONSTANTS_STALE_AGE 1.0
#define CONSTANTS_STANDSTILL_SPEED 0.5

/* curve.py: A path of cubics over arc length, straight beyond both ends, and foot points of positions on it.
    */
#define CURVE_MAX_ITERATIONS 12
#define CURVE_STEP_TOLERANCE 1e-09
#define CURVE_BISECTIONS 50
#define CURVE_SMALLEST_SPEED 1e-90
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
        return (cca_dddddd){x, y, dx, dy, 6.0 * powers[i * 8 + 0] * t + 2.0 * powers[i * 8 + 2], 6.0 *
            powers[i * 8 + 1] * t + 2.0 * powers[i * 8 + 3]};
    }
    return (cca_dddddd){x + (s - on) * dx, y + (s - on) * dy, dx, dy, 0.0, 0.0};
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
static cca_dd curve_foot_point_at_sample(const Curve *curve, const CurveSamples *samples, double x, double y,
    int i)
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

/* First sample after another one, by at least a length of the curve; one past the last if none is. */
static int curve_sample_after(const CurveSamples *samples, int i, double excess)
{
    double s = samples->s[i] + excess / samples->max_speed;
    int low = i + 1;
    int high = samples->count;
    for (int turn1_ = 0, turn1__end_ = CURVE_MAX_HALVINGS; turn1_ < turn1__end_; turn1_ += 1) {
        if (low >= high || samples->s[low] >= s) {
            break;
        }
        int middle = int_floor(low + high, 2);
        if (samples->s[middle] < s) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

/* Distance of a position from the nearest sample [m]. */
static double curve_nearest_sample_distance(const CurveSamples *samples, double x, double y)
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
    i = 0;
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

/* Foot point s, d of a position that is nearest on the whole path. */
cca_dd cca_nearest_point(const Curve *curve, const CurveSamples *samples, double x, double y)
{
    int n = samples->count;
    double limit = curve_nearest_sample_distance(samples, x, y) + 0.5 * samples->max_speed * samples->spacing;
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

/* Nearest points of n positions on the whole path. */
void cca_nearest_points(const Curve *curve, const CurveSamples *samples, int n, const double *x, const double
    *y, double *s, double *d)
{
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        const cca_dd result1_ = cca_nearest_point(curve, samples, x[i], y[i]);
        s[i] = result1_.item0;
        d[i] = result1_.item1;
    }
}

/* reach.py: Where other vehicles may be: distances, reachable and occupied intervals, danger zones, occupancy
    boxes. */
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

/* Speed at the time of the measurement, before it was dead-reckoned. */
static double reach_measured_speed(double speed, double age, double rate)
{
    return real_max(speed - rate * real_min(age, CONSTANTS_STALE_AGE), 0.0);
}

/* Distance that was driven before now or before t, or that dead reckoning has counted. */
static double reach_distance_counted(double speed, double t, double age, double rate)
{
    if (t < 0.0) {
        return speed * t;
    }
    double counted = real_min(age, CONSTANTS_STALE_AGE);
    return -(speed * age - 0.5 * rate * counted * counted);
}

/* Smallest distance driven, as if forwards. */
static double reach_shortest(double speed, double t, double braking, double age, double rate)
{
    double known = reach_distance_counted(speed, t, age, rate);
    if (t < 0.0) {
        return known;
    }
    double measured = reach_measured_speed(speed, age, rate);
    double slows = t + age;
    if (braking > 0.0) {
        slows = real_min(slows, measured / real_max(braking, REACH_SMALLEST));
    }
    return measured * slows - 0.5 * braking * slows * slows + known;
}

/* Largest distance driven, as if forwards. */
static double reach_longest(double speed, double t, double acceleration, double age, double rate)
{
    double known = reach_distance_counted(speed, t, age, rate);
    if (t < 0.0) {
        return known;
    }
    double since = t + age;
    return reach_measured_speed(speed, age, rate) * since + 0.5 * acceleration * since * since + known;
}

/* Smallest displacement along the road within assumed limits. */
static double reach_reach_low(double v, double t, double braking, double acceleration, double age, double
    rate)
{
    double creeping = acceleration > 0.0 ? CONSTANTS_STANDSTILL_SPEED : 0.0;
    if (v < creeping) {
        return -reach_longest(fabs(v), t, acceleration, age, rate);
    }
    return reach_shortest(fabs(v), t, braking, age, rate);
}

/* Largest displacement along the road within assumed limits. */
static double reach_reach_high(double v, double t, double braking, double acceleration, double age, double
    rate)
{
    double creeping = acceleration > 0.0 ? CONSTANTS_STANDSTILL_SPEED : 0.0;
    if (v > -creeping) {
        return reach_longest(fabs(v), t, acceleration, age, rate);
    }
    return -reach_shortest(fabs(v), t, braking, age, rate);
}

/* Distance driven at many times. */
void cca_distances_driven(int n, const double *t, double v, double a_x, double *distance)
{
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        distance[i] = reach_distance_driven(v, a_x, t[i]);
    }
}

/* Displacements that vehicles can reach, one time for each. */
void cca_reachable_intervals(int n, const double *v, const double *t, const double *age, const double *rate,
    double braking, double acceleration, double *low, double *high)
{
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        low[i] = reach_reach_low(v[i], t[i], braking, acceleration, age[i], rate[i]);
        high[i] = reach_reach_high(v[i], t[i], braking, acceleration, age[i], rate[i]);
    }
}

/* Stations that the bodies of vehicles may cover at common times. */
void cca_occupied_intervals(int vehicles, int times, const double *motion, const double *t, double *rear,
    double *front)
{
    for (int k = 0, k_end_ = vehicles; k < k_end_; k += 1) {
        double v = motion[k * 8 + REACH_SPEED];
        double braking = motion[k * 8 + REACH_BRAKING];
        double acceleration = motion[k * 8 + REACH_ACCELERATION];
        for (int i = 0, i_end_ = times; i < i_end_; i += 1) {
            double low = copysign(1.0, v) * reach_distance_driven(fabs(v), motion[k * 8 + REACH_A_X], t[i]);
            double high = low;
            if (!(braking == 0.0 && acceleration == 0.0)) {
                low = reach_reach_low(v, t[i], braking, acceleration, motion[k * 8 + REACH_AGE], motion[k * 8
                    + REACH_RATE]);
                high = reach_reach_high(v, t[i], braking, acceleration, motion[k * 8 + REACH_AGE], motion[k *
                    8 + REACH_RATE]);
            }
            rear[k * times + i] = motion[k * 8 + REACH_REAR] + low;
            front[k * times + i] = motion[k * 8 + REACH_FRONT] + high;
        }
    }
}

/* Intervals of the road in which vehicles of the adjacent lane block a maneuver, relative to the ego. */
void cca_danger_zones(int vehicles, int times, const double *motion, const double *t, const double *travel,
    double *zone)
{
    for (int k = 0, k_end_ = vehicles; k < k_end_; k += 1) {
        double low = HUGE_VAL;
        double high = -HUGE_VAL;
        for (int i = 0, i_end_ = times; i < i_end_; i += 1) {
            double first = reach_reach_low(motion[k * 8 + REACH_SPEED], t[i], motion[k * 8 + REACH_BRAKING],
                motion[k * 8 + REACH_ACCELERATION], motion[k * 8 + REACH_AGE], motion[k * 8 + REACH_RATE]);
            double last = reach_reach_high(motion[k * 8 + REACH_SPEED], t[i], motion[k * 8 + REACH_BRAKING],
                motion[k * 8 + REACH_ACCELERATION], motion[k * 8 + REACH_AGE], motion[k * 8 + REACH_RATE]);
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

/* Boxes that cover occupied intervals near given stations: x, y, heading, length and width of each. */
void cca_occupancy_boxes(const Curve *curve, int n, const double *s, const double *rear, const double *front,
    const double *d, const double *half_width, double *boxes)
{
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        double first = real_min(real_max(rear[i], s[i] - REACH_WINDOW), front[i]);
        double last = real_max(real_min(front[i], s[i] + REACH_WINDOW), rear[i]);
        double length = fabs(last - first);
        const cca_dddddd result1_ = cca_curve_point(curve, 0.5 * (first + last));
        double x = result1_.item0;
        double y = result1_.item1;
        double dx = result1_.item2;
        double dy = result1_.item3;
        double ddx = result1_.item4;
        double ddy = result1_.item5;
        double speed = real_max(box_gaps_norm(dx, dy), CURVE_SMALLEST_SPEED);
        boxes[i * 5 + 0] = x - d[i] * dy / speed;
        boxes[i * 5 + 1] = y + d[i] * dx / speed;
        boxes[i * 5 + 2] = atan2(dy, dx);
        boxes[i * 5 + 3] = length;
        boxes[i * 5 + 4] = 2.0 * half_width[i] + 0.25 * fabs(curve_curvature_of(dx, dy, ddx, ddy)) * length *
            length;
    }
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
void cca_same_direction_distances(int n, const double *v_rear, const double *v_front, const RssReaction *rear,
    const RssReaction *front, double *distance)
{
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        double apart = rss_stopping_distance(v_rear[i], rear, rear->b_min) - v_front[i] * v_front[i] / (2.0 *
            front->b_max);
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
void cca_lateral_distances(int n, const double *v_left, const double *v_right, const RssReaction *left, const
    RssReaction *right, double *distance)
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
static cca_dddddddd single_track_rates(const SingleTrackCar *car, double psi, double v_x, double v_y, double
    r, double angle, double force, double delta, double a_x)
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
    double side = sqrt(real_max(grip * grip - force * force, SINGLE_TRACK_MIN_SIDE * grip *
        (SINGLE_TRACK_MIN_SIDE * grip)));
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
    return (cca_dddddddd){v_x * c - v_y * s, v_x * s + v_y * c, r, force * (1.0 - front) + front_x / car->m +
        v_y * r, (front_y + f_r) / car->m - v_x * r, (car->l_f * front_y - car->l_r * f_r) / car->inertia,
        rate, drive_rate};
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
    const cca_dddddddd result2_ = single_track_rates(car, psi + m * ap, v + m * av, w + m * aw, r + m * ar,
        angle + m * aa, force + m * af, delta, a_x);
    double bx = result2_.item0;
    double by = result2_.item1;
    double bp = result2_.item2;
    double bv = result2_.item3;
    double bw = result2_.item4;
    double br = result2_.item5;
    double ba = result2_.item6;
    double bf = result2_.item7;
    const cca_dddddddd result3_ = single_track_rates(car, psi + m * bp, v + m * bv, w + m * bw, r + m * br,
        angle + m * ba, force + m * bf, delta, a_x);
    double cx = result3_.item0;
    double cy = result3_.item1;
    double cp = result3_.item2;
    double cv = result3_.item3;
    double cw = result3_.item4;
    double cr = result3_.item5;
    double ca = result3_.item6;
    double cf = result3_.item7;
    const cca_dddddddd result4_ = single_track_rates(car, psi + h * cp, v + h * cv, w + h * cw, r + h * cr,
        angle + h * ca, force + h * cf, delta, a_x);
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
    const cca_dddddddd result1_ = single_track_rates(car, car->psi, car->v_x, car->v_y, car->r, car->delta,
        car->a_x, delta, a_x);
    double v_y_dot = result1_.item4;
    car->a_y = v_y_dot + car->v_x * car->r;
}

/* speed.py: Speeds along a path, and times of arrival. */
#define SPEED_STRAIGHT 1e-09
#define SPEED_LOOKAHEAD 2.0

/* Compute when points ahead are reached if the target speed is approached freely. */
void cca_arrival_times(int n, double v_x, double v_target, const double *distance, double a_max, double
    b_comfort, double *t)
{
    double v = real_max(v_x, CONSTANTS_STANDSTILL_SPEED);
    double target = real_max(v_target, CONSTANTS_STANDSTILL_SPEED);
    double a = target > v ? a_max : -b_comfort;
    double ramp = (target * target - v * v) / (2.0 * a);
    for (int i = 0, i_end_ = n; i < i_end_; i += 1) {
        double on_ramp = real_min(real_max(distance[i], 0.0), ramp);
        t[i] = (sqrt(v * v + 2.0 * a * on_ramp) - v) / a;
        t[i] += real_min(distance[i], 0.0) / v + real_max(distance[i] - ramp, 0.0) / target;
    }
}

/* Squares of the highest speeds at stations, with standstill at the last one. */
void cca_squared_speed_limits(const Curve *curve, int n, double cruise, double a_y, double b_comfort, const
    double *s, double *squared)
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
double cca_profile_acceleration(int n, const double *at, const double *squared, double s, double v_x, double
    a_max, double b_comfort, double b_max)
{
    double horizon = SPEED_LOOKAHEAD + real_max(v_x, 0.0);
    double here = real_max(cca_interpolated(n, at, squared, s), 0.0);
    double there = cca_interpolated(n, at, squared, s + horizon);
    double ahead = (there - v_x * v_x) / (2.0 * horizon);
    double cruise = real_min(real_max(sqrt(here) - v_x, -b_comfort), a_max);
    return real_min(cruise, real_max(ahead, -b_max));
}

/* steering.py: Preview steering: the single-track model inverted along a path, and PD control of the error
    ahead. */
#define STEERING_ROLLING_SPEED 3.0
#define STEERING_INTEGRAL_TIME 3.0
#define STEERING_INTEGRAL_LIMIT 0.02
#define STEERING_SMALL_OFFSET 0.1
#define STEERING_SIDESLIP_FRACTION 0.3
#define STEERING_MAX_STEP 0.005
#define STEERING_MAX_STEPS 1000
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
        double r_dot = (car->l_f * car->m * a_y - (car->l_f + car->l_r) * steering_rear_force(car, v)) /
            car->inertia;
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
    double rolling = v < STEERING_ROLLING_SPEED ? 0.0 : car->l_f * car->m * v * v / (car->c_r * (car->l_f +
        car->l_r));
    car->v_y = v * kappa * (car->l_r - rolling);
}

/* Where entry i of the trace lies in its ring. */
static int steering_ring_index(const IdealCar *car, int i)
{
    int at = car->first + i;
    return at >= STEERING_TRACE ? at - STEERING_TRACE : at;
}

/* Move the ideal car along the path; return the steering angle that it needs there. */
double cca_advance(IdealCar *car, double s, double kappa, double v_x, double dt)
{
    double v = real_max(v_x, 0.0);
    if (!car->started || fabs(s - car->s) > STEERING_MAX_JUMP || v < STEERING_ROLLING_SPEED) {
        steering_start_steady(car, kappa, v);
    } else {
        steering_integrate(car, kappa, v, dt);
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
    if (v < STEERING_ROLLING_SPEED) {
        return atan((car->l_f + car->l_r) * kappa);
    }
    double rest = car->m * v * v * kappa - steering_rear_force(car, v);
    double grip = car->mu * CONSTANTS_GRAVITY * car->m * car->l_r / (car->l_f + car->l_r);
    return atan2(car->v_y + car->l_f * car->r, v) + cca_front_slip(car, rest / grip);
}

/* Sideslip and yaw rate of the ideal car at a station that it has passed; older ones are dropped. */
cca_dd cca_find_passed(IdealCar *car, double s)
{
    for (int turn1_ = 0, turn1__end_ = STEERING_TRACE; turn1_ < turn1__end_; turn1_ += 1) {
        if (car->count < 2 || car->trace_s[steering_ring_index(car, 1)] > s) {
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
static double steering_limited(const Steering *law, const IdealCar *car, double target, double v_x, double
    v_y, double r, double dt)
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
    if (law->started) {
        double step = law->delta_rate_max * dt;
        delta = real_min(real_max(delta, law->delta - step), law->delta + step);
    }
    return delta;
}

/* Road-wheel angle for this cycle; `law.s` becomes the station of the vehicle. */
double cca_steer(Steering *law, IdealCar *car, const Curve *curve, double s_guess, double x, double y, double
    psi, double v_x, double v_y, double r, double dt)
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
    if (delta == target && fabs(d) < STEERING_SMALL_OFFSET && v > 1.0) {
        law->integral = real_min(real_max(law->integral + k_p * d * dt / STEERING_INTEGRAL_TIME,
            -STEERING_INTEGRAL_LIMIT), STEERING_INTEGRAL_LIMIT);
    }
    law->delta = delta;
    law->started = true;
    return delta;
}
