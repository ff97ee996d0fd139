/* Gear's predictor-corrector for x'' = f(x, x') with a fixed step h and one correction a step
 * (Gear, Numerical Initial Value Problems in Ordinary Differential Equations, 1971, chapter 9.2;
 * Allen and Tildesley, Computer Simulation of Liquids, appendix E).
 *
 * The state is Nordsieck's: row i holds r_i = h^i x^(i)/i!. A step predicts by Taylor's series,
 *
 *   r_i = sum over j >= i of binomial(j, i) r_j,
 *
 * and adds c_i d to row i, d = h^2/2 f - r_2, with f at the predicted state. Rows 0 and 1 carry the
 * rounding errors of their sums (Kahan 1965), so that round-off does not accumulate.
 */
#ifndef REFDEM_GEAR_H
#define REFDEM_GEAR_H

#include <stdint.h>

#include "double_double.h"

enum { MOST_VALUES = 7, COMPENSATED = 2 };

static const double BINOMIAL[MOST_VALUES][MOST_VALUES] = {
    {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0},   {0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0},
    {0.0, 0.0, 1.0, 3.0, 6.0, 10.0, 15.0}, {0.0, 0.0, 0.0, 1.0, 4.0, 10.0, 20.0},
    {0.0, 0.0, 0.0, 0.0, 1.0, 5.0, 15.0},  {0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 6.0},
    {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0},
};

typedef struct {
    int values;              /* rows of Nordsieck's state, at most MOST_VALUES */
    int64_t size;            /* coordinates */
    const double *corrector; /* (values), the c_i */
    double *row;             /* (values, size), h^i x^(i)/i! */
    double *low;             /* (COMPENSATED, size), what rounding rows 0 and 1 has lost */
    double *increment;       /* (COMPENSATED, size), what the prediction adds to them */
    double *x, *v, *a;       /* (size) each: predicted, and f there */
} gear;

/* The force per mass a = f(x, v) of a system. */
typedef void (*gear_acceleration)(void *system, const double *x, const double *v, double *a);

/* Doubles of work space that `gear_in` lays out. */
static inline int64_t gear_work(int64_t size)
{
    return (MOST_VALUES + 2 * COMPENSATED + 3) * size;
}

/* A state of `size` coordinates in work space; its rows are still to be filled. */
static inline gear gear_in(double *work, int values, int64_t size, const double *corrector)
{
    gear g = {.values = values, .size = size, .corrector = corrector, .row = work};
    g.low = g.row + MOST_VALUES * size;
    g.increment = g.low + COMPENSATED * size;
    g.x = g.increment + COMPENSATED * size;
    g.v = g.x + size;
    g.a = g.v + size;
    for (int64_t k = 0; k < COMPENSATED * size; k++)
        g.low[k] = 0.0;
    return g;
}

/* What the prediction adds to row i of coordinate k: the sum over j > i of binomial(j, i) r_j. */
static inline double gear_added(const gear *g, int i, int64_t k)
{
    double sum = 0.0;
    for (int j = g->values - 1; j > i; j--)
        sum += BINOMIAL[i][j] * g->row[j * g->size + k];
    return sum;
}

/* Taylor's series over a step: rows from 2 on in place, x and v beside their rows. */
static inline void gear_predict(gear *g, double h)
{
    int64_t n = g->size;
    for (int64_t k = 0; k < n; k++) {
        /* r_0 += r_1 + r_2 + .., with what rounding r_1 has lost, and r_1 += 2 r_2 + 3 r_3 + ..; x
         * = r_0 and v = r_1/h. */
        g->increment[k] = g->low[n + k] + gear_added(g, 0, k);
        g->increment[n + k] = gear_added(g, 1, k);
        for (int i = COMPENSATED; i < g->values; i++)
            g->row[i * n + k] += gear_added(g, i, k);
        g->x[k] = g->row[k] + (g->low[k] + g->increment[k]);
        g->v[k] = (g->row[n + k] + (g->low[n + k] + g->increment[n + k])) / h;
    }
}

/* Adds c_i d to every row, d = h^2/2 f - r_2. */
static inline void gear_correct(gear *g, double h)
{
    int64_t n = g->size;
    for (int64_t k = 0; k < n; k++) {
        /* d = h^2/2 f(x, v) - r_2; r_i += c_i d. */
        double d = 0.5 * h * h * g->a[k] - g->row[2 * n + k];
        for (int i = 0; i < COMPENSATED; i++) {
            int64_t at = i * n + k;
            dd sum = two_sum(g->row[at], g->low[at] + (g->increment[at] + g->corrector[i] * d));
            g->row[at] = sum.hi;
            g->low[at] = sum.lo;
        }
        for (int i = COMPENSATED; i < g->values; i++)
            g->row[i * n + k] += g->corrector[i] * d;
    }
}

/* One step h: predict, evaluate, correct. */
static inline void gear_step(gear *g, double h, gear_acceleration acceleration, void *system)
{
    gear_predict(g, h);
    acceleration(system, g->x, g->v, g->a);
    gear_correct(g, h);
}

#endif
