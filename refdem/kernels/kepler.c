/* A point in Newton's central field, bound orbits, in closed form (Danby, Fundamentals of Celestial
 * Mechanics, 6.2-6.8).
 *
 * From the start, with alpha = 1/a = 2/r - v^2/gm:
 *   mean motion n = sqrt(gm alpha^3),  e cos E0 = 1 - r alpha,  e sin E0 = (r.v) sqrt(alpha/gm),
 *   1 - e^2 = (r^2 v^2 - (r.v)^2) alpha/gm,  M0 = E0 - e sin E0.
 * At time t: M = M0 + n (t - t0), Kepler's equation M = E - e sin E, and, along the unit vectors P
 * towards periapsis and Q a quarter turn on,
 *   r = a (cos E - e) P + a sqrt(1 - e^2) sin E Q,
 *   v = n a/(1 - e cos E) (sqrt(1 - e^2) cos E Q - sin E P).
 * The mean anomaly is measured from periapsis in double-double, so that its error is small where M
 * is small.
 */
#include <assert.h>

#include "elliptic.h"
#include "kernels.h"

typedef struct {
    dd rate, start; /* n [rad/s] and M0 [rad] */
    double e, one_minus_e, root_one_minus_e2;
    double a, speed;   /* a [m], n a [m/s] */
    double p[3], q[3]; /* P, Q */
    double t0, position[3], velocity[3];
    int64_t samples;
    const double *t;
    double *out_position, *out_velocity;
} orbit;

/* x - sin x, s = sin x; for |x| <= 1 by its series x^3/3! - x^5/5! + .., without cancellation. */
static double minus_sine(double x, double s)
{
    if (fabs(x) > 1.0)
        return x - s;
    double square = x * x;
    double term = x * square / 6.0;
    double sum = term;
    for (int n = 2; n < 10; n++) {
        term *= -square / (2.0 * n * (2.0 * n + 1.0));
        sum += term;
    }
    return sum;
}

/* cos E and sin E for M in -pi..pi. Kepler's equation as f(E) = (1 - e) E + e (E - sin E) - M = 0,
 * which does not cancel near periapsis; from Danby's start E = M + 0.85 e sgn M by his quartic
 * steps (6.6.7), and one last Newton step, with M's low part, applied to cosine and sine. */
static void solve_kepler(const orbit *o, dd mean, double *restrict c, double *restrict s)
{
    double m = mean.hi;
    double anomaly = m + copysign(0.85 * o->e, m);
    if (fabs(m) < 0.1 * o->one_minus_e) /* near periapsis M = (1 - e) E */
        anomaly = m / o->one_minus_e;
    /* With f1 = 1 - e cos E, f2 = e sin E, f3 = e cos E, the first three derivatives of f:
     *   d1 = -f/f1,   d2 = -f/(f1 + d1 f2/2),   d3 = -f/(f1 + d2 f2/2 + d2^2 f3/6),
     * steps of order 2, 3 and 4, and E += d3. */
    double change = 1.0;
    for (int i = 0; i < 30 && fabs(change) > 1e-9 * fabs(anomaly); i++) {
        double s0 = sin(anomaly);
        double f = o->one_minus_e * anomaly + o->e * minus_sine(anomaly, s0) - m;
        double e_sin = o->e * s0;
        double e_cos = o->e * cos(anomaly);
        double slope = 1.0 - e_cos;
        double newton = -f / slope;
        double halley = -f / (slope + 0.5 * newton * e_sin);
        change = -f / (slope + 0.5 * halley * e_sin + halley * halley * e_cos / 6.0);
        anomaly += change;
    }
    /* dE = -f/f', cos(E + dE) = cos E - dE sin E, sin(E + dE) = sin E + dE cos E. */
    double s0 = sin(anomaly);
    double c0 = cos(anomaly);
    double correction = (m - (o->one_minus_e * anomaly + o->e * minus_sine(anomaly, s0)) + mean.lo)
                        / (1.0 - o->e * c0);
    *c = fma(-correction, s0, c0);
    *s = fma(correction, c0, s0);
}

/* The orbit from its start, by the formulas above; 1 if it is not bound or goes through the centre.
 */
static int prepare(orbit *o, double gm, const double *restrict position,
                   const double *restrict velocity)
{
    dd r[3], v[3];
    dd one = dd_of(1.0);
    dd mu = dd_of(gm);
    for (int i = 0; i < 3; i++) {
        r[i] = dd_of(position[i]);
        v[i] = dd_of(velocity[i]);
    }
    /* alpha = 2/r - v^2/gm, a = 1/alpha, e cos E0 = 1 - r alpha, e sin E0 = (r.v) sqrt(alpha/gm),
     * 1 - e^2 = (r^2 v^2 - (r.v)^2) alpha/gm. */
    dd distance = dd_sqrt(dd_dot(r, r));
    dd alpha = dd_sub(dd_div(dd_of(2.0), distance), dd_div(dd_dot(v, v), mu));
    if (!(alpha.hi > 0.0)) /* a parabola or hyperbola */
        return 1;
    dd root_alpha_mu = dd_sqrt(dd_div(alpha, mu));
    dd a = dd_div(one, alpha);
    dd e_cos_e0 = dd_sub(one, dd_mul(distance, alpha));
    dd e_sin_e0 = dd_mul(dd_dot(r, v), root_alpha_mu);
    dd e = dd_sqrt(dd_add(dd_square(e_cos_e0), dd_square(e_sin_e0)));
    dd one_minus_e2 = dd_mul(dd_sub(dd_mul(dd_dot(r, r), dd_dot(v, v)), dd_square(dd_dot(r, v))),
                             dd_div(alpha, mu));
    if (!(one_minus_e2.hi > 1e-16)) /* numerically a straight line through the centre */
        return 1;
    dd root = dd_sqrt(one_minus_e2);
    dd e0 = angle_of(e_sin_e0, e_cos_e0);
    dd cos_e0 = one; /* on a circle periapsis is where it starts */
    dd sin_e0 = dd_of(0.0);
    if (e.hi > 0.0) {
        cos_e0 = dd_div(e_cos_e0, e);
        sin_e0 = dd_div(e_sin_e0, e);
    }
    /* n = sqrt(gm alpha^3), M0 = E0 - e sin E0. */
    o->rate = dd_mul(alpha, dd_sqrt(dd_mul(mu, alpha)));
    o->start = dd_sub(e0, e_sin_e0);
    o->e = e.hi;
    o->one_minus_e = dd_div(one_minus_e2, dd_add(one, e)).hi;
    o->root_one_minus_e2 = root.hi;
    o->a = a.hi;
    o->speed = dd_mul(o->rate, a).hi;
    /* 1 - e = (1 - e^2)/(1 + e) without cancellation, and with b = sqrt(1 - e^2)
     *   P = cos E0 r/|r| - sin E0 v/sqrt(gm alpha),
     *   Q = (sin E0 r/|r| + (cos E0 - e) v/sqrt(gm alpha))/b. */
    for (int i = 0; i < 3; i++) {
        dd radial = dd_div(r[i], distance);
        dd along_v = dd_div(v[i], dd_sqrt(dd_mul(mu, alpha)));
        o->position[i] = position[i];
        o->velocity[i] = velocity[i];
        o->p[i] = dd_sub(dd_mul(cos_e0, radial), dd_mul(sin_e0, along_v)).hi;
        o->q[i]
            = dd_div(dd_add(dd_mul(sin_e0, radial), dd_mul(dd_sub(cos_e0, e), along_v)), root).hi;
    }
    return 0;
}

/* Doubles that a prepared orbit takes. */
int64_t refdem_kepler_size(void)
{
    return (sizeof(orbit) + sizeof(double) - 1) / sizeof(double);
}

REFDEM_EVERY_CPU
int refdem_kepler_prepare(double gm, const double *position, const double *velocity, double t0,
                          int64_t samples, const double *t, double *out_position,
                          double *out_velocity, double *motion)
{
    assert(position && velocity && motion);
    assert(samples == 0 || (t && out_position && out_velocity)); /* (samples, 3) doubles each */
    orbit *o = (orbit *)motion;
    o->t0 = t0;
    o->samples = samples;
    o->t = t;
    o->out_position = out_position;
    o->out_velocity = out_velocity;
    return prepare(o, gm, position, velocity);
}

REFDEM_EVERY_CPU
int refdem_kepler_run(const double *motion)
{
    assert(motion);
    const orbit *o = (const orbit *)motion;
    const double *t = o->t;
    double *out_position = o->out_position;
    double *out_velocity = o->out_velocity;
    const dd period = dd_scale(DD_PI, 2.0);
    for (int64_t n = 0; n < o->samples; n++) {
        if (t[n] == o->t0) { /* the start as it was given */
            memcpy(out_position + 3 * n, o->position, sizeof o->position);
            memcpy(out_velocity + 3 * n, o->velocity, sizeof o->velocity);
            continue;
        }
        double cos_e, sin_e;
        int odd;
        /* M = M0 + n (t - t0). */
        dd mean = dd_add(o->start, dd_mul(o->rate, two_sum(t[n], -o->t0)));
        solve_kepler(o, dd_reduced(mean, period, &odd), &cos_e, &sin_e);
        /* 1 - cos E, as sin^2 E/(1 + cos E) where the difference would cancel. Then
         * cos E - e = (1 - e) - (1 - cos E),   1 - e cos E = (1 - e) + e (1 - cos E). */
        double small = sin_e * sin_e / (1.0 + fabs(cos_e));
        double one_minus_cos = 1.0 - cos_e;
        if (cos_e > 0.0)
            one_minus_cos = small;
        /* r = a (cos E - e) P + a sqrt(1 - e^2) sin E Q, and
         * v = n a/(1 - e cos E) (sqrt(1 - e^2) cos E Q - sin E P). */
        double along_p = o->a * (o->one_minus_e - one_minus_cos);
        double along_q = o->a * o->root_one_minus_e2 * sin_e;
        double speed_over_radius = o->speed / (o->one_minus_e + o->e * one_minus_cos);
        for (int i = 0; i < 3; i++) {
            out_position[3 * n + i] = along_p * o->p[i] + along_q * o->q[i];
            out_velocity[3 * n + i]
                = speed_over_radius * (o->root_one_minus_e2 * cos_e * o->q[i] - sin_e * o->p[i]);
        }
    }
    return 0;
}

int refdem_kepler(double gm, const double *position, const double *velocity, double t0,
                  int64_t samples, const double *t, double *out_position, double *out_velocity)
{
    orbit o;
    double *prepared = (double *)&o; /* callers know a prepared run as doubles */
    if (refdem_kepler_prepare(gm, position, velocity, t0, samples, t, out_position, out_velocity,
                              prepared)) /* not bound, or straight */
        return 1;
    return refdem_kepler_run(prepared);
}
