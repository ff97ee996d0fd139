/* Points under springs, gravity and a central field by Gear's predictor-corrector (gear.h).
 *
 * The rows from 3 on start from derivatives of the acceleration. Extrapolation integrates the
 * motion, to round-off, to seven nodes a quarter of a step apart, with the start in the middle. The
 * polynomial through the accelerations there, sum of p_i s^i with s in node distances, gives these
 * derivatives up to terms of order h^9 in the rows: r_(i+2) = h^2 4^i p_i/((i + 1) (i + 2)).
 */
#ifndef REFDEM_PARTICLE_GEAR_H
#define REFDEM_PARTICLE_GEAR_H

#include "gear.h"
#include "particle_steps.h"

enum { SIDE = 3, NODES = 2 * SIDE + 1, PARTS = 4 };

/* Coefficients p_i = f^(i)(0)/i!, i = 0 to 4, of the polynomial of degree 6 through the values of f
 * at -3 .. 3: central differences. */
static const double THROUGH_NODES[MOST_VALUES - 2][NODES] = {
    {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0},
    {-1.0 / 60.0, 9.0 / 60.0, -45.0 / 60.0, 0.0, 45.0 / 60.0, -9.0 / 60.0, 1.0 / 60.0},
    {2.0 / 360.0, -27.0 / 360.0, 270.0 / 360.0, -490.0 / 360.0, 270.0 / 360.0, -27.0 / 360.0,
     2.0 / 360.0},
    {1.0 / 48.0, -8.0 / 48.0, 13.0 / 48.0, 0.0, -13.0 / 48.0, 8.0 / 48.0, -1.0 / 48.0},
    {-1.0 / 144.0, 12.0 / 144.0, -39.0 / 144.0, 56.0 / 144.0, -39.0 / 144.0, 12.0 / 144.0,
     -1.0 / 144.0},
};

/* The accelerations (NODES, 3 bodies) at the nodes, from the state `start` (size). work: 6 sizes.
 */
static inline void accelerations_at_nodes(runner *r, const double *restrict start, double h,
                                          double *restrict work, double *restrict acceleration)
{
    int64_t coordinates = 3 * r->p->bodies;
    double *y = work;
    double *next = y + 2 * r->size;
    double *dy = next + 2 * r->size;
    double *rate = dy + r->size;
    for (int side = -1; side <= 1; side += 2) {
        memset(y, 0, 2 * (size_t)r->size * sizeof *y);
        memcpy(y, start, (size_t)r->size * sizeof *y);
        rates(r->p, r->mode, y, dy);
        for (int node = 0; node <= SIDE; node++) {
            memcpy(acceleration + (SIDE + side * node) * coordinates, dy + coordinates,
                   (size_t)coordinates * sizeof *dy);
            update_scales(r, y, dy, h);
            step(r, y, dy, side * h / PARTS, next, rate);
            memcpy(y, next, 2 * (size_t)r->size * sizeof *y);
            memcpy(dy, rate, (size_t)r->size * sizeof *dy);
        }
    }
}

/* Fills Nordsieck's rows at the state `start` from the accelerations a_k at the nodes k:
 *
 *   p_i = sum over k of THROUGH_NODES[i][k] a_k,   r_(i+2) = h^2 4^i p_i/((i + 1) (i + 2)). */
static inline void fill_rows(gear *g, const double *restrict start, double h,
                             const double *restrict acceleration)
{
    int64_t n = g->size;
    double factor = h * h;
    for (int64_t k = 0; k < n; k++) {
        g->row[k] = start[k];
        g->row[n + k] = h * start[n + k];
    }
    for (int i = 0; i + 2 < g->values; i++) {
        for (int64_t k = 0; k < n; k++) {
            double coefficient = 0.0;
            for (int node = 0; node < NODES; node++)
                coefficient += THROUGH_NODES[i][node] * acceleration[node * n + k];
            g->row[(i + 2) * n + k] = factor * coefficient / ((i + 1) * (i + 2));
        }
        factor *= PARTS;
    }
}

/* The arguments of `particle_acceleration`: the scene, and room for a state and its rates. */
typedef struct {
    const runner *r;
    double *state, *rate;
} asked;

/* The accelerations at places x and velocities v. */
static inline void particle_acceleration(void *system, const double *x, const double *v, double *a)
{
    asked *s = system;
    int64_t coordinates = 3 * s->r->p->bodies;
    memcpy(s->state, x, (size_t)coordinates * sizeof *x);
    memcpy(s->state + coordinates, v, (size_t)coordinates * sizeof *v);
    rates(s->r->p, s->r->mode, s->state, s->rate);
    memcpy(a, s->rate + coordinates, (size_t)coordinates * sizeof *a);
}

#endif
