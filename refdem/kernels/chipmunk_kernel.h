/* The kernel family chipmunk: what stands below its line is what Python calls. */
#ifndef REFDEM_CHIPMUNK_KERNEL_H
#define REFDEM_CHIPMUNK_KERNEL_H

#include <stdint.h>

/* == chipmunk == */

typedef struct {
    double x, y;
} refdem_vector2;

/* Addresses in the engine: its space, its step, and the functions that read a body's state; angle
 * and omega are NULL if no body can rotate. */
typedef struct {
    void *space;
    void (*step)(void *space, double h);
    refdem_vector2 (*position)(void *body);
    refdem_vector2 (*velocity)(void *body);
    double (*angle)(void *body);
    double (*omega)(void *body);
} refdem_chipmunk_engine;

/* Steps Chipmunk `stride` times a sample. out (samples, bodies, 6): x, y [m], vx, vy [m/s], angle
 * [rad], omega [rad/s]; row 0 is the state at the start; angle and omega are not written if no body
 * can rotate. Returns 0. */
int refdem_chipmunk_record(const refdem_chipmunk_engine *engine, int64_t bodies, void *const *body,
                           double h, int64_t samples, int64_t stride, double *out);

/* Forces that Chipmunk evaluates in every step by callbacks. owner (laws): the engine's body or
 * constraint that each law belongs to, in ascending order of addresses. kind (laws): 0 drive, 1
 * spring, 2 dashpot, 3 central field, 4 piecewise field, 5 soft contact, 6 dry friction that
 * depends on the speed. number (laws, 10): the rows of force_rows.h; of friction: normal force [N],
 * mu0, mu1, lambda0 [s/m], lambda1 [s^2/m^2 or s/m], the power of the speed in its last term, axis
 * (2). The others are addresses in the engine; the step that began when `timestamp` was n ends at
 * start + n step [s]. */
typedef struct {
    void *space;
    unsigned int (*timestamp)(const void *space);
    refdem_vector2 (*position)(const void *body);
    refdem_vector2 (*velocity)(const void *body);
    void (*set_force)(void *body, refdem_vector2 force);
    void (*update_velocity)(void *body, refdem_vector2 gravity, double damping, double h);
    void *(*body_a)(const void *constraint);
    void *(*body_b)(const void *constraint);
    void (*set_damping)(void *spring, double damping);
    void (*set_limit)(void *joint, double force);
    double start, step;
    int64_t laws;
    void *const *owner;
    const int64_t *kind;
    const double *number;
} refdem_chipmunk_laws;

/* What the functions below apply in this thread from now on; NULL for nothing. */
void refdem_chipmunk_set(const refdem_chipmunk_laws *laws);

/* cpBodyVelocityFunc: the forces on a body, then the engine's own update of its velocity. */
void refdem_chipmunk_push(void *body, refdem_vector2 gravity, double damping, double h);

/* cpDampedSpringForceFunc: the force [N] of a spring or soft contact at a distance [m], positive
 * where it pushes its ends apart. */
double refdem_chipmunk_spring(void *constraint, double distance);

/* cpConstraintPreSolveFunc: before a step, whether the damper of a soft contact acts, and the limit
 * of a friction. */
void refdem_chipmunk_prepare(void *constraint, void *space);

#endif
