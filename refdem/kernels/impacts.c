/* Rigid spheres in free flight between impacts, event-driven (Alder and Wainwright 1959).
 *
 * Let d = (r_j - r_i)/R with R = R_i + R_j, w = v_j - v_i and u = w/|w|. With b = d.u < 0 two
 * spheres meet when |d + u |w| s/R| = 1, at the first root
 *
 *     s = (R/|w|) c / (-b + sqrt(q)),   c = (|d| - 1) (|d| + 1),   q = 1 - |d x u|^2,
 *
 * without cancellation and independent of units, since uniform gravity accelerates both equally. A
 * sphere meets a plane at s = (height - R)/closing speed, or at the root of a quadratic equation
 * where gravity acts. An impact changes velocities and spins by impulses (impacts_law.h).
 *
 * With few bodies every pair is examined (impacts_pairs.h). With many, bodies examine their
 * neighbours in cells, and events are kept in a queue (impacts_events.h): O(log bodies) an event.
 * Samples are copies of the state: the motion does not depend on the times of samples.
 */
#include "impacts_kernel.h"

#include "impacts_events.h"
#include "impacts_pairs.h"
#include "simd.h"

enum { LINE = 64 };

/* The address of the next `bytes` of `room`, which are rounded up to whole cache lines; NULL
 * without `room`. */
static void *claimed(char *room, int64_t *used, size_t bytes)
{
    void *at = NULL;
    if (room)
        at = room + *used;
    *used += ((int64_t)bytes + LINE - 1) / LINE * LINE;
    return at;
}

/* Assigns the arrays for so many bodies within `room`; with NULL only counts. Returns the bytes. */
static int64_t lay_out(motion *m, crowd *k, int64_t bodies, char *room)
{
    const size_t n = (size_t)bodies;
    const size_t nodes = 2 * (size_t)leaves_of(bodies);
    int64_t used = 0;
    m->flight = claimed(room, &used, n * sizeof *m->flight);
    m->spin = claimed(room, &used, n * sizeof *m->spin);
    m->creeping = claimed(room, &used, n * sizeof *m->creeping);
    m->next = claimed(room, &used, n * sizeof *m->next);
    m->partner = claimed(room, &used, n * sizeof *m->partner);
    m->boxes = claimed(room, &used, 3 * n * sizeof *m->boxes);
    k->plan = claimed(room, &used, n * sizeof *k->plan);
    k->near = claimed(room, &used, (n + 2) * sizeof *k->near);
    k->due = claimed(room, &used, n * sizeof *k->due);
    k->queue.node = claimed(room, &used, nodes * sizeof *k->queue.node);
    k->grid.slot = claimed(room, &used, n * sizeof *k->grid.slot);
    k->grid.next = claimed(room, &used, (n + 1) * sizeof *k->grid.next);
    k->grid.previous = claimed(room, &used, (n + 1) * sizeof *k->grid.previous);
    const size_t cells = (size_t)most_cells(bodies);
    k->grid.first = claimed(room, &used, cells * sizeof *k->grid.first);
    return used;
}

int64_t refdem_impacts_room(int64_t bodies)
{
    motion m;
    crowd k;
    const int64_t bytes = lay_out(&m, &k, bodies, NULL) + LINE;
    return (bytes + (int64_t)sizeof(double) - 1) / (int64_t)sizeof(double);
}

/* The state at the start. */
static void begin(const refdem_impacts *p, motion *m, double now, const double *position,
                  const double *velocity, const double *omega, const double *attitude)
{
    for (int64_t i = 0; i < m->bodies; i++) {
        flight *f = m->flight + i;
        spin *s = m->spin + i;
        memcpy(f->place, position + 3 * i, sizeof f->place);
        memcpy(f->velocity, velocity + 3 * i, sizeof f->velocity);
        f->since = now;
        f->radius = p->radius[i];
        memcpy(s->omega, omega + 3 * i, sizeof s->omega);
        memcpy(s->attitude, attitude + 4 * i, sizeof s->attitude);
        s->since = now;
        m->creeping[i] = 0;
    }
    memcpy(m->gravity, p->gravity, sizeof m->gravity);
    m->falls = dot(p->gravity, p->gravity) > 0.0;
    m->period = p->period;
    m->work = 0.0;
}

/* The state at a sample: copies, advanced to its time. */
static void sample(const motion *m, double now, double *position, double *velocities, double *omega,
                   double *attitude)
{
    for (int64_t i = 0; i < m->bodies; i++) {
        place_beyond(m, i, now, position + 3 * i);
        velocity(m, i, now, velocities + 3 * i);
        memcpy(omega + 3 * i, m->spin[i].omega, sizeof m->spin[i].omega);
        faced(m, i, now, attitude + 4 * i);
    }
}

REFDEM_EVERY_CPU
int64_t refdem_impacts_run(const refdem_impacts *p, int64_t samples, const double *t, int64_t most,
                           int64_t longest, double *room, double *event, double *work,
                           double *position, double *velocity, double *omega, double *attitude)
{
    assert(samples >= 1 && p->bodies >= 1 && p->bodies < INT32_MAX && room && work);
    motion m = {.bodies = p->bodies};
    crowd k = {.m = &m};
    const uintptr_t address = (uintptr_t)room;
    lay_out(&m, &k, p->bodies, (char *)room + (LINE - address % LINE) % LINE);
    event_log log = {.event = event, .most = most, .longest = longest};
    const bool in_cells = p->bodies > p->few || p->period > 0.0;
    begin(p, &m, t[0], position, velocity, omega, attitude);
    if (in_cells)
        begin_cells(p, &k, t[0]);
    else
        begin_pairs(p, &m, t[0]);
    work[0] = 0.0;
    for (int64_t row = 1; row < samples; row++) {
        const int64_t from = p->bodies * row;
        const int status
            = in_cells ? cells_until(p, &k, t[row], &log) : pairs_until(p, &m, t[row], &log);
        if (status == TOO_MANY)
            return -row;
        if (status == RESTS)
            return -samples - row;
        sample(&m, t[row], position + 3 * from, velocity + 3 * from, omega + 3 * from,
               attitude + 4 * from);
        work[row] = m.work;
    }
    return log.events;
}
