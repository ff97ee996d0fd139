/* Chipmunk (the engine of pymunk): a loop over its own steps that records the bodies, and callbacks
 * for forces and laws for which it has no element.
 *
 * The engine's functions come as addresses; no header of Chipmunk is used. Its numbers are doubles
 * (the adapter checks this), and its vectors are passed by value. Its callbacks have no user
 * argument: the laws are therefore kept for each thread, and found by the address of their owner.
 */
#include "chipmunk_kernel.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "force_rows.h"

enum { COLUMNS = 6 }; /* of a body: position (2), velocity (2), angle, omega */
enum { CONTACT = PIECEWISE + 1, FRICTION }; /* further kinds of laws, of constraints */

/* The friction of a joint is at most load mu(u), with
 * mu(u) = (mu0 - mu1)/(1 + lambda0 u) + mu1 + lambda1 u^power at the speed u along the axis. */
typedef struct {
    double load, mu0, mu1, lambda0, lambda1, power, axis[2];
} friction_row;

static _Thread_local const refdem_chipmunk_laws *running;

/* Writes the columns of one body; those of its rotation are left unchanged in a scene in which no
 * body can turn. */
static void record(const refdem_chipmunk_engine *engine, void *body, double *restrict out)
{
    refdem_vector2 position = engine->position(body);
    refdem_vector2 velocity = engine->velocity(body);
    out[0] = position.x;
    out[1] = position.y;
    out[2] = velocity.x;
    out[3] = velocity.y;
    if (engine->omega) { /* something can turn */
        out[4] = engine->angle(body);
        out[5] = engine->omega(body);
    }
}

int refdem_chipmunk_record(const refdem_chipmunk_engine *engine, int64_t bodies, void *const *body,
                           double h, int64_t samples, int64_t stride, double *out)
{
    assert(engine && engine->step && engine->position && engine->velocity);
    assert(!engine->omega || engine->angle);
    assert(samples >= 1 && stride >= 0);
    assert(bodies == 0 || (body && out)); /* `out`: (samples, bodies, COLUMNS) doubles */
    for (int64_t k = 0; k < samples; k++) {
        int64_t steps = stride;
        if (k == 0) /* the first sample is the start */
            steps = 0;
        for (int64_t j = 0; j < steps; j++)
            engine->step(engine->space, h);
        for (int64_t i = 0; i < bodies; i++)
            record(engine, body[i], out + COLUMNS * (bodies * k + i));
    }
    return 0;
}

void refdem_chipmunk_set(const refdem_chipmunk_laws *laws)
{
    running = laws;
}

/* The number of the first law of that owner, by bisection: owners are in ascending order. If the
 * owner has no law, the number at which one would be inserted. */
static int64_t first_law_of(const refdem_chipmunk_laws *f, const void *owner)
{
    int64_t below = 0, above = f->laws;
    while (below < above) {
        int64_t middle = below + (above - below) / 2;
        if ((uintptr_t)f->owner[middle] < (uintptr_t)owner)
            below = middle + 1;
        else
            above = middle;
    }
    return below;
}

void refdem_chipmunk_push(void *body, refdem_vector2 gravity, double damping, double h)
{
    const refdem_chipmunk_laws *f = running;
    assert(f);
    refdem_vector2 r = f->position(body), v = f->velocity(body);
    double place[3] = {r.x, r.y, 0}, velocity[3] = {v.x, v.y, 0};
    /* Chipmunk calls this after it has moved the body and counted the step: the force is that at
     * the end of the step, F(t, r, v). */
    double t = f->start + f->step * f->timestamp(f->space);
    refdem_vector2 total = {0, 0};
    for (int64_t k = first_law_of(f, body); k < f->laws && f->owner[k] == body; k++) {
        double force[3];
        force_on(f->kind[k], f->number + NUMBERS * k, t, place, velocity, force);
        total.x += force[0];
        total.y += force[1];
    }
    f->set_force(body, total);
    f->update_velocity(body, gravity, damping, h);
}

/* Position and velocity of the second body of a constraint relative to the first. */
static void relative(const refdem_chipmunk_laws *f, const void *constraint, double *d, double *w)
{
    const void *a = f->body_a(constraint), *b = f->body_b(constraint);
    refdem_vector2 r_a = f->position(a), r_b = f->position(b);
    refdem_vector2 v_a = f->velocity(a), v_b = f->velocity(b);
    d[0] = r_b.x - r_a.x;
    d[1] = r_b.y - r_a.y;
    w[0] = v_b.x - v_a.x;
    w[1] = v_b.y - v_a.y;
}

/* True while two discs overlap, and the forces of spring and damper together push or may pull. */
static bool is_pressed(const refdem_chipmunk_laws *f, const void *constraint, const contact_row *p,
                       double distance)
{
    double overlap = p->reach - distance;
    if (!(overlap > 0))
        return false;
    if (p->may_pull != 0 || p->damping == 0)
        return true;
    double d[2], w[2];
    relative(f, constraint, d, w);
    /* k o^e + c o' > 0, with the overlap o and o' = -w.d/|d| */
    double overlap_rate = -(w[0] * d[0] + w[1] * d[1]) / hypot(d[0], d[1]);
    return p->stiffness * pow(overlap, p->exponent) + p->damping * overlap_rate > 0;
}

/* The force [N] along the line between both bodies, positive if it pushes them apart. */
double refdem_chipmunk_spring(void *constraint, double distance)
{
    const refdem_chipmunk_laws *f = running;
    assert(f);
    int64_t k = first_law_of(f, constraint);
    assert(k < f->laws && f->owner[k] == constraint);
    const void *row = f->number + NUMBERS * k;
    if (f->kind[k] == SPRING) {
        const spring_row *p = row;
        /* The pull at the stretch |d| - l, with the opposite sign. */
        return -spring_pull(p, distance - p->length);
    }
    const contact_row *p = row;
    /* k o^e; the engine adds the damping that refdem_chipmunk_prepare sets. */
    if (!is_pressed(f, constraint, p, distance))
        return 0.0;
    return p->stiffness * pow(p->reach - distance, p->exponent);
}

/* Sets, before each step, the damping of a contact or the largest friction of a joint. */
void refdem_chipmunk_prepare(void *constraint, void *space)
{
    (void)space;
    const refdem_chipmunk_laws *f = running;
    assert(f);
    int64_t k = first_law_of(f, constraint);
    assert(k < f->laws && f->owner[k] == constraint);
    const void *row = f->number + NUMBERS * k;
    double d[2], w[2];
    relative(f, constraint, d, w);
    if (f->kind[k] == CONTACT) {
        const contact_row *p = row;
        double damping = 0.0;
        if (is_pressed(f, constraint, p, hypot(d[0], d[1])))
            damping = p->damping;
        f->set_damping(constraint, damping);
    } else {
        const friction_row *p = row;
        /* limit = load ((mu0 - mu1)/(1 + lambda0 u) + mu1 + lambda1 u^power) */
        double speed = fabs(p->axis[0] * w[0] + p->axis[1] * w[1]);
        double falling = (p->mu0 - p->mu1) / (1 + p->lambda0 * speed) + p->mu1;
        f->set_limit(constraint, p->load * (falling + p->lambda1 * pow(speed, p->power)));
    }
}
