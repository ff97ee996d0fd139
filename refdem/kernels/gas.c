/* A gas of equal smooth spheres under a linear spring-dashpot contact law, in a periodic box or between planes.
 *
 * Velocity Verlet (Swope et al. 1982), synchronous; the dashpot sees the velocity of the end of the step, predicted with the last
 * acceleration. Verlet's list (1967) of pairs closer than a diameter and a skin is rebuilt, from a counting sort of the bodies into cells,
 * before the two fastest bodies could have crossed the skin. Bodies lie in memory in the order of their cells. Work is done on a
 * velocity only while a contact lasts. Impulses are rounded to a grid on which velocities lie, and given to both bodies of a pair with
 * opposite signs: sums are then exact, in any order, and so is total momentum. Positions are kept in the box, with whole boxes
 * counted apart, so that a body's velocity knows nothing of the walls of the box.
 */
#include "gas_list.h"

#define GRID 8.0      /* times the fastest body at the start: faster ones are still right, but no longer on the grid */

int64_t refdem_gas_doubles(const refdem_gas *p) { return 12 * p->bodies + 5 * refdem_gas_contacts(p); }

int64_t refdem_gas_contacts(const refdem_gas *p) { return 9 * p->bodies + 16; }

int64_t refdem_gas_integers(const refdem_gas *p)
{
    return 13 * p->bodies + 2 + most_cells(p) + 2 * p->most_pairs + 2 * refdem_gas_contacts(p);
}

int64_t refdem_gas_bytes(const refdem_gas *p) { return p->most_pairs + p->bodies; }

/* Overlap of a listed pair, positive if it touches, and the normal from a to b in n (3). */
static inline double overlap(const gas *g, int64_t a, int64_t b, double *n)
{
    const double *x = g->x + 3 * a, size = g->p->size, d = g->p->diameter;
    if (b < 0) {
        const double *q = g->p->plane + 6 * (-1 - b);
        double away = 0.0;
        for (int c = 0; c < 3; c++)
            away += (x[c] - q[c]) * q[3 + c], n[c] = -q[3 + c];
        return 0.5 * d - away;
    }
    double d2 = 0.0;
    for (int c = 0; c < 3; c++) {
        n[c] = g->x[3 * b + c] - x[c];
        n[c] = size > 0.0 ? nearest(n[c], size) : n[c];
        d2 += n[c] * n[c];
    }
    if (!(d2 < d * d))
        return 0.0;
    double r = sqrt(d2);
    for (int c = 0; c < 3; c++)
        n[c] /= r;
    return d - r;
}

/* Contacts of the listed pairs: bodies, normal, overlap. Returns the events so far, or -1 if there is no room for a contact. */
static int64_t touch(gas *g, double time, int64_t most, int64_t events, double *event)
{
    g->contacts = 0;
    for (int64_t m = 0; m < g->pairs; m++) {
        double n[3], deep = overlap(g, g->a[m], g->b[m], n);
        if (!(deep > 0.0)) {
            g->touching[m] = 0;
            continue;
        }
        if (g->contacts == refdem_gas_contacts(g->p))
            return -1;
        if (!g->touching[m] && events < most)
            event[2 * events] = time, event[2 * events + 1] = (double)g->label[g->a[m]];
        events += !g->touching[m], g->touching[m] = 1;
        double *k = g->contact + 5 * g->contacts;
        k[0] = n[0], k[1] = n[1], k[2] = n[2], k[3] = deep;
        g->ca[g->contacts] = g->a[m], g->cb[g->contacts++] = g->b[m];
    }
    return events;
}

/* The rate of the overlap at the end of the step, as the last accelerations predict it, into the contact's fifth number. */
static void predict(gas *g)
{
    for (int64_t m = 0; m < g->contacts; m++) {
        double *k = g->contact + 5 * m;
        int64_t a = 3 * g->ca[m], b = 3 * (int64_t)g->cb[m];
        k[4] = 0.0;
        for (int c = 0; c < 3; c++) {
            double other = b < 0 ? 0.0 : g->v[b + c] + g->kick[b + c];
            k[4] += (g->v[a + c] + g->kick[a + c] - other) * k[c];
        }
    }
}

static void marked(gas *g, int64_t i)
{
    if (!g->mark[i])
        g->mark[i] = 1, g->marked[g->touched++] = (int32_t)i;
}

/* Half a step's change of velocity by every contact, on the grid, to both bodies. */
static void press(gas *g)
{
    double ease = 0.5 * g->h / g->p->mass, grid = g->round, power = 0.0;
    for (int64_t m = 0; m < g->touched; m++) {
        g->mark[g->marked[m]] = 0;
        memset(g->kick + 3 * g->marked[m], 0, 3 * sizeof(double));
    }
    g->touched = 0;
    for (int64_t m = 0; m < g->contacts; m++) {
        double *k = g->contact + 5 * m, pull = g->p->damping * k[4], force = g->p->stiffness * k[3] + pull;
        if (g->p->no_pull && force < 0.0)
            pull -= force, force = 0.0;
        power += pull * k[4];
        int64_t a = g->ca[m], b = g->cb[m];
        marked(g, a);
        if (b >= 0)
            marked(g, b);
        for (int c = 0; c < 3; c++) {
            double change = (ease * force * k[c] + grid) - grid;
            g->kick[3 * a + c] -= change;
            if (b >= 0)
                g->kick[3 * b + c] += change;
        }
    }
    g->work += 0.5 * g->h * (g->power + power), g->power = power;
}

static void kick(gas *g)
{
    double most = g->fastest * g->fastest;
    for (int64_t m = 0; m < g->touched; m++) {
        double *v = g->v + 3 * g->marked[m], *k = g->kick + 3 * g->marked[m];
        v[0] += k[0], v[1] += k[1], v[2] += k[2];
        most = fmax(most, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    }
    g->fastest = sqrt(most);
}

static void drift(gas *g)
{
    double h = g->h, *restrict x = g->x;
    const double *restrict v = g->v;
    for (int64_t i = 0; i < 3 * g->n; i++)
        x[i] += h * v[i];
    g->way += fabs(h) * g->fastest;
}

static void recorded(const gas *g, double *channel, double *out)
{
    double size = g->p->size;
    for (int64_t i = 0; i < g->n; i++)
        for (int c = 0; c < 3; c++) {
            out[3 * g->label[i] + c] = g->x[3 * i + c] + size * g->image[3 * i + c];
            out[3 * (g->n + g->label[i]) + c] = g->v[3 * i + c];
        }
    channel[0] = (double)g->contacts, channel[1] = g->work;
}

static void begun(gas *g, double step, const double *start)
{
    int64_t n = g->n;
    double room = g->p->size > 0.0 ? 0.5 * g->p->size - g->p->diameter : SKIN * g->p->diameter;
    memcpy(g->x, start, (size_t)(3 * n) * sizeof(double));
    memcpy(g->v, start + 3 * n, (size_t)(3 * n) * sizeof(double));
    memset(g->kick, 0, (size_t)(3 * n) * sizeof(double));
    memset(g->image, 0, (size_t)(3 * n) * sizeof(int32_t));
    memset(g->mark, 0, (size_t)n);
    for (int64_t i = 0; i < n; i++)
        g->label[i] = (int32_t)i;
    g->skin = fmin(SKIN * g->p->diameter, 0.9 * room), g->reach = g->p->diameter + g->skin;
    g->h = step, g->work = g->power = 0.0, g->contacts = g->touched = 0;
    double most = fastest(g);
    g->round = most > 0.0 ? ldexp(0.75, ilogb(GRID * most) + 1) : 0.0; /* 1.5 2^52 times a grid of 2^-53 of the next power of two */
}

int64_t refdem_gas_run(const refdem_gas *p, double step, int64_t samples, int64_t stride, int64_t most, double *work, int32_t *integers,
                       uint8_t *bytes, double *event, double *channel, double *out)
{
    gas g;
    int64_t size = 6 * p->bodies, events = 0, taken = 0;
    laid_out(&g, p, work, integers, bytes);
    begun(&g, step, out);
    if (rebuilt(&g) || (events = touch(&g, 0.0, most, 0, event)) < 0)
        return -1;
    events = 0; /* what touches at the start does not begin to */
    predict(&g), press(&g);
    g.work = 0.0;
    channel[0] = (double)g.contacts, channel[1] = 0.0;
    for (int64_t s = 1; s < samples; s++) {
        for (int64_t k = 0; k < stride; k++) {
            kick(&g);
            if (2.0 * (g.way + fabs(step) * g.fastest) > g.skin && rebuilt(&g))
                return -1;
            drift(&g);
            if ((events = touch(&g, (double)++taken * step, most, events, event)) < 0)
                return -1;
            predict(&g), press(&g), kick(&g);
        }
        recorded(&g, channel + 2 * s, out + size * s);
    }
    return events;
}
