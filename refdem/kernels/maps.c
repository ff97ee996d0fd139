/* Maps applied again and again: the logistic map x -> eta x (1 - x) and the flow of x' = eta x (1 -
 * x), billiards in a rectangle and in a stadium.
 *
 * The rectangle is unfolded: instead of the ball the table is mirrored at each bounce, and the path
 * is a straight line through the mirrored tables, in double-double, so that nothing adds up from
 * bounce to bounce. The stadium goes from bounce to bounce, direction u -> u - 2 (u.n) n with the
 * normal n of the wall; place and direction are put back on the wall and to length 1 each time, so
 * that only what the motion itself amplifies grows.
 */
#include <assert.h>

#include "kernels.h"
#include "double_double.h"

int refdem_logistic(double eta, double x0, int64_t samples, const double *restrict n,
                    double *restrict out)
{
    assert(samples == 0 || (n && out)); /* (samples) doubles each */
    double x = x0;
    int64_t steps = 0;
    for (int64_t k = 0; k < samples; k++) {
        for (int64_t goal = (int64_t)n[k]; steps < goal; steps++)
            x = eta * x * (1.0 - x);
        out[k] = x;
    }
    return 0;
}

/* x = 1/(1 + (1/x0 - 1) e^(-eta n)), as x0/(x0 + (1 - x0) e^(-eta n)): no division by x0 = 0. */
int refdem_logistic_flow(double eta, double x0, int64_t samples, const double *restrict n,
                         double *restrict out)
{
    assert(samples == 0 || (n && out)); /* (samples) doubles each */
    for (int64_t k = 0; k < samples; k++)
        out[k] = x0 / (x0 + (1.0 - x0) * exp(-eta * n[k]));
    return 0;
}

/* One coordinate start + rate t of the unfolded path through tables of the width `size`; sense is
 * the sign of the rate, count the number of its walls behind it, and next the time at which it
 * meets the next one. */
typedef struct {
    double start, rate, size, sense;
    int64_t count;
    dd next;
} unfolded;

/* Sets the time of the next bounce, at a wall at the distance size (count + 1/2) from the centre of
 * the first table: t = (size (count + 1/2) - sense start)/|rate|. */
static inline void find_next_wall(unfolded *c)
{
    dd way = dd_sub(dd_scale(dd_of(c->size), (double)c->count + 0.5), dd_of(c->sense * c->start));
    c->next = dd_of(INFINITY); /* it moves along these walls */
    if (c->rate != 0.0)
        c->next = dd_div(way, dd_of(fabs(c->rate)));
}

/* The coordinate within the table at time t: the unfolded one, less the tables passed, mirrored in
 * every other. It is right to 2^-100 of the way, so that at a wall it rounds to that wall. */
static inline double fold(const unfolded *c, dd t)
{
    dd place = dd_add(dd_of(c->start), dd_mul(dd_of(c->rate), t));
    place = dd_sub(place, dd_scale(dd_of(c->size), c->sense * (double)c->count));
    if (c->count % 2 == 1)
        return -dd_round(place);
    return dd_round(place);
}

int refdem_rectangle(double width, double height, const double *restrict start, int64_t samples,
                     const double *restrict n, double *restrict out)
{
    assert(start && (samples == 0 || (n && out))); /* (4), (samples), (samples, 4) doubles */
    unfolded c[2];
    dd t = {0.0, 0.0};
    int64_t bounces = 0;
    double size[2] = {width, height};
    for (int i = 0; i < 2; i++) {
        c[i] = (unfolded){.start = start[i], .rate = start[2 + i], .size = size[i], .sense = -1.0};
        if (start[2 + i] > 0.0)
            c[i].sense = 1.0;
        find_next_wall(&c[i]);
    }
    if (start[2] == 0.0 && start[3] == 0.0) /* it never bounces */
        return 1;
    for (int64_t k = 0; k < samples; k++) {
        int wall = -1;
        /* The next bounce is on the wall that is met first. */
        for (int64_t goal = (int64_t)n[k]; bounces < goal; bounces++) {
            double gap = c[1].next.hi - c[0].next.hi;
            wall = gap < 0.0 || (gap == 0.0 && c[1].next.lo < c[0].next.lo);
            t = c[wall].next;
            c[wall].count++;
            find_next_wall(&c[wall]);
        }
        /* Coordinate and velocity are mirrored after an odd number of bounces on that axis. */
        for (int i = 0; i < 2; i++) {
            double mirrored = 1.0;
            if (c[i].count % 2 == 1)
                mirrored = -1.0;
            if (i == wall) /* exactly on the wall of the last bounce */
                out[4 * k + i] = -mirrored * c[i].sense * 0.5 * c[i].size;
            else if (bounces > 0)
                out[4 * k + i] = fold(&c[i], t);
            else /* no bounce yet */
                out[4 * k + i] = start[i];
            out[4 * k + 2 + i] = mirrored * start[2 + i];
        }
    }
    return 0;
}

/* On to the next bounce in a stadium of radius r and half length a of its straight walls: s is
 * place and direction, arc the half circle on which it stands (-1, 1), 0 if on none. Returns the
 * half circle that it met, 0 for a straight wall. */
static inline int bounce(double r, double a, int arc, double *restrict s)
{
    double x = s[0];
    double y = s[1];
    double u = s[2];
    double v = s[3];
    double wall_side = copysign(1.0, v);
    /* Where it meets the line of the straight wall; along the walls it goes to a half circle. */
    double crossing = copysign(INFINITY, u);
    if (v != 0.0)
        crossing = x + (wall_side * r - y) * u / v;
    if (a > 0.0 && fabs(crossing) <= a) { /* the straight wall */
        s[0] = crossing;
        s[1] = wall_side * r;
        s[3] = -v;
        return 0;
    }
    int side = 2 * (crossing > 0.0) - 1; /* 1 to the right, -1 to the left */
    /* |(q, y) + t (u, v)| = r, from the centre of that half circle: t^2 + 2 b t + (q^2 + y^2 - r^2)
     * = 0. */
    double q = x - side * a;
    /* t = -b + sqrt(b^2 - (q^2 + y^2 - r^2)), b = q u + y v */
    double b = q * u + y * v;
    double t = -2.0 * b; /* from a place on the same half circle: q^2 + y^2 = r^2 */
    if (arc != side)
        t = -b + sqrt(fmax(0.0, b * b - (q * q + y * y - r * r)));
    double n0 = q + t * u;
    double n1 = y + t * v;
    double length = hypot(n0, n1);
    n0 /= length;
    n1 /= length;
    /* u -= 2 (u.n) n, then a step of Newton's for |u| = 1. */
    double along = n0 * u + n1 * v;
    u -= 2.0 * along * n0;
    v -= 2.0 * along * n1;
    double normalise = 1.5 - 0.5 * (u * u + v * v);
    s[0] = side * a + r * n0;
    s[1] = r * n1;
    s[2] = u * normalise;
    s[3] = v * normalise;
    return side;
}

int refdem_stadium(double width, double height, const double *restrict start, int64_t samples,
                   const double *restrict n, double *restrict out)
{
    assert(start && (samples == 0 || (n && out))); /* (4), (samples), (samples, 4) doubles */
    double s[4] = {start[0], start[1], start[2], start[3]};
    double r = 0.5 * height;
    double a = 0.5 * (width - height);
    int64_t bounces = 0;
    int arc = 0;
    for (int64_t k = 0; k < samples; k++) {
        for (int64_t goal = (int64_t)n[k]; bounces < goal; bounces++)
            arc = bounce(r, a, arc, s);
        for (int i = 0; i < 4; i++)
            out[4 * k + i] = s[i];
    }
    return 0;
}
