/* A point on a rigid rod in uniform gravity, in Cartesian coordinates, in space: a Taylor method
 * with projection on the constraint.
 *
 *   r' = v,   v' = g - lambda r,   lambda = (v.v + g.r)/l^2 the multiplier,   tension m l lambda.
 *
 * The rod does no work, (v.v)' = 2 g.v, so that lambda' = 3 g.v/l^2: one scalar product for each
 * coefficient, and no division by r.r, whose error would enter. After each step the state is
 * projected on |r| = l, r.v = 0 (Hairer, Lubich and Wanner, sec. IV.4). A step is STEP_PART times
 * the radius of convergence, which is estimated from the last two coefficients (Jorba and Zou, Exp.
 * Math. 14 (2005) 99).
 *
 * At small speeds an error e along the rod obeys e'' = -(lambda + g.r/l^2) e. Near the top it grows
 * as exp(t sqrt(2 g/l)) until the next projection. The series converge there for much longer times,
 * so that a step is limited to the inverse of this rate.
 */
#include <assert.h>

#include "kernels.h"
#include "simd.h"

enum { ORDER = 24 };
/* Step over the radius of convergence: what is cut off is 0.18^24 = 1e-18. */
static const float STEP_PART = 0.18f;
/* Keeps a coefficient that is zero from an infinite radius. */
static const float LEAST = 1e-30f;

/* Three components and one that stays zero: one register where there are such, arithmetic by
 * component everywhere. */
typedef double wide __attribute__((vector_size(32)));
typedef wide series[ORDER + 1];

typedef struct {
    double length, lambda_factor; /* l [m]; 3/l^2 */
    wide gravity;                 /* [m/s^2] */
    dd r[3], v[3];                /* from the anchor [m]; [m/s] */
} hanging;

/* a.b of the first three components. */
static inline double dot(const wide *restrict a, const wide *restrict b)
{
    return fma((*a)[0], (*b)[0], fma((*a)[1], (*b)[1], (*a)[2] * (*b)[2]));
}

/* lambda [1/s^2] of a state. */
static inline double multiplier(const hanging *restrict m, const wide *restrict r,
                                const wide *restrict v)
{
    return (dot(v, v) + dot(&m->gravity, r)) / (m->length * m->length);
}

/* Coefficients of r and v from the state, in two independent sums over even and odd k:
 *   (n+1) v_(n+1) = (g if n = 0) - sum over k of lambda_(n-k) r_k,   (n+1) r_(n+1) = v_n,
 *   (n+1) lambda_(n+1) = 3 g.v_n/l^2. */
static inline void expand(const hanging *restrict m, wide *restrict r, wide *restrict v)
{
    double lambda[ORDER + 1];
    r[0] = (wide){m->r[0].hi, m->r[1].hi, m->r[2].hi, 0.0};
    v[0] = (wide){m->v[0].hi, m->v[1].hi, m->v[2].hi, 0.0};
    lambda[0] = multiplier(m, r, v);
    for (int n = 0; n < ORDER; n++) {
        double inverse = 1.0 / (n + 1.0);
        wide even_terms = {0.0};
        if (n == 0) /* gravity is constant in time */
            even_terms = -m->gravity;
        wide odd_terms = {0.0};
        lambda[n + 1] = m->lambda_factor * inverse * dot(&m->gravity, v + n);
        int k = 0;
        for (; k < n; k += 2) {
            even_terms += lambda[n - k] * r[k];
            odd_terms += lambda[n - k - 1] * r[k + 1];
        }
        if (k == n)
            even_terms += lambda[0] * r[n];
        v[n + 1] = -inverse * (even_terms + odd_terms);
        r[n + 1] = inverse * v[n];
    }
}

/* Largest component over a scale. */
static inline float largest(const wide *restrict a, double scale)
{
    return (float)(fmax(fmax(fabs((*a)[0]), fabs((*a)[1])), fabs((*a)[2])) / scale) + LEAST;
}

/* -(lambda + g.r/l^2) [1/s^2]: the square of the rate at which an error along the rod grows;
 * negative where it oscillates. */
static inline double drift_rate_squared(const hanging *restrict m, const wide *restrict r,
                                        const wide *restrict v)
{
    return -(dot(v, v) + 2.0 * dot(&m->gravity, r)) / (m->length * m->length);
}

/* The step [s]: from the last two coefficients of r, and no longer than 1/rate where an error along
 * the rod grows. */
static inline double step_size(const hanging *restrict m, const wide *restrict r,
                               const wide *restrict v)
{
    /* 1/rho = max over n = ORDER - 1, ORDER of (max_i |r_n,i|/l)^(1/n), step = STEP_PART rho. */
    float inverse_radius = fmaxf(powf(largest(r + ORDER - 1, m->length), 1.0f / (ORDER - 1)),
                                 powf(largest(r + ORDER, m->length), 1.0f / ORDER));
    double step = STEP_PART / inverse_radius;
    double growth = drift_rate_squared(m, r, v);
    if (growth * step * step > 1.0)
        return 1.0 / sqrt(growth);
    return step;
}

/* a(time) - a(0), by Horner's rule in time^2. */
static inline void gained(const wide *restrict a, double time, wide *restrict out)
{
    wide even = a[ORDER];
    wide odd = a[ORDER - 1];
    double square = time * time;
    for (int k = ORDER - 2; k > 0; k -= 2) {
        even = square * even + a[k];
        odd = square * odd + a[k - 1];
    }
    *out = time * (time * even + odd);
}

/* Projects the state on |r| = l and r.v = 0, to first order in the errors: r -= (r.r - l^2)/(2 l^2)
 * r, v -= (r.v)/l^2 r. */
static inline void hold(hanging *m)
{
    double square = m->length * m->length;
    /* excess = r.r - l^2; r -= excess/(2 l^2) r, v -= (r.v)/l^2 r. */
    dd excess = dd_sub(dd_dot(m->r, m->r), two_product(m->length, m->length));
    double r_factor = -0.5 * excess.hi / square;
    double v_factor = -dd_dot(m->r, m->v).hi / square;
    for (int i = 0; i < 3; i++) {
        double r = m->r[i].hi;
        m->r[i] = dd_add(m->r[i], dd_of(r_factor * r));
        m->v[i] = dd_add(m->v[i], dd_of(v_factor * r));
    }
}

REFDEM_EVERY_CPU
int refdem_rod_taylor(double mass, double length, const double *gravity, const double *anchor,
                      const double *position, const double *velocity, double t0, int64_t samples,
                      const double *t, double *out_position, double *out_velocity,
                      double *out_force)
{
    assert(gravity && anchor && position && velocity);
    assert(samples == 0 || (t && out_position && out_velocity && out_force));
    hanging m = {.length = length,
                 .gravity = {gravity[0], gravity[1], gravity[2], 0.0},
                 .lambda_factor = 3.0 / (length * length)};
    series r, v;
    double step = 0.0;
    double direction = 1.0;
    if (samples > 1 && t[samples - 1] < t0) /* backwards */
        direction = -1.0;
    dd now = dd_of(0.0);
    for (int i = 0; i < 3; i++) {
        m.r[i] = two_sum(position[i], -anchor[i]);
        m.v[i] = dd_of(velocity[i]);
    }
    hold(&m);
    expand(&m, r, v);
    step = step_size(&m, r, v);
    for (int64_t k = 0; k < samples; k++) {
        dd target = two_sum(t[k], -t0);
        dd to_sample = dd_sub(target, now);
        while (direction * to_sample.hi > step) {
            /* Accept: the end of the step becomes the state, held to its rod. */
            wide gain_r, gain_v;
            gained(r, direction * step, &gain_r);
            gained(v, direction * step, &gain_v);
            for (int i = 0; i < 3; i++) {
                m.r[i] = dd_add(m.r[i], dd_of(gain_r[i]));
                m.v[i] = dd_add(m.v[i], dd_of(gain_v[i]));
            }
            hold(&m);
            now = dd_add(now, dd_of(direction * step));
            to_sample = dd_sub(target, now);
            expand(&m, r, v);
            step = step_size(&m, r, v);
            if (!(step > 0.0)) /* the speed is no longer finite */
                return (int)(k + 1);
        }
        wide place, speed;
        gained(r, to_sample.hi, &place);
        gained(v, to_sample.hi, &speed);
        for (int i = 0; i < 3; i++) {
            place[i] = dd_round(dd_add(m.r[i], dd_of(place[i])));
            speed[i] = dd_round(dd_add(m.v[i], dd_of(speed[i])));
            out_position[3 * k + i] = anchor[i] + place[i];
            out_velocity[3 * k + i] = speed[i];
        }
        if (t[k] == t0) { /* the start as it was given */
            memcpy(out_position + 3 * k, position, 3 * sizeof *position);
            memcpy(out_velocity + 3 * k, velocity, 3 * sizeof *velocity);
        }
        /* Tension m l lambda = m (v.v + g.r)/l. */
        out_force[k] = mass * length * multiplier(&m, &place, &speed);
    }
    return 0;
}
