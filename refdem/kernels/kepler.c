/* A point in Newton's central field, bound orbits, in closed form.
 *
 * alpha = 1/a = 2/r - v^2/gm, n = sqrt(gm alpha^3), e cos E0 = 1 - r alpha, e sin E0 = (r.v)
 * sqrt(alpha/gm); Kepler's equation M = E - e sin E; r = a (cos E - e) P + a sqrt(1 - e^2) sin E Q
 * (Danby, Fundamentals of Celestial Mechanics, 6.2-6.8). The mean anomaly counts from periapsis in
 * double-double: near it M is small, and so is its error.
 */
#include "elliptic.h"
#include "kernels.h"

typedef struct {
    dd rate, start;       /* n and M at the start */
    double e, less, flat; /* e, 1 - e, sqrt(1 - e^2) */
    double a, speed;      /* a, n a */
    double p[3], q[3];    /* towards periapsis; a quarter turn on */
    double t0, position[3], velocity[3];
    int64_t samples;
    const double *t;
    double *out_position, *out_velocity;
} orbit;

/* E - sin E, without cancellation for small E; s = sin E. */
static double excess(double x, double s)
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

/* Cos and sin of E for M in -pi..pi: Danby's start and quartic steps (6.6.7), the last one on the
 * residual with M's low part. */
static void eccentric(const orbit *o, dd mean, double *restrict c, double *restrict s)
{
    double m = mean.hi;
    double x = m + copysign(0.85 * o->e, m);
    if (fabs(m) < 0.1 * o->less) /* near the pericentre M = (1 - e) E */
        x = m / o->less;
    double change = 1.0;
    for (int i = 0; i < 30 && fabs(change) > 1e-9 * fabs(x); i++) {
        double s0 = sin(x);
        double f = o->less * x + o->e * excess(x, s0) - m;
        double sine = o->e * s0;
        double cosine = o->e * cos(x);
        double slope = 1.0 - cosine;
        double first = -f / slope;
        double second = -f / (slope + 0.5 * first * sine);
        change = -f / (slope + 0.5 * second * sine + second * second * cosine / 6.0);
        x += change;
    }
    double s0 = sin(x);
    double c0 = cos(x);
    double low = (m - (o->less * x + o->e * excess(x, s0)) + mean.lo) / (1.0 - o->e * c0);
    *c = fma(-low, s0, c0);
    *s = fma(low, c0, s0);
}

/* 0, or 1 if the orbit is not bound or goes through the centre. */
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
    dd distance = dd_sqrt(dd_dot(r, r));
    dd alpha = dd_sub(dd_div(dd_of(2.0), distance), dd_div(dd_dot(v, v), mu));
    if (!(alpha.hi > 0.0))
        return 1;
    dd root = dd_sqrt(dd_div(alpha, mu));
    dd a = dd_div(one, alpha);
    dd cosine = dd_sub(one, dd_mul(distance, alpha));
    dd sine = dd_mul(dd_dot(r, v), root);
    dd e = dd_sqrt(dd_add(dd_square(cosine), dd_square(sine)));
    dd square = dd_mul(dd_sub(dd_mul(dd_dot(r, r), dd_dot(v, v)), dd_square(dd_dot(r, v))),
                       dd_div(alpha, mu));
    if (!(square.hi > 1e-16))
        return 1;
    dd flat = dd_sqrt(square);
    dd anomaly = angle_of(sine, cosine);
    dd c = one;
    dd s = dd_of(0.0);
    if (e.hi > 0.0) {
        c = dd_div(cosine, e);
        s = dd_div(sine, e);
    }
    o->rate = dd_mul(alpha, dd_sqrt(dd_mul(mu, alpha)));
    o->start = dd_sub(anomaly, sine);
    o->e = e.hi;
    o->less = dd_div(square, dd_add(one, e)).hi;
    o->flat = flat.hi;
    o->a = a.hi;
    o->speed = dd_mul(o->rate, a).hi;
    for (int i = 0; i < 3; i++) {
        dd out = dd_div(r[i], distance);
        dd on = dd_div(v[i], dd_sqrt(dd_mul(mu, alpha)));
        o->position[i] = position[i];
        o->velocity[i] = velocity[i];
        o->p[i] = dd_sub(dd_mul(c, out), dd_mul(s, on)).hi;
        o->q[i] = dd_div(dd_add(dd_mul(s, out), dd_mul(dd_sub(c, e), on)), flat).hi;
    }
    return 0;
}

int64_t refdem_kepler_size(void)
{
    return (sizeof(orbit) + sizeof(double) - 1) / sizeof(double);
}

REFDEM_EVERY_CPU
int refdem_kepler_prepare(double gm, const double *position, const double *velocity, double t0,
                          int64_t samples, const double *t, double *out_position,
                          double *out_velocity, double *motion)
{
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
    const orbit *o = (const orbit *)motion;
    const double *t = o->t;
    double *out_position = o->out_position;
    double *out_velocity = o->out_velocity;
    const dd turn = dd_scale(DD_PI, 2.0);
    for (int64_t n = 0; n < o->samples; n++) {
        if (t[n] == o->t0) {
            memcpy(out_position + 3 * n, o->position, sizeof o->position);
            memcpy(out_velocity + 3 * n, o->velocity, sizeof o->velocity);
            continue;
        }
        double c, s;
        int odd;
        dd mean = dd_add(o->start, dd_mul(o->rate, two_sum(t[n], -o->t0)));
        eccentric(o, dd_reduced(mean, turn, &odd), &c, &s);
        double small = s * s / (1.0 + fabs(c));
        double above = 1.0 - c; /* 1 - cos E, without cancellation */
        if (c > 0.0)
            above = small;
        double x = o->a * (o->less - above);
        double y = o->a * o->flat * s;
        double per = o->speed / (o->less + o->e * above);
        for (int i = 0; i < 3; i++) {
            out_position[3 * n + i] = x * o->p[i] + y * o->q[i];
            out_velocity[3 * n + i] = per * (o->flat * c * o->q[i] - s * o->p[i]);
        }
    }
    return 0;
}

int refdem_kepler(double gm, const double *position, const double *velocity, double t0,
                  int64_t samples, const double *t, double *out_position, double *out_velocity)
{
    orbit o;
    if (refdem_kepler_prepare(gm, position, velocity, t0, samples, t, out_position, out_velocity,
                              (double *)&o))
        return 1;
    return refdem_kepler_run((const double *)&o);
}
