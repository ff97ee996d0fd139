/* The contact of two equal spheres, or of one with a plane: linear spring and dashpot, tangential
 * spring, Coulomb's limit.
 *
 * Cundall and Strack 1979; signs and levers are those of particles.h. The tangential spring grows
 * by the slip of both halves of a step, each with its own geometry, and turns with the normal in
 * between; where it would exceed friction times the normal force it is cut.
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

/* Overlap of a listed pair, positive if it touches, and then the normal from a to b in n (3). */
static inline double overlap(const gas *g, int64_t a, int64_t b, int image, double *n)
{
    const double *x = g->now.x + 3 * a;
    const double d = g->p->diameter;
    if (b < 0) {
        const double *q = g->p->plane + 6 * (-1 - b);
        double away = 0.0;
        for (int c = 0; c < 3; c++) {
            away += (x[c] - q[c]) * q[3 + c];
            n[c] = -q[3 + c];
        }
        return 0.5 * d - away;
    }
    const double *y = g->now.x + 3 * b;
    const double *s = g->shift[image];
    for (int c = 0; c < 3; c++)
        n[c] = (y[c] - x[c]) + s[c];
    double square = dot(n, n);
    if (!(square < d * d))
        return 0.0;
    double r = sqrt(square);
    for (int c = 0; c < 3; c++)
        n[c] /= r;
    return d - r;
}

/* A velocity or a spin as it is, or later, as the last forces predict it. */
static inline double expected(const double *now, const double *change, int64_t at, int later)
{
    if (later)
        return now[at] + change[at];
    return now[at] + 0.0;
}

/* Velocity of a against b at the ends of their levers, without what is along the normal; `later`:
 * as the last forces predict it for the end of the step. Returns the rate of the overlap. */
static inline double slips(const gas *g, const contact *c, const double *n, double deep, int later,
                           double *slip)
{
    int64_t a = 3 * (int64_t)c->a;
    int64_t b = 3 * (int64_t)c->b;
    double arm = 0.5 * g->p->diameter - g->p->branch * deep;
    double spin[3], turned[3];
    for (int k = 0; k < 3; k++) {
        slip[k] = expected(g->now.v, g->now.kick, a + k, later);
        if (c->b >= 0) /* a plane rests */
            slip[k] -= expected(g->now.v, g->now.kick, b + k, later);
    }
    double rate = dot(slip, n);
    if (!(g->p->friction > 0.0))
        return rate;
    for (int k = 0; k < 3; k++) {
        spin[k] = expected(g->now.w, g->now.turn, a + k, later);
        if (c->b >= 0)
            spin[k] += expected(g->now.w, g->now.turn, b + k, later);
        spin[k] *= arm;
    }
    cross(spin, n, turned);
    for (int k = 0; k < 3; k++)
        slip[k] += turned[k] - rate * n[k];
    return rate;
}

/* The tangential spring over the step: from that of the contact before, or from the moment at which
 * a new one has begun; at the start of a run it is slack. */
static inline void stretch(const gas *g, contact *c, const contact *before, double sense,
                           int has_moved)
{
    double slip[3];
    double half = 0.5 * g->h;
    if (before == NULL) {
        double rate = slips(g, c, c->n, c->deep, 0, slip);
        double since = g->h;
        memset(c->bend, 0, sizeof c->bend);
        if (!has_moved)
            return;
        /* The overlap has grown at its rate since it began, but not for longer than a step. */
        if (rate * g->h > 0.0 && fabs(c->deep / rate) < fabs(g->h))
            since = c->deep / rate;
        add_scaled(c->bend, since, slip);
        return;
    }
    double old[3], both[3];
    for (int k = 0; k < 3; k++) {
        old[k] = sense * before->n[k];
        c->bend[k] = sense * before->bend[k];
        both[k] = old[k] + c->n[k];
    }
    slips(g, c, old, before->deep, 0, slip);
    add_scaled(c->bend, half, slip);
    add_scaled(c->bend, -dot(c->n, c->bend) / (1.0 + dot(old, c->n)), both);
    slips(g, c, c->n, c->deep, 0, slip);
    add_scaled(c->bend, half, slip);
}

/* Half a step's change of velocity, on the grid, and of spin; the power of damping and of friction.
 */
static inline void press(const gas *g, contact *c)
{
    const refdem_gas *p = g->p;
    double slip[3];
    double rate = slips(g, c, c->n, c->deep, 1, slip);
    double pull = p->damping * rate;
    double normal = p->stiffness * c->deep + pull;
    double ease = 0.5 * g->h / p->mass;
    double force[3];
    if (p->no_pull && normal < 0.0) {
        pull -= normal;
        normal = 0.0;
    }
    c->power = pull * rate;
    for (int k = 0; k < 3; k++)
        force[k] = -normal * c->n[k];
    if (p->friction > 0.0) {
        double limit = p->friction * fmax(normal, 0.0);
        double held = p->tangential_stiffness * sqrt(dot(c->bend, c->bend));
        double kept = 1.0;
        if (held > limit) /* it slides: the spring is cut to its limit */
            kept = limit / held;
        double rub[3];
        double arm = 0.5 * p->diameter - p->branch * c->deep;
        for (int k = 0; k < 3; k++) {
            c->bend[k] *= kept;
            rub[k] = -p->tangential_stiffness * c->bend[k];
            force[k] += rub[k];
        }
        c->power -= dot(rub, slip);
        cross(c->n, rub, c->twist);
        for (int k = 0; k < 3; k++)
            c->twist[k] *= arm * 0.5 * g->h / p->inertia;
    }
    for (int k = 0; k < 3; k++)
        c->push[k] = (ease * force[k] + g->round) - g->round;
}

/* Energy that a contact's tangential spring holds. */
static inline double stored(const gas *g, const contact *c)
{
    if (!(g->p->friction > 0.0))
        return 0.0;
    return 0.5 * g->p->tangential_stiffness * dot(c->bend, c->bend);
}

#endif
