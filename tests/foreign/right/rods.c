/* Points on rigid rods, whose forces are solved for, all at once: RATTLE (`rattle`, Andersen 1983),
 * and Runge and Kutta's method of order 4 on the accelerations (`rk4`), which lets lengths drift.
 */
#include "forces.h"

enum { NEWTON = 12 };

static struct element *rod[MOST];
static int rods;

/* +1 for the body that a rod begins at, -1 for the one at its end, 0 for others: the sign of the
 * tension's pull along the rod. */
static int sign_of(const struct element *e, int i)
{
    return (e->a == i) - (e->b == i);
}

/* From one end of each rod to the other, and the velocity of the one against the other. */
static void arms(real (*arm)[3], real (*closing)[3])
{
    for (int i = 0; i < rods; i++)
        relative(rod[i], arm[i], closing[i]);
}

/* The lengthening of rod i, times its length, by tensions of size 1 times `pull` in rod j. */
static real coupling(int i, int j, real (*arm)[3], real (*pull)[3])
{
    real inverse = 0;
    for (int k = 0; k < bodies; k++)
        inverse += sign_of(rod[i], k) * sign_of(rod[j], k) / body[k].m;
    return -inverse * dot(arm[i], pull[j]);
}

/* Solves matrix x = x in place, by Gauss's elimination with pivots. */
static void solved(real (*matrix)[MOST], real *x)
{
    for (int c = 0; c < rods; c++) {
        int pivot = c;
        for (int i = c + 1; i < rods; i++)
            if (fabs(matrix[i][c]) > fabs(matrix[pivot][c]))
                pivot = i;
        if (matrix[pivot][c] == 0)
            refuse("rods that hold each other");
        for (int k = 0; k < rods; k++) {
            const real entry = matrix[c][k];
            matrix[c][k] = matrix[pivot][k];
            matrix[pivot][k] = entry;
        }
        const real entry = x[c];
        x[c] = x[pivot];
        x[pivot] = entry;
        for (int i = c + 1; i < rods; i++) {
            const real factor = matrix[i][c] / matrix[c][c];
            for (int k = c; k < rods; k++)
                matrix[i][k] -= factor * matrix[c][k];
            x[i] -= factor * x[c];
        }
    }
    for (int c = rods - 1; c >= 0; c--) {
        for (int k = c + 1; k < rods; k++)
            x[c] -= matrix[c][k] * x[k];
        x[c] /= matrix[c][c];
    }
}

/* Tensions along `pull` that lengthen each rod (times its length) by so much. */
static void tensions(real *wanted, real (*arm)[3], real (*pull)[3])
{
    static real matrix[MOST][MOST];
    for (int i = 0; i < rods; i++)
        for (int j = 0; j < rods; j++)
            matrix[i][j] = coupling(i, j, arm, pull);
    solved(matrix, wanted);
}

/* What tensions along `pull` add to each component of a velocity, or of a place. */
static real pulled(int i, int k, const real *tension, real (*pull)[3])
{
    real sum = 0;
    for (int j = 0; j < rods; j++)
        sum += sign_of(rod[j], i) * tension[j] * pull[j][k];
    return sum / body[i].m;
}

/* Velocities along the rods are taken away. */
static void project_velocities(void)
{
    real arm[MOST][3], closing[MOST][3], tension[MOST];
    arms(arm, closing);
    for (int i = 0; i < rods; i++)
        tension[i] = -dot(arm[i], closing[i]);
    tensions(tension, arm, arm);
    for (int i = 0; i < bodies; i++)
        for (int k = 0; k < 3; k++)
            body[i].v[k] += pulled(i, k, tension, arm);
}

static void half_kick(real h)
{
    for (int i = 0; i < bodies; i++)
        for (int k = 0; k < 3; k++)
            body[i].v[k] += h / 2 * body[i].f[k] / body[i].m;
}

static void rattle(double t, real h)
{
    real before[MOST][3], arm[MOST][3], closing[MOST][3], wrong[MOST];
    half_kick(h);
    arms(before, closing);
    for (int i = 0; i < bodies; i++)
        for (int k = 0; k < 3; k++)
            body[i].r[k] += h * body[i].v[k];
    /* Tensions along the rods of the start of the step bring them to their lengths. */
    real last = INFINITY;
    for (int n = 0; n < NEWTON; n++) {
        real largest = 0;
        arms(arm, closing);
        for (int i = 0; i < rods; i++) {
            const real excess = size_of(arm[i]) - rod[i]->length;
            wrong[i] = -excess * (size_of(arm[i]) + rod[i]->length) / 2;
            largest = fmax(largest, fabs(excess) / rod[i]->length);
        }
        if (!(largest < last))
            break;
        last = largest;
        tensions(wrong, arm, before);
        for (int i = 0; i < bodies; i++)
            for (int k = 0; k < 3; k++) {
                const real shift = pulled(i, k, wrong, before);
                body[i].r[k] += shift;
                body[i].v[k] += shift / h;
            }
    }
    forces(t + h);
    half_kick(h);
    project_velocities();
}

enum { SLOTS = 6, STATE = SLOTS * MOST };

static void packed(real *y)
{
    for (int i = 0; i < bodies; i++) {
        memcpy(y + SLOTS * i, body[i].r, sizeof body[i].r);
        memcpy(y + SLOTS * i + 3, body[i].v, sizeof body[i].v);
    }
}

static void unpacked(const real *y)
{
    for (int i = 0; i < bodies; i++) {
        memcpy(body[i].r, y + SLOTS * i, sizeof body[i].r);
        memcpy(body[i].v, y + SLOTS * i + 3, sizeof body[i].v);
    }
}

/* The second derivative of |d|^2/2 of each rod is d . d'' + d'^2 = 0. */
static void rate(double t, const real *y, real *dy)
{
    real arm[MOST][3], closing[MOST][3], tension[MOST];
    unpacked(y);
    forces(t);
    arms(arm, closing);
    for (int i = 0; i < rods; i++) {
        tension[i] = -dot(closing[i], closing[i]);
        for (int k = 0; k < 3; k++) {
            const struct body *a = &body[rod[i]->a];
            const struct body *b = rod[i]->b < 0 ? NULL : &body[rod[i]->b];
            tension[i] -= arm[i][k] * ((b ? b->f[k] / b->m : 0) - a->f[k] / a->m);
        }
    }
    tensions(tension, arm, arm);
    for (int i = 0; i < bodies; i++)
        for (int k = 0; k < 3; k++) {
            dy[SLOTS * i + k] = body[i].v[k];
            dy[SLOTS * i + 3 + k] = body[i].f[k] / body[i].m + pulled(i, k, tension, arm);
        }
}

static void rk4(double t, real h)
{
    static real y[STATE], at[STATE], sum[STATE], k[STATE];
    const real part[4] = {0, 0.5, 0.5, 1};
    const real weight[4] = {1, 2, 2, 1};
    const int n = SLOTS * bodies;
    packed(y);
    memset(sum, 0, sizeof sum);
    memset(k, 0, sizeof k);
    for (int s = 0; s < 4; s++) {
        for (int i = 0; i < n; i++)
            at[i] = y[i] + part[s] * h * k[i];
        rate(t + (double)(part[s] * h), at, k);
        for (int i = 0; i < n; i++)
            sum[i] += weight[s] * k[i];
    }
    for (int i = 0; i < n; i++)
        y[i] += h / 6 * sum[i];
    unpacked(y);
}

static void solve(const char *method)
{
    refuse_scene();
    rods = 0;
    for (int i = 0; i < elements; i++)
        if (is_kind(&element[i], "rod"))
            rod[rods++] = &element[i];
    const int is_rattle = strcmp(method, "rattle") == 0;
    const struct schedule s = asked_schedule();
    forces(s.start);
    march(&s, is_rattle ? rattle : rk4, NULL);
}
