/* The kernel family impacts: what stands below its line is what Python calls. */
#ifndef REFDEM_IMPACTS_KERNEL_H
#define REFDEM_IMPACTS_KERNEL_H

#include <stdint.h>

/* == impacts == */

/* Rigid spheres and planes: of each body mass [kg] (infinite: it is fixed), moment of inertia [kg
 * m^2] about every axis (infinite: it cannot be spun up) and radius [m], each (bodies); plane
 * (planes, 6): point [m] and unit normal; the law's coefficients; uniform gravity [m/s^2], without
 * fixed bodies, which all others would fall on; period [m] of a periodic box, at least 5.1 times
 * the largest diameter, or 0. With up to `few` bodies every pair is examined; with more bodies only
 * those of neighbouring cells are, which gives the same impacts faster. */
typedef struct {
    int64_t bodies, planes, few;
    const double *mass, *inertia, *radius, *plane;
    double restitution, tangential_restitution, friction, period;
    double gravity[3];
} refdem_impacts;

/* Doubles of room that a run needs. */
int64_t refdem_impacts_room(int64_t bodies);

/* From event to event, at the samples t (samples) [s], rising. position [m], velocity [m/s] and
 * omega [1/s] (samples, bodies, 3), attitude (samples, bodies, 4); row 0 is the start, given. work
 * (samples): energy lost so far [J]. event (most, 3): time [s], body, and the body or plane k as -1
 * - k that it meets; events after the first `most` are not kept. Errors: round-off times the
 * motion's own sensitivity. Returns the number of events; -k if sample k (from 1) was not reached
 * within `longest` events; -samples - k if the times of impacts before it could not be
 * distinguished, since spheres come to rest against each other in infinitely many impacts. */
int64_t refdem_impacts_run(const refdem_impacts *p, int64_t samples, const double *t, int64_t most,
                           int64_t longest, double *room, double *event, double *work,
                           double *position, double *velocity, double *omega, double *attitude);

#endif
