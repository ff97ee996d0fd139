/* A point on a rigid rod that swings in one plane, in closed form.
 *
 * theta'' = -w0^2 sin theta, w0^2 = g/l; S = sin(theta/2), C = cos(theta/2), P = theta'/(2 w0), k^2 = S^2 + P^2:
 * k < 1: S = k sn(w0 t + u0 | k^2), C = dn, P = k cn;  k > 1: S = sn(k w0 t + u0 | 1/k^2), C = cn, P = k dn;
 * k = 1: S = tanh, C = P = sech (Whittaker, Analytical Dynamics, section 44; DLMF 22.19.2-5).
 */
#include "elliptic.h"
#include "kernels.h"

enum { RESTING, TURNING, SWINGING, ROTATING };

typedef struct {
    int kind;
    dd rate, start;   /* u = rate t + start; without gravity theta itself */
    double k, sense;  /* modulus as above; -1 mirrors the motion */
    double w0, omega; /* sqrt(g/l); theta' at the start */
    jacobi j;
} pendulum;

/* The in-plane unit vectors: down (along gravity, else the rod) and across. */
typedef struct {
    dd down[3], across[3];
} plane;

static dd length_of(const dd *v)
{
    return dd_sqrt(dd_dot(v, v));
}

/* Part of v that is perpendicular to the unit vector n, made a unit vector; its length. */
static dd perpendicular(const dd *restrict v, const dd *restrict n, dd *restrict out)
{
    dd along = dd_dot(v, n), size;
    for (int i = 0; i < 3; i++)
        out[i] = dd_sub(v[i], dd_mul(along, n[i]));
    size = length_of(out);
    for (int i = 0; i < 3; i++)
        out[i] = size.hi > 0.0 ? dd_div(out[i], size) : dd_of(0.0);
    return size;
}

static plane plane_of(const double *restrict gravity, const dd *restrict rod, const dd *restrict velocity)
{
    plane p;
    dd down[3], size;
    for (int i = 0; i < 3; i++)
        down[i] = dd_of(gravity[i]);
    size = length_of(down);
    if (size.hi == 0.0) {
        for (int i = 0; i < 3; i++)
            down[i] = rod[i];
        size = length_of(down);
    }
    for (int i = 0; i < 3; i++)
        p.down[i] = dd_div(down[i], size);
    dd reach = perpendicular(rod, p.down, p.across);
    if (reach.hi <= 1e-28 * length_of(rod).hi)
        perpendicular(velocity, p.down, p.across);
    return p;
}

/* S and C >= 0 from sin and cos of theta, without cancellation. */
static void halved(dd s, dd c, dd *restrict sine, dd *restrict cosine)
{
    dd one = dd_of(1.0), large = dd_sqrt(dd_scale(dd_add(one, dd_abs(c)), 0.5)), small = dd_div(dd_scale(s, 0.5), large);
    *cosine = c.hi > 0.0 ? large : dd_abs(small);
    *sine = c.hi > 0.0 ? small : s.hi < 0.0 ? dd_neg(large) : large;
}

/* Which of the forms the motion has, its modulus, rate and phase, from sin and cos of theta, theta' and w0. */
static void prepare(pendulum *b, dd s, dd c, dd omega, dd w0)
{
    dd sine, cosine, one = dd_of(1.0);
    halved(s, c, &sine, &cosine);
    b->w0 = w0.hi, b->omega = omega.hi, b->sense = 1.0;
    if (w0.hi == 0.0 || (omega.hi == 0.0 && (sine.hi == 0.0 || cosine.hi == 0.0))) {
        b->kind = omega.hi == 0.0 ? RESTING : TURNING;
        b->rate = omega, b->start = angle_of(s, c);
        return;
    }
    dd p = dd_div(omega, dd_scale(w0, 2.0)), square = dd_add(dd_square(sine), dd_square(p));
    dd rest = dd_sub(dd_square(cosine), dd_square(p)), k = dd_sqrt(square);
    b->kind = rest.hi >= 0.0 ? SWINGING : ROTATING;
    b->k = k.hi;
    if (omega.hi < 0.0 && (b->kind == ROTATING || rest.hi == 0.0))
        b->sense = -1.0, sine = dd_neg(sine), p = dd_neg(p);
    if (b->kind == SWINGING) {
        b->j = jacobi_prepared(square, rest);
        b->rate = w0;
        b->start = jacobi_inverse(&b->j, dd_div(sine, k), dd_div(p, k), cosine);
    } else {
        b->j = jacobi_prepared(dd_div(one, square), dd_div(dd_neg(rest), square));
        b->rate = dd_mul(k, w0);
        b->start = jacobi_inverse(&b->j, sine, cosine, dd_div(p, k));
    }
}

/* sin and cos of theta, and theta', after a time. */
static void at(const pendulum *b, dd time, double *restrict s, double *restrict c, double *restrict omega)
{
    dd u = dd_add(b->start, dd_mul(b->rate, time));
    if (b->kind == RESTING || b->kind == TURNING) {
        turned(u, c, s);
        *omega = b->omega;
        return;
    }
    jacobi_point p = jacobi_at(&b->j, u);
    double sine = b->kind == SWINGING ? b->k * p.sn : p.sn, cosine = b->kind == SWINGING ? p.dn : p.cn;
    *s = 2.0 * b->sense * sine * cosine;
    *c = cosine * cosine - sine * sine;
    *omega = 2.0 * b->sense * b->w0 * b->k * (b->kind == SWINGING ? p.cn : p.dn);
}

int refdem_pendulum(double mass, double length, const double *gravity, const double *anchor, const double *position,
                    const double *velocity, double t0, int64_t samples, const double *t, double *out_position, double *out_velocity,
                    double *out_force)
{
    dd rod[3], v[3], across, along, size;
    pendulum b;
    for (int i = 0; i < 3; i++)
        rod[i] = two_sum(position[i], -anchor[i]), v[i] = dd_of(velocity[i]);
    plane way = plane_of(gravity, rod, v);
    across = dd_dot(rod, way.across), along = dd_dot(rod, way.down);
    size = dd_sqrt(dd_add(dd_square(across), dd_square(along)));
    dd s = dd_div(across, size), c = dd_div(along, size);
    dd omega = dd_div(dd_sub(dd_mul(dd_dot(v, way.across), c), dd_mul(dd_dot(v, way.down), s)), dd_of(length));
    dd fall[3] = {dd_of(gravity[0]), dd_of(gravity[1]), dd_of(gravity[2])}, g = length_of(fall);
    prepare(&b, s, c, omega, dd_sqrt(dd_div(g, dd_of(length))));
    for (int64_t k = 0; k < samples; k++) {
        double sine = s.hi, cosine = c.hi, rate = omega.hi;
        int is_start = t[k] == t0 || b.kind == RESTING;
        if (!is_start)
            at(&b, two_sum(t[k], -t0), &sine, &cosine, &rate);
        for (int i = 0; i < 3; i++) {
            double down = way.down[i].hi, side = way.across[i].hi;
            out_position[3 * k + i] = is_start ? position[i] : anchor[i] + length * (cosine * down + sine * side);
            out_velocity[3 * k + i] = is_start ? velocity[i] : length * rate * (cosine * side - sine * down);
        }
        out_force[k] = mass * (length * rate * rate + g.hi * cosine);
    }
    return 0;
}
