/* Springs, dashpots, contacts, fields, drives, rods and Euler's equations for REBOUND, as its
 * callbacks; and a loop over its own steps that records the state.
 *
 * The only argument of a callback is the address of the simulation (or set of equations). The scene
 * is the target of a pointer that the engine reserves for its users. The offset of this pointer in
 * the simulation depends on the engine's version. There is therefore one callback for each offset,
 * and the adapter chooses that of the layout which the installed engine reports. No header of
 * REBOUND is used.
 *
 * Forces on a, their opposites on b, with d = x_a - x_b, w = v_a - v_b:
 *   spring   -(k |s|^e sgn s + k2 s^2 + k3 s^3) d/|d|,   s = |d| - length
 *   dashpot  -(damping + van_der_pol |d|^2) (w - rate x d)
 *   contact  (k o^e + damping o') d/|d|,   o = reach - |d| > 0, o' = -w.d/|d|
 *   drive    F cos(frequency t + phase) axis
 *   rod      -lambda d,   lambda = (w.w + d.(a_a - a_b))/(d.d (1/m_a + 1/m_b)),
 * from d.d'' + w.w = 0. The division is by d.d and not by length^2, so that d.d'' + w.w = 0 holds
 * for any drift of |d|, which therefore grows as t and not exponentially. Bodies that turn obey
 * Euler's equations J w' = (J w) x w in body axes and q' = q w/2.
 */
#define _POSIX_C_SOURCE 200809L
#include <assert.h>
#include <math.h>
#include <signal.h>
#include <stdbool.h>
#include <string.h>

#include "force_rows.h"
#include "kernels.h"

typedef refdem_rebound_scene scene_t;

/* Position, velocity or acceleration (3) of a body: the doubles at that byte offset of its particle
 * in the engine's array. */
static double *column(const scene_t *scene, int64_t body, int64_t offset)
{
    return (double *)(void *)(scene->particle + body * scene->size + offset);
}

/* The scalar product p.q. */
static double dot(const double *p, const double *q)
{
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
}

/* out = x_a - x_b of one column of the bodies a = end[0] and b = end[1]; if b is the world (-1),
 * x_b is `rest`. */
static void difference(const scene_t *scene, const int64_t *end, int64_t offset, const double *rest,
                       double *out)
{
    const double *a = column(scene, end[0], offset);
    const double *b = rest;
    if (end[1] >= 0)
        b = column(scene, end[1], offset);
    for (int i = 0; i < 3; i++)
        out[i] = a[i] - b[i];
}

/* Adds the acceleration by the force `factor * force` (3) [N] to body a, and that by its opposite
 * to body b; the world and fixed bodies stay as they are. */
static void add_force(const scene_t *scene, const int64_t *end, double factor, const double *force)
{
    double signed_factor[2] = {factor, -factor};
    for (int side = 0; side < 2; side++) {
        if (end[side] < 0 || scene->fixed[end[side]])
            continue;
        double *a = column(scene, end[side], scene->acceleration);
        for (int i = 0; i < 3; i++)
            a[i] += signed_factor[side] * force[i] / scene->mass[end[side]];
    }
}

/* F = -(k |s|^e sgn s + k2 s^2 + k3 s^3) d/|d| with the stretch s = |d| - length. */
static void spring(const scene_t *scene, const int64_t *end, const spring_row *p)
{
    double d[3];
    difference(scene, end, scene->position, p->anchor, d);
    /* A linear spring of no length: no root, and none of its rounding. */
    if (p->length == 0 && p->exponent == 1 && p->quadratic == 0 && p->cubic == 0) {
        add_force(scene, end, -p->stiffness, d);
        return;
    }
    double distance = sqrt(dot(d, d));
    if (!(distance > 0)) /* a spring of no length has no direction */
        return;
    add_force(scene, end, -spring_pull(p, distance - p->length) / distance, d);
}

/* F = -(damping + van_der_pol |d|^2) (w - rate x d). */
static void dashpot(const scene_t *scene, const int64_t *end, const dashpot_row *p)
{
    static const double rest[3] = {0, 0, 0};
    double d[3], w[3], slip[3];
    difference(scene, end, scene->position, p->anchor, d);
    difference(scene, end, scene->velocity, rest, w);
    slip_of(p, d, w, slip);
    add_force(scene, end, -(p->damping + p->van_der_pol * dot(d, d)), slip);
}

/* F = (k o^e + damping o') d/|d| with the overlap o = reach - |d|, which grows as o' = -(w.d)/|d|;
 * none without an overlap, and none that pulls unless it may. */
static void contact(const scene_t *scene, const int64_t *end, const contact_row *p)
{
    static const double rest[3] = {0, 0, 0};
    double d[3], w[3];
    difference(scene, end, scene->position, rest, d);
    double distance = sqrt(dot(d, d));
    double overlap = p->reach - distance;
    if (!(overlap > 0))
        return;
    difference(scene, end, scene->velocity, rest, w);
    double overlap_rate = -dot(w, d) / distance;
    double force = p->stiffness * pow(overlap, p->exponent) + p->damping * overlap_rate;
    bool may_pull = p->may_pull != 0;
    if (force > 0 || may_pull)
        add_force(scene, end, force / distance, d);
}

/* The piecewise linear force along its axis at s = (x - point).axis. */
static void field(const scene_t *scene, int64_t body, const piecewise_row *p)
{
    const int64_t end[2] = {body, -1};
    double d[3];
    difference(scene, end, scene->position, p->point, d);
    add_force(scene, end, piecewise_force(p, dot(d, p->axis)), p->axis);
}

/* F = force cos(frequency t + phase) along the axis, at the engine's time t. */
static void drive(const scene_t *scene, const int64_t *end, const drive_row *p)
{
    add_force(scene, end, p->force * cos(p->frequency * *scene->clock + p->phase), p->axis);
}

/* 1/m [1/kg]; 0 for the world and for fixed bodies. */
static double inverse_mass(const scene_t *scene, int64_t body)
{
    if (body < 0 || scene->fixed[body]) /* nothing moves it */
        return 0.0;
    return 1.0 / scene->mass[body];
}

/* Adds the force of a rod, after all other forces; returns its tension lambda |d| [N]. */
static double rod(const scene_t *scene, const int64_t *end, const double *anchor)
{
    static const double rest[3] = {0, 0, 0};
    double d[3], w[3], a[3];
    difference(scene, end, scene->position, anchor, d);
    difference(scene, end, scene->velocity, rest, w);
    difference(scene, end, scene->acceleration, rest, a);
    double distance_squared = dot(d, d);
    double inverse_masses = inverse_mass(scene, end[0]) + inverse_mass(scene, end[1]);
    /* lambda = (w.w + d.(a_a - a_b))/(d.d (1/m_a + 1/m_b)). */
    double lambda = (dot(w, w) + dot(d, a)) / (distance_squared * inverse_masses);
    add_force(scene, end, -lambda, d);
    return lambda * sqrt(distance_squared);
}

/* Adds gravity to the accelerations; those of fixed bodies are zero. */
static void gravity(const scene_t *scene)
{
    for (int64_t body = 0; body < scene->bodies; body++) {
        double *a = column(scene, body, scene->acceleration);
        for (int i = 0; i < 3; i++) {
            a[i] += scene->gravity[i];
            if (scene->fixed[body])
                a[i] = 0.0;
        }
    }
}

/* Adds all forces to the accelerations; those of the rods last, for they depend on all others. */
static void forces(const scene_t *scene)
{
    gravity(scene);
    for (int64_t k = 0; k < scene->springs; k++)
        spring(scene, scene->spring_end + 2 * k, (const spring_row *)scene->spring + k);
    for (int64_t k = 0; k < scene->dashpots; k++)
        dashpot(scene, scene->dashpot_end + 2 * k, (const dashpot_row *)scene->dashpot + k);
    for (int64_t k = 0; k < scene->contacts; k++)
        contact(scene, scene->contact_end + 2 * k, (const contact_row *)scene->contact + k);
    for (int64_t k = 0; k < scene->fields; k++)
        for (int64_t body = 0; body < scene->bodies; body++)
            field(scene, body, (const piecewise_row *)scene->field + k);
    for (int64_t k = 0; k < scene->drives; k++)
        drive(scene, scene->drive_end + 2 * k, (const drive_row *)scene->drive + k);
    for (int64_t k = 0; k < scene->rods; k++)
        scene->tension[k] = rod(scene, scene->rod_end + 2 * k, scene->rod_anchor + 3 * k);
}

/* Rates of the further equations: y has for each body that turns its attitude q = (q0, q1, q2, q3)
 * and its angular velocity w (3) in body axes. */
static void euler(const scene_t *scene, double *restrict rate, const double *restrict y)
{
    for (int64_t k = 0; k < scene->turning; k++, y += 7, rate += 7) {
        const double *j = scene->inertia + 3 * k;
        const double *q = y;
        const double *w = y + 4;
        /* q' = q (0, w)/2. */
        rate[0] = 0.5 * (-q[1] * w[0] - q[2] * w[1] - q[3] * w[2]);
        rate[1] = 0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]);
        rate[2] = 0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]);
        rate[3] = 0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]);
        /* J1 w1' = (J2 - J3) w2 w3, and cyclically. */
        rate[4] = (j[1] - j[2]) * w[1] * w[2] / j[0];
        rate[5] = (j[2] - j[0]) * w[2] * w[0] / j[1];
        rate[6] = (j[0] - j[1]) * w[0] * w[1] / j[2];
    }
}

/* One callback for each of 128 places of the user's pointer, in words of 8 bytes: forces_000 for
 * byte 0, forces_001 for byte 8, up to forces_0177 for byte 1016. EIGHT(X, n) makes X of the octal
 * numbers n0 to n7, PLACES(X) of all. */
#define EIGHT(X, n) X(n##0) X(n##1) X(n##2) X(n##3) X(n##4) X(n##5) X(n##6) X(n##7)
#define PLACES(X)                                                                                  \
    EIGHT(X, 0)                                                                                    \
    EIGHT(X, 01)                                                                                   \
    EIGHT(X, 02)                                                                                   \
    EIGHT(X, 03)                                                                                   \
    EIGHT(X, 04)                                                                                   \
    EIGHT(X, 05)                                                                                   \
    EIGHT(X, 06)                                                                                   \
    EIGHT(X, 07)                                                                                   \
    EIGHT(X, 010)                                                                                  \
    EIGHT(X, 011)                                                                                  \
    EIGHT(X, 012) EIGHT(X, 013) EIGHT(X, 014) EIGHT(X, 015) EIGHT(X, 016) EIGHT(X, 017)
/* The scene to which the pointer at that word of a simulation or set of equations points. */
#define SCENE_AT(owner, place)                                                                     \
    (*(const scene_t *const *)(const void *)((const char *)(owner) + 8 * (place)))
#define FORCES(place)                                                                              \
    static void forces_##place(void *simulation)                                                   \
    {                                                                                              \
        forces(SCENE_AT(simulation, place));                                                       \
    }
#define EULER(place)                                                                               \
    static void euler_##place(void *ode, double *rate, const double *y, double t)                  \
    {                                                                                              \
        (void)t;                                                                                   \
        euler(SCENE_AT(ode, place), rate, y);                                                      \
    }
#define NAME_FORCES(place) forces_##place,
#define NAME_EULER(place) euler_##place,
PLACES(FORCES)
PLACES(EULER)

/* True for the byte at which one of these words begins. */
static int has_callback(int64_t place)
{
    return place % 8 == 0 && place >= 0 && place < 1024;
}

void *refdem_rebound_forces(int64_t place)
{
    static void (*const all[])(void *) = {PLACES(NAME_FORCES)};
    if (!has_callback(place))
        return NULL;
    return (void *)all[place / 8];
}

void *refdem_rebound_euler(int64_t place)
{
    static void (*const all[])(void *, double *, const double *, double) = {PLACES(NAME_EULER)};
    if (!has_callback(place))
        return NULL;
    return (void *)all[place / 8];
}

/* Writes one sample: the time, the bodies, the equations of those that turn, the tensions of the
 * rods; returns the address of the next sample. */
static double *record(const refdem_rebound_engine *engine, const scene_t *scene, double *out)
{
    *out++ = *engine->clock;
    for (int64_t body = 0; body < scene->bodies; body++, out += 6) {
        memcpy(out, column(scene, body, scene->position), 3 * sizeof(double));
        memcpy(out + 3, column(scene, body, scene->velocity), 3 * sizeof(double));
    }
    if (scene->turning) {
        memcpy(out, *engine->equations, 7 * (size_t)scene->turning * sizeof(double));
        out += 7 * scene->turning;
    }
    if (scene->rods) { /* tensions of this sample, not of the last stage of a step */
        engine->update(engine->simulation);
        memcpy(out, scene->tension, (size_t)scene->rods * sizeof(double));
        out += scene->rods;
    }
    return out;
}

int refdem_rebound_record(const refdem_rebound_engine *engine, const refdem_rebound_scene *scene,
                          int64_t stride, int64_t samples, const double *times, double *out)
{
    assert(engine && scene && engine->clock && samples >= 1 && out);
    assert(stride || times); /* (samples) doubles */
    /* REBOUND takes over the handler of an interrupt; the caller's is put back. */
    struct sigaction interrupt;
    int failed = 0;
    sigaction(SIGINT, NULL, &interrupt);
    out = record(engine, scene, out);
    for (int64_t k = 1; k < samples && !failed; k++) {
        if (stride) /* steps of fixed size */
            engine->steps(engine->simulation, (size_t)stride);
        else if (engine->integrate(engine->simulation, times[k]))
            failed = (int)(k + 1);
        out = record(engine, scene, out);
    }
    sigaction(SIGINT, &interrupt, NULL);
    return failed;
}
