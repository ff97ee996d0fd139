/* Forces that MuJoCo calls for in every stage of an integrator (mjcb_passive), at the state of that
 * stage: drives, springs of any power, dashpots, central and piecewise fields.
 *
 * No header of MuJoCo is used: the adapter tells where the state lies. MuJoCo's callback has no
 * argument for its user, and is one for the whole process; what it applies is kept for each thread.
 * The laws of the forces stand in force_rows.h.
 */
#include "mujoco_forces_kernel.h"

#include "force_rows.h"

#include <math.h>
#include <stddef.h>

enum { DRIVE, SPRING, DASHPOT, CENTRAL, PIECEWISE };
enum { COLUMNS = 12, NUMBERS = 10 };

static _Thread_local const refdem_mujoco_forces *running;

/* The value of a column of MuJoCo's state; 0 for -1, which stands for what does not move. */
static double at(const double *values, int64_t column)
{
    if (column < 0)
        return 0.0;
    return values[column];
}

static void drive(const drive_row *p, double t, double *force)
{
    double strength = p->force * cos(p->frequency * t + p->phase);
    for (int i = 0; i < 3; i++)
        force[i] = strength * p->axis[i];
}

static void spring(const spring_row *p, const double *place, double *force)
{
    double d[3];
    for (int i = 0; i < 3; i++)
        d[i] = place[i] - p->anchor[i];
    double distance = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    if (!(distance > 0)) /* a spring of no length has no direction */
        return;
    double stretch = distance - p->length;
    double pull = p->stiffness * copysign(pow(fabs(stretch), p->exponent), stretch);
    pull += (p->quadratic + p->cubic * stretch) * stretch * stretch;
    for (int i = 0; i < 3; i++)
        force[i] = -pull * d[i] / distance;
}

static void dashpot(const dashpot_row *p, const double *place, const double *velocity,
                    double *force)
{
    double square = 0.0;
    for (int i = 0; i < 3; i++)
        square += (place[i] - p->anchor[i]) * (place[i] - p->anchor[i]);
    double coefficient = p->damping + p->van_der_pol * square;
    for (int i = 0; i < 3; i++)
        force[i] = -coefficient * velocity[i];
}

static void central(const central_row *p, const double *place, double *force)
{
    double square = place[0] * place[0] + place[1] * place[1] + place[2] * place[2];
    double pull = p->attraction / (square * sqrt(square));
    for (int i = 0; i < 3; i++)
        force[i] = -pull * place[i];
}

static void piecewise(const piecewise_row *p, const double *place, double *force)
{
    double s = 0.0;
    for (int i = 0; i < 3; i++)
        s += (place[i] - p->point[i]) * p->axis[i];
    double strength = piecewise_force(p, s);
    for (int i = 0; i < 3; i++)
        force[i] = strength * p->axis[i];
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
        const void *row = f->number + NUMBERS * k;
        double place[3], velocity[3];
        double force[3] = {0, 0, 0};
        for (int i = 0; i < 3; i++) {
            place[i] = at(f->q, column[i]) - at(f->q, column[6 + i]);
            velocity[i] = at(f->v, column[3 + i]) - at(f->v, column[9 + i]);
        }
        if (f->kind[k] == DRIVE)
            drive(row, *f->clock, force);
        else if (f->kind[k] == SPRING)
            spring(row, place, force);
        else if (f->kind[k] == DASHPOT)
            dashpot(row, place, velocity, force);
        else if (f->kind[k] == CENTRAL)
            central(row, place, force);
        else if (f->kind[k] == PIECEWISE)
            piecewise(row, place, force);
        /* Action on a, reaction on b. */
        for (int i = 0; i < 3; i++) {
            if (column[3 + i] >= 0)
                f->passive_force[column[3 + i]] += force[i];
            if (column[9 + i] >= 0)
                f->passive_force[column[9 + i]] -= force[i];
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
