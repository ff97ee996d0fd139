/* A contact whose force is a power of the overlap, one law on the way in and one on the way out, in
 * closed form.
 *
 * m d'' = -k d^n. With a = 1/(n+1), greatest overlap D = ((n+1) m v^2/(2k))^a, y = d/D and s = d'/v
 * the energy is y^(n+1) + s^2 = 1, and the time, in units of D/v, is y 2F1(1/2, a; 1+a; y^(n+1))
 * since touch, 2a s 2F1(1-a, 1/2; 3/2; s^2) before the turn; each is solved by Newton's rule where
 * its series has an argument below 0.6 (Hertz 1882: n = 3/2).
 */
#include <assert.h>

#include <math.h>

#include "kernels.h"

typedef struct {
    double a, power;           /* 1/(n+1), n+1 */
    double depth, speed, unit; /* D, v, D/v */
    double half;               /* time from touch to the turn */
} leg;

enum { TERMS = 120, TRIES = 40 };
static const double NEAR_TOUCH = 0.8;
static const double PI = 3.14159265358979323846;

/* y 2F1(1/2, a; 1+a; z), z = y^(n+1). */
static double since_touch(const leg *l, double y, double z)
{
    double sum = 1.0;
    double factor = 1.0;
    for (int k = 1; k < TERMS && factor > 1e-18; k++) {
        factor *= z * (k - 0.5) / k;
        sum += factor * l->a / (l->a + k);
    }
    return y * sum;
}

/* 2a s 2F1(1-a, 1/2; 3/2; s^2). */
static double before_turn(const leg *l, double s)
{
    double sum = 1.0;
    double factor = 1.0;
    for (int k = 1; k < TERMS && factor > 1e-18; k++) {
        factor *= s * s * (k - l->a) / k;
        sum += factor / (2 * k + 1);
    }
    return 2.0 * l->a * s * sum;
}

/* A leg with this greatest overlap. */
static leg prepared(double mass, double stiffness, double exponent, double depth)
{
    leg l = {.a = 1.0 / (exponent + 1.0), .power = exponent + 1.0, .depth = depth};
    l.speed = sqrt(2.0 * stiffness / (l.power * mass) * pow(depth, l.power));
    l.unit = depth / l.speed;
    l.half = l.unit * sqrt(PI) * tgamma(1.0 + l.a) / tgamma(l.a + 0.5);
    return l;
}

/* The greatest overlap that the energy of an overlap and a rate reaches. */
static double reached(double mass, double stiffness, double exponent, double overlap, double rate)
{
    double power = exponent + 1.0;
    double ease = power * mass / (2.0 * stiffness);
    return pow(ease * rate * rate + pow(fmax(overlap, 0.0), power), 1.0 / power);
}

/* Time from touch to a state on the way in. */
static double elapsed(const leg *l, double overlap, double rate)
{
    double y = overlap / l->depth;
    double z = pow(y, l->power);
    if (z < 0.5)
        return l->unit * since_touch(l, y, z);
    return l->half - l->unit * before_turn(l, rate / l->speed); /* from the turn, which is nearer */
}

/* Overlap and rate at `since` touch, up to the turn. */
static void pressed(const leg *l, double since, double left, double *restrict overlap,
                    double *restrict rate)
{
    double goal = since / l->unit;
    double x = goal;
    double change = 1.0;
    if (goal < NEAR_TOUCH) {
        for (int i = 0; i < TRIES && fabs(change) > 1e-17 * x; i++) {
            double z = pow(x, l->power);
            double before = fabs(change);
            change = (goal - since_touch(l, x, z)) * sqrt(1.0 - z);
            if (i > 3 && fabs(change) >= before)
                break;
            x += change;
        }
        *overlap = l->depth * x;
        *rate = l->speed * sqrt(1.0 - pow(x, l->power));
        return;
    }
    goal = left / l->unit;
    x = goal;
    for (int i = 0; i < TRIES && fabs(change) > 1e-17 * fabs(x); i++) {
        double before = fabs(change);
        change = (goal - before_turn(l, x)) * pow(1.0 - x * x, 1.0 - l->a) / (2.0 * l->a);
        if (i > 3 && fabs(change) >= before)
            break;
        x += change;
    }
    *overlap = l->depth * pow(1.0 - x * x, l->a);
    *rate = l->speed * x;
}

int refdem_power_contact(double mass, const double *in, const double *out_law, double overlap,
                         double rate, int64_t samples, const double *t, double *touch, double *out)
{
    assert(samples >= 1 && touch && out);
    int overlaps = overlap > 0.0;
    int is_leaving = overlaps && rate < 0.0;
    int meets = overlaps || rate > 0.0;
    const double *law = in; /* the one that holds at the start */
    if (is_leaving)
        law = out_law;
    double depth = 1.0;
    if (meets)
        depth = reached(mass, law[0], law[1], overlap, rate);
    leg inward = prepared(mass, in[0], in[1], depth);
    leg outward = prepared(mass, out_law[0], out_law[1], depth);
    if (meets && !overlaps) { /* the speed of touch is given: it need not go through the powers */
        inward.half *= inward.speed / rate;
        inward.speed = rate;
        inward.unit = depth / rate;
    }
    double turn = INFINITY;
    if (is_leaving) /* it has turned already */
        turn = elapsed(&outward, overlap, -rate) - outward.half;
    else if (overlaps)
        turn = inward.half - elapsed(&inward, overlap, rate);
    else if (meets) /* it flies first */
        turn = inward.half - overlap / rate;
    touch[0] = turn - inward.half;
    touch[1] = turn;
    touch[2] = turn + outward.half;
    for (int64_t row = 0; row < samples; row++, out += 2) {
        double left = turn - t[row];
        const leg *l = &inward;
        double sense = 1.0;
        if (!(left >= 0.0)) { /* after the turn */
            l = &outward;
            sense = -1.0;
        }
        double since = l->half - fabs(left);
        if (!meets) {
            out[0] = overlap + rate * t[row];
            out[1] = rate;
        } else if (since <= 0.0) {
            out[0] = l->speed * since;
            out[1] = sense * l->speed;
        } else {
            pressed(l, since, fabs(left), out, out + 1);
            out[1] *= sense;
        }
    }
    return 0;
}
