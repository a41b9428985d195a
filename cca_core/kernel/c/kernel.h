/* Made from the Python of cca_core/kernel by `make kernel`: edit that. */

#ifndef CCA_KERNEL_H
#define CCA_KERNEL_H

#include <stdbool.h>

double cca_oriented_box_gap(double dx, double dy, double ax, double ay, double bx, double by, double length_a,
    double width_a, double length_b, double width_b);

double cca_aligned_box_gaps(int n, const double *dx, const double *dy, double length, double width, double
    *gap);

#endif
