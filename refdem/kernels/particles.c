/* Points and spheres, stepped from event to event: contacts begin, stick, slip and end inside a
 * step.
 *
 * A step that leaves the mode of a pair is repeated up to the moment at which it does (Illinois
 * rule on the method's own map), the mode changes, and the rest of the step follows: a method keeps
 * its order through contacts, and a reversible one stays so.
 */
#include <assert.h>

#include "contact_modes.h"

enum { MOST_EVENTS = 64, HALVES = 16 };
enum { BEGINS = 1, ENDS = 2 }; /* what is told of a contact */

typedef struct {
    double *y, *dy, *next, *rate; /* state and rates at the start and at the end of the step */
    double *event;                /* time, what, body */
    int64_t most, events;
} course;

static const double SLACK = 1e-15;     /* a guard that is off by no more is at zero */
static const double SHORTEST = 1e-6;   /* part of a step: shorter pieces are not tried */
static const double EDGE = 1.0 / 16.0; /* part of a step: where guards are seen to fall and rise */
static const double NARROW = 1e-4;     /* part of a step: a dip as narrow as this is seen */

/* A guard at a part of the step, by a step that ends there. */
static double guard_at(const runner *r, course *c, int64_t k, int kind, double h, double part)
{
    step(r, c->y, c->dy, part * h, c->next, c->rate);
    return guard(r, k, kind, c->next, c->rate);
}

/* Where a guard that begins at zero has risen before it fails at the part `high` of the step: the
 * last such place that halves of it show, as after a slip that ends and begins anew; 0 if it falls
 * at once. */
static double risen(const runner *r, course *c, int64_t k, int kind, double h, double high,
                    double *restrict value)
{
    double found = 0.0;
    for (int i = 1; i <= HALVES; i++) {
        double part = ldexp(high, -i);
        double seen = guard_at(r, c, k, kind, h, part);
        if (found > 0.0 && seen < -SLACK)
            return 0.0;
        if (found == 0.0 && seen > SLACK) {
            found = part;
            *value = seen;
        }
    }
    return found;
}

/* Fraction of the step at which a guard that fails at the part `high` of it becomes zero (Illinois
 * rule; Dowell and Jarratt 1971). */
static double crossing(const runner *r, course *c, int64_t k, int kind, double h, double high,
                       double last)
{
    double low = 0.0;
    double at_low = guard(r, k, kind, c->y, c->dy);
    double at_high = last;
    double found = high;
    int side = 0;
    /* What parts within rounding parts now: else it would stick and slip without end at the last
     * bit. */
    if (kind == GAP && at_low <= SLACK && meet(r->p, k, c->y).rate * h < 0.0)
        return 0.0;
    /* What begins at zero must first have risen. */
    if (at_low <= SLACK) {
        low = risen(r, c, k, kind, h, high, &at_low);
        if (low == 0.0)
            return 0.0;
    }
    if (at_low <= 0.0)
        return 0.0;
    for (int tries = 0; tries < 80 && high - low > 2e-16 * high; tries++) {
        found = (low * at_high - high * at_low) / (at_high - at_low);
        found = fmin(fmax(found, low + 1e-16 * high), high);
        if (tries > 40)
            found = 0.5 * (low + high);
        double value = guard_at(r, c, k, kind, h, found);
        if (value == 0.0 || found == high || found == low)
            break;
        if (value > 0.0) {
            low = found;
            at_low = value;
            if (side == 1) /* twice on this side: the other end counts half */
                at_high *= 0.5;
            side = 1;
        } else {
            high = found;
            at_high = value;
            if (side == -1)
                at_low *= 0.5;
            side = -1;
        }
    }
    return found;
}

/* The state at a part of the step by Hermite's cubic through its ends, and its rates. */
static void between(const runner *r, const course *c, double h, double part, double *restrict y,
                    double *restrict dy)
{
    double left = 1.0 - part;
    double first = left * left * (1.0 + 2.0 * part);
    double last = part * part * (3.0 - 2.0 * part);
    double begins = left * left * part * h;
    double ends = -part * part * left * h;
    for (int64_t i = 0; i < r->size; i++)
        y[i] = first * c->y[i] + begins * c->dy[i] + last * c->next[i] + ends * c->rate[i];
    rates(r->p, r->mode, y, dy);
}

/* Which guards of pair k fall at the start of the step and rise at its end, where neither fails:
 * bits by kind. */
static int dipping(const runner *r, const course *c, int64_t k, const double *early,
                   const double *late, const double *last)
{
    int found = 0;
    for (int g = 0; g < GUARDS; g++) {
        double begins = guard(r, k, g, c->y, c->dy);
        if (!(guard(r, k, g, early, early + r->size) < begins)) /* it does not fall */
            continue;
        if (guard(r, k, g, late, late + r->size) < last[g])
            found |= 1 << g;
    }
    return found;
}

/* The part of the step at which such a guard is lowest, or fails for the first time that is seen
 * (golden section). */
static double lowest(const runner *r, course *c, int64_t k, int kind, double h,
                     double *restrict value)
{
    const double golden = 0.6180339887498949;
    double low = 0.0;
    double high = 1.0;
    double a = 1.0 - golden;
    double b = golden;
    double at_a = guard_at(r, c, k, kind, h, a);
    double at_b = INFINITY; /* not asked where the earlier place fails already */
    if (!(at_a < -SLACK))
        at_b = guard_at(r, c, k, kind, h, b);
    while (!(fmin(at_a, at_b) < -SLACK) && high - low > NARROW) {
        if (at_a < at_b) {
            high = b;
            b = a;
            at_b = at_a;
            a = high - golden * (high - low);
            at_a = guard_at(r, c, k, kind, h, a);
        } else {
            low = a;
            a = b;
            at_a = at_b;
            b = low + golden * (high - low);
            at_b = guard_at(r, c, k, kind, h, b);
        }
    }
    *value = fmin(at_a, at_b);
    if (at_a < at_b)
        return a;
    return b;
}

/* The first guard that fails within the step, as (fraction, pair, kind); 0 if none does.
 * Extrapolation, which claims round-off, sees those too that fail for a while between the ends of
 * the step. */
static int leaving(const runner *r, course *c, double h, double *fraction, int64_t *pair, int *kind)
{
    int found = 0;
    int elsewhere = 0;
    int looks_inside = r->method == EXTRAPOLATION;
    double value[GUARDS];
    double *early = r->scratch + (COLUMNS + 3) * r->size;
    double *late = early + 2 * r->size;
    if (looks_inside) {
        between(r, c, h, EDGE, early, early + r->size);
        between(r, c, h, 1.0 - EDGE, late, late + r->size);
    }
    for (int64_t k = 0; k < r->p->pairs; k++) {
        if (elsewhere) { /* searches overwrite the end of the step */
            step(r, c->y, c->dy, h, c->next, c->rate);
            elsewhere = 0;
        }
        for (int g = 0; g < GUARDS; g++)
            value[g] = guard(r, k, g, c->next, c->rate);
        int dips = 0;
        if (looks_inside)
            dips = dipping(r, c, k, early, late, value);
        for (int g = 0; g < GUARDS; g++) {
            double end = 1.0;
            double last = value[g];
            if (!(last < -SLACK) && (dips >> g & 1)) {
                end = lowest(r, c, k, g, h, &last);
                elsewhere = 1;
            }
            if (!(last < -SLACK))
                continue;
            double at = crossing(r, c, k, g, h, end, last);
            if (!found || at < *fraction) {
                *fraction = at;
                *pair = k;
                *kind = g;
            }
            found = 1;
            elsewhere = 1;
        }
    }
    if (elsewhere && !found)
        step(r, c->y, c->dy, h, c->next, c->rate);
    return found;
}

/* Notes what happened to a body at time t, as long as there is room. */
static void note(course *c, double t, int what, double body)
{
    double row[3] = {t, (double)what, body};
    if (c->events == c->most)
        return;
    memcpy(c->event + 3 * c->events, row, sizeof row);
    c->events++;
}

/* The end of a step becomes the state. */
static void accept(const runner *r, course *c)
{
    const refdem_particles *p = r->p;
    double *swap = c->y;
    c->y = c->next;
    c->next = swap;
    swap = c->dy;
    c->dy = c->rate;
    c->rate = swap;
    if (!(p->friction > 0.0) || p->tangential_stiffness != 0.0)
        return;
    /* Without a spring the history is the direction of the slip. */
    for (int64_t k = 0; k < p->pairs; k++) {
        if (r->mode[k] < SLIP)
            continue;
        meeting m = meet(p, k, c->y);
        double fast = size(m.slip);
        if (!(fast > least_slip(p, &m))) /* rounding has no direction */
            continue;
        for (int i = 0; i < 3; i++)
            c->y[history_at(p) + 3 * k + i] = m.slip[i] / fast;
    }
}

/* What is left of a slip that has ended along its direction is taken away by one impulse: sticking
 * would keep it for ever. */
static void stop(const refdem_particles *p, int64_t k, double *restrict y)
{
    meeting m = meet(p, k, y);
    double impulse[3];
    double ease = yields(p, &m);
    for (int c = 0; c < 3; c++)
        impulse[c] = -m.slip[c] / ease;
    twist(p, &m, impulse, y);
    y[work_at(p)] += 0.5 * dot(m.slip, m.slip) / ease;
}

/* The mode that pair k changes to, at time t. */
static void change(runner *r, course *c, int64_t k, int kind, double t)
{
    int64_t before = r->mode[k];
    int64_t now = next_mode(r, k, kind, c->y, c->dy);
    r->mode[k] = now;
    if (before >= SLIP && now == STICK && r->p->tangential_stiffness == 0.0)
        stop(r->p, k, c->y);
    meeting m = meet(r->p, k, c->y);
    /* What the spring still holds when the force ends is lost, until it presses again. */
    double *work = c->y + work_at(r->p);
    if (now == PARTED)
        *work += 0.5 * r->p->stiffness * m.overlap * m.overlap;
    else if (before == PARTED)
        *work += -0.5 * r->p->stiffness * m.overlap * m.overlap;
    int has_pressed = before >= FREE;
    int presses = now >= FREE;
    double body = (double)r->p->pair[2 * k];
    if (presses && !has_pressed)
        note(c, t, BEGINS, body);
    if (has_pressed && !presses)
        note(c, t, ENDS, body);
    rates(r->p, r->mode, c->y, c->dy);
}

static int finite(const runner *r, const double *restrict y)
{
    double none = 0.0;
    for (int64_t i = 0; i < r->size; i++)
        none += 0.0 * y[i];
    return none == 0.0;
}

/* Steps to the end of a piece, which is halved until the step settles, or until halving no longer
 * helps: `rough` from then on. Returns the piece. */
static double measured(const runner *r, course *c, double piece, double h, int *rough)
{
    for (;;) {
        int settled = step(r, c->y, c->dy, piece, c->next, c->rate);
        if (settled || *rough)
            return piece;
        int is_shortest = fabs(piece) <= SHORTEST * fabs(h);
        if (is_shortest || !finite(r, c->y))
            *rough = 1; /* once more as it is: that step is kept */
        else
            piece *= 0.5;
    }
}

/* One step of size h from time t, cut at events, and halved where extrapolation needs that. What
 * the shortest piece does not settle, no other will: the rest of the step is then taken as it
 * comes, for the checks to judge, and not in a million pieces. */
static void advance(runner *r, course *c, double t, double h)
{
    double left = h;
    double piece = h;
    double fraction = 0.0;
    int64_t pair = 0;
    int kind = 0;
    int rough = 0;
    for (int events = 0; left != 0.0; piece = left) {
        piece = measured(r, c, piece, h, &rough);
        int looks = r->p->pairs > 0 && events < MOST_EVENTS;
        if (!looks || !leaving(r, c, piece, &fraction, &pair, &kind)) {
            accept(r, c);
            left -= piece;
            if (r->mode[pair] == FADE) {
                r->mode[pair] = SLIP;
                rates(r->p, r->mode, c->y, c->dy);
            }
            continue;
        }
        if (kind == HOLD && r->mode[pair] == SLIP && r->p->tangential_stiffness == 0.0
            && r->method != EXTRAPOLATION) {
            r->mode[pair] = FADE; /* the same piece again */
            continue;
        }
        if (fraction > 0.0) {
            step(r, c->y, c->dy, fraction * piece, c->next, c->rate);
            accept(r, c);
            left -= fraction * piece;
        }
        events++;
        change(r, c, pair, kind, t + (h - left));
    }
}

/* Pairs that press, largest overlap, largest normal force, and the work lost so far (less what
 * tangential springs hold). */
static void observe(const runner *r, const double *restrict y, double *restrict channel)
{
    const refdem_particles *p = r->p;
    memset(channel, 0, 4 * sizeof *channel);
    channel[3] = y[work_at(p)];
    for (int64_t k = 0; k < p->pairs; k++) {
        meeting m = meet(p, k, y);
        channel[1] = fmax(channel[1], m.overlap);
        if (r->mode[k] == PARTED)
            channel[3] -= 0.5 * p->stiffness * m.overlap * m.overlap;
        if (r->mode[k] < FREE)
            continue;
        channel[0] += 1.0;
        if (fabs(m.normal) > fabs(channel[2]))
            channel[2] = m.normal;
        if (p->tangential_stiffness == 0.0 || r->mode[k] < STICK)
            continue;
        if (p->hertz) /* its spring keeps no account: see Contact */
            continue;
        double bent = m.limit / p->tangential_stiffness;
        if (r->mode[k] == STICK)
            bent = size(y + history_at(p) + 3 * k);
        channel[3] -= 0.5 * p->tangential_stiffness * bent * bent;
    }
}

int64_t refdem_particles_size(const refdem_particles *p)
{
    return work_at(p) + 1;
}

int64_t refdem_particles_work(const refdem_particles *p)
{
    return (COLUMNS + 13) * refdem_particles_size(p);
}

int64_t refdem_particles_run(const refdem_particles *p, int method, double h, int64_t samples,
                             int64_t stride, int64_t most, int64_t *mode, double *work,
                             double *event, double *channel, double *out)
{
    assert(samples >= 1 && stride >= 1 && most >= 0);
    assert(mode && work && event && channel && out); /* `work` has refdem_particles_work doubles */
    assert(p->pairs == 0 || p->pair);
    int64_t size = refdem_particles_size(p);
    runner r = {.p = p, .method = method, .size = size, .mode = mode, .scratch = work + 6 * size};
    course c = {work, work + 2 * size, work + 3 * size, work + 5 * size, event, most, 0};
    memset(c.y, 0, 2 * (size_t)size * sizeof *out);
    memcpy(c.y, out, (size_t)size * sizeof *out);
    for (int64_t k = 0; k < p->pairs; k++)
        mode[k] = first_mode(p, k, h, c.y);
    rates(p, mode, c.y, c.dy);
    observe(&r, c.y, channel);
    for (int64_t row = 1; row < samples; row++) {
        for (int64_t j = 0; j < stride; j++) {
            if (method == EXTRAPOLATION)
                measure(&r, c.y, c.dy, h);
            advance(&r, &c, (double)((row - 1) * stride + j) * h, h);
        }
        memcpy(out + row * size, c.y, (size_t)size * sizeof *out);
        observe(&r, c.y, channel + 4 * row);
    }
    return c.events;
}
