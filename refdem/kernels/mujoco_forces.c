/* Forces that MuJoCo calls for in every stage of an integrator (mjcb_passive), at the state of that
 * stage: drives, springs of any power, dashpots, central and piecewise fields.
 *
 * No header of MuJoCo is used: the adapter tells where the state lies. MuJoCo's callback has no
 * argument for its user, and is one for the whole process; what it applies is kept for each thread.
 */
#include "mujoco_forces_kernel.h"

#include <math.h>
#include <stddef.h>

enum { DRIVE, SPRING, DASHPOT, CENTRAL, PIECEWISE };
enum { COLUMNS = 12, NUMBERS = 10 };

static _Thread_local const refdem_mujoco_forces *running;

static double at(const double *values, int64_t column)
{
    if (column < 0)
        return 0.0;
    return values[column];
}

/* F = amplitude cos(frequency t + phase) along the axis. */
static void drive(const double *p, double t, double *force)
{
    double size = p[0] * cos(p[1] * t + p[2]);
    for (int i = 0; i < 3; i++)
        force[i] = size * p[3 + i];
}

/* F = -(k |s|^n sgn(s) + a s^2 + b s^3) d/|d|, with d from the anchor and s = |d| - length. */
static void spring(const double *p, const double *place, double *force)
{
    double d[3];
    for (int i = 0; i < 3; i++)
        d[i] = place[i] - p[3 + i];
    double distance = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    if (!(distance > 0)) /* a spring of no length has no direction */
        return;
    double stretch = distance - p[1];
    double pull = p[0] * copysign(pow(fabs(stretch), p[2]), stretch);
    pull += (p[6] + p[7] * stretch) * stretch * stretch;
    for (int i = 0; i < 3; i++)
        force[i] = -pull * d[i] / distance;
}

/* F = -(damping + van_der_pol d^2) v, with d from the anchor. */
static void dashpot(const double *p, const double *place, const double *velocity, double *force)
{
    double square = 0.0;
    for (int i = 0; i < 3; i++)
        square += (place[i] - p[2 + i]) * (place[i] - p[2 + i]);
    double coefficient = p[0] + p[1] * square;
    for (int i = 0; i < 3; i++)
        force[i] = -coefficient * velocity[i];
}

/* F = -gm m r/|r|^3. */
static void central(const double *p, const double *place, double *force)
{
    double square = place[0] * place[0] + place[1] * place[1] + place[2] * place[2];
    double pull = p[0] / (square * sqrt(square));
    for (int i = 0; i < 3; i++)
        force[i] = -pull * place[i];
}

/* F along the axis at s = (r - point).axis: k1 (s - x1) for x1 <= s <= 0, k2 (s - x2) for
 * 0 <= s <= x2, else none. */
static void piecewise(const double *p, const double *place, double *force)
{
    const double *axis = p + 7;
    double s = 0.0;
    for (int i = 0; i < 3; i++)
        s += (place[i] - p[4 + i]) * axis[i];
    double size = 0.0;
    if (s > p[2] && s <= 0)
        size = p[0] * (s - p[2]);
    else if (s > 0 && s < p[3])
        size = p[1] * (s - p[3]);
    for (int i = 0; i < 3; i++)
        force[i] = size * axis[i];
}

static void callback(const void *model, void *data)
{
    (void)model;
    (void)data;
    const refdem_mujoco_forces *f = running;
    if (f == NULL)
        return;
    for (int64_t k = 0; k < f->pushes; k++) {
        const int64_t *column = f->column + COLUMNS * k;
        const double *p = f->number + NUMBERS * k;
        double place[3], velocity[3];
        double force[3] = {0, 0, 0};
        for (int i = 0; i < 3; i++) {
            place[i] = at(f->q, column[i]) - at(f->q, column[6 + i]);
            velocity[i] = at(f->v, column[3 + i]) - at(f->v, column[9 + i]);
        }
        if (f->kind[k] == DRIVE)
            drive(p, *f->clock, force);
        else if (f->kind[k] == SPRING)
            spring(p, place, force);
        else if (f->kind[k] == DASHPOT)
            dashpot(p, place, velocity, force);
        else if (f->kind[k] == CENTRAL)
            central(p, place, force);
        else if (f->kind[k] == PIECEWISE)
            piecewise(p, place, force);
        /* Action on a, reaction on b. */
        for (int i = 0; i < 3; i++) {
            if (column[3 + i] >= 0)
                f->felt[column[3 + i]] += force[i];
            if (column[9 + i] >= 0)
                f->felt[column[9 + i]] -= force[i];
        }
    }
}

void refdem_mujoco_forces_set(const refdem_mujoco_forces *forces)
{
    running = forces;
}

void *refdem_mujoco_forces_callback(void)
{
    return (void *)callback;
}
