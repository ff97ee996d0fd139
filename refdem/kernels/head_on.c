/* Head-on contact of two spheres with a linear spring and dashpot, in closed form: the overlap d
 * obeys m d'' + c d' + k d = 0 from d = 0, d' = V at the touch.
 *
 * With the effective mass m = m1 m2/(m1 + m2), b = c/(2m), w0^2 = k/m and w^2 = w0^2 - b^2:
 *
 *   d = V exp(-b t) S(t),   d' = V exp(-b t) (S'(t) - b S(t)),
 *   S = sin(w t)/w for w^2 > 0,   sinh(W t)/W for w^2 = -W^2 < 0,   t for w^2 = 0.
 *
 * The contact ends at d = 0, half a period pi/w after the touch, or, with no_pull, where the force
 * k d + c d' is zero, at twice the time of the largest overlap. Either leaves the speed V exp(-b
 * t_end) (Schwager and Poeschel 2007).
 */
#include <assert.h>
#include <stdbool.h>

#include "double_double.h"
#include "kernels.h"

typedef struct {
    double decay;     /* b [1/s] */
    double frequency; /* w or W [rad/s] */
    double end;       /* how long the contact lasts [s] */
    int sign;         /* of w^2: 1 underdamped, 0 critically damped, -1 overdamped */
} damped;

/* Columns of a row of the output. */
enum { OVERLAP, OVERLAP_RATE, PRESSES, FORCE, LOST_WORK, COLUMNS };

/* A time [s] that stands for "never": exp(-b LATEST) is 0, where infinity would give 0 * infinity.
 */
#define LATEST 1e300

/* Time [s] of the largest overlap, d' = 0: tan(w t) = w/b, tanh(W t) = W/b, or t = 1/b. */
static double turning_time(const damped *s)
{
    if (s->sign == 0)
        return 1.0 / s->decay;
    if (s->sign > 0)
        return atan2(s->frequency, s->decay) / s->frequency;
    return atanh(s->frequency / s->decay) / s->frequency;
}

/* The contact of spheres with the effective mass `mass`. */
static damped prepare(dd mass, double stiffness, double damping, int no_pull)
{
    dd b = dd_div(dd_of(0.5 * damping), mass);
    /* w^2 = k/m - b^2 in twice the digits: near critical damping it cancels. */
    dd square = dd_sub(dd_div(dd_of(stiffness), mass), dd_square(b));
    damped s = {.decay = dd_round(b), .frequency = sqrt(fabs(dd_round(square)))};
    if (square.hi > 0.0)
        s.sign = 1;
    else if (square.hi < 0.0)
        s.sign = -1;
    s.end = INFINITY; /* overdamped with a force that may pull: the contact does not end */
    if (no_pull && damping > 0.0)
        s.end = 2.0 * turning_time(&s);
    else if (s.sign > 0) /* half a period */
        s.end = dd_round(dd_div(DD_PI, dd_sqrt(square)));
    return s;
}

/* Overlap and its rate at t [s] after the touch, for V = 1. */
static void state_at(const damped *p, double t, double *restrict overlap, double *restrict rate)
{
    /* S and S' by the sign of w^2. */
    double s_rate = 1.0;
    double s = t;
    double decayed = exp(-p->decay * t);
    if (p->sign > 0) {
        s_rate = cos(p->frequency * t);
        s = sin(p->frequency * t) / p->frequency;
    }
    if (p->sign < 0) {
        s_rate = cosh(p->frequency * t);
        s = sinh(p->frequency * t) / p->frequency;
    }
    /* d = exp(-b t) S,   d' = exp(-b t) (S' - b S). */
    *overlap = decayed * s;
    *rate = decayed * (s_rate - p->decay * s);
}

int refdem_head_on(double mass1, double mass2, double stiffness, double damping, int no_pull,
                   double overlap, double closing, int64_t samples, const double *t, double *touch,
                   double *out)
{
    assert(samples >= 1 && t && touch && out); /* touch (2), out (samples, COLUMNS) */
    dd total = two_sum(mass1, mass2);
    dd mass = dd_div(two_product(mass1, mass2), total);
    damped contact = prepare(mass, stiffness, damping, no_pull);
    double m = dd_round(mass);
    /* The time of the touch, where overlap + closing t = 0; never for spheres that do not close. */
    double begin = INFINITY;
    if (closing > 0.0)
        begin = fmax(0.0, -overlap / closing);
    /* Where no force may pull, it ends while the spheres still overlap. */
    double overlap_after = 0.0;
    if (no_pull && damping > 0.0) {
        double unit_overlap, unit_rate; /* for V = 1 */
        state_at(&contact, fmin(contact.end, LATEST), &unit_overlap, &unit_rate);
        overlap_after = unit_overlap * closing;
    }
    /* Speed after the contact: -V exp(-b end). */
    double rate_after = -closing * exp(-contact.decay * contact.end);
    for (int64_t row = 0; row < samples; row++, out += COLUMNS) {
        double since = t[row] - begin;
        bool presses = since >= 0.0 && since < contact.end;
        /* Before the touch the spheres approach at a constant speed. */
        double d = overlap + closing * t[row];
        double d_rate = closing;
        if (presses) {
            state_at(&contact, since, &d, &d_rate);
            d *= closing;
            d_rate *= closing;
        } else if (since >= contact.end) { /* they fly apart */
            d = overlap_after + rate_after * (since - contact.end);
            d_rate = rate_after;
        }
        out[OVERLAP] = d;
        out[OVERLAP_RATE] = d_rate;
        out[PRESSES] = 0.0;
        out[FORCE] = 0.0;
        if (presses) {
            out[PRESSES] = 1.0;
            out[FORCE] = stiffness * d + damping * d_rate;
        }
        /* Energy lost: m (V^2 - d'^2)/2 - k d^2/2. */
        double kinetic_lost = 0.5 * m * (closing - d_rate) * (closing + d_rate);
        out[LOST_WORK] = kinetic_lost - 0.5 * stiffness * fmax(d, 0.0) * fmax(d, 0.0);
    }
    touch[0] = begin;
    touch[1] = begin + contact.end;
    return 0;
}
