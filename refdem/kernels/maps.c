/* Maps applied again and again: the logistic map and equation, billiards in a rectangle and in a
 * stadium.
 *
 * The rectangle is unfolded (the path is a straight line through mirrored tables), in
 * double-double, so that nothing adds up from bounce to bounce. The stadium goes from bounce to
 * bounce; place and direction are put back on the wall and to length 1 each time, so that only what
 * the motion itself amplifies grows.
 */
#include "kernels.h"
#include "double_double.h"

int refdem_logistic(double eta, double x0, int64_t samples, const double *restrict n,
                    double *restrict out)
{
    double x = x0;
    int64_t at = 0;
    for (int64_t k = 0; k < samples; k++) {
        for (int64_t goal = (int64_t)n[k]; at < goal; at++)
            x = eta * x * (1.0 - x);
        out[k] = x;
    }
    return 0;
}

/* 1/(1 + (1/x0 - 1) e^(-eta n)), as x0/(x0 + (1 - x0) e^(-eta n)): no division by x0 = 0. */
int refdem_logistic_flow(double eta, double x0, int64_t samples, const double *restrict n,
                         double *restrict out)
{
    for (int64_t k = 0; k < samples; k++)
        out[k] = x0 / (x0 + (1.0 - x0) * exp(-eta * n[k]));
    return 0;
}

/* One coordinate of the unfolded path: how many of its walls are behind it, and when it meets the
 * next. */
typedef struct {
    double start, rate, size, sense;
    int64_t count;
    dd next;
} unfolded;

static inline void ahead(unfolded *c)
{
    dd reach = dd_sub(dd_scale(dd_of(c->size), (double)c->count + 0.5), dd_of(c->sense * c->start));
    c->next = dd_of(INFINITY); /* it moves along these walls */
    if (c->rate != 0.0)
        c->next = dd_div(reach, dd_of(fabs(c->rate)));
}

/* Its place in the table at time t: the unfolded one, less the tables passed, mirrored in every
 * other. */
static inline double folded(const unfolded *c, dd t)
{
    dd place = dd_add(dd_of(c->start), dd_mul(dd_of(c->rate), t));
    place = dd_sub(place, dd_scale(dd_of(c->size), c->sense * (double)c->count));
    double x = dd_round(place);
    if (c->count % 2 == 1)
        x = -x;
    return fmax(-0.5 * c->size, fmin(0.5 * c->size, x));
}

int refdem_rectangle(double width, double height, const double *restrict start, int64_t samples,
                     const double *restrict n, double *restrict out)
{
    unfolded c[2];
    dd t = {0.0, 0.0};
    int64_t at = 0;
    double size[2] = {width, height};
    for (int i = 0; i < 2; i++) {
        c[i] = (unfolded){.start = start[i], .rate = start[2 + i], .size = size[i], .sense = -1.0};
        if (start[2 + i] > 0.0)
            c[i].sense = 1.0;
        ahead(&c[i]);
    }
    if (start[2] == 0.0 && start[3] == 0.0)
        return 1;
    for (int64_t k = 0; k < samples; k++) {
        int last = -1;
        for (int64_t goal = (int64_t)n[k]; at < goal; at++) {
            double gap = c[1].next.hi - c[0].next.hi;
            last = gap < 0.0 || (gap == 0.0 && c[1].next.lo < c[0].next.lo);
            t = c[last].next;
            c[last].count++;
            ahead(&c[last]);
        }
        for (int i = 0; i < 2; i++) {
            double mirrored = 1.0;
            if (c[i].count % 2 == 1)
                mirrored = -1.0;
            if (i == last) /* on the wall that it has just met, exactly */
                out[4 * k + i] = -mirrored * c[i].sense * 0.5 * c[i].size;
            else if (at > 0)
                out[4 * k + i] = folded(&c[i], t);
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
static inline int bounced(double r, double a, int arc, double *restrict s)
{
    double x = s[0];
    double y = s[1];
    double u = s[2];
    double v = s[3];
    double up = copysign(1.0, v);
    double meets; /* where it meets the line of the straight wall */
    if (v != 0.0)
        meets = x + (up * r - y) * u / v;
    else if (u > 0.0) /* along the walls it goes to a half circle */
        meets = INFINITY;
    else
        meets = -INFINITY;
    if (a > 0.0 && fabs(meets) <= a) {
        s[0] = meets;
        s[1] = up * r;
        s[3] = -v;
        return 0;
    }
    int side = 2 * (meets > 0.0) - 1; /* 1 to the right, -1 to the left */
    double q = x - side * a;
    double b = q * u + y * v;
    double t = -2.0 * b; /* from a place on the same half circle */
    if (arc != side)
        t = -b + sqrt(fmax(0.0, b * b - (q * q + y * y - r * r)));
    double n0 = q + t * u;
    double n1 = y + t * v;
    double size = hypot(n0, n1);
    n0 /= size;
    n1 /= size;
    double along = n0 * u + n1 * v;
    u -= 2.0 * along * n0;
    v -= 2.0 * along * n1;
    double longer = 1.5 - 0.5 * (u * u + v * v);
    s[0] = side * a + r * n0;
    s[1] = r * n1;
    s[2] = u * longer;
    s[3] = v * longer;
    return side;
}

int refdem_stadium(double width, double height, const double *restrict start, int64_t samples,
                   const double *restrict n, double *restrict out)
{
    double s[4] = {start[0], start[1], start[2], start[3]};
    double r = 0.5 * height;
    double a = 0.5 * (width - height);
    int64_t at = 0;
    int arc = 0;
    for (int64_t k = 0; k < samples; k++) {
        for (int64_t goal = (int64_t)n[k]; at < goal; at++)
            arc = bounced(r, a, arc, s);
        for (int i = 0; i < 4; i++)
            out[4 * k + i] = s[i];
    }
    return 0;
}
