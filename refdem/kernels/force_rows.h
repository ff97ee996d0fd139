/* The numbers of one force as an adapter hands them over: a row of doubles, seen through the struct
 * of its kind. The callbacks of MuJoCo, REBOUND and Chipmunk read the same rows. */
#ifndef REFDEM_FORCE_ROWS_H
#define REFDEM_FORCE_ROWS_H

#include <math.h>
#include <stdint.h>

/* The kinds of forces on a point, as adapters number them. */
enum { DRIVE, SPRING, DASHPOT, CENTRAL, PIECEWISE };
/* Doubles of a row in a table of several kinds. */
enum { NUMBERS = 10 };

/* F = force cos(frequency t + phase) along the axis. [N], [rad/s], [rad]. */
typedef struct {
    double force, frequency, phase, axis[3];
} drive_row;

/* F = -(stiffness |s|^exponent sgn(s) + quadratic s^2 + cubic s^3) d/|d|, with d from the anchor
 * [m] and s = |d| - length. */
typedef struct {
    double stiffness, length, exponent, anchor[3], quadratic, cubic;
} spring_row;

/* F = -(damping + van_der_pol |d|^2) (v - rate x d), with d from the anchor [m]; `rate` [rad/s] is
 * that of the fluid, 0 for a fluid at rest. */
typedef struct {
    double damping, van_der_pol, anchor[3], rate[3];
} dashpot_row;

/* F = -attraction r/|r|^3 with attraction = G M m [N m^2]. */
typedef struct {
    double attraction;
} central_row;

/* F along the axis at s = (r - point).axis: k1 (s - x1) for x1 <= s <= 0, k2 (s - x2) for
 * 0 <= s <= x2, else none. [N/m], [m]. */
typedef struct {
    double k1, k2, x1, x2, point[3], axis[3];
} piecewise_row;

/* F = stiffness o^exponent + damping do/dt along the line of centres at the overlap
 * o = reach - distance > 0, reach being the sum of the radii [m]; below 0 only if it may pull. */
typedef struct {
    double reach, stiffness, exponent, damping, may_pull;
} contact_row;

/* The pull stiffness |s|^exponent sgn(s) + quadratic s^2 + cubic s^3 of a spring at the stretch s.
 */
static inline double spring_pull(const spring_row *p, double s)
{
    double power = p->stiffness * copysign(pow(fabs(s), p->exponent), s);
    return power + (p->quadratic + p->cubic * s) * s * s;
}

/* The force of a piecewise field at s: k1 (s - x1) on (x1, 0], k2 (s - x2) on (0, x2), else 0. */
static inline double piecewise_force(const piecewise_row *p, double s)
{
    if (s > p->x1 && s <= 0)
        return p->k1 * (s - p->x1);
    if (s > 0 && s < p->x2)
        return p->k2 * (s - p->x2);
    return 0.0;
}

/* The distance of a point from an anchor, and its branch vector d. */
static inline double branch(const double *anchor, const double *place, double *d)
{
    double square = 0.0;
    for (int i = 0; i < 3; i++) {
        d[i] = place[i] - anchor[i];
        square += d[i] * d[i];
    }
    return sqrt(square);
}

/* The velocity of a point against the fluid of a dashpot, v - rate x d. */
static inline void slip_of(const dashpot_row *p, const double *d, const double *velocity,
                           double *slip)
{
    const double *w = p->rate;
    slip[0] = velocity[0] - (w[1] * d[2] - w[2] * d[1]);
    slip[1] = velocity[1] - (w[2] * d[0] - w[0] * d[2]);
    slip[2] = velocity[2] - (w[0] * d[1] - w[1] * d[0]);
}

/* The force (3) [N] of one row on a point at time t [s], from its place (3) [m] and velocity (3)
 * [m/s]: relative to the other end of the row's element, where it has one. */
static inline void force_on(int64_t kind, const double *row, double t, const double *place,
                            const double *velocity, double *force)
{
    static const double origin[3] = {0, 0, 0};
    const double *direction = place; /* F = strength direction */
    double strength = 0.0;
    double d[3], slip[3];
    if (kind == DRIVE) {
        const drive_row *p = (const void *)row;
        /* F = force cos(frequency t + phase) axis. */
        strength = p->force * cos(p->frequency * t + p->phase);
        direction = p->axis;
    } else if (kind == SPRING) {
        const spring_row *p = (const void *)row;
        double distance = branch(p->anchor, place, d);
        /* F = -pull(|d| - length) d/|d|; 0 where the ends coincide and d has no direction. */
        if (distance > 0)
            strength = -spring_pull(p, distance - p->length) / distance;
        direction = d;
    } else if (kind == DASHPOT) {
        const dashpot_row *p = (const void *)row;
        double distance = branch(p->anchor, place, d);
        /* F = -(damping + van_der_pol |d|^2) (v - rate x d). */
        strength = -(p->damping + p->van_der_pol * distance * distance);
        slip_of(p, d, velocity, slip);
        direction = slip;
    } else if (kind == CENTRAL) {
        const central_row *p = (const void *)row;
        double distance = branch(origin, place, d);
        /* F = -G M m r/|r|^3. */
        strength = -p->attraction / (distance * distance * distance);
    } else if (kind == PIECEWISE) {
        const piecewise_row *p = (const void *)row;
        /* F = f(s) axis, s = (r - point).axis. */
        double s = 0.0;
        for (int i = 0; i < 3; i++)
            s += (place[i] - p->point[i]) * p->axis[i];
        strength = piecewise_force(p, s);
        direction = p->axis;
    }
    for (int i = 0; i < 3; i++)
        force[i] = strength * direction[i];
}

#endif
