/* The contact of two equal spheres a and b, or of one with a plane: linear spring and dashpot,
 * tangential spring, Coulomb's limit (Cundall and Strack 1979; signs and levers as in particles.h).
 *   overlap      d = diameter - |x_b - x_a|,   d' = (v_a - v_b).n,   n from a to b
 *   force        F = k d + c d',   on a: -F n - k_t s,   |k_t s| <= mu F
 *   slip         u = v_a - v_b - d' n + l (w_a + w_b) x n,   l = diameter/2 - branch d
 *   spring       s' = u: it grows by the slip of both halves of a step, each with its own geometry,
 *                and is rotated with the normal in between; beyond its limit it is shortened
 * A step of velocity Verlet changes velocities by h/2 force/m at its start and at its end: the
 * `impulse` of a contact is h/2 force/m, its `spin_change` h/2 torque/J.
 */
#ifndef REFDEM_GAS_CONTACT_H
#define REFDEM_GAS_CONTACT_H

#include "gas_state.h"

static inline double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross(const double *a, const double *b, double *out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void add_scaled(double *a, double factor, const double *b)
{
    for (int c = 0; c < 3; c++)
        a[c] += factor * b[c];
}

/* Overlap [m] of a listed pair, positive if it is in contact, and then the normal from a to b in n
 * (3). For spheres that are not in contact it is 0, which saves the square root. `image`: the image
 * of the box that b is in.
 *   spheres   d = diameter - |r|,   r = x_b + shift - x_a,   n = r/|r|
 *   plane     d = diameter/2 - (x_a - p).n_p,   n = -n_p */
static inline double overlap(const gas *g, int64_t a, int64_t b, int image, double *n)
{
    const double *x = g->now.x + 3 * a;
    const double diameter = g->p->diameter;
    if (b < 0) {
        const double *plane = g->p->plane + 6 * (-1 - b);
        double distance = 0.0;
        for (int c = 0; c < 3; c++) {
            distance += (x[c] - plane[c]) * plane[3 + c];
            n[c] = -plane[3 + c];
        }
        return 0.5 * diameter - distance;
    }
    const double *y = g->now.x + 3 * b;
    const double *shift = g->shift[image];
    for (int c = 0; c < 3; c++)
        n[c] = (y[c] - x[c]) + shift[c];
    double square = dot(n, n);
    if (!(square < diameter * diameter))
        return 0.0;
    double distance_b = sqrt(square);
    for (int c = 0; c < 3; c++)
        n[c] /= distance_b;
    return diameter - distance_b;
}

/* A component of a velocity or spin, or, if `later`, its prediction v + h/2 a for the end of the
 * step with the last forces. Adding 0.0 in the first case rounds alike in both: -0.0 becomes 0.0.
 */
static inline double predicted(const double *now, const double *change, int64_t at, int later)
{
    if (later)
        return now[at] + change[at];
    return now[at] + 0.0;
}

/* The slip u (3) of a contact with the normal n and the overlap `deep`, from velocities as they are
 * or `later`, as predicted for the end of the step. Returns the rate d' of the overlap. Without
 * friction only d' is needed. */
static inline double slip_of(const gas *g, const contact *c, const double *n, double deep,
                             int later, double *slip)
{
    int64_t a = 3 * (int64_t)c->a;
    int64_t b = 3 * (int64_t)c->b;
    /* l = diameter/2 - branch d,  d' = (v_a - v_b).n,  u = v_a - v_b - d' n + l (w_a + w_b) x n */
    double arm = 0.5 * g->p->diameter - g->p->branch * deep;
    double spin[3], spin_slip[3];
    for (int k = 0; k < 3; k++) {
        slip[k] = predicted(g->now.v, g->now.kick, a + k, later);
        if (c->b >= 0) /* a plane rests */
            slip[k] -= predicted(g->now.v, g->now.kick, b + k, later);
    }
    double rate = dot(slip, n);
    if (!(g->p->friction > 0.0)) /* the slip is not asked for */
        return rate;
    for (int k = 0; k < 3; k++) {
        spin[k] = predicted(g->now.w, g->now.turn, a + k, later);
        if (c->b >= 0)
            spin[k] += predicted(g->now.w, g->now.turn, b + k, later);
        spin[k] *= arm;
    }
    cross(spin, n, spin_slip);
    for (int k = 0; k < 3; k++)
        slip[k] += spin_slip[k] - rate * n[k];
    return rate;
}

/* Advances the tangential spring s over the step, from the contact `before`, with `sign` -1 if that
 * was of (b, a), by h/2 u at the old normal n0, the rotation to the new normal n, and h/2 u there:
 *
 *   s += h/2 u(n0),   s -= (n.s)/(1 + n0.n) (n0 + n),   s += h/2 u(n).
 *
 * A new contact began a time d/d' ago, but at most h: s = u min(d/d', h). At the start of a run
 * (has_moved 0) s = 0. */
static inline void move_spring(const gas *g, contact *c, const contact *before, double sign,
                               int has_moved)
{
    double slip[3];
    double half_step = 0.5 * g->h;
    if (before == NULL) {
        double rate = slip_of(g, c, c->n, c->overlap, 0, slip);
        double duration = g->h;
        memset(c->spring, 0, sizeof c->spring);
        if (!has_moved)
            return;
        /* The overlap has grown at its rate since it began, but not for longer than a step. */
        if (rate * g->h > 0.0 && fabs(c->overlap / rate) < fabs(g->h))
            duration = c->overlap / rate;
        add_scaled(c->spring, duration, slip);
        return;
    }
    double normal_before[3], bisector[3];
    for (int k = 0; k < 3; k++) {
        normal_before[k] = sign * before->n[k];
        c->spring[k] = sign * before->spring[k];
        bisector[k] = normal_before[k] + c->n[k];
    }
    slip_of(g, c, normal_before, before->overlap, 0, slip);
    add_scaled(c->spring, half_step, slip);
    add_scaled(c->spring, -dot(c->n, c->spring) / (1.0 + dot(normal_before, c->n)), bisector);
    slip_of(g, c, c->n, c->overlap, 0, slip);
    add_scaled(c->spring, half_step, slip);
}

/* The impulse h/2 force/m of a on the grid of velocities, the change h/2 l (n x f)/J of both spins
 * by the tangential force f, and the power lost by damping, c d'^2, and by friction, -f.u. Where
 * F = k d + c d' < 0 and the law does not pull, F = 0, and the force of the dashpot is -k d. */
static inline void add_forces(const gas *g, contact *c)
{
    const refdem_gas *p = g->p;
    double slip[3];
    double rate = slip_of(g, c, c->n, c->overlap, 1, slip);
    double damping_force = p->damping * rate;
    double normal = p->stiffness * c->overlap + damping_force;
    double half_step_per_mass = 0.5 * g->h / p->mass;
    double force[3];
    if (p->no_pull && normal < 0.0) {
        damping_force -= normal;
        normal = 0.0;
    }
    c->power = damping_force * rate;
    for (int k = 0; k < 3; k++)
        force[k] = -normal * c->n[k];
    if (p->friction > 0.0) {
        double limit = p->friction * fmax(normal, 0.0);
        double spring_force = p->tangential_stiffness * sqrt(dot(c->spring, c->spring));
        double part_kept = 1.0;
        if (spring_force > limit) /* it slides: the spring is shortened to k_t |s| = mu F */
            part_kept = limit / spring_force;
        double friction[3];
        double arm = 0.5 * p->diameter - p->branch * c->overlap;
        for (int k = 0; k < 3; k++) {
            c->spring[k] *= part_kept;
            friction[k] = -p->tangential_stiffness * c->spring[k]; /* f = -k_t s */
            force[k] += friction[k];
        }
        c->power -= dot(friction, slip);
        cross(c->n, friction, c->spin_change);
        for (int k = 0; k < 3; k++)
            c->spin_change[k] *= arm * 0.5 * g->h / p->inertia;
    }
    /* Rounded to the grid, so that what a gains b loses, exactly. */
    for (int k = 0; k < 3; k++)
        c->impulse[k] = (half_step_per_mass * force[k] + g->round) - g->round;
}

/* Energy k_t s^2/2 [J] that a contact's tangential spring holds. */
static inline double spring_energy(const gas *g, const contact *c)
{
    if (!(g->p->friction > 0.0))
        return 0.0;
    return 0.5 * g->p->tangential_stiffness * dot(c->spring, c->spring);
}

#endif
