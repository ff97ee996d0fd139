/* Runge-Kutta methods of soft bodies: the state as one vector, its rate, and a step of a table. */
#include "forces.h"

/* A body in the vector: place, velocity, attitude, angular velocity. */
enum { SLOTS = 13, STATE = SLOTS * MOST };

static void packed(real *y)
{
    for (int i = 0; i < bodies; i++) {
        real *to = y + SLOTS * i;
        memcpy(to, body[i].r, sizeof body[i].r);
        memcpy(to + 3, body[i].v, sizeof body[i].v);
        memcpy(to + 6, body[i].q, sizeof body[i].q);
        memcpy(to + 10, body[i].w, sizeof body[i].w);
    }
}

static void unpacked(const real *y)
{
    for (int i = 0; i < bodies; i++) {
        const real *from = y + SLOTS * i;
        memcpy(body[i].r, from, sizeof body[i].r);
        memcpy(body[i].v, from + 3, sizeof body[i].v);
        memcpy(body[i].q, from + 6, sizeof body[i].q);
        memcpy(body[i].w, from + 10, sizeof body[i].w);
    }
}

static void rate(double t, const real *y, real *dy)
{
    unpacked(y);
    forces(t);
    for (int i = 0; i < bodies; i++) {
        const struct body *b = &body[i];
        real *to = dy + SLOTS * i;
        const real omega[4] = {0, b->w[0] / 2, b->w[1] / 2, b->w[2] / 2};
        for (int k = 0; k < 3; k++) {
            to[k] = b->v[k];
            to[3 + k] = b->f[k] / b->m;
            to[10 + k] = b->J[k] > 0 ? b->torque[k] / b->J[k] : 0;
        }
        product(to + 6, omega, b->q);
    }
}

/* A table of Butcher: `stages` rows of weights of the earlier rates, then those of the result. */
struct table {
    int stages;
    double c[7], a[7][7], b[7], lower[7];
};

static const struct table HEUN = {2, {0, 1}, {{0}, {1}}, {0.5, 0.5}, {0}};
static const struct table RK4 = {
    4, {0, 0.5, 0.5, 1}, {{0}, {0.5}, {0, 0.5}, {0, 0, 1}}, {1. / 6, 1. / 3, 1. / 3, 1. / 6}, {0}};

/* The state after a step of a table; `error` (if not NULL) is the difference to the lower order. */
static void stages(const struct table *table, double t, real h, const real *y, real *next,
                   real *error)
{
    static real k[7][STATE], at[STATE];
    const int n = SLOTS * bodies;
    for (int s = 0; s < table->stages; s++) {
        for (int i = 0; i < n; i++) {
            real sum = 0;
            for (int j = 0; j < s; j++)
                sum += (real)table->a[s][j] * k[j][i];
            at[i] = y[i] + h * sum;
        }
        rate(t + table->c[s] * h, at, k[s]);
    }
    for (int i = 0; i < n; i++) {
        real sum = 0;
        real difference = 0;
        for (int s = 0; s < table->stages; s++) {
            sum += (real)table->b[s] * k[s][i];
            difference += (real)(table->b[s] - table->lower[s]) * k[s][i];
        }
        next[i] = y[i] + h * sum;
        if (error)
            error[i] = h * difference;
    }
}

static void unit_quaternions(void)
{
    for (int i = 0; i < bodies; i++)
        unit_quaternion(body[i].q);
}

static void by_table(const struct table *table, double t, real h)
{
    static real y[STATE], next[STATE];
    packed(y);
    stages(table, t, h, y, next, NULL);
    unpacked(next);
    unit_quaternions();
}
