/* A point in a force that rises linearly from x1 to 0 and falls linearly to x2 (Matuttis and Chen
 * 2014, (1.139)), in closed form, with the time t since the start of a phase, x and v there, and s
 * = x - x1 or x - x2:
 *
 *   rising,  x1 < x < 0:  x - x1 = A exp(lambda t) + B exp(-lambda t),  lambda^2 = k1/m,
 *                         A, B = (s +- v/lambda)/2;  ends at x = 0 (A > 0) or x = x1 (A < 0)
 *   falling, 0 < x < x2:  x - x2 = R cos(omega t + delta),  omega^2 = -k2/m,
 *                         R^2 = s^2 + (v/omega)^2;  ends at x = 0 or x = x2
 *   outside:              free flight
 */
#include <assert.h>
#include <math.h>

#include "kernels.h"

enum { LEFT, RISING, FALLING, RIGHT }; /* regions, along x */

/* The field: its edges [m], lambda and omega [1/s]. */
typedef struct {
    double x1, x2, lambda, omega;
} tent;

/* The motion while it stays in one region. */
typedef struct {
    int region;
    double x, v;      /* at its start [m, m/s] */
    double a, b, lag; /* A, B; or R and delta in a and lag */
    double lasts;     /* how long [s] */
    int next;         /* the region that follows */
} phase;

/* Free flight outside the field: without end, or until it reaches the edge, (edge - x)/v. */
static phase free_flight(const tent *f, int region, double x, double v)
{
    phase p = {.region = region, .x = x, .v = v, .lasts = INFINITY};
    if (region == LEFT && v > 0.0) { /* towards the field */
        p.lasts = (f->x1 - x) / v;
        p.next = RISING;
    }
    if (region == RIGHT && v < 0.0) {
        p.lasts = (f->x2 - x) / v;
        p.next = FALLING;
    }
    return p;
}

/* Leaves at x = 0 (A > 0), where A exp(lambda t) + B exp(-lambda t) = -x1 = h, a quadratic equation
 * in z = exp(lambda t) with z = (h + sqrt(h^2 - 4 A B))/(2 A), or at x = x1 (A < 0), where
 * exp(2 lambda t) = -B/A. With A = 0 it approaches x1 without reaching it. */
static phase rising(const tent *f, double x, double v)
{
    double s = x - f->x1;
    double h = -f->x1;
    phase p = {.region = RISING,
               .x = x,
               .v = v,
               .lasts = INFINITY,
               .a = 0.5 * (s + v / f->lambda),
               .b = 0.5 * (s - v / f->lambda)};
    if (p.a > 0.0) {
        p.lasts = log((h + sqrt(fmax(0.0, h * h - 4.0 * p.a * p.b))) / (2.0 * p.a)) / f->lambda;
        p.next = FALLING;
    }
    if (p.a < 0.0) {
        p.lasts = 0.5 * log(-p.b / p.a) / f->lambda;
        p.next = LEFT;
    }
    return p;
}

/* Leaves at x = 0, where cos(omega t + delta) = -x2/R, if it moves left with R > x2; else at x =
 * x2, where omega t + delta = 3 pi/2. */
static phase falling(const tent *f, double x, double v)
{
    const double pi = 3.14159265358979323846;
    double s = x - f->x2;
    phase p = {.region = FALLING,
               .x = x,
               .v = v,
               .lasts = INFINITY,
               /* R cos delta = s, R sin delta = -v/omega. */
               .a = hypot(s, v / f->omega),
               .lag = atan2(-v / f->omega, s)};
    if (p.lag < 0.0)
        p.lag += 2.0 * pi;
    if (v < 0.0 && p.a > f->x2) {
        p.lasts = (acos(-f->x2 / p.a) - p.lag) / f->omega;
        p.next = RISING;
    } else if (p.a > 0.0) {
        p.lasts = (1.5 * pi - p.lag) / f->omega;
        p.next = RIGHT;
    }
    return p;
}

/* The phase that begins at x, v in a region. */
static phase enter(const tent *f, int region, double x, double v)
{
    if (region == RISING)
        return rising(f, x, v);
    if (region == FALLING)
        return falling(f, x, v);
    return free_flight(f, region, x, v);
}

/* x [m] and v [m/s] at t [s] after the start of a phase:
 *   x = x1 + A exp(lambda t) + B exp(-lambda t),   v = lambda (A exp(lambda t) - B exp(-lambda t)),
 *   x = x2 + R cos(omega t + delta),               v = -omega R sin(omega t + delta),
 * or x + v t outside the field. */
static void state_at(const tent *f, const phase *p, double t, double *restrict x,
                     double *restrict v)
{
    *x = p->x + p->v * t;
    *v = p->v;
    if (p->region == RISING) {
        double grown = p->a * exp(f->lambda * t);
        double left = p->b * exp(-f->lambda * t);
        *x = f->x1 + (grown + left);
        *v = f->lambda * (grown - left);
    }
    if (p->region == FALLING) {
        *x = f->x2 + p->a * cos(f->omega * t + p->lag);
        *v = -f->omega * p->a * sin(f->omega * t + p->lag);
    }
}

/* The region that the motion is in just after x, v. */
static int region_at(const tent *f, double x, double v)
{
    if (x < f->x1 || (x == f->x1 && v <= 0.0))
        return LEFT;
    if (x < 0.0 || (x == 0.0 && v < 0.0))
        return RISING;
    if (x < f->x2 || (x == f->x2 && v < 0.0))
        return FALLING;
    return RIGHT;
}

int refdem_piecewise_field(double mass, double k1, double k2, double x1, double x2, double x0,
                           double v0, int64_t samples, const double *t, double *out)
{
    assert(samples == 0 || (t && out)); /* (samples), (samples, 2) doubles */
    tent f = {x1, x2, sqrt(k1 / mass), sqrt(-k2 / mass)};
    double begin = 0.0;
    double edges[4] = {x1, 0.0, x2, 0.0};
    phase now = enter(&f, region_at(&f, x0, v0), x0, v0);
    for (int64_t row = 0; row < samples; row++, out += 2) {
        while (t[row] - begin > now.lasts) {
            double x, v;
            state_at(&f, &now, now.lasts, &x, &v);
            begin += now.lasts;
            int edge = now.region; /* of the edge between the two regions */
            if (now.next < edge)
                edge = now.next;
            now = enter(&f, now.next, edges[edge], v);
        }
        state_at(&f, &now, t[row] - begin, out, out + 1);
    }
    return 0;
}
