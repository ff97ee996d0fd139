/* A gas of equal spheres under a linear contact law with friction, in a periodic box, between
 * planes or without boundaries.
 *
 * Velocity Verlet (Swope et al. 1982), of the contact law in gas_contact.h:
 *
 *   v += h/2 a,  x += h v,  contacts at x,  v += h/2 a,   spins alike, attitudes q = exp(w t/2) q.
 *
 * Forces that depend on velocities use those of the end of the step, predicted with the last
 * acceleration. Verlet's list (1967) of pairs closer than a diameter and a skin is rebuilt, from a
 * counting sort of the bodies into cells, before the two fastest bodies could have crossed the
 * skin. Bodies lie in memory in the order of their cells. A velocity is updated only while a
 * contact lasts, and an attitude only when its spin changes. Impulses are rounded to a grid on
 * which velocities lie, and applied to both bodies of a pair with opposite signs: sums are then
 * exact, and so is total momentum. Positions are kept in the box, and whole boxes are counted
 * separately, so that crossing a face of the box does not change a velocity.
 *
 * Threads own bodies that are neighbours in memory. Each finds the contacts of its own, and
 * gathers for its own, from all contacts in the order of the list: the result has the same bits
 * for any number of threads.
 *
 * Phases of a step: kick, drift, measure (contacts, and their impulses), gather (the impulses of
 * each body), kick; record at a sample.
 */
#include <assert.h>

#include "gas_contact.h"
#include "gas_list.h"

/* Largest speed on the grid of velocities, over that of the fastest body at the start: larger ones
 * are still correct, but are not on the grid, so that momentum is then conserved to round-off. */
#define GRID 8.0

int64_t refdem_gas_room(const refdem_gas *p, int64_t threads)
{
    assert(p && threads >= 1 && threads <= MOST_THREADS);
    gas g;
    return lay_out(&g, p, threads, NULL);
}

/* Finds the contacts among the share's listed pairs at `time` [s] since the start, with their
 * impulses. The contacts of this step and of the one before are kept in two lists, which are
 * exchanged in every step. */
static void measure(gas *g, share *t, int rank, double time)
{
    int64_t first_number = rank * g->p->most_contacts;
    const contact *before = g->contact[t->side];
    t->side ^= 1;
    contact *now = g->contact[t->side] + first_number;
    t->contacts = 0;
    t->crossing = 0;
    for (int64_t m = 0; m < t->pairs; m++) {
        double n[3];
        double d = overlap(g, t->a[m], t->b[m], t->image[m], n);
        int32_t number_before = t->was[m];
        if (!(d > 0.0)) {
            if (number_before)
                t->was[m] = 0;
            continue;
        }
        if (t->contacts == g->p->most_contacts) { /* the caller must provide more memory */
            t->failed = NO_ROOM;
            return;
        }
        contact *c = now + t->contacts;
        c->a = t->a[m];
        c->b = t->b[m];
        c->overlap = d;
        copy3(c->n, n);
        if (!number_before && t->events < g->most) { /* the contact begins in this step */
            t->event[2 * t->events] = time;
            t->event[2 * t->events + 1] = (double)g->now.label[c->a];
        }
        t->events += !number_before;
        if (g->p->friction > 0.0) {
            /* The tangential spring of the same contact in the step before. A number below 0 means
             * that this was the pair (b, a), whose vectors have the opposite sign. */
            const contact *contact_before = NULL;
            double sign = 1.0;
            if (number_before > 0)
                contact_before = before + number_before - 1;
            if (number_before < 0) {
                contact_before = before - number_before - 1;
                sign = -1.0;
            }
            move_spring(g, c, contact_before, sign, time != 0.0);
        }
        add_forces(g, c);
        /* Body b belongs to another thread, which reads its impulses from this list. */
        if (c->b >= 0 && (c->b < t->from || c->b >= t->to))
            t->out[t->crossing++] = (int32_t)t->contacts;
        t->contacts++;
        t->was[m] = (int32_t)(first_number + t->contacts);
    }
}

/* Adds sign times the contact's impulse, and its change of spin, to body i; the first of a step
 * clears what the body had, and marks it as one to be kicked. */
static inline void add_impulse(gas *g, share *t, int64_t i, double sign, const contact *c)
{
    double *impulse = g->now.kick + 3 * i;
    double *spin_change = g->now.turn + 3 * i;
    int has_friction = g->p->friction > 0.0;
    if (!g->now.mark[i]) {
        g->now.mark[i] = 1;
        t->marked[t->touched++] = (int32_t)i;
        memset(impulse, 0, 3 * sizeof *impulse);
        if (g->p->turning)
            memset(spin_change, 0, 3 * sizeof *spin_change);
    }
    for (int k = 0; k < 3; k++)
        impulse[k] += sign * c->impulse[k];
    if (!has_friction)
        return;
    for (int k = 0; k < 3; k++)
        spin_change[k] += c->spin_change[k];
}

/* Sums the impulses of the share's own bodies, over all contacts in the order of the list: the same
 * order, and so the same bits, for any number of threads. Adds the work lost in the step by the
 * share's own contacts, h power, to that of body a. */
static void gather(gas *g, share *t, int rank)
{
    for (int64_t k = 0; k < t->touched; k++) {
        int64_t i = t->marked[k];
        g->now.mark[i] = 0;
        memset(g->now.kick + 3 * i, 0, 3 * sizeof(double));
        if (g->p->turning)
            memset(g->now.turn + 3 * i, 0, 3 * sizeof(double));
    }
    t->touched = 0;
    for (int s = 0; s < g->threads; s++) {
        const share *other = g->share + s;
        const contact *found = g->contact[t->side] + s * g->p->most_contacts;
        for (int64_t k = 0; s == rank && k < t->contacts; k++) {
            const contact *c = found + k;
            add_impulse(g, t, c->a, 1.0, c);
            if (c->b >= t->from && c->b < t->to)
                add_impulse(g, t, c->b, -1.0, c);
            g->lost[g->now.label[c->a]] += g->h * c->power;
        }
        for (int64_t k = 0; s != rank && k < other->crossing; k++) {
            const contact *c = found + other->out[k];
            if (c->b >= t->from && c->b < t->to)
                add_impulse(g, t, c->b, -1.0, c);
        }
    }
}

/* out = exp(w time/2) q: the attitude q (4) turned by the rotation vector w time, exactly, with the
 * half angle a = |w| time/2 and exp(..) = (cos a, (sin a/a) w time/2); then one step of Newton's
 * for |q| = 1, q *= 3/2 - |q|^2/2. */
static void rotate(const double *w, double time, const double *q, double *out)
{
    /* (cos a, u)(q_0, q_v) = (cos a q_0 - u.q_v, cos a q_v + q_0 u + u x q_v), u = (sin a/a) w
     * time/2. */
    double angle = 0.5 * time * sqrt(dot(w, w));
    double factor = 0.5 * time; /* sin(angle)/angle tends to 1 */
    if (angle != 0.0)
        factor = 0.5 * time * sin(angle) / angle;
    double cosine = cos(angle);
    double vector[3] = {factor * w[0], factor * w[1], factor * w[2]};
    double crossed[3], after[4];
    cross(vector, q + 1, crossed);
    after[0] = cosine * q[0] - dot(vector, q + 1);
    for (int k = 0; k < 3; k++)
        after[1 + k] = cosine * q[1 + k] + q[0] * vector[k] + crossed[k];
    double unit = 1.0; /* what does not turn keeps its bits */
    if (angle != 0.0)
        unit = 1.5 - 0.5 * (after[0] * after[0] + dot(after + 1, after + 1));
    for (int k = 0; k < 4; k++)
        out[k] = after[k] * unit;
}

/* Half a step of velocities and spins of the share's bodies in contact, after `taken` steps. An
 * attitude is turned only here, up to the moment at which its spin changes. */
static void kick(gas *g, share *t, int64_t taken)
{
    /* v += h/2 f/m, w += h/2 torque/J, with the changes that `gather` has summed. */
    double most = t->fastest * t->fastest;
    for (int64_t m = 0; m < t->touched; m++) {
        int64_t i = t->marked[m];
        int64_t label = g->now.label[i];
        double *v = g->now.v + 3 * i;
        add_scaled(v, 1.0, g->now.kick + 3 * i);
        most = fmax(most, dot(v, v));
        if (!(g->p->friction > 0.0))
            continue;
        double *w = g->now.w + 3 * i;
        if (g->since[label] != taken)
            rotate(w, (double)(taken - g->since[label]) * g->h, g->attitude + 4 * label,
                   g->attitude + 4 * label);
        g->since[label] = (int32_t)taken;
        add_scaled(w, 1.0, g->now.turn + 3 * i);
    }
    t->fastest = sqrt(most);
}

/* x += h v of the share's bodies. */
static void drift(const gas *g, const share *t)
{
    double h = g->h;
    double *restrict x = g->now.x;
    const double *restrict v = g->now.v;
    for (int64_t i = 3 * t->from; i < 3 * t->to; i++)
        x[i] += h * v[i];
}

/* Writes the share's bodies at sample s, after `taken` steps. Rank 0 also writes the channels: the
 * number of contacts, and the work lost since the start. With the power P_k [W] after step k, whose
 * sum h (P_0 + .. + P_n) is in `lost`, and the energy E_n of the tangential springs,
 *
 *   W_n = h (P_0 + .. + P_n) - h/2 P_n - E_n,   channel = W_n - W_0,
 *
 * which is the trapezoidal rule. */
static void record(gas *g, share *t, int rank, int64_t s, int64_t taken)
{
    for (int64_t i = t->from; i < t->to; i++) {
        int64_t label = g->now.label[i];
        int64_t row = s * g->n + label;
        for (int c = 0; c < 3; c++)
            g->out_x[3 * row + c] = g->now.x[3 * i + c] + g->p->size * g->now.boxes[3 * i + c];
        copy3(g->out_v + 3 * row, g->now.v + 3 * i);
        if (!g->p->turning) /* no spins, no attitudes */
            continue;
        copy3(g->out_w + 3 * row, g->now.w + 3 * i);
        rotate(g->now.w + 3 * i, (double)(taken - g->since[label]) * g->h, g->attitude + 4 * label,
               g->out_q + 4 * row);
    }
    wait_for_all(&g->team);
    if (rank > 0) /* channels are written once, in the order of the bodies */
        return;
    double *channel = g->channel + 2 * s;
    double work = 0.0;
    channel[0] = 0.0;
    for (int64_t i = 0; i < g->n; i++)
        work += g->lost[i];
    for (int64_t k = 0; k < g->threads; k++) {
        const contact *c = g->contact[t->side] + k * g->p->most_contacts;
        const contact *end = c + g->share[k].contacts;
        channel[0] += (double)g->share[k].contacts;
        for (; c < end; c++)
            work -= 0.5 * g->h * c->power + spring_energy(g, c);
    }
    if (s == 0)
        g->first_work = work;
    channel[1] = work - g->first_work;
}

/* The failure of a share, the one with the largest number; 0 if none has failed. */
static int has_failed(const gas *g)
{
    int failed = 0;
    for (int64_t k = 0; k < g->threads; k++) {
        if (g->share[k].failed > failed)
            failed = g->share[k].failed;
    }
    return failed;
}

/* Largest speed of any body [m/s]. */
static double fastest(const gas *g)
{
    double most = 0.0;
    for (int64_t k = 0; k < g->threads; k++)
        most = fmax(most, g->share[k].fastest);
    return most;
}

/* Contacts after `taken` steps, and the impulses of the bodies. Returns 1 if a share has failed. */
static int measure_and_gather(gas *g, share *t, int rank, int64_t taken)
{
    measure(g, t, rank, (double)taken * g->h);
    wait_for_all(&g->team);
    if (has_failed(g))
        return 1;
    gather(g, t, rank);
    return 0;
}

/* One thread's part of the whole run, as member `rank` of the team. */
static void run_share(void *shared, int rank)
{
    gas *g = shared;
    share *t = g->share + rank;
    rebuild(g, t, rank);
    if (measure_and_gather(g, t, rank, 0))
        return;
    t->events = 0; /* contacts of the initial state are not events */
    record(g, t, rank, 0, 0);
    for (int64_t taken = 1, s = 1; s < g->samples; s++) {
        for (int64_t last = s * g->stride; taken <= last; taken++) {
            kick(g, t, taken - 1);
            drift(g, t);
            wait_for_all(&g->team);
            /* Two bodies can have approached by twice the distance that the fastest has moved. */
            t->way += fabs(g->h) * fastest(g);
            if (2.0 * t->way > g->skin)
                rebuild(g, t, rank);
            if (measure_and_gather(g, t, rank, taken))
                return;
            kick(g, t, taken);
        }
        record(g, t, rank, s, taken - 1);
    }
}

/* The start, row 0 of the outputs, into columns in the order given; skin, reach and grid. */
static void begin(gas *g, double step)
{
    const refdem_gas *p = g->p;
    int64_t n = g->n;
    double most_skin = SKIN * p->diameter;
    if (p->size > 0.0) /* reach below half a box: a body meets one image of another at a time */
        most_skin = 0.5 * p->size - p->diameter;
    double fastest = 0.0;
    size_t three = (size_t)(3 * n) * sizeof(double);
    memcpy(g->now.x, g->out_x, three);
    memcpy(g->now.v, g->out_v, three);
    memset(g->now.kick, 0, three);
    if (p->turning) {
        memcpy(g->now.w, g->out_w, three);
        memset(g->now.turn, 0, three);
        memcpy(g->attitude, g->out_q, (size_t)(4 * n) * sizeof(double));
    }
    memset(g->now.boxes, 0, (size_t)(3 * n) * sizeof(int32_t));
    memset(g->now.mark, 0, (size_t)n);
    memset(g->since, 0, (size_t)n * sizeof(int32_t));
    memset(g->lost, 0, (size_t)n * sizeof(double));
    for (int64_t i = 0; i < n; i++) {
        g->now.label[i] = (int32_t)i;
        fastest = fmax(fastest, dot(g->now.v + 3 * i, g->now.v + 3 * i));
    }
    fastest = sqrt(fastest);
    /* reach = diameter + skin, with diameter + most_skin = size/2 in a box */
    g->skin = fmin(SKIN * p->diameter, 0.9 * most_skin);
    g->reach = p->diameter + g->skin;
    g->h = step;
    /* (x + round) - round rounds x to a multiple of the grid if round = 1.5 2^52 grid. Here grid =
     * 2^-53 2^(e+1), with 2^e <= GRID fastest < 2^(e+1), so that round = 0.75 2^(e+1). */
    g->round = 0.0;
    if (fastest > 0.0)
        g->round = ldexp(0.75, ilogb(GRID * fastest) + 1);
    place_images(g);
}

int64_t refdem_gas_run(const refdem_gas *p, int64_t threads, double step, int64_t samples,
                       int64_t stride, int64_t most, uint8_t *memory, int64_t *events,
                       double *event, double *channel, double *position, double *velocity,
                       double *omega, double *attitude)
{
    assert(p && p->bodies >= 1 && (p->planes == 0 || p->plane));
    assert(threads >= 1 && threads <= MOST_THREADS && samples >= 1 && stride >= 1 && most >= 0);
    assert(memory && events && event && channel); /* `memory` has refdem_gas_room bytes */
    assert(position && velocity);
    assert(!p->turning || (omega && attitude));
    gas g = {.samples = samples, .stride = stride, .most = most, .channel = channel};
    g.out_x = position;
    g.out_v = velocity;
    g.out_w = omega;
    g.out_q = attitude;
    lay_out(&g, p, threads, memory);
    begin(&g, step);
    for (int64_t k = 0; k < threads; k++)
        g.share[k].event = event + 2 * most * k;
    if (run_team(&g.team, (int)threads, run_share, &g))
        return 2;
    for (int64_t k = 0; k < threads; k++)
        events[k] = g.share[k].events;
    return has_failed(&g);
}
