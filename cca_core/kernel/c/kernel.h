/* Made from the Python of cca_core/kernel by `make kernel`: edit that. */

#ifndef CCA_KERNEL_H
#define CCA_KERNEL_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A band between pinned ends, one-sided bounds and the active set. */
typedef struct Equilibrium {
    int n;
    int max_n;
    double rate;
    double bending;
    double tension;
    double contact;
    double curvature_contact;
    double *lower; /* [max_n] */
    double *upper; /* [max_n] */
    bool bounded;
    double *lower_difference; /* [max_n] */
    double *upper_difference; /* [max_n] */
    int *active; /* [max_n] */
    int *sharp; /* [max_n] */
    double *u; /* [max_n] */
    int solves;
    bool definite;
    double *force; /* [max_n] */
    double *target; /* [max_n] */
    double *step; /* [max_n] */
    double *residual; /* [max_n] */
    double *difference; /* [max_n] */
    double *moment; /* [max_n] */
    double *inverse; /* [max_n] */
    double *factor_1; /* [max_n] */
    double *factor_2; /* [max_n] */
    double *factor_3; /* [max_n] */
} Equilibrium;

/* One band: its problem, its certificate, and what the rounds of tightening need. */
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
    bool has_valid_boxes;
    double *route_x; /* [max_n] */
    double *route_y; /* [max_n] */
    double *right_edge; /* [max_n] */
    double *left_edge; /* [max_n] */
    double *curvature_limit; /* [max_n] */
    double *box_x; /* [max_m][max_n] */
    double *box_y; /* [max_m][max_n] */
    double *half_length; /* [max_m][max_n] */
    double *half_width; /* [max_m][max_n] */
    double *lead_distance; /* [max_m] */
    int *passes_left; /* [max_m] */
    bool has_former;
    int *former; /* [max_m] */
    double start_before;
    double start_0;
    double start_1;
    double spacing;
    double *tangent_x; /* [max_n] */
    double *tangent_y; /* [max_n] */
    double *route_curvature; /* [max_n] */
    double *free; /* [max_n] */
    double heading_x0;
    double heading_y0;
    double heading_x1;
    double heading_y1;
    double moment_x0;
    double moment_y0;
    double moment_x1;
    double moment_y1;
    double *box_ahead_x; /* [max_m][max_n] */
    double *box_ahead_y; /* [max_m][max_n] */
    double *radius; /* [max_m][max_n] */
    double *max_radius; /* [max_m] */
    int *is_fixed; /* [max_m] */
    double *max_step; /* [max_m] */
    double *overlap; /* [max_m][max_n] */
    double *passing_right; /* [max_m][max_n] */
    double *passing_left; /* [max_m][max_n] */
    double *u; /* [max_n] */
    double *best_u; /* [max_n] */
    double *lower; /* [max_n] */
    double *upper; /* [max_n] */
    double *low; /* [max_n] */
    double *high; /* [max_n] */
    double *lower_difference; /* [max_n] */
    double *upper_difference; /* [max_n] */
    double *x; /* [max_n] */
    double *y; /* [max_n] */
    double *chord; /* [max_n] */
    double *ahead_x; /* [max_n] */
    double *ahead_y; /* [max_n] */
    double *moment_x; /* [max_n] */
    double *moment_y; /* [max_n] */
    double *curvature; /* [max_n] */
    double *diagonal; /* [max_n] */
    double *center_x; /* [max_n] */
    double *center_y; /* [max_n] */
    double near;
    int n_pairs;
    double *right_margin; /* [max_n] */
    double *left_margin; /* [max_n] */
    double min_gap;
    double min_edge_clearance;
    double max_curvature;
    double curvature_ratio;
    bool finite;
    int *pair_obstacle; /* [max_m * max_n] */
    int *pair_node; /* [max_m * max_n] */
    double *sampled; /* [max_m * max_n] */
    double *bulge; /* [max_m * max_n] */
    double *bound; /* [max_m * max_n] */
    double *parts; /* [17] */
    int status;
    int reason;
    int active;
    int other;
    int node;
    int solves;
    double value;
    double limit;
    int *blocking; /* [max_m] */
    int *is_free; /* [max_m] */
    int *default_side; /* [max_m] */
    int *rank; /* [max_m] */
    double *distance; /* [max_m] */
    int *codes; /* [max_certified] */
    double *costs; /* [max_certified] */
} BandWork;

/* Problems of bands of one shape. */
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
    double *nodes; /* [max_bands][2 * max_n] */
    double *boxes; /* [5 * max_m * max_bands * max_n] */
    double *right_edge; /* [max_bands][max_n] */
    double *left_edge; /* [max_bands][max_n] */
    double *curvature_limit; /* [max_bands][max_n] */
    double *start; /* [max_bands][3] */
    double *lead_distance; /* [max_m] */
    int *former; /* [max_m * max_bands] */
    int *passes_left; /* [max_m * max_bands] */
} BandBatch;

/* Signed distance of box b, at dx, dy from box a, from unit headings and half extents [m]. */
double cca_oriented_box_gap(double dx, double dy, double ax, double ay, double bx, double by,
    double length_a, double width_a, double length_b, double width_b);

/* Signed distance of two boxes from centers, headings and full extents [m]; NaN if one is not finite. */
double cca_box_gap(double ax, double ay, double a_psi, double a_length, double a_width, double bx,
    double by, double b_psi, double b_length, double b_width);

/* Signed distances of n boxes b from k boxes a, which repeat: x, y, heading, length, width of each.
   a[k][5], b[n][5], gap[n] */
void cca_box_gaps(int n, int k, const double *a, const double *b, double *gap);

/* Relax the bands of a batch; their status is in the first column of `codes`.
   found[(bands * columns)], codes[(6 * bands)] */
void cca_relax_bands(BandBatch *q, BandWork *w, Equilibrium *e, int bands, int columns, double *found, int
    *codes);

/* Certify a displacement of the first band of a batch; return a status.

Its frame, its bounds for the given sides, and its certificate are left in the workspace.
   u[n], found[columns], codes[6] */
int cca_measure_band(BandBatch *q, BandWork *w, Equilibrium *e, int n, const double *u, int columns,
    double *found, int *codes);

/* Compute arc lengths, and a, b, c, d of x and then of y, from nodes and spline moments / 6.
   nodes[(segments + 1)][2], moments[(segments + 1)][2], breaks[(segments + 1)], cubics[segments][8] */
void cca_join_cubics(int segments, const double *nodes, const double *moments, double start, double
    *breaks, double *cubics);

/* Route, candidate paths, other vehicles, the ego and its motions of one decision. */
typedef struct Scene {
    int n;
    int max_m;
    int max_paths;
    int max_rows;
    int steps;
    int max_lanes;
    double *x; /* [n] */
    double *y; /* [n] */
    double *psi; /* [n] */
    double *kappa; /* [n] */
    double *cap; /* [n] */
    double lane_right;
    double lane_left;
    double edge_right;
    double edge_left;
    double *other_lanes; /* [max_lanes][2] */
    double *d; /* [max_paths][n] */
    double *path_cap; /* [max_paths][n] */
    double *path_low; /* [max_paths] */
    double *path_high; /* [max_paths] */
    double *end_right; /* [max_paths] */
    double *end_left; /* [max_paths] */
    double *overtakes; /* [max_paths][max_m] */
    double *t; /* [steps] */
    int m;
    double *seen; /* [max_m][27] */
    double *s_o; /* [max_m][steps] */
    double *v_o; /* [max_m][steps] */
    double *d_o; /* [max_m][steps] */
    double *s_follow; /* [max_m][steps] */
    double *v_follow; /* [max_m][steps] */
    double *half_l; /* [max_m] */
    double *half_w; /* [max_m] */
    double *low; /* [max_m][steps] */
    double *high; /* [max_m][steps] */
    double *high_passed; /* [max_m][steps] */
    double *low_passed; /* [max_m][steps] */
    double *right; /* [max_m][steps] */
    double *left; /* [max_m][steps] */
    double *d_low; /* [max_m] */
    double *d_high; /* [max_m] */
    int *order; /* [max_m] */
    int *leads; /* [max_m] */
    int *met; /* [max_m] */
    int crossing;
    double *s_enter; /* [max_m] */
    double *s_exit; /* [max_m] */
    double *t_enter; /* [max_m] */
    double *t_exit; /* [max_m] */
    int *crosses; /* [max_m] */
    int *stands; /* [max_m] */
    double *passing_distance; /* [max_m] */
    double *x_o; /* [max_m][steps] */
    double *y_o; /* [max_m][steps] */
    double *psi_o; /* [max_m][steps] */
    double *x_w; /* [max_m][steps] */
    double *y_w; /* [max_m][steps] */
    double *psi_w; /* [max_m][steps] */
    double *half_l_w; /* [max_m][steps] */
    double *half_w_w; /* [max_m][steps] */
    int *adjacent; /* [max_m] */
    int *assumed; /* [max_m] */
    double v_limit;
    double a_other;
    double a_passed;
    double b_crossing;
    double a_crossing;
    double min_pet;
    double braking_time;
    double acceleration_time;
    double crossing_time;
    double yield_time;
    bool keeps;
    double entry_tolerance;
    double queue_gap;
    double passing_gap;
    int stops;
    double *stop_s; /* [8] */
    double *stop_until; /* [8] */
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
    double opening_speed;
    double creep_time;
    double b_firm;
    double look;
    double react;
    double margin;
    double *s; /* [max_rows][steps] */
    double *v; /* [max_rows][steps] */
    double *a; /* [max_rows][steps] */
    double *offset_at; /* [max_rows][steps] */
    int *limited_by; /* [max_rows] */
    double *terms; /* [max_rows][9] */
    double *turn; /* [steps] */
    double *scale; /* [steps] */
    double *wide; /* [steps] */
    double *bends; /* [steps] */
    double *x_e; /* [steps] */
    double *y_e; /* [steps] */
    double *c_e; /* [steps] */
    double *s_e; /* [steps] */
    double *x_p; /* [n] */
    double *y_p; /* [n] */
    double *c_p; /* [n] */
    double *s_p; /* [n] */
    double *x_b; /* [n] */
    double *y_b; /* [n] */
    double *r_b; /* [n] */
    double min_margin;
    double gap;
    int which;
    int when;
    double impact;
    double zone_from;
    double begin_from;
    int zone_side;
    double rear_reaction;
    double rear_braking;
    int established;
    bool leaves;
    int duty_from;
    double rear;
} Scene;

/* Squared speed at which the curvature of a path needs a lateral acceleration, led down to in comfort. */
void cca_limit_path_speed(Scene *w, int p, double a_y);

/* Drive a path: cruise, follow, yield to the first crossing vehicles, brake; `tail` after `react`. */
void cca_roll_out(Scene *w, int row, int p, bool follows, bool passes, int yields, double braking,
    double tail, bool kept);

/* Integrals over a time of what a motion costs, and its peak lateral acceleration. */
void cca_sum_costs(Scene *w, int row, int p, double until);

/* Keep the vehicles of one direction behind each other, the first one first. */
void cca_set_order(Scene *w, double sign);

/* Speed of a vehicle that stays behind others; second order for unequal steps. */
void cca_set_following_speed(Scene *w, int j);

/* A path. The kernel only reads it, so threads may share it. */
typedef struct Curve {
    int segments;
    double *breaks; /* [segments + 1] */
    double *powers; /* [segments][8] */
} Curve;

/* Points of a path from its first to its last one, for the search of the nearest one. */
typedef struct CurveSamples {
    int count;
    int stride;
    double max_gap;
    double *s; /* [count] */
    double *x; /* [count] */
    double *y; /* [count] */
} CurveSamples;

typedef struct cca_dddddd { double item0; double item1; double item2; double item3; double item4; double item5; } cca_dddddd;

/* Position x, y [m], first and second derivative by arc length. */
cca_dddddd cca_curve_point(const Curve *curve, double s);

/* Positions, first and second derivatives at n arc lengths.
   s[n], position[n][2], first[n][2], second[n][2] */
void cca_curve_points(const Curve *curve, int n, const double *s, double *position, double *first, double
    *second);

/* Signed curvature at an arc length [1/m]. */
double cca_curvature_at(const Curve *curve, double s);

typedef struct cca_dddd { double item0; double item1; double item2; double item3; } cca_dddd;

/* Foot point by Newton's method from an initial guess: s, d [m], heading [rad] and curvature [1/m]. */
cca_dddd cca_foot_point(const Curve *curve, double x, double y, double s_guess);

typedef struct cca_dd { double item0; double item1; } cca_dd;

/* Foot point s, d of a position that is nearest on the whole path. */
cca_dd cca_nearest_point(const Curve *curve, const CurveSamples *samples, double x, double y);

/* Foot points of n positions from initial guesses.
   x[n], y[n], s_guess[n], s[n], d[n], heading[n], curvature[n] */
void cca_foot_points(const Curve *curve, int n, const double *x, const double *y, const double *s_guess,
    double *s, double *d, double *heading, double *curvature);

/* Nearest points of n positions on the whole path; those that follow each other are found sooner.
   x[n], y[n], s[n], d[n] */
void cca_nearest_points(const Curve *curve, const CurveSamples *samples, int n, const double *x,
    const double *y, double *s, double *d);

typedef struct cca_ddd { double item0; double item1; double item2; } cca_ddd;

/* Distance driven at many times.
   t[n], distance[n] */
void cca_distances_driven(int n, const double *t, double v, double a_x, double *distance);

/* Displacements that vehicles can reach, one time for each.
   v[n], t[n], age[n], rate[n], low[n], high[n] */
void cca_reachable_intervals(int n, const double *v, const double *t, const double *age, const double
    *rate, double braking, double acceleration, double *low, double *high);

/* Stations that the bodies of vehicles may cover at common times.
   motion[vehicles][8], t[times], rear[vehicles][times], front[vehicles][times] */
void cca_occupied_intervals(int vehicles, int times, const double *motion, const double *t, double *rear,
    double *front);

/* Intervals of the road in which vehicles of the adjacent lane block a maneuver, relative to the ego.
   motion[vehicles][8], t[times], travel[times], zone[vehicles][2] */
void cca_danger_zones(int vehicles, int times, const double *motion, const double *t, const double
    *travel, double *zone);

typedef struct cca_ddddd { double item0; double item1; double item2; double item3; double item4; } cca_ddddd;

/* Boxes that cover occupied intervals near given stations.
   s[n], rear[n], front[n], d[n], half_width[n], boxes[n][5] */
void cca_occupancy_boxes(const Curve *curve, int n, const double *s, const double *rear, const double
    *front, const double *d, const double *half_width, double *boxes);

/* Boxes of vehicles at common times, one vehicle after another, near the stations of the ego then.
   s[times], rear[vehicles][times], front[vehicles][times], d[vehicles], half_width[vehicles],
       boxes[(vehicles * times)][5] */
void cca_vehicle_boxes(const Curve *curve, int vehicles, int times, const double *s, const double *rear,
    const double *front, const double *d, const double *half_width, double *boxes);

/* Predict the vehicles in `seen`, the first of which are real, the others assumed. */
void cca_locate_vehicles(Scene *w, int seen);

/* Find from when on vehicles behind the ego must keep their distance; return when it is in its lane. */
int cca_find_duty(Scene *w, int row, int p, double wait);

/* Whether a vehicle is behind the ego in its lane from `duty_from` on, for good. */
bool cca_has_duty(const Scene *w, int j, int back);

/* First step at which a vehicle from the side is behind the ego in its way, and keeps its distance. */
int cca_merges_behind(const Scene *w, int row, int j);

/* Whether a vehicle that is nominally behind cannot be alongside: far enough, or in the ego's lane. */
bool cca_is_behind(const Scene *w, int row, int p, int j, int back);

/* Whether a vehicle follows an ego outside its lane, in one of the lanes that the ego is in. */
bool cca_is_established(const Scene *w, int j);

/* Index of the first time that is not before another. */
int cca_zone_begin(const Scene *w, double since);

/* Whether a vehicle is in the adjacent lane that the maneuver enters. */
bool cca_is_in_zone_lane(const Scene *w, int j);

/* Whether a vehicle is for certain in the adjacent lane that the maneuver enters, not in the ego's. */
bool cca_keeps_zone(const Scene *w, int j);

/* Whether a driver behind in the adjacent lane has the room to react to the ego from a time on. */
bool cca_reacts(const Scene *w, int row, int j, int begin);

/* Least gap behind the ego to a vehicle of the adjacent lane, in its worst case until it reacts. */
double cca_worst_rear_gap(const Scene *w, int row, int j, int begin);

/* Least gap to the nominal motion of others beyond what is asked, and the first overlap.

Asked are `clearance` of vehicles that are passed; of others `touch`, and `met` where the ego is outside
its lane. */
void cca_check_nominal(Scene *w, int row, int p, double touch, double met, double clearance, double wait,
    double pet);

/* Whether vehicles within the declared bounds cannot touch the ego.

`which`: 0 all vehicles; 1 those of the adjacent lane on `zone_side`; 2 all others. With `x_safety` the
ego keeps that distance along the road to vehicles of the adjacent lane until it has returned: from when
it enters that lane, or from when the maneuver begins if the vehicle comes nearer. `impact` is the closing
speed at the first overlap. */
bool cca_check_worst_case(Scene *w, int row, int p, double touch, double clearance, double wait,
    double x_safety, int which);

/* Find the stations of a path that each crossing vehicle passes over, and when; infinite if none. */
void cca_find_conflicts(Scene *w, int p, int reach, double margin);

/* Find the displacement of each band; `stiffness` is that of rate, bending, tension and both contacts.
   stiffness[bands][5], lower[bands][n], upper[bands][n], lower_difference[bands][n],
       upper_difference[bands][n], u[bands][n], solves[bands], converged[bands] */
void cca_find_equilibria(Equilibrium *e, int bands, int n, bool bounded, const double *stiffness,
    const double *lower, const double *upper, const double *lower_difference, const double *upper_difference,
    double *u, int *solves, int *converged);

/* Find the step at which a motion along the route meets each vehicle ahead of `rear`. */
void cca_find_meetings(Scene *w, int row, double rear);

/* Stations between which the ego is alongside a vehicle in its worst case, and the lead before that. */
cca_ddd cca_find_span(const Scene *w, int row, int j, double clearance, double ttc);

/* Boxes of a group in its worst case, and nominally of the others near the stations; their number.
   s[n], t[n], rows[vehicles], boxes[(vehicles * n)][5] */
int cca_find_obstacles(const Scene *w, const Curve *curve, double base, int n, const double *s,
    const double *t, double rear, int group, int vehicles, int *rows, double *boxes);

/* Assumed reaction of a vehicle. */
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

/* Safe distances behind vehicles that may brake fully.
   v_rear[n], v_front[n], distance[n] */
void cca_same_direction_distances(int n, const double *v_rear, const double *v_front, const RssReaction
    *rear, const RssReaction *front, double *distance);

/* Safe distances between vehicles that approach each other.
   v_correct[n], v_opposite[n], distance[n] */
void cca_opposite_distances(int n, const double *v_correct, const double *v_opposite, const RssReaction
    *correct, const RssReaction *opposite, double *distance);

/* Safe lateral distances between vehicles alongside each other.
   v_left[n], v_right[n], distance[n] */
void cca_lateral_distances(int n, const double *v_left, const double *v_right, const RssReaction *left,
    const RssReaction *right, double *distance);

/* Constants and states of the car. */
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

/* Side force for the tangent of the slip angle [N]. */
double cca_fiala_force(double stiffness, double slip, double f_max);

typedef struct cca_dddddddd { double item0; double item1; double item2; double item3; double item4; double item5; double item6; double item7; } cca_dddddddd;

/* Advance a moving car by a time step with a commanded angle and acceleration. */
void cca_drive(SingleTrackCar *car, double delta, double a_x, double dt);

/* Compute when points ahead are reached if the target speed is approached freely.
   distance[n], t[n] */
void cca_arrival_times(int n, double v_x, double v_target, const double *distance, double a_max,
    double b_comfort, double *t);

/* Squares of the highest speeds at stations, with standstill at the last one.
   s[n], squared[n] */
void cca_squared_speed_limits(const Curve *curve, int n, double cruise, double a_y, double b_comfort,
    const double *s, double *squared);

/* Value at a station, linear between the given ones and constant beyond.
   at[n], value[n] */
double cca_interpolated(int n, const double *at, const double *value, double s);

/* Acceleration along a speed profile, with its slope as feedforward.
   at[n], squared[n] */
double cca_profile_acceleration(int n, const double *at, const double *squared, double s, double v_x,
    double a_max, double b_comfort, double b_max);

/* The model whose center of gravity stays on the path, and its states where it has passed. */
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
    double delta;
    bool held;
    int first;
    int count;
    double *trace_s; /* [1024] */
    double *trace_beta; /* [1024] */
    double *trace_r; /* [1024] */
} IdealCar;

/* Gains, limits and states of the steering law. */
typedef struct Steering {
    double delta_max;
    double delta_rate_max;
    double steering_lag;
    double understeer;
    double delay;
    double a_y_max;
    bool ahead;
    int count;
    double *speeds; /* [count] */
    double *k_p; /* [count] */
    double *k_d; /* [count] */
    double *l_s; /* [count] */
    double s;
    double integral;
    bool started;
    double delta;
} Steering;

/* Slip angle at which the front tires carry a fraction of their grip. */
double cca_front_slip(const IdealCar *car, double fraction);

/* Move the ideal car along the path; return the steering angle that it needs there.

An input that is no number is dropped: the car stays, and the last angle is held. */
double cca_advance(IdealCar *car, double s, double kappa, double v_x, double dt);

/* Sideslip and yaw rate of the ideal car at a station that it has passed; older ones are dropped. */
cca_dd cca_find_passed(IdealCar *car, double s);

/* Road-wheel angle for this cycle; `law.s` becomes the station of the vehicle. */
double cca_steer(Steering *law, IdealCar *car, const Curve *curve, double s_guess, double x, double y,
    double psi, double v_x, double v_y, double r, double dt);

#ifdef __cplusplus
}
#endif

#endif
