/* Velocity Verlet, Runge-Kutta and extrapolation for points and spheres; contacts begin, stick, slip and end inside a step.
 *
 * A step that leaves the mode of a pair is repeated up to the moment at which it does (Illinois rule on the method's own map),
 * the mode changes, and the rest of the step follows: a method keeps its order through contacts, and a reversible one stays so.
 */
#include "particles.h"

enum { VERLET, RUNGE_KUTTA, EXTRAPOLATION };
enum { COLUMNS = 10, MOST_EVENTS = 64, GUARDS = 3 };
enum { GAP, PULL, HOLD };

typedef struct {
    const refdem_particles *p;
    int method;
    int64_t size;
    int64_t *mode;
    double *scratch;
    double length, speed, turning, way; /* what an error is compared with */
} runner;

/* Number c of a state grows by `by`; what rounding loses is kept beside the state (Kahan 1965; Knuth's sum, TAOCP 4.2.2). */
static inline void gain(const runner *r, const double *restrict from, int64_t c, double by, double *restrict to)
{
    double part = from[r->size + c] + by, sum = from[c] + part, taken = sum - from[c];
    to[r->size + c] = (from[c] - (sum - taken)) + (part - taken);
    to[c] = sum;
}

/* --- velocity Verlet (Swope et al. 1982): kick, drift, kick ---------------------------------------------------------- */

/* Turns the unit vector s towards the slip: tan(angle/2) falls as exp(-|slip| t k_t/limit), exactly for constant slip. */
static void lean(const meeting *m, double stiffness, double h, double *restrict s)
{
    double fast = size(m->slip);
    if (fast == 0.0)
        return;
    double along = dot(s, m->slip) / fast, decay = m->limit > 0.0 ? exp(-fast * stiffness * h / m->limit) : 0.0;
    double tangent = decay * sqrt(fmax(0.0, 1.0 - along) / fmax(1e-300, 1.0 + along));
    double cosine = (1.0 - tangent * tangent) / (1.0 + tangent * tangent), sine = 2.0 * tangent / (1.0 + tangent * tangent);
    double across[3];
    for (int c = 0; c < 3; c++)
        across[c] = s[c] - along * m->slip[c] / fast;
    double rest = size(across);
    if (rest < 1e-14)
        return;
    for (int c = 0; c < 3; c++)
        s[c] = cosine * m->slip[c] / fast + sine * across[c] / rest;
}

/* Half a step of every tangential spring; keeps the normals it saw, or turns the springs from those to the new ones. */
static void stretch(const runner *r, double *restrict y, double h, double *restrict normal, int carried)
{
    const refdem_particles *p = r->p;
    for (int64_t k = 0; k < p->pairs; k++) {
        double *s = y + history_at(p) + 3 * k, *old = normal + 3 * k;
        if (r->mode[k] < STICK)
            continue;
        meeting m = meet(p, k, y);
        if (carried) {
            double both[3] = {old[0] + m.n[0], old[1] + m.n[1], old[2] + m.n[2]};
            add(s, -dot(m.n, s) / (1.0 + dot(old, m.n)), both);
        }
        if (r->mode[k] == STICK && p->tangential_stiffness > 0.0)
            add(s, h, m.slip);
        if (r->mode[k] == SLIP && p->tangential_stiffness > 0.0)
            lean(&m, p->tangential_stiffness, h, s);
        memcpy(old, m.n, sizeof m.n);
    }
}

/* q turned by the rotation vector w h, exactly. */
static void spin(int64_t n, const double *restrict w, double h, double *restrict q)
{
    for (int64_t i = 0; i < n; i++, w += 3, q += 4) {
        double angle = 0.5 * h * size(w), part = angle != 0.0 ? 0.5 * h * sin(angle) / angle : 0.5 * h, c = cos(angle);
        double v[3] = {part * w[0], part * w[1], part * w[2]}, old[4] = {q[0], q[1], q[2], q[3]}, across[3];
        cross(v, old + 1, across);
        q[0] = c * old[0] - dot(v, old + 1);
        for (int k = 0; k < 3; k++)
            q[1 + k] = c * old[1 + k] + old[0] * v[k] + across[k];
    }
}

/* Velocities and turning rates. */
static void kick(const runner *r, const double *restrict from, const double *restrict dy, double h, double *restrict to)
{
    int64_t n = r->p->bodies;
    for (int64_t c = 3 * n; c < (r->p->turning ? 9 * n : 6 * n); c++)
        gain(r, from, c, h * dy[c], to);
}

/* Forces that depend on velocities get a predicted velocity and one correction, which keeps the second order. */
static int verlet(const runner *r, const double *restrict y, const double *restrict dy, double h, double *restrict out,
                   double *restrict rate)
{
    const refdem_particles *p = r->p;
    double *half = r->scratch, *normal = half + 2 * r->size;
    int rubs = p->friction > 0.0, lags = p->damping > 0.0 || rubs;
    memcpy(out, y, 2 * (size_t)r->size * sizeof *y);
    kick(r, y, dy, 0.5 * h, out);
    if (rubs)
        stretch(r, out, 0.5 * h, normal, 0);
    for (int64_t c = 0; c < 3 * p->bodies; c++)
        gain(r, y, c, h * out[3 * p->bodies + c], out);
    if (p->turning)
        spin(p->bodies, out + spin_at(p), h, out + 9 * p->bodies);
    if (rubs)
        stretch(r, out, 0.5 * h, normal, 1);
    memcpy(half, out, 2 * (size_t)r->size * sizeof *y);
    if (lags) {
        kick(r, half, dy, 0.5 * h, out);
        rates(p, r->mode, out, rate);
        kick(r, half, rate, 0.5 * h, out);
    }
    rates(p, r->mode, out, rate);
    kick(r, half, rate, 0.5 * h, out);
    out[work_at(p)] += 0.5 * h * (dy[work_at(p)] + rate[work_at(p)]);
    return 1;
}

/* --- Runge-Kutta and extrapolation ----------------------------------------------------------------------------------- */

/* Attitudes to unit length; springs into the tangent plane, their directions to unit length. */
static void settle(const runner *r, double *restrict y)
{
    const refdem_particles *p = r->p;
    for (int64_t i = 0; p->turning && i < p->bodies; i++) {
        double *q = y + 9 * p->bodies + 4 * i, norm = sqrt(q[0] * q[0] + dot(q + 1, q + 1));
        for (int c = 0; c < 4; c++)
            q[c] /= norm;
    }
    for (int64_t k = 0; p->friction > 0.0 && k < p->pairs; k++) {
        double *s = y + history_at(p) + 3 * k;
        if (r->mode[k] < STICK)
            continue;
        meeting m = meet(p, k, y);
        add(s, -dot(s, m.n), m.n);
        double length = size(s);
        for (int c = 0; r->mode[k] == SLIP && length > 0.0 && c < 3; c++)
            s[c] /= length;
    }
}

/* Kutta 1901. */
static int runge_kutta(const runner *r, const double *restrict y, const double *restrict dy, double h, double *restrict out,
                        double *restrict rate)
{
    double *b = r->scratch, *c = b + r->size, *d = c + r->size, *at = d + r->size;
    for (int64_t i = 0; i < r->size; i++)
        at[i] = y[i] + 0.5 * h * dy[i];
    rates(r->p, r->mode, at, b);
    for (int64_t i = 0; i < r->size; i++)
        at[i] = y[i] + 0.5 * h * b[i];
    rates(r->p, r->mode, at, c);
    for (int64_t i = 0; i < r->size; i++)
        at[i] = y[i] + h * c[i];
    rates(r->p, r->mode, at, d);
    for (int64_t i = 0; i < r->size; i++)
        gain(r, y, i, h / 6.0 * ((dy[i] + d[i]) + 2.0 * (b[i] + c[i])), out);
    settle(r, out);
    rates(r->p, r->mode, out, rate);
    return 1;
}

/* The change over h by n steps of the modified midpoint rule (Gragg 1965), n even, as an increment. */
static void midpoint(const runner *r, const double *restrict y, const double *restrict dy, double h, int n,
                     double *restrict change, double *restrict work)
{
    double *at = work, *rate = at + r->size, *before = rate + r->size, step = h / n;
    for (int64_t i = 0; i < r->size; i++)
        before[i] = 0.0, change[i] = step * dy[i];
    for (int k = 1; k <= n; k++) {
        for (int64_t i = 0; i < r->size; i++)
            at[i] = y[i] + change[i];
        rates(r->p, r->mode, at, rate);
        for (int64_t i = 0; i < r->size; i++) {
            double next = k < n ? before[i] + 2.0 * step * rate[i] : 0.5 * (before[i] + change[i] + step * rate[i]);
            before[i] = change[i], change[i] = next;
        }
    }
}

/* Largest difference of two rows in units of each block's scale; the direction of a slipping spring counts as its force does. */
static double gap(const runner *r, const double *restrict end, const double *restrict a, const double *restrict b)
{
    const refdem_particles *p = r->p;
    int64_t n = p->bodies;
    double worst = 0.0;
    for (int64_t i = 0; i < history_at(p); i++) {
        double scale = i < 3 * n ? r->length : i < 6 * n ? r->speed : i < 9 * n ? r->turning : 1.0;
        worst = fmax(worst, fabs(a[i] - b[i]) / scale);
    }
    for (int64_t k = 0; p->friction > 0.0 && p->tangential_stiffness > 0.0 && k < p->pairs; k++) {
        if (r->mode[k] < STICK)
            continue;
        meeting m = meet(p, k, end);
        double strain = m.normal / (p->stiffness * p->radius[m.i]), unit = r->mode[k] == STICK ? r->way : 1e-3 / strain;
        for (int64_t i = history_at(p) + 3 * k; i < history_at(p) + 3 * k + 3; i++)
            worst = fmax(worst, fabs(a[i] - b[i]) / fmax(fabs(unit), r->mode[k] == STICK ? 0.0 : 1.0));
    }
    return worst;
}

/* Raises the scales to what the state shows: lengths, speeds, turning rates, and the way of a step. */
static void measure(runner *r, const double *restrict y, const double *restrict dy, double h)
{
    const refdem_particles *p = r->p;
    int64_t n = p->bodies;
    double radius = 0.0, least = INFINITY;
    for (int64_t i = 0; i < n; i++)
        if (p->radius[i] > 0.0)
            radius = fmax(radius, p->radius[i]), least = fmin(least, p->radius[i]);
    for (int64_t i = 0; i < 3 * n; i++) {
        r->length = fmax(r->length, fmax(fabs(y[i]), radius));
        r->speed = fmax(r->speed, fmax(fabs(y[3 * n + i]), fabs(h * dy[3 * n + i])));
    }
    r->turning = fmax(r->turning, r->speed / least);
    for (int64_t i = spin_at(p); p->turning && i < spin_at(p) + 3 * n; i++)
        r->turning = fmax(r->turning, fabs(y[i]));
    r->way = r->speed * fabs(h);
    r->length = fmax(r->length, r->way);
}

/* One step by Aitken-Neville extrapolation in (h/n)^2; 0 if ten columns do not settle it to round-off. */
static int extrapolated(const runner *r, const double *restrict y, const double *restrict dy, double h, double *restrict out)
{
    double *table = r->scratch, *work = table + COLUMNS * r->size;
    for (int j = 0; j < COLUMNS; j++) {
        int n = 2 * (j + 1);
        double *row = table + j * r->size;
        midpoint(r, y, dy, h, n, row, work);
        /* Row m holds T(m, j - m ...): each older entry is replaced by the next one of the new diagonal. */
        for (int m = j - 1; m >= 0; m--) {
            double ratio = (double)(j + 1) / (m + 1), factor = 1.0 / (ratio * ratio - 1.0);
            double *older = table + m * r->size;
            const double *newer = older + r->size;
            for (int64_t i = 0; i < r->size; i++)
                older[i] = newer[i] + (newer[i] - older[i]) * factor;
        }
        if (j < 3)
            continue;
        for (int64_t i = 0; i < r->size; i++)
            gain(r, y, i, table[i], out);
        if (gap(r, out, table, table + r->size) < 1e-15)
            return 1;
    }
    return 0;
}

/* Bulirsch and Stoer 1966; 0 if the step is too long. */
static int extrapolation(const runner *r, const double *restrict y, const double *restrict dy, double h, double *restrict out,
                         double *restrict rate)
{
    int held = extrapolated(r, y, dy, h, out);
    settle(r, out);
    rates(r->p, r->mode, out, rate);
    return held;
}

static int step(const runner *r, const double *restrict y, const double *restrict dy, double h, double *restrict out,
                double *restrict rate)
{
    return r->method == VERLET        ? verlet(r, y, dy, h, out, rate)
           : r->method == RUNGE_KUTTA ? runge_kutta(r, y, dy, h, out, rate)
                                      : extrapolation(r, y, dy, h, out, rate);
}

/* --- modes ----------------------------------------------------------------------------------------------------------- */

/* What must stay above zero for pair k to stay in its mode, in units of its own size; INFINITY if the mode does not ask. */
static double guard(const runner *r, int64_t k, int kind, const double *restrict y, const double *restrict dy)
{
    const refdem_particles *p = r->p;
    int64_t mode = r->mode[k];
    meeting m = meet(p, k, y);
    double radius = p->radius[m.i], strain = m.overlap / radius, force = m.normal / (p->stiffness * radius);
    if (mode == APART)
        return kind == GAP ? -strain : INFINITY;
    if (mode == PARTED)
        return kind == GAP ? strain : kind == PULL ? -force : INFINITY;
    if (kind == GAP)
        return p->no_pull && p->damping > 0.0 ? force : strain;
    if (p->friction == 0.0 || (kind == PULL && (p->no_pull || p->damping == 0.0)))
        return INFINITY;
    if (kind == PULL)
        return mode == FREE ? -force : mode == SLIP ? force : INFINITY;
    if (mode == FREE)
        return INFINITY;
    const double *s = y + history_at(p) + 3 * k, *a = dy + 3 * p->bodies;
    double stiffness = p->tangential_stiffness, growth = 0.0, along = dot(m.slip, s);
    if (mode == STICK) {
        double held = stiffness > 0.0 ? stiffness * size(s) : size(dy + history_at(p) + 3 * k);
        return (m.limit - held) / (p->friction * p->stiffness * radius);
    }
    if (stiffness > 0.0) {
        double bend = dot(m.w, m.turn);
        for (int c = 0; c < 3; c++)
            bend += (a[3 * m.i + c] - (m.j < 0 ? 0.0 : a[3 * m.j + c])) * m.n[c];
        growth = m.normal > 0.0 ? p->friction / stiffness * (p->stiffness * m.rate + p->damping * bend) : 0.0;
    }
    return (along - growth) / (1e11 * least_slip(p, &m));
}

/* The mode of a pair that begins to press, and its spring. */
static int64_t pressing(const refdem_particles *p, int64_t k, double *restrict y)
{
    if (p->friction == 0.0)
        return FREE;
    meeting m = meet(p, k, y);
    double *s = y + history_at(p) + 3 * k, fast = size(m.slip), stiffness = p->tangential_stiffness;
    double least = 1e-13 * p->stiffness * p->radius[m.i];
    int slides = fast > least_slip(p, &m);
    if (stiffness > 0.0)
        slides = fabs(m.normal) <= least && fast * stiffness > p->friction * p->stiffness * m.rate;
    for (int c = 0; c < 3; c++)
        s[c] = slides ? m.slip[c] / fast : 0.0;
    return m.normal < -least ? FREE : slides ? SLIP : STICK;
}

/* The mode of pair k after it has left its own through one of the guards. */
static int64_t next_mode(const runner *r, int64_t k, int kind, double *restrict y, const double *restrict dy)
{
    const refdem_particles *p = r->p;
    int64_t mode = r->mode[k];
    if (mode == APART || (mode == PARTED && kind == PULL))
        return pressing(p, k, y);
    if (mode == PARTED)
        return APART;
    if (kind == GAP)
        return p->no_pull && p->damping > 0.0 ? PARTED : APART;
    double *s = y + history_at(p) + 3 * k, stiffness = p->tangential_stiffness;
    if (kind == PULL)
        return mode == SLIP ? FREE : pressing(p, k, y);
    meeting m = meet(p, k, y);
    if (mode == SLIP) {
        for (int c = 0; c < 3; c++)
            s[c] = stiffness > 0.0 ? s[c] * (m.limit / stiffness) : 0.0;
        return STICK;
    }
    const double *pull = stiffness > 0.0 ? s : dy + history_at(p) + 3 * k;
    double length = size(pull), sense = stiffness > 0.0 ? 1.0 : -1.0;
    for (int c = 0; c < 3; c++)
        s[c] = length > 0.0 ? sense * pull[c] / length : 0.0;
    return SLIP;
}

/* The mode of pair k at the start: overlapping or touching and not about to part. */
static int64_t first_mode(const refdem_particles *p, int64_t k, double h, double *restrict y)
{
    meeting m = meet(p, k, y);
    double touch = 1e-15 * p->radius[m.i];
    if (m.overlap < -touch || (m.overlap <= touch && m.rate * h <= 0.0))
        return APART;
    return p->no_pull && p->damping > 0.0 && m.normal <= 0.0 ? PARTED : pressing(p, k, y);
}

/* --- a step with its events ------------------------------------------------------------------------------------------ */

typedef struct {
    double *y, *dy, *next, *rate; /* state and rates at the start and at the end of the step */
    double *event;                /* time, what, body */
    int64_t most, events;
} course;

static const double SLACK = 1e-15, SHORTEST = 1e-6;

/* Fraction of the step at which a guard that fails at its end becomes zero (Illinois rule; Dowell and Jarratt 1971). */
static double crossing(const runner *r, course *c, int64_t k, int kind, double h, double last)
{
    double low = 0.0, high = 1.0, at_low = guard(r, k, kind, c->y, c->dy), at_high = last, found = 1.0;
    int side = 0;
    if (at_low <= 0.0)
        return 0.0;
    for (int tries = 0; tries < 80 && high - low > 2e-16 * high; tries++) {
        found = (low * at_high - high * at_low) / (at_high - at_low);
        found = fmin(fmax(found, low + 1e-16 * high), high);
        if (tries > 40)
            found = 0.5 * (low + high);
        step(r, c->y, c->dy, found * h, c->next, c->rate);
        double value = guard(r, k, kind, c->next, c->rate);
        if (value == 0.0 || found == high || found == low)
            break;
        if (value > 0.0) {
            low = found, at_low = value, at_high *= side == 1 ? 0.5 : 1.0, side = 1;
        } else {
            high = found, at_high = value, at_low *= side == -1 ? 0.5 : 1.0, side = -1;
        }
    }
    return found;
}

/* The first guard that fails within the step, as (fraction, pair, kind); 0 if none does. */
static int leaving(const runner *r, course *c, double h, double *fraction, int64_t *pair, int *kind)
{
    int found = 0;
    double value[GUARDS];
    for (int64_t k = 0; k < r->p->pairs; k++) {
        int fails = 0;
        if (found) /* the search for an earlier failure has overwritten the end of the step */
            step(r, c->y, c->dy, h, c->next, c->rate);
        for (int g = 0; g < GUARDS; g++) {
            value[g] = guard(r, k, g, c->next, c->rate);
            fails |= value[g] < -SLACK;
        }
        for (int g = 0; fails && g < GUARDS; g++) {
            if (!(value[g] < -SLACK))
                continue;
            double at = crossing(r, c, k, g, h, value[g]);
            if (!found || at < *fraction)
                *fraction = at, *pair = k, *kind = g;
            found = 1;
        }
    }
    return found;
}

static void note(course *c, double t, double what, double body)
{
    double row[3] = {t, what, body};
    if (c->events < c->most)
        memcpy(c->event + 3 * c->events, row, sizeof row);
    c->events += c->events < c->most;
}

static void accept(const runner *r, course *c)
{
    const refdem_particles *p = r->p;
    double *swap = c->y;
    c->y = c->next, c->next = swap;
    swap = c->dy, c->dy = c->rate, c->rate = swap;
    for (int64_t k = 0; p->friction > 0.0 && p->tangential_stiffness == 0.0 && k < p->pairs; k++) {
        if (r->mode[k] != SLIP)
            continue;
        meeting m = meet(p, k, c->y);
        double fast = size(m.slip);
        for (int i = 0; fast > least_slip(p, &m) && i < 3; i++)
            c->y[history_at(p) + 3 * k + i] = m.slip[i] / fast;
    }
}

/* The mode that pair k changes to, at time t. */
static void change(runner *r, course *c, int64_t k, int kind, double t)
{
    int64_t before = r->mode[k], now = next_mode(r, k, kind, c->y, c->dy);
    r->mode[k] = now;
    meeting m = meet(r->p, k, c->y);
    if (before == PARTED || now == PARTED) /* what the spring still holds when the force ends is lost */
        c->y[work_at(r->p)] += (now == PARTED ? 0.5 : -0.5) * r->p->stiffness * m.overlap * m.overlap;
    if ((before >= FREE) != (now >= FREE))
        note(c, t, now >= FREE ? 1.0 : 2.0, (double)r->p->pair[2 * k]);
    rates(r->p, r->mode, c->y, c->dy);
}

/* One step of size h from time t, cut at events, and halved where extrapolation needs that. */
static void advance(runner *r, course *c, double t, double h)
{
    double left = h, piece = h, fraction = 0.0;
    int64_t pair = 0;
    int kind = 0;
    for (int events = 0; left != 0.0; piece = left) {
        while (!step(r, c->y, c->dy, piece, c->next, c->rate) && fabs(piece) > SHORTEST * fabs(h))
            piece *= 0.5;
        if (r->p->pairs == 0 || events == MOST_EVENTS || !leaving(r, c, piece, &fraction, &pair, &kind)) {
            accept(r, c);
            left -= piece;
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

/* --- a run ----------------------------------------------------------------------------------------------------------- */

/* Pairs that press, largest overlap, largest normal force, and the work lost so far (less what tangential springs hold). */
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
        channel[2] = fabs(m.normal) > fabs(channel[2]) ? m.normal : channel[2];
        if (p->tangential_stiffness == 0.0 || r->mode[k] < STICK)
            continue;
        const double *s = y + history_at(p) + 3 * k;
        double bent = r->mode[k] == STICK ? size(s) : m.limit / p->tangential_stiffness;
        channel[3] -= 0.5 * p->tangential_stiffness * bent * bent;
    }
}

int64_t refdem_particles_size(const refdem_particles *p)
{
    return work_at(p) + 1;
}

int64_t refdem_particles_work(const refdem_particles *p)
{
    return (COLUMNS + 12) * refdem_particles_size(p);
}

int64_t refdem_particles_run(const refdem_particles *p, int method, double h, int64_t samples, int64_t stride, int64_t most,
                             int64_t *mode, double *work, double *event, double *channel, double *out)
{
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
