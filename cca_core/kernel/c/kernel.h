/* Made from the Python of cca_core/kernel by `make kernel`: edit that. */

#ifndef CCA_KERNEL_H
#define CCA_KERNEL_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct Equilibrium {
    int n;
    int max_n;
    double rate;
    double bending;
    double tension;
    double contact;
    double curvature_contact;
    double *lower;
    double *upper;
    bool bounded;
    double *lower_difference;
    double *upper_difference;
    int *active;
    int *sharp;
    double *u;
    int solves;
    bool definite;
    double *force;
    double *target;
    double *step;
    double *residual;
    double *difference;
    double *moment;
    double *inverse;
    double *factor_1;
    double *factor_2;
    double *factor_3;
} Equilibrium;

typedef struct BandWork {
    int n;
    int m;
    int n_certified;
    int max_n;
    int max_m;
    int max_certified;
    double length;
    double width;
    double box_offset;
    double clearance;
    double k_s;
    double k_b;
    double k_c;
    double k_e;
    double max_displacement;
    int max_tightenings;
    int max_solves;
    int max_stalls;
    double min_progress;
    double clearance_margin;
    double curvature_margin;
    double max_end_shortfall;
    int max_free_sides;
    double side_change_fraction;
    bool has_edges;
    double *route_x;
    double *route_y;
    double *right_edge;
    double *left_edge;
    double *curvature_limit;
    double *box_x;
    double *box_y;
    double *box_psi;
    double *half_length;
    double *half_width;
    double *lead_distance;
    int *passes_left;
    bool has_former;
    int *former;
    double start_before;
    double start_0;
    double start_1;
    double spacing;
    double *tangent_x;
    double *tangent_y;
    double *route_curvature;
    double *free;
    double heading_x0;
    double heading_y0;
    double heading_x1;
    double heading_y1;
    double moment_x0;
    double moment_y0;
    double moment_x1;
    double moment_y1;
    double *box_ahead_x;
    double *box_ahead_y;
    double *radius;
    double *max_radius;
    double *max_step;
    double *overlap;
    double *passing_right;
    double *passing_left;
    double *u;
    double *best_u;
    double *lower;
    double *upper;
    double *low;
    double *high;
    double *lower_difference;
    double *upper_difference;
    double *x;
    double *y;
    double *chord;
    double *ahead_x;
    double *ahead_y;
    double *moment_x;
    double *moment_y;
    double *curvature;
    double *diagonal;
    double *center_x;
    double *center_y;
    double near;
    int n_pairs;
    double *right_margin;
    double *left_margin;
    double min_gap;
    double min_edge_clearance;
    double max_curvature;
    double curvature_ratio;
    bool finite;
    int *pair_obstacle;
    int *pair_node;
    double *sampled;
    double *bulge;
    double *bound;
    double *parts;
    int status;
    int reason;
    int active;
    int other;
    int node;
    int solves;
    double value;
    double limit;
    int *blocking;
    int *is_free;
    int *default_side;
    int *rank;
    double *distance;
    int *codes;
    double *costs;
} BandWork;

typedef struct BandBatch {
    int n;
    int m;
    int bands;
    int max_bands;
    int max_n;
    int max_m;
    int side_rule;
    bool has_edges;
    bool has_former;
    double *nodes;
    double *boxes;
    double *right_edge;
    double *left_edge;
    double *curvature_limit;
    double *start;
    double *lead_distance;
    int *former;
    int *passes_left;
} BandBatch;

double cca_oriented_box_gap(double dx, double dy, double ax, double ay, double bx, double by,
    double length_a, double width_a, double length_b, double width_b);

double cca_box_gap(double ax, double ay, double a_psi, double a_length, double a_width, double bx,
    double by, double b_psi, double b_length, double b_width);

void cca_box_gaps(int n, int k, const double *a, const double *b, double *gap);

void cca_relax_bands(BandBatch *q, BandWork *w, Equilibrium *e, int bands, int columns, double *found, int
    *codes);

int cca_measure_band(BandBatch *q, BandWork *w, Equilibrium *e, int n, const double *u, int columns,
    double *found, int *codes);

void cca_join_cubics(int segments, const double *nodes, const double *moments, double start, double
    *breaks, double *cubics);

typedef struct Curve {
    int segments;
    double *breaks;
    double *powers;
} Curve;

typedef struct CurveSamples {
    int count;
    int stride;
    double max_gap;
    double *s;
    double *x;
    double *y;
} CurveSamples;

typedef struct cca_dddddd { double item0; double item1; double item2; double item3; double item4; double item5; } cca_dddddd;

cca_dddddd cca_curve_point(const Curve *curve, double s);

void cca_curve_points(const Curve *curve, int n, const double *s, double *position, double *first, double
    *second);

double cca_curvature_at(const Curve *curve, double s);

typedef struct cca_dddd { double item0; double item1; double item2; double item3; } cca_dddd;

cca_dddd cca_foot_point(const Curve *curve, double x, double y, double s_guess);

typedef struct cca_dd { double item0; double item1; } cca_dd;

cca_dd cca_nearest_point(const Curve *curve, const CurveSamples *samples, double x, double y);

void cca_foot_points(const Curve *curve, int n, const double *x, const double *y, const double *s_guess,
    double *s, double *d, double *heading, double *curvature);

void cca_nearest_points(const Curve *curve, const CurveSamples *samples, int n, const double *x,
    const double *y, double *s, double *d);

void cca_find_equilibria(Equilibrium *e, int bands, int n, bool bounded, const double *stiffness,
    const double *lower, const double *upper, const double *lower_difference, const double *upper_difference,
    double *u, int *solves, int *converged);

typedef struct Scene {
    int n;
    int max_m;
    int max_paths;
    int max_rows;
    int steps;
    double *x;
    double *y;
    double *psi;
    double *kappa;
    double *cap;
    double lane_right;
    double lane_left;
    double *d;
    double *path_cap;
    double *overtakes;
    double *t;
    int m;
    double *s_o;
    double *v_o;
    double *d_o;
    double *s_follow;
    double *v_follow;
    double *half_l;
    double *half_w;
    double *low;
    double *high;
    double *high_passed;
    double *low_passed;
    double *right;
    double *left;
    int *crosses;
    int *stands;
    double *passing_distance;
    double *x_o;
    double *y_o;
    double *psi_o;
    double *x_w;
    double *y_w;
    double *psi_w;
    double *half_l_w;
    double *half_w_w;
    int *adjacent;
    int *assumed;
    int stops;
    double *stop_s;
    double *stop_until;
    double s_0;
    double v_0;
    double a_0;
    double a_true;
    double half_length;
    double half_width;
    double offset;
    double a_max;
    double b_comfort;
    double b_max;
    double b_soft;
    double b_other;
    double risk_until;
    double grip;
    double standstill_gap;
    double time_gap;
    double approach_rate;
    double jerk;
    double jerk_emergency;
    double lag;
    double blocking_gap;
    double look;
    double react;
    double margin;
    double *s;
    double *v;
    double *a;
    double *offset_at;
    int *limited_by;
    double *terms;
    double min_margin;
    double gap;
    int which;
    int when;
    double impact;
    double s_enter;
    double s_exit;
    double t_enter;
    double t_exit;
    double zone_from;
    double begin_from;
    int zone_side;
    double rear_reaction;
    double rear_braking;
    bool established;
    int duty_from;
    double rear;
} Scene;

void cca_limit_path_speed(Scene *w, int p, double a_y);

void cca_roll_out(Scene *w, int row, int p, bool follows, bool passes, int yields, double braking,
    double tail, bool kept);

void cca_sum_costs(Scene *w, int row, int p, double until);

bool cca_find_conflict_stations(Scene *w, int p, int j, int reach, double until, double margin);

void cca_check_nominal(Scene *w, int row, int p, double touch, double clearance, double wait, double pet);

bool cca_check_worst_case(Scene *w, int row, int p, double touch, double clearance, double wait,
    double x_safety, int which);

typedef struct cca_ddd { double item0; double item1; double item2; } cca_ddd;

void cca_distances_driven(int n, const double *t, double v, double a_x, double *distance);

void cca_reachable_intervals(int n, const double *v, const double *t, const double *age, const double
    *rate, double braking, double acceleration, double *low, double *high);

void cca_occupied_intervals(int vehicles, int times, const double *motion, const double *t, double *rear,
    double *front);

void cca_danger_zones(int vehicles, int times, const double *motion, const double *t, const double
    *travel, double *zone);

typedef struct cca_ddddd { double item0; double item1; double item2; double item3; double item4; } cca_ddddd;

void cca_occupancy_boxes(const Curve *curve, int n, const double *s, const double *rear, const double
    *front, const double *d, const double *half_width, double *boxes);

void cca_vehicle_boxes(const Curve *curve, int vehicles, int times, const double *s, const double *rear,
    const double *front, const double *d, const double *half_width, double *boxes);

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

void cca_same_direction_distances(int n, const double *v_rear, const double *v_front, const RssReaction
    *rear, const RssReaction *front, double *distance);

void cca_opposite_distances(int n, const double *v_correct, const double *v_opposite, const RssReaction
    *correct, const RssReaction *opposite, double *distance);

void cca_lateral_distances(int n, const double *v_left, const double *v_right, const RssReaction *left,
    const RssReaction *right, double *distance);

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

typedef struct cca_dddddddd { double item0; double item1; double item2; double item3; double item4; double item5; double item6; double item7; } cca_dddddddd;

void cca_drive(SingleTrackCar *car, double delta, double a_x, double dt);

void cca_arrival_times(int n, double v_x, double v_target, const double *distance, double a_max,
    double b_comfort, double *t);

void cca_squared_speed_limits(const Curve *curve, int n, double cruise, double a_y, double b_comfort,
    const double *s, double *squared);

double cca_interpolated(int n, const double *at, const double *value, double s);

double cca_profile_acceleration(int n, const double *at, const double *squared, double s, double v_x,
    double a_max, double b_comfort, double b_max);

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

double cca_steer(Steering *law, IdealCar *car, const Curve *curve, double s_guess, double x, double y,
    double psi, double v_x, double v_y, double r, double dt);

#ifdef __cplusplus
}
#endif

#endif
