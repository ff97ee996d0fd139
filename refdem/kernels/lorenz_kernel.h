/* The kernel family lorenz: what stands below its line is what Python calls. */
#ifndef REFDEM_LORENZ_KERNEL_H
#define REFDEM_LORENZ_KERNEL_H

#include <stdint.h>

/* == lorenz == */

/* x' = sigma (y - x), y' = x (rho - z) - y, z' = x y - beta z; `interval` is the time of one
 * iterate. */
typedef struct {
    double sigma, rho, beta, interval;
} refdem_lorenz_numbers;

/* The states (samples, 3) at times n (samples) in units of the interval; row 0 is the start, given,
 * at n[0]. Errors: a few ulp, times the growth S of the motion. Returns 0, or the sample (from 1)
 * that was not reached. */
int refdem_lorenz(const refdem_lorenz_numbers *p, int64_t samples, const double *n, double *out);

#endif
