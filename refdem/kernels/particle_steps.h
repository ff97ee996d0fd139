/* One step of points and spheres within the modes of their contacts: velocity Verlet, Runge-Kutta,
 * extrapolation.
 *
 * All three are maps (y, y') -> (y, y') over h, of the rates y' = f(y) of particles.h at fixed
 * modes:
 *
 *   Verlet         v += h/2 a,  x += h v,  v += h/2 a                   (order 2)
 *   Runge-Kutta    y += h/6 (k1 + 2 k2 + 2 k3 + k4)                     (order 4)
 *   extrapolation  the modified midpoint rule with n = 2, 4, .., 20 parts a step, extrapolated in
 *                  (h/n)^2 to 0 until it changes by round-off only
 *
 * Every sum is compensated: after its `size` numbers a state has as many that hold what rounding
 * has lost.
 */
#ifndef REFDEM_PARTICLE_STEPS_H
#define REFDEM_PARTICLE_STEPS_H

#include "particles.h"

enum { VERLET, RUNGE_KUTTA, EXTRAPOLATION };
enum { COLUMNS = 10 }; /* of the extrapolation table */

typedef struct {
    const refdem_particles *p;
    int method;
    int64_t size;
    int64_t *mode;   /* of each pair */
    double *scratch; /* work space of the methods */
    /* Scales of errors of positions [m], of velocities [m/s], of spins [rad/s], and of springs, the
     * largest distance in a step [m]. */
    double length, speed, turning, way;
} runner;

/* to[c] = from[c] + increment; the rounding error is kept in to[size + c], and added to the
 * increment of the next sum (Kahan 1965; Knuth's two-sum, TAOCP 4.2.2). */
static inline void add_compensated(const runner *r, const double *from, int64_t c, double increment,
                                   double *to)
{
    double compensated = from[r->size + c] + increment;
    double sum = from[c] + compensated;
    double added = sum - from[c];
    to[r->size + c] = (from[c] - (sum - added)) + (compensated - added);
    to[c] = sum;
}

/* Turns the unit vector s of a spring at its limit towards the slip u. For constant u the angle a
 * between them obeys a' = -(|u| k_t/(mu F)) sin a, so that tan(a/2) falls as exp(-|u| k_t t/(mu
 * F)): exact for the time h. */
static inline void turn_towards_slip(const contact *m, double stiffness, double h,
                                     double *restrict s)
{
    double slip_speed = size(m->slip);
    if (slip_speed == 0.0)
        return;
    double cosine_before = dot(s, m->slip) / slip_speed;
    double decay = 0.0; /* for mu F = 0: the spring has the direction of the slip at once */
    if (m->limit > 0.0)
        decay = exp(-slip_speed * stiffness * h / m->limit);
    /* tan(a/2) = sqrt((1 - cos a)/(1 + cos a)) at the start, times the decay at the end. */
    double tangent
        = decay * sqrt(fmax(0.0, 1.0 - cosine_before) / fmax(1e-300, 1.0 + cosine_before));
    double cosine = (1.0 - tangent * tangent) / (1.0 + tangent * tangent);
    double sine = 2.0 * tangent / (1.0 + tangent * tangent);
    double across[3];
    for (int c = 0; c < 3; c++)
        across[c] = s[c] - cosine_before * m->slip[c] / slip_speed;
    double across_length = size(across);
    /* Motion in a plane: rounding must not turn the spring, least of all from where it points
     * against the slip. */
    if (across_length < STRAIGHT)
        return;
    for (int c = 0; c < 3; c++)
        s[c] = cosine * m->slip[c] / slip_speed + sine * across[c] / across_length;
}

/* Advances every tangential spring by h, at the normals and slips of state y: s += h u where it
 * sticks, by turn_towards_slip where it slips. The normals are kept in `normal` (pairs, 3); if
 * `carried`, the springs are first rotated from the normals kept there, n0, to those of y, n1: for
 * s across n0, s -= (n1.s)/(1 + n0.n1) (n0 + n1). */
static inline void move_springs(const runner *r, double *restrict y, double h,
                                double *restrict normal, int is_carried)
{
    const refdem_particles *p = r->p;
    for (int64_t k = 0; k < p->pairs; k++) {
        double *s = y + history_at(p) + 3 * k;
        double *normal_before = normal + 3 * k;
        if (r->mode[k] < STICK)
            continue;
        contact m = measure(p, k, y);
        if (is_carried) {
            double bisector[3]
                = {normal_before[0] + m.n[0], normal_before[1] + m.n[1], normal_before[2] + m.n[2]};
            add_scaled(s, -dot(m.n, s) / (1.0 + dot(normal_before, m.n)), bisector);
        }
        if (r->mode[k] == STICK && p->tangential_stiffness > 0.0)
            add_scaled(s, h, m.slip);
        if (r->mode[k] == SLIP && p->tangential_stiffness > 0.0)
            turn_towards_slip(&m, tangential_stiffness(p, &m), h, s);
        memcpy(normal_before, m.n, sizeof m.n);
    }
}

/* n attitudes q turned by the rotation vectors w h, exactly: q = exp(w h/2) q, with the half angle
 * a = |w| h/2 and exp(w h/2) = (cos a, (sin a/a) w h/2). Then one step of Newton's for |q| = 1, q
 * *= 3/2 - |q|^2/2: the same turn rounds the same way every time, so that the length would drift
 * with the number of steps. */
static inline void rotate(int64_t n, const double *restrict w, double h, double *restrict q)
{
    for (int64_t i = 0; i < n; i++, w += 3, q += 4) {
        double angle = 0.5 * h * size(w);
        double factor = 0.5 * h; /* sin(angle)/angle tends to 1 */
        if (angle != 0.0)
            factor = 0.5 * h * sin(angle) / angle;
        double cosine = cos(angle);
        double vector[3] = {factor * w[0], factor * w[1], factor * w[2]};
        double before[4] = {q[0], q[1], q[2], q[3]};
        double crossed[3];
        cross(vector, before + 1, crossed);
        q[0] = cosine * before[0] - dot(vector, before + 1);
        for (int k = 0; k < 3; k++)
            q[1 + k] = cosine * before[1 + k] + before[0] * vector[k] + crossed[k];
        if (angle == 0.0) /* what does not turn keeps its bits */
            continue;
        double unit = 1.5 - 0.5 * (q[0] * q[0] + dot(q + 1, q + 1));
        for (int k = 0; k < 4; k++)
            q[k] *= unit;
    }
}

/* Velocities and spins: to = from + h dy. */
static inline void kick(const runner *r, const double *from, const double *restrict dy, double h,
                        double *to)
{
    int64_t n = r->p->bodies;
    int64_t end = 6 * n;
    if (r->p->turning)
        end = 9 * n;
    for (int64_t c = 3 * n; c < end; c++)
        add_compensated(r, from, c, h * dy[c], to);
}

/* Velocity Verlet (Swope et al. 1982): kick, drift, kick; springs move by half a step before the
 * drift and half a step after it. Forces that depend on velocities are evaluated with v + h/2 a of
 * the old a, then again with that of the new one, which keeps the second order. */
static inline int verlet(const runner *r, const double *restrict y, const double *restrict dy,
                         double h, double *restrict out, double *restrict rate)
{
    const refdem_particles *p = r->p;
    double *half_step = r->scratch;
    double *normal = half_step + 2 * r->size;
    int has_friction = p->friction > 0.0;
    int depends_on_velocity = p->damping > 0.0 || has_friction;
    memcpy(out, y, 2 * (size_t)r->size * sizeof *y);
    /* Kick: v(h/2) = v + h/2 a, and the springs with it. */
    kick(r, y, dy, 0.5 * h, out);
    if (has_friction)
        move_springs(r, out, 0.5 * h, normal, 0);
    /* Drift: x(h) = x + h v(h/2), attitudes by w(h/2). */
    for (int64_t c = 0; c < 3 * p->bodies; c++)
        add_compensated(r, y, c, h * out[3 * p->bodies + c], out);
    if (p->turning)
        rotate(p->bodies, out + spin_at(p), h, out + 9 * p->bodies);
    if (has_friction)
        move_springs(r, out, 0.5 * h, normal, 1);
    /* Forces at the end; where they depend on velocities, of v(h/2) + h/2 a, a the old one. */
    if (depends_on_velocity) {
        memcpy(half_step, out, 2 * (size_t)r->size * sizeof *y);
        kick(r, half_step, dy, 0.5 * h, out);
        rates(p, r->mode, out, rate);
        kick(r, half_step, rate, 0.5 * h, out);
    }
    rates(p, r->mode, out, rate);
    /* Kick: v(h) = v(h/2) + h/2 a(h), anew from the half step where a first one was predicted. */
    if (depends_on_velocity)
        kick(r, half_step, rate, 0.5 * h, out);
    else
        kick(r, out, rate, 0.5 * h, out);
    /* Work by the trapezoidal rule. */
    out[work_at(p)] += 0.5 * h * (dy[work_at(p)] + rate[work_at(p)]);
    return 1;
}

/* Puts a state back on its constraints: attitudes to unit length, springs into the plane of contact
 * (s -= (s.n) n), the directions of slipping springs to unit length. */
static inline void project(const runner *r, double *restrict y)
{
    const refdem_particles *p = r->p;
    if (p->turning) {
        for (int64_t i = 0; i < p->bodies; i++) {
            /* q = q/|q|. */
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
        /* s -= (s.n) n, and s = s/|s| where s is the direction of a slipping spring. */
        contact m = measure(p, k, y);
        add_scaled(s, -dot(s, m.n), m.n);
        double length = size(s);
        if (r->mode[k] == SLIP && length > 0.0) {
            for (int c = 0; c < 3; c++)
                s[c] /= length;
        }
    }
}

/* The classical method of order 4 (Kutta 1901), with k1 = dy = f(y):
 *
 *   k2 = f(y + h/2 k1),   k3 = f(y + h/2 k2),   k4 = f(y + h k3),
 *   y(h) = y + h/6 (k1 + 2 k2 + 2 k3 + k4). */
static inline int runge_kutta(const runner *r, const double *restrict y, const double *restrict dy,
                              double h, double *restrict out, double *restrict rate)
{
    double *k2 = r->scratch;
    double *k3 = k2 + r->size;
    double *k4 = k3 + r->size;
    double *stage = k4 + r->size;
    for (int64_t i = 0; i < r->size; i++)
        stage[i] = y[i] + 0.5 * h * dy[i];
    rates(r->p, r->mode, stage, k2);
    for (int64_t i = 0; i < r->size; i++)
        stage[i] = y[i] + 0.5 * h * k2[i];
    rates(r->p, r->mode, stage, k3);
    for (int64_t i = 0; i < r->size; i++)
        stage[i] = y[i] + h * k3[i];
    rates(r->p, r->mode, stage, k4);
    for (int64_t i = 0; i < r->size; i++)
        add_compensated(r, y, i, h / 6.0 * ((dy[i] + k4[i]) + 2.0 * (k2[i] + k3[i])), out);
    project(r, out);
    rates(r->p, r->mode, out, rate);
    return 1;
}

/* The increment y(h) - y(0) by n steps of the modified midpoint rule (Gragg 1965), n even, with
 * step = h/n, z_1 = step y', z_(k+1) = z_(k-1) + 2 step f(y + z_k), and at the end the smoothing
 * step (z_(n-1) + z_n + step f(y + z_n))/2. Its error is a series in (h/n)^2. */
static inline void midpoint(const runner *r, const double *restrict y, const double *restrict dy,
                            double h, int n, double *restrict increment, double *restrict work)
{
    double *point = work;
    double *rate = point + r->size;
    double *increment_before = rate + r->size;
    double step = h / n;
    for (int64_t i = 0; i < r->size; i++) {
        /* z_0 = 0, z_1 = step y'. */
        increment_before[i] = 0.0;
        increment[i] = step * dy[i];
    }
    for (int k = 1; k <= n; k++) {
        for (int64_t i = 0; i < r->size; i++)
            point[i] = y[i] + increment[i];
        rates(r->p, r->mode, point, rate);
        for (int64_t i = 0; i < r->size; i++) {
            double increment_next;
            if (k < n)
                increment_next = increment_before[i] + 2.0 * step * rate[i];
            else /* the smoothing step at the end */
                increment_next = 0.5 * (increment_before[i] + increment[i] + step * rate[i]);
            increment_before[i] = increment[i];
            increment[i] = increment_next;
        }
    }
}

/* The larger of a and b, and NaN if either is: a step that overflows has not converged. */
static inline double larger_or_nan(double a, double b)
{
    if (a > b || a != a)
        return a;
    return b;
}

/* The scale with which a difference in component i of a state is compared. */
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

/* Largest difference of two rows a and b of the extrapolation table, each component over its scale;
 * the direction of a slipping spring at the state `end` counts as its force does. */
static inline double difference(const runner *r, const double *restrict end,
                                const double *restrict a, const double *restrict b)
{
    const refdem_particles *p = r->p;
    double worst = 0.0;
    for (int64_t i = 0; i < history_at(p); i++) {
        if (a[i] != b[i]) /* at rest there is no scale */
            worst = larger_or_nan(fabs(a[i] - b[i]) / scale_of(r, i), worst);
    }
    if (!(p->friction > 0.0 && p->tangential_stiffness > 0.0))
        return worst;
    for (int64_t k = 0; k < p->pairs; k++) {
        if (r->mode[k] < STICK)
            continue;
        double scale = fabs(r->way);
        /* An error e of the direction is one of mu F e of the force: it is compared with
         * max(1e-3 k R/F, 1), so that it weighs less in a contact of small strain F/(k R). */
        if (r->mode[k] != STICK) {
            contact m = measure(p, k, end);
            double strain = m.force / (p->stiffness * p->radius[m.i]);
            scale = fmax(fabs(1e-3 / strain), 1.0);
        }
        const double *spring_a = a + history_at(p) + 3 * k;
        const double *spring_b = b + history_at(p) + 3 * k;
        for (int c = 0; c < 3; c++)
            worst = larger_or_nan(fabs(spring_a[c] - spring_b[c]) / scale, worst);
    }
    return worst;
}

/* Raises the scales to those of the state before a step h. */
static inline void update_scales(runner *r, const double *restrict y, const double *restrict dy,
                                 double h)
{
    const refdem_particles *p = r->p;
    int64_t n = p->bodies;
    double largest_radius = 0.0;
    double smallest_radius = INFINITY;
    for (int64_t i = 0; i < n; i++) {
        if (!(p->radius[i] > 0.0)) /* a point */
            continue;
        largest_radius = fmax(largest_radius, p->radius[i]);
        smallest_radius = fmin(smallest_radius, p->radius[i]);
    }
    /* length = max(|x|, R), speed = max(|v|, |h a|), over all components and bodies. */
    for (int64_t i = 0; i < 3 * n; i++) {
        r->length = fmax(r->length, fmax(fabs(y[i]), largest_radius));
        r->speed = fmax(r->speed, fmax(fabs(y[3 * n + i]), fabs(h * dy[3 * n + i])));
    }
    /* Forces that cancel leave the rounding of each: h F/m counts as a speed. */
    for (int64_t k = 0; k < p->pairs; k++) {
        if (r->mode[k] < FREE)
            continue;
        contact m = measure(p, k, y);
        double inverse_mass = p->inverse_mass[m.i];
        if (m.j >= 0)
            inverse_mass = fmax(inverse_mass, p->inverse_mass[m.j]);
        r->speed = fmax(r->speed, fabs(h * m.force) * inverse_mass);
    }
    /* turning = max(speed/R of the smallest sphere, |w|), way = speed |h|. */
    r->turning = fmax(r->turning, r->speed / smallest_radius);
    if (p->turning) {
        for (int64_t i = spin_at(p); i < spin_at(p) + 3 * n; i++)
            r->turning = fmax(r->turning, fabs(y[i]));
    }
    r->way = r->speed * fabs(h);
    r->length = fmax(r->length, r->way);
}

/* One step by Aitken-Neville extrapolation in (h/n)^2, n_j = 2 (j + 1),
 *   T(m) = T(m + 1) + (T(m + 1) - T(m))/((n_j/n_m)^2 - 1),
 * until the last two entries agree to 1e-15 of the scales; returns 0 if the last of the ten columns
 * does not reach this. */
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
        if (j < 3) /* four columns at least: two low ones may agree by chance */
            continue;
        for (int64_t i = 0; i < r->size; i++)
            add_compensated(r, y, i, table[i], out);
        if (difference(r, out, table, table + r->size) < 1e-15)
            return 1;
    }
    return 0;
}

/* Extrapolation (Bulirsch and Stoer 1966); returns 0 if the step is too long to converge. */
static inline int extrapolation(const runner *r, const double *restrict y,
                                const double *restrict dy, double h, double *restrict out,
                                double *restrict rate)
{
    int converged = extrapolated(r, y, dy, h, out);
    project(r, out);
    rates(r->p, r->mode, out, rate);
    return converged;
}

/* One step by the runner's method: y, dy to out, rate. Returns 0 if it has not converged. */
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
