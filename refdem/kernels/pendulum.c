/* A point on a rigid rod that swings in one plane, in closed form (Whittaker, Analytical Dynamics,
 * section 44; DLMF 22.19.2-5).
 *
 * theta'' = -w0^2 sin theta, w0^2 = g/l. With S = sin(theta/2), C = cos(theta/2), P = theta'/(2
 * w0) the energy is k^2 = S^2 + P^2, and
 *
 *   k < 1, swinging:    S = k sn(u | k^2),   C = dn,   P = k cn,   u = w0 t + u0,
 *   k > 1, rotating:    S = sn(u | 1/k^2),   C = cn,   P = k dn,   u = k w0 t + u0,
 *   k = 1, separatrix:  S = tanh u,          C = P = sech u.
 *
 * Then sin theta = 2 S C, cos theta = C^2 - S^2, and the rod pulls with m (l theta'^2 + g cos
 * theta). Without gravity theta = theta0 + theta' t.
 */
#include <assert.h>

#include "elliptic.h"
#include "kernels.h"

/* At rest, without gravity, and by the energy. */
enum { RESTING, TURNING, SWINGING, ROTATING };

typedef struct {
    int kind;
    dd rate, start;     /* u = rate t + start; without gravity theta itself */
    turns phase;        /* the same in periods of sn */
    double k, sign;     /* modulus as above; -1 mirrors the motion */
    double w0;          /* sqrt(g/l) */
    double s, c, omega; /* sin and cos of theta, and theta', at the start */
    jacobi j;
} pendulum;

/* The unit vectors of the plane: down (along gravity, else along the rod) and across; theta counts
 * from down towards across. */
typedef struct {
    dd down[3], across[3];
} plane;

/* A prepared run: the pendulum, its plane, and the arguments of refdem_pendulum_prepare; the state
 * holds at t0. */
typedef struct {
    pendulum b;
    double mass, length, gravity, t0, anchor[3], down[3], across[3], position[3], velocity[3];
    int64_t samples;
    const double *t;
    double *out_position, *out_velocity, *out_force;
} run;

/* |v|. */
static dd length_of(const dd *v)
{
    return dd_sqrt(dd_dot(v, v));
}

/* The unit vector of v - (v.n) n, the part of v perpendicular to the unit vector n, zero if there
 * is none; returns the length of that part. */
static dd perpendicular(const dd *restrict v, const dd *restrict n, dd *restrict out)
{
    dd along = dd_dot(v, n);
    dd length;
    for (int i = 0; i < 3; i++)
        out[i] = dd_sub(v[i], dd_mul(along, n[i]));
    length = length_of(out);
    for (int i = 0; i < 3; i++) {
        if (length.hi > 0.0)
            out[i] = dd_div(out[i], length);
        else
            out[i] = dd_of(0.0);
    }
    return length;
}

/* The plane of the motion. Where the rod hangs along gravity, up to 1e-28, the velocity decides. */
static plane plane_of(const double *restrict gravity, const dd *restrict rod,
                      const dd *restrict velocity)
{
    plane p;
    dd down[3], length;
    /* down = g/|g|, or r/|r| without gravity; across is the unit vector of r - (r.down) down, or of
     * the same part of the velocity. */
    for (int i = 0; i < 3; i++)
        down[i] = dd_of(gravity[i]);
    length = length_of(down);
    if (length.hi == 0.0) {
        for (int i = 0; i < 3; i++)
            down[i] = rod[i];
        length = length_of(down);
    }
    for (int i = 0; i < 3; i++)
        p.down[i] = dd_div(down[i], length);
    dd across_length = perpendicular(rod, p.down, p.across);
    if (across_length.hi <= 1e-28 * length_of(rod).hi)
        perpendicular(velocity, p.down, p.across);
    return p;
}

/* S and C >= 0 from sin and cos of theta: the larger one is sqrt((1 + |cos theta|)/2), the smaller
 * one sin theta over twice it, without cancellation. */
static void half_angle(dd s, dd c, dd *restrict sine, dd *restrict cosine)
{
    dd one = dd_of(1.0);
    dd large = dd_sqrt(dd_scale(dd_add(one, dd_abs(c)), 0.5));
    dd small = dd_div(dd_scale(s, 0.5), large);
    if (c.hi > 0.0) { /* nearer to the bottom */
        *cosine = large;
        *sine = small;
        return;
    }
    *cosine = dd_abs(small);
    *sine = large;
    if (s.hi < 0.0)
        *sine = dd_neg(large);
}

/* Kind, modulus k, rate and phase u0 of the motion, from sin and cos of theta, theta' [rad/s] and
 * w0 [rad/s]. Its parameter m and 1 - m, with rest = C^2 - P^2 = 1 - k^2: k^2 and rest where it
 * swings, 1/k^2 and -rest/k^2 where it rotates. */
static void prepare(pendulum *b, dd s, dd c, dd omega, dd w0)
{
    dd sine, cosine;
    dd one = dd_of(1.0);
    half_angle(s, c, &sine, &cosine);
    b->w0 = w0.hi;
    b->omega = omega.hi;
    b->s = s.hi;
    b->c = c.hi;
    b->sign = 1.0;
    /* Without gravity, or at rest at the bottom or the top. */
    if (w0.hi == 0.0 || (omega.hi == 0.0 && (sine.hi == 0.0 || cosine.hi == 0.0))) {
        /* theta = theta0 + theta' t. */
        b->kind = TURNING;
        if (omega.hi == 0.0)
            b->kind = RESTING;
        b->rate = omega;
        b->start = angle_of(s, c);
        return;
    }
    /* P = theta'/(2 w0),  k^2 = S^2 + P^2,  rest = 1 - k^2 = C^2 - P^2 */
    dd p = dd_div(omega, dd_scale(w0, 2.0));
    dd square = dd_add(dd_square(sine), dd_square(p));
    dd rest = dd_sub(dd_square(cosine), dd_square(p));
    dd k = dd_sqrt(square);
    b->kind = ROTATING;
    if (rest.hi >= 0.0)
        b->kind = SWINGING;
    b->k = k.hi;
    /* The formulas of a rotation and of the separatrix have theta' > 0: a negative one is mirrored.
     */
    if (omega.hi < 0.0 && (b->kind == ROTATING || rest.hi == 0.0)) {
        b->sign = -1.0;
        sine = dd_neg(sine);
        p = dd_neg(p);
    }
    if (b->kind == SWINGING) {
        /* At the start sn u0 = S/k, cn u0 = P/k, dn u0 = C. */
        b->j = jacobi_prepare(square, rest);
        b->rate = w0;
        b->start = jacobi_inverse(&b->j, dd_div(sine, k), dd_div(p, k), cosine);
    } else {
        /* At the start sn u0 = S, cn u0 = C, dn u0 = P/k. */
        b->j = jacobi_prepare(dd_div(one, square), dd_div(dd_neg(rest), square));
        b->rate = dd_mul(k, w0);
        b->start = jacobi_inverse(&b->j, sine, cosine, dd_div(p, k));
    }
    b->phase = jacobi_turns(&b->j, b->rate, b->start);
}

/* sin and cos of theta, and theta', by columns. */
typedef struct {
    double s[BLOCK], c[BLOCK], omega[BLOCK];
} angles;

/* sin theta, cos theta and theta' at count <= BLOCK times t [s], in any order. */
static inline void angles_at(const pendulum *restrict b, double t0, int count,
                             const double *restrict t, angles *restrict out)
{
    if (b->kind == RESTING || b->kind == TURNING) {
        for (int k = 0; k < count; k++) {
            /* theta = theta0 + theta' (t - t0). */
            turned(dd_add(b->start, dd_mul(b->rate, two_sum(t[k], -t0))), &out->c[k], &out->s[k]);
            out->omega[k] = b->omega;
        }
        return;
    }
    jacobi_points p;
    jacobi_at(&b->j, b->phase, t0, count, t, &p);
    /* S = sin(theta/2), C = cos(theta/2) and P = theta'/(2 w0) are k sn, dn and k cn where it
     * swings, and sn, cn and k dn where it rotates. */
    const double *cosine_half = p.cn;
    const double *speed = p.dn;
    double modulus = 1.0;
    if (b->kind == SWINGING) {
        cosine_half = p.dn;
        speed = p.cn;
        modulus = b->k;
    }
    /* sin theta = 2 S C,  cos theta = C^2 - S^2,  theta' = 2 w0 P */
    double twice = 2.0 * b->sign; /* the sign mirrors theta and theta' */
    double rate = twice * b->w0 * b->k;
    for (int k = 0; k < count; k++) {
        double sine = modulus * p.sn[k];
        double cosine = cosine_half[k];
        out->s[k] = twice * sine * cosine;
        out->c[k] = fma(cosine, cosine, -(sine * sine));
        out->omega[k] = rate * speed[k];
    }
}

/* Position anchor + l (sin theta across + cos theta down), velocity theta' l (cos theta across -
 * sin theta down), and the force of the rod, of columns of angles. */
static inline void place(const run *restrict m, int count, const angles *restrict a,
                         double *restrict position, double *restrict velocity,
                         double *restrict force)
{
    double down[3], across[3];
    for (int i = 0; i < 3; i++) {
        down[i] = m->length * m->down[i];
        across[i] = m->length * m->across[i];
    }
    for (int k = 0; k < count; k++) {
        /* r = anchor + l (s across + c down),  v = theta' l (c across - s down). */
        double s = a->s[k];
        double c = a->c[k];
        double omega = a->omega[k];
        double speed_c = omega * c;
        double speed_s = -omega * s;
        position[3 * k] = fma(s, across[0], fma(c, down[0], m->anchor[0]));
        position[3 * k + 1] = fma(s, across[1], fma(c, down[1], m->anchor[1]));
        position[3 * k + 2] = fma(s, across[2], fma(c, down[2], m->anchor[2]));
        velocity[3 * k] = fma(speed_s, down[0], speed_c * across[0]);
        velocity[3 * k + 1] = fma(speed_s, down[1], speed_c * across[1]);
        velocity[3 * k + 2] = fma(speed_s, down[2], speed_c * across[2]);
    }
    /* m (l theta'^2 + g cos theta) */
    for (int k = 0; k < count; k++)
        force[k] = m->mass * fma(m->length * a->omega[k], a->omega[k], m->gravity * a->c[k]);
}

/* Doubles that a prepared run takes. */
int64_t refdem_pendulum_size(void)
{
    return (sizeof(run) + sizeof(double) - 1) / sizeof(double);
}

REFDEM_EVERY_CPU
int refdem_pendulum_prepare(double mass, double length, const double *gravity, const double *anchor,
                            const double *position, const double *velocity, double t0,
                            int64_t samples, const double *t, double *out_position,
                            double *out_velocity, double *out_force, double *motion)
{
    assert(gravity && anchor && position && velocity && motion);
    assert(samples == 0 || (t && out_position && out_velocity && out_force));
    dd rod[3], v[3], across, along, size;
    run *m = (run *)motion;
    *m = (run){.mass = mass,
               .length = length,
               .t0 = t0,
               .samples = samples,
               .t = t,
               .out_position = out_position,
               .out_velocity = out_velocity,
               .out_force = out_force};
    for (int i = 0; i < 3; i++) {
        rod[i] = two_sum(position[i], -anchor[i]);
        v[i] = dd_of(velocity[i]);
    }
    plane axes = plane_of(gravity, rod, v);
    /* sin theta = r.across/|r|, cos theta = r.down/|r|, with r from the anchor to the point and |r|
     * its length in the plane. */
    across = dd_dot(rod, axes.across);
    along = dd_dot(rod, axes.down);
    size = dd_sqrt(dd_add(dd_square(across), dd_square(along)));
    dd s = dd_div(across, size);
    dd c = dd_div(along, size);
    /* theta' = (v.across cos theta - v.down sin theta)/l. */
    dd omega = dd_div(dd_sub(dd_mul(dd_dot(v, axes.across), c), dd_mul(dd_dot(v, axes.down), s)),
                      dd_of(length));
    /* w0 = sqrt(g/l). */
    dd g_vector[3] = {dd_of(gravity[0]), dd_of(gravity[1]), dd_of(gravity[2])};
    dd g = length_of(g_vector);
    prepare(&m->b, s, c, omega, dd_sqrt(dd_div(g, dd_of(length))));
    m->gravity = g.hi;
    for (int i = 0; i < 3; i++) {
        m->anchor[i] = anchor[i];
        m->down[i] = axes.down[i].hi;
        m->across[i] = axes.across[i].hi;
        m->position[i] = position[i];
        m->velocity[i] = velocity[i];
    }
    return 0;
}

/* Writes the given start to those of count samples that are at t0; to all of them if the point is
 * at rest. */
static inline void restore_start(const run *m, int64_t first, int count)
{
    int is_resting = m->b.kind == RESTING;
    int meets = is_resting;
    for (int k = 0; k < count; k++)
        meets |= m->t[first + k] == m->t0;
    if (!meets) /* no sample at t0 */
        return;
    for (int64_t k = first; k < first + count; k++) {
        if (!is_resting && m->t[k] != m->t0) /* not the start */
            continue;
        memcpy(m->out_position + 3 * k, m->position, sizeof m->position);
        memcpy(m->out_velocity + 3 * k, m->velocity, sizeof m->velocity);
        /* m (l theta'^2 + g cos theta). */
        m->out_force[k] = m->mass * (m->length * m->b.omega * m->b.omega + m->gravity * m->b.c);
    }
}

REFDEM_EVERY_CPU
int refdem_pendulum_run(const double *motion)
{
    assert(motion);
    const run *m = (const run *)motion;
    for (int64_t first = 0; first < m->samples; first += BLOCK) {
        int count = BLOCK;
        if (m->samples - first < BLOCK) /* the last ones */
            count = (int)(m->samples - first);
        angles a;
        angles_at(&m->b, m->t0, count, m->t + first, &a);
        place(m, count, &a, m->out_position + 3 * first, m->out_velocity + 3 * first,
              m->out_force + first);
        restore_start(m, first, count);
    }
    return 0;
}

int refdem_pendulum(double mass, double length, const double *gravity, const double *anchor,
                    const double *position, const double *velocity, double t0, int64_t samples,
                    const double *t, double *out_position, double *out_velocity, double *out_force)
{
    run m;
    double *prepared = (double *)&m; /* callers know a prepared run as doubles */
    refdem_pendulum_prepare(mass, length, gravity, anchor, position, velocity, t0, samples, t,
                            out_position, out_velocity, out_force, prepared);
    return refdem_pendulum_run(prepared);
}
