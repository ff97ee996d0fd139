/* A contact whose force is a power of the overlap, m d'' = -k d^n, with one law on the way in and
 * one on the way out, in closed form (Hertz 1882: n = 3/2).
 *
 * With the speed v at the touch, a = 1/(n+1), greatest overlap D = ((n+1) m v^2/(2k))^a, y = d/D
 * and s = d'/v the energy is y^(n+1) + s^2 = 1, and the time, in units of D/v,
 *
 *   since the touch   T(y) = y 2F1(1/2, a; 1+a; y^(n+1)),    dT/dy = 1/sqrt(1 - y^(n+1)),
 *   before the turn   U(s) = 2a s 2F1(1-a, 1/2; 3/2; s^2),   dU/ds = 2a (1 - s^2)^(a-1).
 *
 * Each is inverted by Newton's method where the argument of its series is the smaller one. The time
 * from touch to turn is T(1) = sqrt(pi) Gamma(1+a)/Gamma(a+1/2).
 */
#include <assert.h>

#include <math.h>

#include "kernels.h"

/* The way in or the way out, which is a way in run backwards. */
typedef struct {
    double a, power;           /* 1/(n+1), n+1 */
    double depth, speed, unit; /* D [m], v [m/s], D/v [s] */
    double half;               /* time from touch to turn [s] */
} leg;

enum { TERMS = 120, TRIES = 40 };
/* Times T below which the touch is the nearer end; the series there has an argument below 0.6. */
static const double NEAR_TOUCH = 0.8;
static const double PI = 3.14159265358979323846;

/* T(y) = y 2F1(1/2, a; 1+a; z), z = y^(n+1): terms (1/2)_k/k! a/(a+k) z^k. */
static double time_since_touch(const leg *l, double y, double z)
{
    double sum = 1.0;
    double factor = 1.0;
    for (int k = 1; k < TERMS && factor > 1e-18; k++) {
        factor *= z * (k - 0.5) / k;
        sum += factor * l->a / (l->a + k);
    }
    return y * sum;
}

/* U(s) = 2a s 2F1(1-a, 1/2; 3/2; s^2): terms (1-a)_k/k! s^(2k)/(2k+1). */
static double time_before_turn(const leg *l, double s)
{
    double sum = 1.0;
    double factor = 1.0;
    for (int k = 1; k < TERMS && factor > 1e-18; k++) {
        factor *= s * s * (k - l->a) / k;
        sum += factor / (2 * k + 1);
    }
    return 2.0 * l->a * s * sum;
}

/* The leg of a law with the greatest overlap `depth` [m]. */
static leg prepare(double mass, double stiffness, double exponent, double depth)
{
    /* v^2 = 2 k D^(n+1)/((n+1) m), and the time from touch to turn T(1) D/v. */
    leg l = {.a = 1.0 / (exponent + 1.0), .power = exponent + 1.0, .depth = depth};
    l.speed = sqrt(2.0 * stiffness / (l.power * mass) * pow(depth, l.power));
    l.unit = depth / l.speed;
    l.half = l.unit * sqrt(PI) * tgamma(1.0 + l.a) / tgamma(l.a + 0.5);
    return l;
}

/* The greatest overlap [m] from the energy: D^(n+1) = d^(n+1) + (n+1) m d'^2/(2k). */
static double greatest_overlap(double mass, double stiffness, double exponent, double overlap,
                               double rate)
{
    double power = exponent + 1.0;
    double ease = power * mass / (2.0 * stiffness);
    return pow(ease * rate * rate + pow(fmax(overlap, 0.0), power), 1.0 / power);
}

/* Time [s] from touch to a state on the way in, by the series of the nearer end. */
static double time_of(const leg *l, double overlap, double rate)
{
    double y = overlap / l->depth;
    double z = pow(y, l->power);
    if (z < 0.5)
        return l->unit * time_since_touch(l, y, z);
    return l->half
           - l->unit * time_before_turn(l, rate / l->speed); /* from the turn, which is nearer */
}

/* Overlap and rate at the time `since` the touch, `left` before the turn [s], by Newton's method
 * until it no longer converges:
 *
 *   T(y) = since v/D:   d = D y,                    d' = v sqrt(1 - y^(n+1)),
 *   U(s) = left v/D:    d = D (1 - s^2)^(1/(n+1)),  d' = v s. */
static void state_at(const leg *l, double since, double left, double *restrict overlap,
                     double *restrict rate)
{
    double scaled_time = since / l->unit;
    double root = scaled_time;
    double change = 1.0;
    if (scaled_time < NEAR_TOUCH) {
        for (int i = 0; i < TRIES && fabs(change) > 1e-17 * root; i++) {
            double z = pow(root, l->power);
            double before = fabs(change);
            /* (since v/D - T(y))/(dT/dy) */
            change = (scaled_time - time_since_touch(l, root, z)) * sqrt(1.0 - z);
            if (i > 3 && fabs(change) >= before) /* all that is left is rounding */
                break;
            root += change;
        }
        *overlap = l->depth * root;
        *rate = l->speed * sqrt(1.0 - pow(root, l->power));
        return;
    }
    scaled_time = left / l->unit;
    root = scaled_time;
    for (int i = 0; i < TRIES && fabs(change) > 1e-17 * fabs(root); i++) {
        double before = fabs(change);
        /* (left v/D - U(s))/(dU/ds) */
        change = (scaled_time - time_before_turn(l, root)) * pow(1.0 - root * root, 1.0 - l->a)
                 / (2.0 * l->a);
        if (i > 3 && fabs(change) >= before)
            break;
        root += change;
    }
    *overlap = l->depth * pow(1.0 - root * root, l->a);
    *rate = l->speed * root;
}

int refdem_power_contact(double mass, const double *in, const double *out_law, double overlap,
                         double rate, int64_t samples, const double *t, double *touch, double *out)
{
    assert(in && out_law);                     /* (2) doubles each */
    assert(samples >= 1 && t && touch && out); /* (3) and (samples, 2) doubles */
    int overlaps = overlap > 0.0;
    int is_leaving = overlaps && rate < 0.0;
    int meets = overlaps || rate > 0.0;
    const double *law = in; /* the one that holds at the start */
    if (is_leaving)
        law = out_law;
    double depth = 1.0;
    if (meets)
        depth = greatest_overlap(mass, law[0], law[1], overlap, rate);
    leg inward = prepare(mass, in[0], in[1], depth);
    leg outward = prepare(mass, out_law[0], out_law[1], depth);
    if (meets && !overlaps) { /* the speed of touch is given: it need not go through the powers */
        inward.half *= inward.speed / rate;
        inward.speed = rate;
        inward.unit = depth / rate;
    }
    double turn = INFINITY; /* time of the greatest overlap */
    if (is_leaving)         /* it has turned already */
        turn = time_of(&outward, overlap, -rate) - outward.half;
    else if (overlaps)
        turn = inward.half - time_of(&inward, overlap, rate);
    else if (meets) /* it flies first */
        turn = inward.half - overlap / rate;
    touch[0] = turn - inward.half;
    touch[1] = turn;
    touch[2] = turn + outward.half;
    for (int64_t row = 0; row < samples; row++, out += 2) {
        double left = turn - t[row];
        const leg *l = &inward;
        double sign = 1.0;
        if (!(left >= 0.0)) { /* after the turn */
            l = &outward;
            sign = -1.0;
        }
        double since = l->half - fabs(left);
        if (!meets) { /* free flight without end */
            out[0] = overlap + rate * t[row];
            out[1] = rate;
        } else if (since <= 0.0) { /* before the touch, or after the parting */
            out[0] = l->speed * since;
            out[1] = sign * l->speed;
        } else {
            state_at(l, since, fabs(left), out, out + 1);
            out[1] *= sign;
        }
    }
    return 0;
}
