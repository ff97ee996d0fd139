/* RATTLE: velocity Verlet for points joined by rods (Andersen, J. Comput. Phys. 52 (1983) 24;
 * Hairer, Lubich, Wanner VII.1.4).
 *
 * kick and drift by h/2 and h; rods of the new positions by multipliers along the old ones (Newton
 * to round-off); kick by h/2; then rods of the velocities. Positions and velocities carry what
 * their sums left over (Kahan), so that round-off does not pile up. The rod force is the exact one
 * of the sampled state: G M^-1 G^T T = G a + |relative velocity|^2.
 */
#include <assert.h>

#include <string.h>

#include "double_double.h"
#include "kernels.h"

typedef struct {
    int64_t n, rods, springs;
    const double *mass;      /* (n,), infinite for a fixed point */
    const double *gravity;   /* (3,) */
    const int64_t *rod_ends; /* (rods, 2), -1 is the world */
    const double *rod_anchor, *rod_length;
    const int64_t *spring_ends;
    const double *spring_anchor, *spring_law; /* law: stiffness, length, exponent */
    double *acceleration, *low_x, *low_v, *old, *new, *matrix, *rhs, *solution, *column;
} system_of_rods;

/* From the second end (or the world's anchor) to the first. */
static void separation(const int64_t *restrict ends, const double *restrict anchor,
                       const double *restrict x, double *restrict d)
{
    const double *other = anchor;
    if (ends[1] >= 0)
        other = x + 3 * ends[1];
    for (int i = 0; i < 3; i++)
        d[i] = x[3 * ends[0] + i] - other[i];
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* With what the sums left over, so that rods far from the origin are held as well as near it. */
static void directions(const system_of_rods *s, const double *restrict x, double *restrict d)
{
    static const double nothing[3] = {0.0, 0.0, 0.0};
    for (int64_t r = 0; r < s->rods; r++) {
        double low[3];
        separation(s->rod_ends + 2 * r, s->rod_anchor + 3 * r, x, d + 3 * r);
        separation(s->rod_ends + 2 * r, nothing, s->low_x, low);
        for (int i = 0; i < 3; i++)
            d[3 * r + i] += low[i];
    }
}

/* Pull [N] over length of a spring of this size; `law`: stiffness, length, exponent. */
static double pull_per_length(const double *restrict law, double size)
{
    double stretch = size - law[1];
    if (law[1] == 0.0 && law[2] == 1.0) /* no direction is needed */
        return law[0];
    if (!(size > 0.0))
        return 0.0;
    if (law[2] == 1.0)
        return law[0] * stretch / size;
    return law[0] * copysign(pow(fabs(stretch), law[2]), stretch) / size;
}

/* Gravity and springs, per mass. */
static void accelerate(const system_of_rods *s, const double *restrict x)
{
    double *a = s->acceleration;
    for (int64_t b = 0; b < s->n; b++)
        for (int i = 0; i < 3; i++) {
            a[3 * b + i] = s->gravity[i];
            if (isinf(s->mass[b])) /* a fixed point does not fall */
                a[3 * b + i] = 0.0;
        }
    for (int64_t k = 0; k < s->springs; k++) {
        const int64_t *ends = s->spring_ends + 2 * k;
        const double *law = s->spring_law + 3 * k;
        double d[3];
        separation(ends, s->spring_anchor + 3 * k, x, d);
        double pull = pull_per_length(law, sqrt(dot(d, d)));
        double sense[2] = {pull, -pull};
        for (int end = 0; end < 2; end++) {
            if (ends[end] < 0) /* the world */
                continue;
            for (int i = 0; i < 3; i++)
                a[3 * ends[end] + i] -= sense[end] * d[i] / s->mass[ends[end]];
        }
    }
}

/* The sum of 1/m of the points that two rods share, below 0 where first meets second end. */
static double shared_ease(const system_of_rods *s, const int64_t *restrict one,
                          const int64_t *restrict other)
{
    double shared = 0.0;
    for (int p = 0; p < 2; p++) {
        if (one[p] < 0) /* the world does not yield */
            continue;
        for (int q = 0; q < 2; q++) {
            if (one[p] != other[q])
                continue;
            double ease = 1.0 / s->mass[one[p]];
            if (p == q)
                shared += ease;
            else
                shared -= ease;
        }
    }
    return shared;
}

/* Rows G(d1) M^-1 G(d0)^T. */
static void couple(const system_of_rods *s, const double *restrict d1, const double *restrict d0)
{
    for (int64_t i = 0; i < s->rods; i++) {
        for (int64_t j = 0; j < s->rods; j++) {
            double shared = shared_ease(s, s->rod_ends + 2 * i, s->rod_ends + 2 * j);
            double entry = 0.0;
            if (shared != 0.0)
                entry = shared * dot(d1 + 3 * i, d0 + 3 * j);
            s->matrix[i * s->rods + j] = entry;
        }
    }
}

static void swap(double *a, double *b)
{
    double kept = *a;
    *a = *b;
    *b = kept;
}

/* matrix solution = rhs, by elimination with complete pivoting; a redundant rod carries nothing. */
static void solve(const system_of_rods *s)
{
    const int64_t n = s->rods;
    double *a = s->matrix;
    double *b = s->rhs;
    double largest = 0.0;
    int64_t rank = 0;
    for (int64_t i = 0; i < n; i++) {
        s->column[i] = (double)i;
        s->solution[i] = 0.0;
    }
    for (; rank < n; rank++) {
        int64_t row = rank;
        int64_t col = rank;
        for (int64_t i = rank; i < n; i++)
            for (int64_t j = rank; j < n; j++)
                if (fabs(a[i * n + j]) > fabs(a[row * n + col])) {
                    row = i;
                    col = j;
                }
        if (rank == 0)
            largest = fabs(a[row * n + col]);
        if (!(fabs(a[row * n + col]) > 1e-11 * largest))
            break;
        for (int64_t j = 0; j < n; j++)
            swap(&a[row * n + j], &a[rank * n + j]);
        for (int64_t i = 0; i < n; i++)
            swap(&a[i * n + col], &a[i * n + rank]);
        swap(&b[row], &b[rank]);
        swap(&s->column[col], &s->column[rank]);
        for (int64_t i = rank + 1; i < n; i++) {
            double factor = a[i * n + rank] / a[rank * n + rank];
            for (int64_t j = rank; j < n; j++)
                a[i * n + j] -= factor * a[rank * n + j];
            b[i] -= factor * b[rank];
        }
    }
    for (int64_t i = rank - 1; i >= 0; i--) {
        double sum = b[i];
        for (int64_t j = i + 1; j < rank; j++)
            sum -= a[i * n + j] * s->solution[(int64_t)s->column[j]];
        s->solution[(int64_t)s->column[i]] = sum / a[i * n + i];
    }
}

static inline void grow(double *restrict value, double *restrict low, double by)
{
    dd sum = two_sum(*value, by + *low);
    *value = sum.hi;
    *low = sum.lo;
}

/* values -= scale M^-1 G(d)^T solution. */
static void push(const system_of_rods *s, const double *restrict d, double scale,
                 double *restrict values, double *restrict low)
{
    double sense[2] = {-scale, scale};
    for (int64_t r = 0; r < s->rods; r++) {
        for (int end = 0; end < 2; end++) {
            int64_t b = s->rod_ends[2 * r + end];
            if (b < 0) /* the world */
                continue;
            for (int i = 0; i < 3; i++) {
                double change = sense[end] * s->solution[r] * d[3 * r + i] / s->mass[b];
                grow(&values[3 * b + i], &low[3 * b + i], change);
            }
        }
    }
}

/* Newton on the multipliers until the rods' lengths are right to round-off; 0, or 1 if they never
 * are. */
static int hold_lengths(const system_of_rods *s, double h, double *restrict x, double *restrict v)
{
    double before = INFINITY;
    for (int sweep = 0; sweep < 60; sweep++) {
        double worst = 0.0;
        directions(s, x, s->new);
        for (int64_t r = 0; r < s->rods; r++) {
            double l = s->rod_length[r];
            double size = sqrt(dot(s->new + 3 * r, s->new + 3 * r));
            s->rhs[r] = 0.5 * (size - l) * (size + l);
            worst = fmax(worst, fabs(size - l) / l);
            if (!isfinite(size))
                return 1;
        }
        if (worst <= 2.3e-16 || (worst < 1e-14 && worst >= before))
            return 0;
        before = worst;
        couple(s, s->new, s->old);
        solve(s);
        push(s, s->old, 1.0, x, s->low_x);
        push(s, s->old, 1.0 / h, v, s->low_v);
    }
    return before > 1e-14;
}

/* Relative velocity along every rod made zero. */
static void hold_rates(const system_of_rods *s, const double *restrict x, double *restrict v)
{
    directions(s, x, s->new);
    for (int64_t r = 0; r < s->rods; r++) {
        static const double still[3] = {0.0, 0.0, 0.0};
        double relative[3];
        separation(s->rod_ends + 2 * r, still, v, relative);
        s->rhs[r] = dot(s->new + 3 * r, relative);
    }
    couple(s, s->new, s->new);
    solve(s);
    push(s, s->new, 1.0, v, s->low_v);
}

/* Tension (rods,) of the state. */
static void tension(const system_of_rods *s, const double *restrict x, const double *restrict v,
                    double *restrict out)
{
    static const double still[3] = {0.0, 0.0, 0.0};
    accelerate(s, x);
    directions(s, x, s->new);
    for (int64_t r = 0; r < s->rods; r++) {
        double pull[3], relative[3];
        separation(s->rod_ends + 2 * r, still, s->acceleration, pull);
        separation(s->rod_ends + 2 * r, still, v, relative);
        s->rhs[r] = dot(s->new + 3 * r, pull) + dot(relative, relative);
    }
    couple(s, s->new, s->new);
    solve(s);
    for (int64_t r = 0; r < s->rods; r++)
        out[r] = s->solution[r] * s->rod_length[r];
}

static void kick(const system_of_rods *s, double h, double *restrict v)
{
    for (int64_t i = 0; i < 3 * s->n; i++)
        grow(&v[i], &s->low_v[i], h * s->acceleration[i]);
}

static int step(const system_of_rods *s, double h, double *restrict x, double *restrict v)
{
    directions(s, x, s->old);
    kick(s, 0.5 * h, v);
    for (int64_t i = 0; i < 3 * s->n; i++)
        grow(&x[i], &s->low_x[i], h * v[i]);
    if (hold_lengths(s, h, x, v))
        return 1;
    accelerate(s, x);
    kick(s, 0.5 * h, v);
    hold_rates(s, x, v);
    return 0;
}

int refdem_rattle(int64_t n, const double *mass, const double *gravity, int64_t rods,
                  const int64_t *rod_ends, const double *rod_anchor, const double *rod_length,
                  int64_t springs, const int64_t *spring_ends, const double *spring_anchor,
                  const double *spring_law, double h, int64_t samples, int64_t stride, double *work,
                  double *position, double *velocity, double *force)
{
    assert(n >= 1 && samples >= 1 && stride >= 1);
    assert(work && position && velocity && force); /* `work`: 9 n + 9 rods + rods^2 doubles */
    system_of_rods s = {n,
                        rods,
                        springs,
                        mass,
                        gravity,
                        rod_ends,
                        rod_anchor,
                        rod_length,
                        spring_ends,
                        spring_anchor,
                        spring_law,
                        work,
                        work + 3 * n,
                        work + 6 * n,
                        work + 9 * n,
                        work + 9 * n + 3 * rods,
                        0,
                        0,
                        0,
                        0};
    s.rhs = s.new + 3 * rods;
    s.solution = s.rhs + rods;
    s.column = s.solution + rods;
    s.matrix = s.column + rods;
    memset(s.low_x, 0, (size_t)(6 * n) * sizeof(double));
    tension(&s, position, velocity, force);
    for (int64_t k = 1; k < samples; k++) {
        double *x = position + 3 * n * k;
        double *v = velocity + 3 * n * k;
        memcpy(x, x - 3 * n, (size_t)(3 * n) * sizeof(double));
        memcpy(v, v - 3 * n, (size_t)(3 * n) * sizeof(double));
        for (int64_t m = 0; m < stride; m++)
            if (step(&s, h, x, v))
                return (int)k + 1;
        tension(&s, x, v, force + rods * k);
    }
    return 0;
}
