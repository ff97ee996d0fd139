/* One step of points and spheres within the modes of their contacts: velocity Verlet, Runge-Kutta,
 * extrapolation.
 *
 * Every sum is compensated: after its `size` numbers a state has as many that hold what rounding
 * has lost.
 */
#ifndef REFDEM_PARTICLE_STEPS_H
#define REFDEM_PARTICLE_STEPS_H

#include "particles.h"

enum { VERLET, RUNGE_KUTTA, EXTRAPOLATION };
enum { COLUMNS = 10 };

typedef struct {
    const refdem_particles *p;
    int method;
    int64_t size;
    int64_t *mode;
    double *scratch;
    double length, speed, turning, way; /* what an error is compared with */
} runner;

/* Number c of a state grows by `by`; what rounding loses is kept beside the state (Kahan 1965;
 * Knuth's sum, TAOCP 4.2.2). */
static inline void gain(const runner *r, const double *from, int64_t c, double by, double *to)
{
    double part = from[r->size + c] + by;
    double sum = from[c] + part;
    double taken = sum - from[c];
    to[r->size + c] = (from[c] - (sum - taken)) + (part - taken);
    to[c] = sum;
}

/* Velocity Verlet (Swope et al. 1982): kick, drift, kick. */

/* Turns the unit vector s towards the slip: tan(angle/2) falls as exp(-|slip| t k_t/limit), exactly
 * for constant slip. */
static inline void lean(const meeting *m, double stiffness, double h, double *restrict s)
{
    double fast = size(m->slip);
    if (fast == 0.0)
        return;
    double along = dot(s, m->slip) / fast;
    double decay = 0.0; /* a force without a limit to its friction turns the spring at once */
    if (m->limit > 0.0)
        decay = exp(-fast * stiffness * h / m->limit);
    double tangent = decay * sqrt(fmax(0.0, 1.0 - along) / fmax(1e-300, 1.0 + along));
    double cosine = (1.0 - tangent * tangent) / (1.0 + tangent * tangent);
    double sine = 2.0 * tangent / (1.0 + tangent * tangent);
    double across[3];
    for (int c = 0; c < 3; c++)
        across[c] = s[c] - along * m->slip[c] / fast;
    double rest = size(across);
    /* Motion in a plane: rounding must not turn the spring, least of all from where it points
     * against the slip. */
    if (rest < STRAIGHT)
        return;
    for (int c = 0; c < 3; c++)
        s[c] = cosine * m->slip[c] / fast + sine * across[c] / rest;
}

/* Half a step of every tangential spring; keeps the normals it saw, or turns the springs from those
 * to the new ones. */
static inline void stretch(const runner *r, double *restrict y, double h, double *restrict normal,
                           int carried)
{
    const refdem_particles *p = r->p;
    for (int64_t k = 0; k < p->pairs; k++) {
        double *s = y + history_at(p) + 3 * k;
        double *old = normal + 3 * k;
        if (r->mode[k] < STICK)
            continue;
        meeting m = meet(p, k, y);
        if (carried) {
            double both[3] = {old[0] + m.n[0], old[1] + m.n[1], old[2] + m.n[2]};
            add_scaled(s, -dot(m.n, s) / (1.0 + dot(old, m.n)), both);
        }
        if (r->mode[k] == STICK && p->tangential_stiffness > 0.0)
            add_scaled(s, h, m.slip);
        if (r->mode[k] == SLIP && p->tangential_stiffness > 0.0)
            lean(&m, grip(p, &m), h, s);
        memcpy(old, m.n, sizeof m.n);
    }
}

/* q turned by the rotation vector w h, exactly, and put back to unit length by one step of
   Newton's: the same turn rounds the same way every time, so that the length would drift with the
   number of steps. */
static inline void spin(int64_t n, const double *restrict w, double h, double *restrict q)
{
    for (int64_t i = 0; i < n; i++, w += 3, q += 4) {
        double angle = 0.5 * h * size(w);
        double part = 0.5 * h; /* sin(angle)/angle tends to 1 */
        if (angle != 0.0)
            part = 0.5 * h * sin(angle) / angle;
        double c = cos(angle);
        double v[3] = {part * w[0], part * w[1], part * w[2]};
        double old[4] = {q[0], q[1], q[2], q[3]};
        double across[3];
        cross(v, old + 1, across);
        q[0] = c * old[0] - dot(v, old + 1);
        for (int k = 0; k < 3; k++)
            q[1 + k] = c * old[1 + k] + old[0] * v[k] + across[k];
        if (angle == 0.0) /* what does not turn keeps its bits */
            continue;
        double unit = 1.5 - 0.5 * (q[0] * q[0] + dot(q + 1, q + 1));
        for (int k = 0; k < 4; k++)
            q[k] *= unit;
    }
}

/* Velocities and turning rates. */
static inline void kick(const runner *r, const double *from, const double *restrict dy, double h,
                        double *to)
{
    int64_t n = r->p->bodies;
    int64_t end = 6 * n;
    if (r->p->turning)
        end = 9 * n;
    for (int64_t c = 3 * n; c < end; c++)
        gain(r, from, c, h * dy[c], to);
}

/* Forces that depend on velocities get a predicted velocity and one correction, which keeps the
 * second order. */
static inline int verlet(const runner *r, const double *restrict y, const double *restrict dy,
                         double h, double *restrict out, double *restrict rate)
{
    const refdem_particles *p = r->p;
    double *half = r->scratch;
    double *normal = half + 2 * r->size;
    int rubs = p->friction > 0.0;
    int lags = p->damping > 0.0 || rubs;
    memcpy(out, y, 2 * (size_t)r->size * sizeof *y);
    kick(r, y, dy, 0.5 * h, out);
    if (rubs)
        stretch(r, out, 0.5 * h, normal, 0);
    for (int64_t c = 0; c < 3 * p->bodies; c++)
        gain(r, y, c, h * out[3 * p->bodies + c], out);
    if (p->turning)
        spin(p->bodies, out + spin_at(p), h, out + 9 * p->bodies);
    if (rubs)
        stretch(r, out, 0.5 * h, normal, 1);
    if (lags) {
        memcpy(half, out, 2 * (size_t)r->size * sizeof *y);
        kick(r, half, dy, 0.5 * h, out);
        rates(p, r->mode, out, rate);
        kick(r, half, rate, 0.5 * h, out);
    }
    rates(p, r->mode, out, rate);
    /* The second half of the kick: anew from the half step where the first one was a guess. */
    if (lags)
        kick(r, half, rate, 0.5 * h, out);
    else
        kick(r, out, rate, 0.5 * h, out);
    out[work_at(p)] += 0.5 * h * (dy[work_at(p)] + rate[work_at(p)]);
    return 1;
}

/* Attitudes to unit length; springs into the tangent plane, their directions to unit length. */
static inline void settle(const runner *r, double *restrict y)
{
    const refdem_particles *p = r->p;
    if (p->turning) {
        for (int64_t i = 0; i < p->bodies; i++) {
            double *q = y + 9 * p->bodies + 4 * i;
            double norm = sqrt(q[0] * q[0] + dot(q + 1, q + 1));
            for (int c = 0; c < 4; c++)
                q[c] /= norm;
        }
    }
    if (!(p->friction > 0.0))
        return;
    for (int64_t k = 0; k < p->pairs; k++) {
        double *s = y + history_at(p) + 3 * k;
        if (r->mode[k] < STICK)
            continue;
        meeting m = meet(p, k, y);
        add_scaled(s, -dot(s, m.n), m.n);
        double length = size(s);
        if (r->mode[k] == SLIP && length > 0.0) {
            for (int c = 0; c < 3; c++)
                s[c] /= length;
        }
    }
}

/* Kutta 1901. */
static inline int runge_kutta(const runner *r, const double *restrict y, const double *restrict dy,
                              double h, double *restrict out, double *restrict rate)
{
    double *b = r->scratch;
    double *c = b + r->size;
    double *d = c + r->size;
    double *at = d + r->size;
    for (int64_t i = 0; i < r->size; i++)
        at[i] = y[i] + 0.5 * h * dy[i];
    rates(r->p, r->mode, at, b);
    for (int64_t i = 0; i < r->size; i++)
        at[i] = y[i] + 0.5 * h * b[i];
    rates(r->p, r->mode, at, c);
    for (int64_t i = 0; i < r->size; i++)
        at[i] = y[i] + h * c[i];
    rates(r->p, r->mode, at, d);
    for (int64_t i = 0; i < r->size; i++)
        gain(r, y, i, h / 6.0 * ((dy[i] + d[i]) + 2.0 * (b[i] + c[i])), out);
    settle(r, out);
    rates(r->p, r->mode, out, rate);
    return 1;
}

/* The change over h by n steps of the modified midpoint rule (Gragg 1965), n even, as an increment.
 */
static inline void midpoint(const runner *r, const double *restrict y, const double *restrict dy,
                            double h, int n, double *restrict change, double *restrict work)
{
    double *at = work;
    double *rate = at + r->size;
    double *before = rate + r->size;
    double step = h / n;
    for (int64_t i = 0; i < r->size; i++) {
        before[i] = 0.0;
        change[i] = step * dy[i];
    }
    for (int k = 1; k <= n; k++) {
        for (int64_t i = 0; i < r->size; i++)
            at[i] = y[i] + change[i];
        rates(r->p, r->mode, at, rate);
        for (int64_t i = 0; i < r->size; i++) {
            double next;
            if (k < n)
                next = before[i] + 2.0 * step * rate[i];
            else /* the smoothing step at the end */
                next = 0.5 * (before[i] + change[i] + step * rate[i]);
            before[i] = change[i];
            change[i] = next;
        }
    }
}

/* The larger one, and what is not a number if either is none: a step that overflows has not
 * settled. */
static inline double larger(double a, double b)
{
    if (a > b || a != a)
        return a;
    return b;
}

/* What a difference in number i of a state is compared with. */
static inline double scale_of(const runner *r, int64_t i)
{
    int64_t n = r->p->bodies;
    if (i < 3 * n)
        return r->length;
    if (i < 6 * n)
        return r->speed;
    if (i < 9 * n)
        return r->turning;
    return 1.0; /* attitudes */
}

/* Largest difference of two rows in units of each block's scale; the direction of a slipping spring
 * counts as its force does. */
static inline double gap(const runner *r, const double *restrict end, const double *restrict a,
                         const double *restrict b)
{
    const refdem_particles *p = r->p;
    double worst = 0.0;
    for (int64_t i = 0; i < history_at(p); i++) {
        if (a[i] != b[i]) /* at rest there is no scale */
            worst = larger(fabs(a[i] - b[i]) / scale_of(r, i), worst);
    }
    if (!(p->friction > 0.0 && p->tangential_stiffness > 0.0))
        return worst;
    for (int64_t k = 0; k < p->pairs; k++) {
        if (r->mode[k] < STICK)
            continue;
        double unit = fabs(r->way);
        if (r->mode[k] != STICK) { /* a direction: it counts as its force does */
            meeting m = meet(p, k, end);
            double strain = m.normal / (p->stiffness * p->radius[m.i]);
            unit = fmax(fabs(1e-3 / strain), 1.0);
        }
        const double *spring_a = a + history_at(p) + 3 * k;
        const double *spring_b = b + history_at(p) + 3 * k;
        for (int c = 0; c < 3; c++)
            worst = larger(fabs(spring_a[c] - spring_b[c]) / unit, worst);
    }
    return worst;
}

/* Raises the scales to what the state shows: lengths, speeds, turning rates, and the way of a step.
 */
static inline void measure(runner *r, const double *restrict y, const double *restrict dy, double h)
{
    const refdem_particles *p = r->p;
    int64_t n = p->bodies;
    double radius = 0.0;
    double least = INFINITY;
    for (int64_t i = 0; i < n; i++) {
        if (!(p->radius[i] > 0.0)) /* a point */
            continue;
        radius = fmax(radius, p->radius[i]);
        least = fmin(least, p->radius[i]);
    }
    for (int64_t i = 0; i < 3 * n; i++) {
        r->length = fmax(r->length, fmax(fabs(y[i]), radius));
        r->speed = fmax(r->speed, fmax(fabs(y[3 * n + i]), fabs(h * dy[3 * n + i])));
    }
    /* Forces that hold each other leave the rounding of each. */
    for (int64_t k = 0; k < p->pairs; k++) {
        if (r->mode[k] < FREE)
            continue;
        meeting m = meet(p, k, y);
        double ease = p->ease[m.i];
        if (m.j >= 0)
            ease = fmax(ease, p->ease[m.j]);
        r->speed = fmax(r->speed, fabs(h * m.normal) * ease);
    }
    r->turning = fmax(r->turning, r->speed / least);
    if (p->turning) {
        for (int64_t i = spin_at(p); i < spin_at(p) + 3 * n; i++)
            r->turning = fmax(r->turning, fabs(y[i]));
    }
    r->way = r->speed * fabs(h);
    r->length = fmax(r->length, r->way);
}

/* One step by Aitken-Neville extrapolation in (h/n)^2; 0 if ten columns do not settle it to
 * round-off. */
static inline int extrapolated(const runner *r, const double *restrict y, const double *restrict dy,
                               double h, double *restrict out)
{
    double *table = r->scratch;
    double *work = table + COLUMNS * r->size;
    for (int j = 0; j < COLUMNS; j++) {
        int n = 2 * (j + 1);
        double *row = table + j * r->size;
        midpoint(r, y, dy, h, n, row, work);
        /* Row m holds T(m, j - m ...): each older entry is replaced by the next one of the new
         * diagonal. */
        for (int m = j - 1; m >= 0; m--) {
            double ratio = (double)(j + 1) / (m + 1);
            double factor = 1.0 / (ratio * ratio - 1.0);
            double *older = table + m * r->size;
            const double *newer = older + r->size;
            for (int64_t i = 0; i < r->size; i++)
                older[i] = newer[i] + (newer[i] - older[i]) * factor;
        }
        if (j < 3)
            continue;
        for (int64_t i = 0; i < r->size; i++)
            gain(r, y, i, table[i], out);
        if (gap(r, out, table, table + r->size) < 1e-15)
            return 1;
    }
    return 0;
}

/* Bulirsch and Stoer 1966; 0 if the step is too long. */
static inline int extrapolation(const runner *r, const double *restrict y,
                                const double *restrict dy, double h, double *restrict out,
                                double *restrict rate)
{
    int held = extrapolated(r, y, dy, h, out);
    settle(r, out);
    rates(r->p, r->mode, out, rate);
    return held;
}

static inline int step(const runner *r, const double *restrict y, const double *restrict dy,
                       double h, double *restrict out, double *restrict rate)
{
    if (r->method == VERLET)
        return verlet(r, y, dy, h, out, rate);
    if (r->method == RUNGE_KUTTA)
        return runge_kutta(r, y, dy, h, out, rate);
    return extrapolation(r, y, dy, h, out, rate);
}

#endif
