/* Points and spheres: springs, gravity, a central field, and the linear contact law with friction,
 * as rates of a state.
 *
 * Contact law (Cundall and Strack 1979), per pair i, j or sphere i and plane:
 *   overlap         d = R_i + R_j - |x_j - x_i|,   d' = (v_i - v_j).n
 *   normal force    F = k d + c d'                (Hertz: k d^(3/2) + c d')
 *   slip            u = (v_i - v_j) - d' n + (l_i w_i + l_j w_j) x n,   l = R - slip_shortening d
 *   spring          s' = u,   force on i: -k_t s, as long as |k_t s| <= mu F
 *   torque          L_i n x f on i for the tangential force f,   L = R - torque_shortening d
 * The power of f and of its torques is f.U, with U as u but for L in the place of l.
 * n points from i to j (or into the plane). Every pair is in one mode; within a mode the rates are
 * smooth, so that a method keeps its order if a step ends where a mode does.
 */
#ifndef REFDEM_PARTICLES_H
#define REFDEM_PARTICLES_H

#include <math.h>
#include <string.h>

#include "kernels.h"
#include "space.h"

/* APART: no overlap. PARTED: overlap, but the force would pull. FREE: normal force only. STICK: the
 * spring holds (without a spring: no slip). SLIP: friction at its limit; s is then the unit vector
 * of the spring, whose length is mu F / k_t. FADE: a SLIP without a spring that may end in this
 * step. Its direction may turn ever faster, so that friction keeps that of the start of the step:
 * the rates are smooth in it, and the end is located to rounding. */
enum { APART, PARTED, FREE, STICK, SLIP, FADE };

/* One contact as it is in a state. */
typedef struct {
    int64_t i, j;
    double n[3], normal_rate[3]; /* unit normal n and n' [1/s] */
    double velocity[3], slip[3]; /* v_i - v_j and u [m/s] */
    double glide[3];             /* U [m/s]: as u, at the levers of the torque */
    double overlap, rate, force; /* d [m], d' [m/s], F [N] */
    double limit;                /* mu F [N]; negative too, as a step may go beyond a release */
    double arm_i, arm_j;         /* l_i, l_j [m]: of the slip */
    double torque_i, torque_j;   /* L_i, L_j [m]: of the torque */
} contact;

/* Where the blocks of a state (or of its rates) begin: x, v (3 N); w (3 N), q (4 N) if bodies turn;
 * s (3 pairs) if they rub; last the work done against damping and friction. */
static inline int64_t spin_at(const refdem_particles *p)
{
    return 6 * p->bodies;
}

static inline int64_t history_at(const refdem_particles *p)
{
    if (p->turning)
        return 13 * p->bodies;
    return 6 * p->bodies;
}

static inline int64_t work_at(const refdem_particles *p)
{
    if (p->friction > 0.0)
        return history_at(p) + 3 * p->pairs;
    return history_at(p);
}

/* Geometry of pair k: n, d, d' and n' = (d' n - (v_i - v_j))/|x_j - x_i|. */
static inline void measure_geometry(const refdem_particles *p, int64_t k, const double *restrict y,
                                    contact *restrict m)
{
    const double *x = y;
    const double *v = y + 3 * p->bodies;
    int64_t i = p->pair[2 * k];
    int64_t j = p->pair[2 * k + 1];
    m->i = i;
    m->j = j;
    double separation[3];
    double distance = INFINITY;
    if (j < 0) { /* plane -1 - j: a point and the normal towards the spheres; n' = 0 */
        const double *plane = p->plane + 6 * (-1 - j);
        for (int c = 0; c < 3; c++) {
            m->n[c] = -plane[3 + c];
            m->velocity[c] = v[3 * i + c];
            separation[c] = x[3 * i + c] - plane[c];
        }
        /* d = R_i + (x_i - P).n, with the point P of the plane and n = -n_plane. */
        m->overlap = p->radius[i] + dot(separation, m->n);
    } else {
        for (int c = 0; c < 3; c++) {
            separation[c] = x[3 * j + c] - x[3 * i + c];
            m->velocity[c] = v[3 * i + c] - v[3 * j + c];
        }
        /* n = (x_j - x_i)/|x_j - x_i|, d = R_i + R_j - |x_j - x_i|. */
        distance = sqrt(dot(separation, separation));
        for (int c = 0; c < 3; c++)
            m->n[c] = separation[c] / distance;
        m->overlap = (p->radius[i] + p->radius[j]) - distance;
    }
    /* d' = (v_i - v_j).n, n' = (d' n - (v_i - v_j))/|x_j - x_i|. */
    m->rate = dot(m->velocity, m->n);
    for (int c = 0; c < 3; c++)
        m->normal_rate[c] = (m->rate * m->n[c] - m->velocity[c]) / distance;
}

/* Factor of both stiffnesses: sqrt(d) under Hertz's law, whose contact circle has a radius
 * proportional to it; 1 under the linear law. */
static inline double hertz_factor(const refdem_particles *p, double overlap)
{
    if (p->hertz)
        return sqrt(fmax(overlap, 0.0));
    return 1.0;
}

/* The velocity of surface i against surface j where the levers are arm_i and arm_j:
 *   (v_i - v_j) - d' n + (arm_i w_i + arm_j w_j) x n. */
static inline void surface_velocity(const contact *m, const double *restrict omega, double arm_i,
                                    double arm_j, double *restrict out)
{
    double spin[3], by_spin[3];
    for (int c = 0; c < 3; c++) {
        double spin_j = 0.0; /* a plane does not turn */
        if (m->j >= 0)
            spin_j = arm_j * omega[3 * m->j + c];
        spin[c] = arm_i * omega[3 * m->i + c] + spin_j;
    }
    cross(spin, m->n, by_spin);
    for (int c = 0; c < 3; c++)
        out[c] = m->velocity[c] - m->rate * m->n[c] + by_spin[c];
}

/* Geometry, slip and force of pair k in state y. */
static inline contact measure(const refdem_particles *p, int64_t k, const double *restrict y)
{
    contact m;
    measure_geometry(p, k, y, &m);
    /* F = k d + c d', or k d^(3/2) + c d'. */
    m.force = p->stiffness * m.overlap * hertz_factor(p, m.overlap) + p->damping * m.rate;
    m.limit = p->friction * m.force;
    if (p->friction > 0.0) {
        const double *omega = y + spin_at(p);
        /* Levers: l = R - slip_shortening d of the slip, L = R - torque_shortening d of the
         * torque. */
        m.arm_i = p->radius[m.i] - p->slip_shortening * m.overlap;
        m.torque_i = p->radius[m.i] - p->torque_shortening * m.overlap;
        m.arm_j = 0.0;
        m.torque_j = 0.0;
        if (m.j >= 0) {
            m.arm_j = p->radius[m.j] - p->slip_shortening * m.overlap;
            m.torque_j = p->radius[m.j] - p->torque_shortening * m.overlap;
        }
        surface_velocity(&m, omega, m.arm_i, m.arm_j, m.slip);
        surface_velocity(&m, omega, m.torque_i, m.torque_j, m.glide);
    }
    return m;
}

/* Stiffness k_t of the tangential spring [N/m], which grows with Hertz's contact circle. */
static inline double tangential_stiffness(const refdem_particles *p, const contact *m)
{
    return p->tangential_stiffness * hertz_factor(p, m->overlap);
}

/* The stretch |s| [m] at which the spring begins to slip: |k_t s| = mu F. */
static inline double stretch_limit(const refdem_particles *p, const contact *m)
{
    if (p->hertz) /* both stiffnesses have the factor sqrt(d): mu k d/k_t */
        return p->friction * p->stiffness / p->tangential_stiffness * m->overlap;
    return m->limit / p->tangential_stiffness;
}

/* A speed [m/s] below which slip is rounding and has no direction: 1e-11 R w with the frequency
 * w = sqrt(k (1/m_i + 1/m_j)) of the pair. Under Hertz's law k has the value of the stiffness
 * k sqrt(d) at an overlap of 1 m. */
static inline double slip_floor(const refdem_particles *p, const contact *m)
{
    double inverse_mass = p->inverse_mass[m->i];
    if (m->j >= 0)
        inverse_mass += p->inverse_mass[m->j];
    return 1e-11 * p->radius[m->i] * sqrt(p->stiffness * inverse_mass);
}

/* Change of the slip by a unit of tangential impulse [1/kg]: 1/m_i + l_i L_i/J_i + 1/m_j + l_j
 * L_j/J_j. */
static inline double tangential_mobility(const refdem_particles *p, const contact *m)
{
    double mobility = p->inverse_mass[m->i] + m->arm_i * m->torque_i * p->inverse_inertia[m->i];
    if (m->j < 0) /* a plane has infinite mass */
        return mobility;
    return mobility + p->inverse_mass[m->j] + m->arm_j * m->torque_j * p->inverse_inertia[m->j];
}

/* The force on i that keeps the slip at zero where no spring does: f = -u'/(1/m_i + l_i L_i/J_i +
 * 1/m_j + l_j L_j/J_j), with the rate u' that the slip has without it,
 *   u' = a_i - a_j - d' n' + (l_i w_i + l_j w_j)' x n + (l_i w_i + l_j w_j) x n',
 *   l' = -slip_shortening d', less its part along n. dy holds the accelerations without friction.
 */
static inline void sticking_force(const refdem_particles *p, const contact *m,
                                  const double *restrict y, const double *restrict dy,
                                  double *restrict force)
{
    const double *omega = y + spin_at(p);
    const double *a = dy + 3 * p->bodies;
    const double *alpha = dy + spin_at(p);
    double spin[3], spin_rate[3], normal_turn_slip[3], spin_rate_slip[3];
    double mobility = tangential_mobility(p, m);
    double lever_rate = -p->slip_shortening * m->rate; /* l' */
    /* u' = a_i - a_j - d' n' + (l_i w_i + l_j w_j)' x n + (l_i w_i + l_j w_j) x n', in `force` */
    for (int c = 0; c < 3; c++) {
        spin[c] = m->arm_i * omega[3 * m->i + c];
        spin_rate[c] = m->arm_i * alpha[3 * m->i + c] + lever_rate * omega[3 * m->i + c];
        force[c] = a[3 * m->i + c] - m->rate * m->normal_rate[c];
        if (m->j >= 0) {
            spin[c] += m->arm_j * omega[3 * m->j + c];
            spin_rate[c] += m->arm_j * alpha[3 * m->j + c] + lever_rate * omega[3 * m->j + c];
            force[c] -= a[3 * m->j + c];
        }
    }
    cross(spin_rate, m->n, spin_rate_slip);
    cross(spin, m->normal_rate, normal_turn_slip);
    for (int c = 0; c < 3; c++)
        force[c] += spin_rate_slip[c] + normal_turn_slip[c];
    add_scaled(force, -dot(force, m->n), m->n);
    for (int c = 0; c < 3; c++)
        force[c] /= -mobility;
}

/* Angle [rad] within which a spring and the slip count as parallel. */
static const double STRAIGHT = 1e-9;

/* Tangential force on i, and the rate s' of the spring.
 *   STICK: f = -k_t s,  s' = u - (s.n') n: the spring stays in the plane of contact.
 *   SLIP:  f = -mu F s with the unit vector s, which leans towards the slip at the rate
 *          s' = (u - (u.s) s) k_t/(mu F) - (s.n') n, as a spring of the length mu F/k_t does.
 * Without a spring f = -mu F u/|u| in SLIP; in STICK only the lack of slip defines the force, which
 * then stands in the place of s'. */
static inline void tangential_force(const refdem_particles *p, int64_t mode, const contact *m,
                                    const double *restrict y, const double *restrict dy,
                                    const double *restrict s, double *restrict force,
                                    double *restrict rate)
{
    double k_t = tangential_stiffness(p, m);
    double slip_along = dot(s, m->slip);
    double tilt_rate = dot(s, m->normal_rate);
    double force_floor = 1e-8 * p->friction * p->stiffness * p->radius[m->i];
    double limit = fmax(m->limit, 0.0);
    /* lean = k_t mu F/((mu F)^2 + f0^2), f0 = 1e-8 mu k R: k_t/(mu F), but finite at F = 0. */
    double lean = k_t * limit / (limit * limit + force_floor * force_floor);
    double slip_across[3], in_plane[3];
    double direction[3] = {s[0], s[1], s[2]};
    double slip_speed = size(m->slip);
    double length = 1.0;
    double tilt = dot(s, m->n);
    int has_spring = p->tangential_stiffness > 0.0;
    if (!has_spring && mode >= SLIP) {
        /* Along the slip; where that has no direction, as it was. */
        if (mode == SLIP && slip_along > slip_floor(p, m)) {
            for (int c = 0; c < 3; c++)
                direction[c] = m->slip[c] / slip_speed;
        }
        /* In the plane of contact: a slip that ends is all rounding, and friction may be many times
         * the normal force. */
        add_scaled(direction, -dot(direction, m->n), m->n);
        /* No direction yet, as after sticking without any pull: no friction. */
        length = fmax(size(direction), 1e-300);
    }
    /* The part of s in the plane of contact, s - (s.n) n. */
    for (int c = 0; c < 3; c++) {
        in_plane[c] = s[c] - tilt * m->n[c];
        direction[c] /= length;
    }
    /* The slip across the spring: u - (u.s) s/(s.s), s taken within the plane of contact. */
    for (int c = 0; c < 3; c++)
        slip_across[c]
            = m->slip[c] - slip_along * in_plane[c] / fmax(dot(in_plane, in_plane), 1e-300);
    /* Motion in a plane: rounding must not turn the spring, nor a trial step that has tilted it out
     * of the plane of contact. */
    if (mode == SLIP && size(slip_across) < STRAIGHT * slip_speed)
        lean = 0.0;
    for (int c = 0; c < 3; c++) {
        force[c] = 0.0;
        if (mode == STICK)
            force[c] = -k_t * s[c];
        else if (mode >= SLIP)
            force[c] = -m->limit * direction[c];
        rate[c] = 0.0;
        if (has_spring && mode == STICK)
            rate[c] = m->slip[c] - tilt_rate * m->n[c];
        if (has_spring && mode == SLIP)
            rate[c] = slip_across[c] * lean - tilt_rate * m->n[c];
    }
    if (!has_spring && mode == STICK) {
        sticking_force(p, m, y, dy, force);
        memcpy(rate, force, 3 * sizeof *force);
    }
}

/* Adds what a tangential force f on i, and -f on j, does to the rates: f/m_i, -f/m_j, and L (n x
 * f)/J of both. An impulse in place of the force, and a state in place of its rates, serve too. */
static inline void apply_tangential(const refdem_particles *p, const contact *m,
                                    const double *restrict force, double *restrict dy)
{
    double *a = dy + 3 * p->bodies;
    double *alpha = dy + spin_at(p);
    double torque[3];
    cross(m->n, force, torque);
    add_scaled(a + 3 * m->i, p->inverse_mass[m->i], force);
    if (m->j >= 0)
        add_scaled(a + 3 * m->j, -p->inverse_mass[m->j], force);
    add_scaled(alpha + 3 * m->i, m->torque_i * p->inverse_inertia[m->i], torque);
    if (m->j >= 0)
        add_scaled(alpha + 3 * m->j, m->torque_j * p->inverse_inertia[m->j], torque);
}

/* A spring's row: stiffness, length, exponent, anchor (3), factors of the square and the cube. */
enum { STIFFNESS, LENGTH, EXPONENT, ANCHOR, QUADRATIC = 6, CUBIC };

/* Pull over distance [N/m] of a spring with the stretch s = distance - length: (k |s|^e sgn s + k2
 * s^2 + k3 s^3)/distance. */
static inline double pull_per_length(const double *restrict spring, double distance)
{
    double stretch = distance - spring[LENGTH];
    double power = fabs(stretch); /* |s|^e */
    if (spring[EXPONENT] != 1.0)
        power = pow(power, spring[EXPONENT]);
    double pull = spring[STIFFNESS] * copysign(power, stretch);
    double nonlinear = (spring[QUADRATIC] + spring[CUBIC] * stretch) * stretch * stretch;
    if (distance > 0.0)
        return (pull + nonlinear) / distance;
    return 0.0; /* a spring of no length has no direction */
}

/* Adds the forces of the springs [N]: factor (x_j - x_i) on i, its reaction on j. */
static inline void add_springs(const refdem_particles *p, const double *restrict x,
                               double *restrict force)
{
    for (int64_t k = 0; k < p->springs; k++) {
        const double *spring = p->spring + 8 * k;
        int64_t i = p->spring_end[2 * k];
        int64_t j = p->spring_end[2 * k + 1];
        double branch[3]; /* from i to the other end [m] */
        double factor = spring[STIFFNESS];
        const double *end = spring + ANCHOR; /* fixed in space, or another body */
        if (j >= 0)
            end = x + 3 * j;
        for (int c = 0; c < 3; c++)
            branch[c] = end[c] - x[3 * i + c];
        /* A linear spring of no length pulls with k (x_j - x_i): no root, and none of its rounding.
         */
        int has_length = spring[LENGTH] != 0.0;
        int is_linear = spring[EXPONENT] == 1.0 && spring[QUADRATIC] == 0.0 && spring[CUBIC] == 0.0;
        if (has_length || !is_linear)
            factor = pull_per_length(spring, size(branch));
        add_scaled(force + 3 * i, factor, branch);
        if (j >= 0)
            add_scaled(force + 3 * j, -factor, branch);
    }
}

/* Adds the normal forces -F n on i, F n on j [N]; returns the power of damping c d'^2 [W]. */
static inline double add_normal_forces(const refdem_particles *p, const int64_t *restrict mode,
                                       const double *restrict y, double *restrict force)
{
    double power = 0.0;
    for (int64_t k = 0; k < p->pairs; k++) {
        if (mode[k] < FREE)
            continue;
        contact m = measure(p, k, y);
        /* -F n on i, F n on j; the power of damping is c d'^2 */
        add_scaled(force + 3 * m.i, -m.force, m.n);
        if (m.j >= 0)
            add_scaled(force + 3 * m.j, m.force, m.n);
        power += p->damping * m.rate * m.rate;
    }
    return power;
}

/* Adds the accelerations by tangential forces f and the rates of their springs; returns the power
 * -f.U [W]. Accelerations in dy must be complete except for these, since sticking without a spring
 * depends on them. */
static inline double add_tangential_forces(const refdem_particles *p, const int64_t *restrict mode,
                                           const double *restrict y, double *restrict dy)
{
    double power = 0.0;
    double force[3];
    for (int64_t k = 0; k < p->pairs; k++) {
        if (mode[k] < STICK)
            continue;
        contact m = measure(p, k, y);
        tangential_force(p, mode[k], &m, y, dy, y + history_at(p) + 3 * k, force,
                         dy + history_at(p) + 3 * k);
        apply_tangential(p, &m, force, dy);
        power -= dot(force, m.glide);
    }
    return power;
}

/* q' = w q/2 for every body, w in space axes. */
static inline void attitude_rates(const refdem_particles *p, const double *restrict w,
                                  const double *restrict q, double *restrict dq)
{
    for (int64_t i = 0; i < p->bodies; i++, w += 3, q += 4, dq += 4) {
        double across[3];
        /* (0, w) (q0, u)/2 = (-w.u, q0 w + w x u)/2. */
        cross(w, q + 1, across);
        dq[0] = -0.5 * dot(w, q + 1);
        for (int c = 0; c < 3; c++)
            dq[1 + c] = 0.5 * (across[c] + q[0] * w[c]);
    }
}

/* Rates of the whole state, y' = dy, in the given modes. Forces are summed in the place of the
 * accelerations before they are divided by the mass, so that what balances exactly rests. */
static inline void rates(const refdem_particles *p, const int64_t *restrict mode,
                         const double *restrict y, double *restrict dy)
{
    int64_t n = p->bodies;
    double *a = dy + 3 * n;
    memcpy(dy, y + 3 * n, (size_t)(3 * n) * sizeof *dy);
    memset(a, 0, (size_t)(work_at(p) + 1 - 3 * n) * sizeof *dy);
    add_springs(p, y, a);
    dy[work_at(p)] = add_normal_forces(p, mode, y, a);
    for (int64_t i = 0; i < n; i++) {
        double cube = 0.0; /* gm/r^3 of the central field -gm x/r^3 about the origin */
        if (p->gm > 0.0) {
            double square = dot(y + 3 * i, y + 3 * i);
            cube = p->gm / (square * sqrt(square));
        }
        if (!(p->inverse_mass[i] > 0.0)) { /* a fixed body stays */
            memset(a + 3 * i, 0, 3 * sizeof *a);
            continue;
        }
        /* x'' = F/m + g - gm x/|x|^3 */
        for (int c = 0; c < 3; c++)
            a[3 * i + c] = (a[3 * i + c] / p->mass[i] + p->gravity[c]) - cube * y[3 * i + c];
    }
    if (p->turning)
        attitude_rates(p, y + spin_at(p), y + 9 * n, dy + 9 * n);
    if (p->friction > 0.0)
        dy[work_at(p)] += add_tangential_forces(p, mode, y, dy);
}

#endif
