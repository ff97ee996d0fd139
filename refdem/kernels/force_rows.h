/* The numbers of one force as an adapter hands them over: a row of doubles, seen through the struct
 * of its kind. MuJoCo's and REBOUND's callbacks read the same rows. */
#ifndef REFDEM_FORCE_ROWS_H
#define REFDEM_FORCE_ROWS_H

/* F = force cos(frequency t + phase) along the axis. [N], [rad/s], [rad]. */
typedef struct {
    double force, frequency, phase, axis[3];
} drive_row;

/* F = -(stiffness |s|^exponent sgn(s) + quadratic s^2 + cubic s^3) d/|d|, with d from the anchor
 * [m] and s = |d| - length. */
typedef struct {
    double stiffness, length, exponent, anchor[3], quadratic, cubic;
} spring_row;

/* F = -(damping + van_der_pol |d|^2) v, with d from the anchor [m]. */
typedef struct {
    double damping, van_der_pol, anchor[3];
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

/* The force of a piecewise field at s. */
static inline double piecewise_force(const piecewise_row *p, double s)
{
    if (s > p->x1 && s <= 0)
        return p->k1 * (s - p->x1);
    if (s > 0 && s < p->x2)
        return p->k2 * (s - p->x2);
    return 0.0;
}

#endif
