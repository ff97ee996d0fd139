/* Forces that MuJoCo calls for in every stage of an integrator (mjcb_passive), at the state of that
 * stage: drives, springs of any power, dashpots, central and piecewise fields.
 *
 * No header of MuJoCo is used: the adapter passes the addresses of the state. MuJoCo's callback has
 * no user argument, and there is one for the whole process; the forces that it applies are kept for
 * each thread. Their laws are in force_rows.h.
 */
#include "mujoco_forces_kernel.h"

#include "force_rows.h"

#include <stddef.h>

enum { COLUMNS = 12 };

static _Thread_local const refdem_mujoco_forces *running;

/* The value of a column of MuJoCo's state; 0 for -1, which stands for what does not move. */
static double at(const double *values, int64_t column)
{
    if (column < 0)
        return 0.0;
    return values[column];
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
        double place[3], velocity[3], force[3];
        for (int i = 0; i < 3; i++) {
            /* r_a - r_b and v_a - v_b; a column < 0 is the world, at 0. */
            place[i] = at(f->q, column[i]) - at(f->q, column[6 + i]);
            velocity[i] = at(f->v, column[3 + i]) - at(f->v, column[9 + i]);
        }
        force_on(f->kind[k], f->number + NUMBERS * k, *f->clock, place, velocity, force);
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
