/* Masses on springs with dry friction, whose impulse is implicit in the velocity at the end of a
 * step: Moreau's time stepping (`moreau`), or symplectic Euler with it (`implicit-friction`). */
#include "forces.h"

/* The largest friction of a slider at its speed. */
static real limit(const struct element *e, real speed)
{
    if (is_law(e, "coulomb"))
        return e->friction * e->normal_force;
    const real rising = is_law(e, "stribeck") ? speed * speed : speed;
    const real falling = (e->mu0 - e->mu1) / (1 + e->lambda0 * speed);
    return (falling + e->mu1 + e->lambda1 * rising) * e->normal_force;
}

/* Velocities at the end of a step: those without friction, each changed by at most the impulse of
 * its slider towards the velocity of the belt. */
static void rub(real h)
{
    for (const struct element *e = element; e < element + elements; e++) {
        if (!is_kind(e, "slider"))
            continue;
        struct body *b = &body[e->a];
        const real u = dot(b->v, e->axis) - e->belt;
        const real before = dot(b->v, e->axis) - h * dot(b->f, e->axis) / b->m - e->belt;
        const real most = fabs(h) * limit(e, fabs(before)) / b->m;
        const real change = fabs(u) <= most ? -u : copysign(most, -u);
        for (int k = 0; k < 3; k++)
            b->v[k] += change * e->axis[k];
    }
}

static void move(real h)
{
    for (struct body *b = body; b < body + bodies; b++)
        for (int k = 0; k < 3; k++)
            b->r[k] += h * b->v[k];
}

static void kick(real h)
{
    for (struct body *b = body; b < body + bodies; b++)
        for (int k = 0; k < 3; k++)
            b->v[k] += h * b->f[k] / b->m;
}

/* Forces in the middle of the step, where half of the way is done. */
static void moreau(double t, real h)
{
    move(h / 2);
    forces(t + h / 2);
    kick(h);
    rub(h);
    move(h / 2);
}

/* Symplectic Euler with the forces at the start of the step. */
static void implicit_friction(double t, real h)
{
    forces(t);
    kick(h);
    rub(h);
    move(h);
}

static void solve(const char *method)
{
    const int is_moreau = strcmp(method, "moreau") == 0;
    refuse_scene();
    for (int i = 0; i < elements; i++) {
        const struct element *e = &element[i];
        if (is_kind(e, "slider") && e->b >= 0)
            refuse("friction between two bodies");
        for (int j = 0; j < i; j++)
            if (is_kind(e, "slider") && is_kind(&element[j], "slider"))
                refuse("more than one slider");
    }
    const struct schedule s = asked_schedule();
    march(&s, is_moreau ? moreau : implicit_friction, NULL);
}
