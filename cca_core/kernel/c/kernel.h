/* Made from the Python of cca_core/kernel by `make kernel`: edit that. */

#ifndef CCA_KERNEL_H
#define CCA_KERNEL_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

double cca_oriented_box_gap(double dx, double dy, double ax, double ay, double bx, double by, double length_a,
    double width_a, double length_b, double width_b);

double cca_aligned_box_gaps(int n, const double *dx, const double *dy, double length, double width, double
    *gap);

double cca_box_gap(double ax, double ay, double a_psi, double a_length, double a_width, double bx, double by,
    double b_psi, double b_length, double b_width);

void cca_box_gaps(int n, int k, const double *a, const double *b, double *gap);

typedef struct Curve {
    int segments;
    double *breaks;
    double *powers;
} Curve;

typedef struct CurveSamples {
    int count;
    int stride;
    double spacing;
    double max_speed;
    double *s;
    double *x;
    double *y;
} CurveSamples;

typedef struct cca_dddddd { double item0; double item1; double item2; double item3; double item4; double
    item5; } cca_dddddd;

cca_dddddd cca_curve_point(const Curve *curve, double s);

double cca_curvature_at(const Curve *curve, double s);

typedef struct cca_dddd { double item0; double item1; double item2; double item3; } cca_dddd;

cca_dddd cca_foot_point(const Curve *curve, double x, double y, double s_guess);

typedef struct cca_dd { double item0; double item1; } cca_dd;

cca_dd cca_nearest_point(const Curve *curve, const CurveSamples *samples, double x, double y);

void cca_foot_points(const Curve *curve, int n, const double *x, const double *y, const double *s_guess,
    double *s, double *d, double *heading, double *curvature);

void cca_nearest_points(const Curve *curve, const CurveSamples *samples, int n, const double *x, const double
    *y, double *s, double *d);

void cca_distances_driven(int n, const double *t, double v, double a_x, double *distance);

void cca_reachable_intervals(int n, const double *v, const double *t, const double *age, const double *rate,
    double braking, double acceleration, double *low, double *high);

void cca_occupied_intervals(int vehicles, int times, const double *motion, const double *t, double *rear,
    double *front);

void cca_danger_zones(int vehicles, int times, const double *motion, const double *t, const double *travel,
    double *zone);

void cca_occupancy_boxes(const Curve *curve, int n, const double *s, const double *rear, const double *front,
    const double *d, const double *half_width, double *boxes);

typedef struct RssReaction {
    double response_time;
    double a_max;
    double b_min;
    double b_max;
    double b_correct;
    double a_lateral;
    double b_lateral;
    double fluctuation;
    double standstill_gap;
    double v_max;
} RssReaction;

void cca_same_direction_distances(int n, const double *v_rear, const double *v_front, const RssReaction *rear,
    const RssReaction *front, double *distance);

void cca_opposite_distances(int n, const double *v_correct, const double *v_opposite, const RssReaction
    *correct, const RssReaction *opposite, double *distance);

void cca_lateral_distances(int n, const double *v_left, const double *v_right, const RssReaction *left, const
    RssReaction *right, double *distance);

typedef struct SingleTrackCar {
    double l_f;
    double l_r;
    double m;
    double inertia;
    double c_f;
    double c_r;
    double mu;
    double delta_rate_max;
    double steering_lag;
    double drive_lag;
    double x;
    double y;
    double psi;
    double v_x;
    double v_y;
    double r;
    double delta;
    double a_x;
    double a_y;
} SingleTrackCar;

double cca_fiala_force(double stiffness, double slip, double f_max);

typedef struct cca_dddddddd { double item0; double item1; double item2; double item3; double item4; double
    item5; double item6; double item7; } cca_dddddddd;

void cca_drive(SingleTrackCar *car, double delta, double a_x, double dt);

void cca_arrival_times(int n, double v_x, double v_target, const double *distance, double a_max, double
    b_comfort, double *t);

void cca_squared_speed_limits(const Curve *curve, int n, double cruise, double a_y, double b_comfort, const
    double *s, double *squared);

double cca_interpolated(int n, const double *at, const double *value, double s);

double cca_profile_acceleration(int n, const double *at, const double *squared, double s, double v_x, double
    a_max, double b_comfort, double b_max);

typedef struct IdealCar {
    double l_f;
    double l_r;
    double m;
    double inertia;
    double c_f;
    double c_r;
    double mu;
    bool started;
    double s;
    double kappa;
    double v_y;
    double r;
    int first;
    int count;
    double *trace_s;
    double *trace_beta;
    double *trace_r;
} IdealCar;

typedef struct Steering {
    double delta_max;
    double delta_rate_max;
    double steering_lag;
    double understeer;
    double delay;
    double a_y_max;
    bool ahead;
    int count;
    double *speeds;
    double *k_p;
    double *k_d;
    double *l_s;
    double s;
    double integral;
    bool started;
    double delta;
} Steering;

double cca_front_slip(const IdealCar *car, double fraction);

double cca_advance(IdealCar *car, double s, double kappa, double v_x, double dt);

cca_dd cca_find_passed(IdealCar *car, double s);

double cca_steer(Steering *law, IdealCar *car, const Curve *curve, double s_guess, double x, double y, double
    psi, double v_x, double v_y, double r, double dt);

#ifdef __cplusplus
}
#endif

#endif
