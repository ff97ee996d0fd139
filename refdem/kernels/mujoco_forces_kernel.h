/* The kernel family mujoco_forces: what stands below its line is what Python calls. */
#ifndef REFDEM_MUJOCO_FORCES_KERNEL_H
#define REFDEM_MUJOCO_FORCES_KERNEL_H

#include <stdint.h>

/* == mujoco_forces == */

/* Forces that MuJoCo has no element for. q, v, clock [s] and passive_force [N] are addresses in the
 * running mjData: coordinates, velocities, time, passive forces. kind (pushes): 0 drive, 1 spring,
 * 2 dashpot, 3 central field, 4 piecewise field. column (pushes, 12): where the place (3) and the
 * velocity (3) of body a lie in q and v, then those of body b; -1 where there is none, which counts
 * as 0. number (pushes, 10), by kind: force [N], frequency [rad/s], phase, axis (3); stiffness
 * [N/m^exponent], length [m], exponent, anchor (3) [m], quadratic [N/m^2], cubic [N/m^3]; damping
 * [N s/m], van_der_pol [N s/m^3], anchor (3), rate (3) [rad/s]; gm times mass [N m^2]; k1, k2
 * [N/m], x1, x2 [m], point (3) [m], axis (3). */
typedef struct {
    const double *q, *v, *clock;
    double *passive_force;
    int64_t pushes;
    const int64_t *kind, *column;
    const double *number;
} refdem_mujoco_forces;

/* Sets the forces that the callback applies in this thread from now on; NULL for none. */
void refdem_mujoco_forces_set(const refdem_mujoco_forces *forces);

/* The address of the callback `void (const mjModel *, mjData *)`. */
void *refdem_mujoco_forces_callback(void);

#endif
