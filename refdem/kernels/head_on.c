/* Head-on contact of two spheres with a linear spring and dashpot, in closed form: m d'' + c d' + k
 * d = 0.
 *
 * With m the effective mass, b = c/(2m), w0^2 = k/m, w^2 = w0^2 - b^2 and V the closing speed: d =
 * V exp(-b t) sin(w t)/w, or sinh(W t)/W, or t in place of sin(w t)/w. Either cut-off leaves the
 * speed V exp(-b t_end) (Schwager and Poeschel 2007).
 */
#include <assert.h>

#include "double_double.h"
#include "kernels.h"

typedef struct {
    double decay, rate, end; /* b; w or W; how long it lasts */
    int kind;                /* sign of w^2 */
} damped;

/* When the overlap is largest; the force of spring and dashpot vanishes after twice that time. */
static double turning_time(const damped *s)
{
    if (s->kind == 0)
        return 1.0 / s->decay;
    if (s->kind > 0)
        return atan2(s->rate, s->decay) / s->rate;
    return atanh(s->rate / s->decay) / s->rate;
}

static damped prepared(dd mass, double stiffness, double damping, int no_pull)
{
    dd b = dd_div(dd_of(0.5 * damping), mass);
    dd square = dd_sub(dd_div(dd_of(stiffness), mass), dd_square(b));
    damped s = {.decay = dd_round(b), .rate = sqrt(fabs(dd_round(square)))};
    s.kind = (square.hi > 0.0) - (square.hi < 0.0);
    s.end = INFINITY; /* what is damped too much to swing stays pressed for ever */
    if (no_pull && damping > 0.0)
        s.end = 2.0 * turning_time(&s);
    else if (s.kind > 0) /* half a swing */
        s.end = dd_round(dd_div(DD_PI, dd_sqrt(square)));
    return s;
}

/* Overlap and its rate at t after the touch, for V = 1. */
static void pressed(const damped *s, double t, double *restrict overlap, double *restrict rate)
{
    double wave = 1.0;
    double swing = t;
    double size = exp(-s->decay * t);
    if (s->kind > 0) {
        wave = cos(s->rate * t);
        swing = sin(s->rate * t) / s->rate;
    }
    if (s->kind < 0) {
        wave = cosh(s->rate * t);
        swing = sinh(s->rate * t) / s->rate;
    }
    *overlap = size * swing;
    *rate = size * (wave - s->decay * swing);
}

int refdem_head_on(double mass1, double mass2, double stiffness, double damping, int no_pull,
                   double overlap, double closing, int64_t samples, const double *t, double *touch,
                   double *out)
{
    assert(samples >= 1 && touch && out);
    dd total = two_sum(mass1, mass2);
    dd mass = dd_div(two_product(mass1, mass2), total);
    damped s = prepared(mass, stiffness, damping, no_pull);
    double m = dd_round(mass);
    double begin = INFINITY; /* what does not close never meets */
    if (closing > 0.0)
        begin = fmax(0.0, -overlap / closing);
    double at_end, speed;
    double left = 0.0; /* overlap at the end: the force ends before it where there is no pull */
    pressed(&s, fmin(s.end, 1e300), &at_end, &speed);
    if (no_pull && damping > 0.0)
        left = at_end * closing;
    speed = -closing * exp(-s.decay * s.end);
    for (int64_t row = 0; row < samples; row++, out += 5) {
        double since = t[row] - begin;
        double *d = out;
        double *rate = out + 1;
        int presses = since >= 0.0 && since < s.end;
        *d = overlap + closing * t[row];
        *rate = closing;
        if (presses) {
            pressed(&s, since, d, rate);
            *d *= closing;
            *rate *= closing;
        } else if (since >= s.end) {
            *d = left + speed * (since - s.end);
            *rate = speed;
        }
        out[2] = 0.0;
        out[3] = 0.0;
        if (presses) {
            out[2] = 1.0;
            out[3] = stiffness * *d + damping * *rate;
        }
        out[4] = 0.5 * m * (closing - *rate) * (closing + *rate)
                 - 0.5 * stiffness * fmax(*d, 0.0) * fmax(*d, 0.0);
    }
    touch[0] = begin;
    touch[1] = begin + s.end;
    return 0;
}
