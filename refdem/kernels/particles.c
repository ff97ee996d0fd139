/* Points and spheres, stepped from event to event: contacts begin, stick, slip and end inside a
 * step.
 *
 * A step at fixed modes is the map y(h) = step(y(0), h) of particle_steps.h; a pair stays in its
 * mode as long as its guards g(y) (contact_modes.h) are positive. Where a guard is below zero at
 * the end, the fraction x of the step with g(step(y, x h)) = 0 is found by the Illinois rule on
 * that map, the step is repeated up to it, the mode changes, and the rest of the step follows: a
 * method keeps its order through contacts, and a reversible one stays so.
 *
 * Phases: begin, step (measure and rates at fixed modes), locate, accept, change_mode, record.
 */
#include <assert.h>

#include "contact_modes.h"
#include "particle_gear.h"

/* Events in a step beyond which none is looked for; halvings in the search for a rise. */
enum { MOST_EVENTS = 64, HALVES = 16 };
enum { BEGINS = 1, ENDS = 2 }; /* kinds of events that are reported */

typedef struct {
    double *y, *dy, *next, *rate; /* state and rates at the start and at the end of the step */
    double *event;                /* (most, 3): time [s], BEGINS or ENDS, body */
    int64_t most, events;         /* room for events, and those kept */
} course;

static const double SLACK = 1e-15;     /* a guard of at most this size counts as zero */
static const double SHORTEST = 1e-6;   /* part of a step: shorter pieces are not tried */
static const double EDGE = 1.0 / 16.0; /* part of a step: distance from its ends of the two states
                                          at which the slopes of guards are tested */
static const double NARROW = 1e-4;     /* part of a step: width at which the search for a minimum
                                          of a guard ends */

/* The guard of that kind of pair k at a fraction of the step h, by a step that ends there;
 * overwrites c->next and c->rate. */
static double guard_at(const runner *r, course *c, int64_t k, int kind, double h, double fraction)
{
    step(r, c->y, c->dy, fraction * h, c->next, c->rate);
    return guard(r, k, kind, c->next, c->rate);
}

/* A guard that begins at zero and fails at the fraction `high` has no sign change to bracket yet.
 * Returns the last fraction high/2, high/4, .. at which it is positive, and its value there, as
 * after a slip that ends and begins anew; 0 if it falls at once. */
static double risen_before(const runner *r, course *c, int64_t k, int kind, double h, double high,
                           double *restrict value)
{
    double risen_at = 0.0;
    for (int i = 1; i <= HALVES; i++) {
        double fraction = ldexp(high, -i);
        double guard_there = guard_at(r, c, k, kind, h, fraction);
        if (risen_at > 0.0 && guard_there < -SLACK)
            return 0.0;
        if (risen_at == 0.0 && guard_there > SLACK) {
            risen_at = fraction;
            *value = guard_there;
        }
    }
    return risen_at;
}

/* Fraction x of the step h at which a guard that has the value `last` < 0 at the fraction `high`
 * becomes zero. Illinois rule (Dowell and Jarratt 1971): x = (low g_high - high g_low)/(g_high -
 * g_low), where the value of an end that stays twice running counts half. */
static double zero_of_guard(const runner *r, course *c, int64_t k, int kind, double h, double high,
                            double last)
{
    double low = 0.0;
    double at_low = guard(r, k, kind, c->y, c->dy);
    double at_high = last;
    double fraction = high;
    int side = 0;
    /* A contact that is about to part and has no overlap beyond rounding parts now: else it would
     * alternate between modes without end at the last bit. */
    if (kind == GAP && at_low <= SLACK && measure(r->p, k, c->y).rate * h < 0.0)
        return 0.0;
    /* A guard that begins at zero must have risen before it can fall. */
    if (at_low <= SLACK) {
        low = risen_before(r, c, k, kind, h, high, &at_low);
        if (low == 0.0)
            return 0.0;
    }
    if (at_low <= 0.0) /* below zero already: the event is now */
        return 0.0;
    for (int tries = 0; tries < 80 && high - low > 2e-16 * high; tries++) {
        fraction = (low * at_high - high * at_low) / (at_high - at_low);
        fraction = fmin(fmax(fraction, low + 1e-16 * high), high);
        if (tries > 40) /* bisection, where the rule converges slowly */
            fraction = 0.5 * (low + high);
        double value = guard_at(r, c, k, kind, h, fraction);
        if (value == 0.0 || fraction == high || fraction == low)
            break;
        if (value > 0.0) {
            low = fraction;
            at_low = value;
            if (side == 1) /* twice on this side: the other end counts half */
                at_high *= 0.5;
            side = 1;
        } else {
            high = fraction;
            at_high = value;
            if (side == -1) /* likewise */
                at_low *= 0.5;
            side = -1;
        }
    }
    return fraction;
}

/* The state y at a fraction x of the step h, and its rates, by Hermite's cubic through the ends:
 * (1-x)^2 (1+2x) y0 + (1-x)^2 x h y0' + x^2 (3-2x) y1 - x^2 (1-x) h y1'. */
static void interpolate(const runner *r, const course *c, double h, double x, double *restrict y,
                        double *restrict dy)
{
    double rest = 1.0 - x;
    double weight_y0 = rest * rest * (1.0 + 2.0 * x);
    double weight_y1 = x * x * (3.0 - 2.0 * x);
    double weight_dy0 = rest * rest * x * h;
    double weight_dy1 = -x * x * rest * h;
    for (int64_t i = 0; i < r->size; i++)
        y[i] = weight_y0 * c->y[i] + weight_dy0 * c->dy[i] + weight_y1 * c->next[i]
               + weight_dy1 * c->rate[i];
    rates(r->p, r->mode, y, dy);
}

/* The guards of pair k, as bits by kind, that decrease at the start of the step and increase
 * towards its end: such a guard may be below zero in between. `early` and `late` are the states at
 * EDGE and 1 - EDGE, followed by their rates; `last` has the guards at the end. */
static int dipping(const runner *r, const course *c, int64_t k, const double *early,
                   const double *late, const double *last)
{
    int dips = 0;
    for (int g = 0; g < GUARDS; g++) {
        double guard_begin = guard(r, k, g, c->y, c->dy);
        if (!(guard(r, k, g, early, early + r->size) < guard_begin)) /* it does not fall */
            continue;
        if (guard(r, k, g, late, late + r->size) < last[g])
            dips |= 1 << g;
    }
    return dips;
}

/* Fraction of the step h at which such a guard has its minimum, by golden-section search, or the
 * first fraction of the search at which it is below zero; its value there in `value`. */
static double lowest_of_guard(const runner *r, course *c, int64_t k, int kind, double h,
                              double *restrict value)
{
    /* golden = (sqrt(5) - 1)/2: the inner points are a = high - golden (high - low) and b = low +
     * golden (high - low), and one of them is an inner point of the next interval too. */
    const double golden = 0.6180339887498949;
    double low = 0.0;
    double high = 1.0;
    double a = 1.0 - golden;
    double b = golden;
    double at_a = guard_at(r, c, k, kind, h, a);
    double at_b = INFINITY; /* not evaluated if the guard is below zero at a */
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

/* The first guard that becomes negative within the step, as (fraction, pair, kind). Returns 0 if
 * there is none, and then c->next is the end of the step. With extrapolation, which claims errors
 * of round-off, guards that are negative only inside the step are found too. */
static int locate(const runner *r, course *c, double h, double *fraction, int64_t *pair, int *kind)
{
    int found = 0;
    int end_is_lost = 0;
    int looks_inside = r->method == EXTRAPOLATION;
    double value[GUARDS];
    double *early = r->scratch + (COLUMNS + 3) * r->size;
    double *late = early + 2 * r->size;
    if (looks_inside) {
        interpolate(r, c, h, EDGE, early, early + r->size);
        interpolate(r, c, h, 1.0 - EDGE, late, late + r->size);
    }
    for (int64_t k = 0; k < r->p->pairs; k++) {
        if (end_is_lost) { /* searches have overwritten the end of the step: repeat it */
            step(r, c->y, c->dy, h, c->next, c->rate);
            end_is_lost = 0;
        }
        for (int g = 0; g < GUARDS; g++)
            value[g] = guard(r, k, g, c->next, c->rate);
        int dips = 0;
        if (looks_inside)
            dips = dipping(r, c, k, early, late, value);
        for (int g = 0; g < GUARDS; g++) {
            /* The guard fails at x = 1, or at its minimum inside the step; then x solves g(step(y,
             * x h)) = 0, and the least x of all pairs and guards is kept. */
            double end = 1.0;
            double last = value[g];
            if (!(last < -SLACK) && (dips >> g & 1)) {
                end = lowest_of_guard(r, c, k, g, h, &last);
                end_is_lost = 1;
            }
            if (!(last < -SLACK))
                continue;
            double zero = zero_of_guard(r, c, k, g, h, end, last);
            if (!found || zero < *fraction) {
                *fraction = zero;
                *pair = k;
                *kind = g;
            }
            found = 1;
            end_is_lost = 1;
        }
    }
    if (end_is_lost && !found)
        step(r, c->y, c->dy, h, c->next, c->rate);
    return found;
}

/* Keeps an event of a body at time t [s], as long as there is room. */
static void keep_event(course *c, double t, int kind, double body)
{
    double row[3] = {t, (double)kind, body};
    if (c->events == c->most)
        return;
    memcpy(c->event + 3 * c->events, row, sizeof row);
    c->events++;
}

/* The end of the step becomes the state. */
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
        contact m = measure(p, k, c->y);
        double slip_speed = size(m.slip);
        if (!(slip_speed > slip_floor(p, &m))) /* a slip of rounding errors has no direction */
            continue;
        for (int i = 0; i < 3; i++)
            c->y[history_at(p) + 3 * k + i] = m.slip[i] / slip_speed;
    }
}

/* Removes the residual slip u of a slip that has ended along its direction, by the impulse
 *
 *   P = -u/(1/m_i + l_i L_i/J_i + 1/m_j + l_j L_j/J_j),
 *
 * since sticking would preserve it. The energy lost is -P.(U_before + U_after)/2. */
static void end_slip(const refdem_particles *p, int64_t k, double *restrict y)
{
    contact m = measure(p, k, y);
    double impulse[3];
    double mobility = tangential_mobility(p, &m);
    for (int c = 0; c < 3; c++)
        impulse[c] = -m.slip[c] / mobility;
    apply_tangential(p, &m, impulse, y);
    contact after = measure(p, k, y);
    y[work_at(p)] -= 0.5 * (dot(impulse, m.glide) + dot(impulse, after.glide));
}

/* Pair k leaves its mode through the guard of that kind at time t [s]: the new mode, its spring,
 * the work that is lost by it, and the rates in it. */
static void change_mode(runner *r, course *c, int64_t k, int kind, double t)
{
    int64_t before = r->mode[k];
    int64_t after = next_mode(r, k, kind, c->y, c->dy);
    r->mode[k] = after;
    if (before >= SLIP && after == STICK && r->p->tangential_stiffness == 0.0)
        end_slip(r->p, k, c->y);
    contact m = measure(r->p, k, c->y);
    /* The energy k d^2/2 of the normal spring counts as lost from the end of the force on, until
     * the pair presses again. */
    double *work = c->y + work_at(r->p);
    if (after == PARTED)
        *work += 0.5 * r->p->stiffness * m.overlap * m.overlap;
    else if (before == PARTED)
        *work += -0.5 * r->p->stiffness * m.overlap * m.overlap;
    int has_pressed = before >= FREE;
    int presses = after >= FREE;
    double body = (double)r->p->pair[2 * k];
    if (presses && !has_pressed)
        keep_event(c, t, BEGINS, body);
    if (has_pressed && !presses)
        keep_event(c, t, ENDS, body);
    rates(r->p, r->mode, c->y, c->dy);
}

/* True if no component of y is infinite or NaN: 0 times either is NaN. */
static int is_finite(const runner *r, const double *restrict y)
{
    double sum = 0.0;
    for (int64_t i = 0; i < r->size; i++)
        sum += 0.0 * y[i];
    return sum == 0.0;
}

/* Steps by `piece`, which is halved until the step converges, or until halving no longer helps:
 * `rough` from then on. Returns the piece; its end is c->next. */
static double converged_step(const runner *r, course *c, double piece, double h, int *rough)
{
    for (;;) {
        int converged = step(r, c->y, c->dy, piece, c->next, c->rate);
        if (converged || *rough)
            return piece;
        int is_shortest = fabs(piece) <= SHORTEST * fabs(h);
        if (is_shortest || !is_finite(r, c->y))
            *rough = 1; /* the same step again, which is then accepted */
        else
            piece *= 0.5;
    }
}

/* One step of size h from time t, cut at events, and halved where extrapolation does not converge.
 * If the shortest piece does not converge either, the rest of the step is taken without further
 * halving, and the checks judge the result. */
static void advance(runner *r, course *c, double t, double h)
{
    double left = h;
    double piece = h;
    double fraction = 0.0;
    int64_t pair = 0;
    int kind = 0;
    int rough = 0;
    for (int events = 0; left != 0.0; piece = left) {
        piece = converged_step(r, c, piece, h, &rough);
        int may_leave = r->p->pairs > 0 && events < MOST_EVENTS;
        if (!may_leave || !locate(r, c, piece, &fraction, &pair, &kind)) {
            accept(r, c);
            left -= piece;
            if (r->mode[pair] == FADE) { /* the slip has not ended in this piece */
                r->mode[pair] = SLIP;
                rates(r->p, r->mode, c->y, c->dy);
            }
            continue;
        }
        /* A slip without a spring that may end here: the same piece again with the direction of its
         * friction held (particles.h, FADE), so that its end is located on smooth rates. */
        if (kind == HOLD && r->mode[pair] == SLIP && r->p->tangential_stiffness == 0.0
            && r->method != EXTRAPOLATION) {
            r->mode[pair] = FADE;
            continue;
        }
        if (fraction > 0.0) { /* the piece up to the event */
            step(r, c->y, c->dy, fraction * piece, c->next, c->rate);
            accept(r, c);
            left -= fraction * piece;
        }
        events++;
        change_mode(r, c, pair, kind, t + (h - left));
    }
}

/* Channels (4) of a sample: pairs that press, largest overlap [m], largest normal force [N], and
 * the work lost so far [J], less the energy k_t s^2/2 that tangential springs hold. */
static void record(const runner *r, const double *restrict y, double *restrict channel)
{
    const refdem_particles *p = r->p;
    memset(channel, 0, 4 * sizeof *channel);
    channel[3] = y[work_at(p)];
    for (int64_t k = 0; k < p->pairs; k++) {
        contact m = measure(p, k, y);
        channel[1] = fmax(channel[1], m.overlap);
        if (r->mode[k] == PARTED)
            channel[3] -= 0.5 * p->stiffness * m.overlap * m.overlap;
        if (r->mode[k] < FREE) /* it does not press */
            continue;
        channel[0] += 1.0;
        if (fabs(m.force) > fabs(channel[2]))
            channel[2] = m.force;
        if (p->tangential_stiffness == 0.0 || r->mode[k] < STICK) /* it has no spring */
            continue;
        if (p->hertz) /* the energy of its spring is not tracked: see Contact */
            continue;
        /* |s| = mu F/k_t where it slips; where it sticks, s is the state of the spring. */
        double stretch = m.limit / p->tangential_stiffness;
        if (r->mode[k] == STICK)
            stretch = size(y + history_at(p) + 3 * k);
        channel[3] -= 0.5 * p->tangential_stiffness * stretch * stretch;
    }
}

/* See kernels.h. */
int64_t refdem_particles_size(const refdem_particles *p)
{
    assert(p);
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
    record(&r, c.y, channel);
    for (int64_t row = 1; row < samples; row++) {
        for (int64_t j = 0; j < stride; j++) {
            if (method == EXTRAPOLATION)
                update_scales(&r, c.y, c.dy, h);
            advance(&r, &c, (double)((row - 1) * stride + j) * h, h);
        }
        memcpy(out + row * size, c.y, (size_t)size * sizeof *out);
        record(&r, c.y, channel + 4 * row);
    }
    return c.events;
}

int64_t refdem_particles_gear_work(const refdem_particles *p)
{
    int64_t coordinates = 3 * p->bodies;
    int64_t nodes = NODES * coordinates;
    return (COLUMNS + 9) * refdem_particles_size(p) + nodes + gear_work(coordinates);
}

int refdem_particles_gear(const refdem_particles *p, int values, const double *corrector, double h,
                          int64_t samples, int64_t stride, double *work, double *out)
{
    assert(p && p->pairs == 0 && !p->turning);
    assert(values >= 3 && values <= MOST_VALUES && corrector && samples >= 1 && stride >= 0);
    assert(work && out); /* `work` has refdem_particles_gear_work doubles */
    int64_t size = refdem_particles_size(p);
    int64_t coordinates = 3 * p->bodies;
    double *states = work;
    double *scratch = states + 6 * size;
    double *acceleration = scratch + (COLUMNS + 3) * size;
    gear g = gear_in(acceleration + NODES * coordinates, values, coordinates, corrector);
    runner r = {.p = p, .method = EXTRAPOLATION, .size = size, .scratch = scratch};
    accelerations_at_nodes(&r, out, h, states, acceleration);
    fill_rows(&g, out, h, acceleration);
    asked system = {.r = &r, .state = states, .rate = states + size};
    for (int64_t k = 1; k < samples; k++) {
        for (int64_t n = 0; n < stride; n++)
            gear_step(&g, h, particle_acceleration, &system);
        double *row = out + k * size;
        memset(row, 0, (size_t)size * sizeof *row);
        for (int64_t i = 0; i < coordinates; i++) {
            /* Nordsieck's rows: r_0 = x, r_1 = h v. */
            row[i] = g.row[i];
            row[coordinates + i] = g.row[coordinates + i] / h;
        }
    }
    return 0;
}
