/* RATTLE: velocity Verlet for points joined by rods (Andersen, J. Comput. Phys. 52 (1983) 24;
 * Hairer, Lubich, Wanner VII.1.4).
 *
 * With the vector d_r of rod r between its ends a, b and G(d) the matrix with (G v)_r = d_r.(v_a -
 * v_b), a step h is
 *
 *   kick          v += h/2 a(x0)
 *   drift         x += h v
 *   hold lengths  x -= M^-1 G(d0)^T lambda,  v -= 1/h M^-1 G(d0)^T lambda,  |d_r| = l_r
 *   kick          v += h/2 a(x)
 *   hold rates    v -= M^-1 G(d)^T mu,  G(d) v = 0
 *
 * where lambda is found by Newton's method to round-off, and mu by one linear system of equations.
 * Positions and velocities carry the rounding errors of their sums (Kahan 1965), so that round-off
 * does not accumulate. The tension T of the rods is that of the sampled state, from d.d'' + d'.d' =
 * 0:
 *
 *   G M^-1 G^T (T/l) = G a + |v_a - v_b|^2.
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
    double *acceleration;                     /* (n, 3) [m/s^2] */
    double *low_x, *low_v;  /* (n, 3), what rounding the sums x and v has lost so far */
    double *old, *new;      /* (rods, 3), the vectors d of the start and of the end of a step */
    double *matrix;         /* (rods, rods), G M^-1 G^T; `solve` leaves its triangular form */
    double *rhs, *solution; /* (rods,) */
    int64_t *unknown;       /* (rods,), the number of the unknown that each column multiplies */
} system_of_rods;

/* The vector d (3) from the second end (or the world's anchor) to the first, of positions or of any
 * other vectors x (n, 3). */
static void difference(const int64_t *restrict ends, const double *restrict anchor,
                       const double *restrict x, double *restrict d)
{
    const double *other = anchor;
    if (ends[1] >= 0)
        other = x + 3 * ends[1];
    for (int i = 0; i < 3; i++)
        d[i] = x[3 * ends[0] + i] - other[i];
}

/* a.b. */
static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The vectors d (rods, 3) of all rods, with the low parts of the positions, so that the lengths of
 * rods far from the origin are as accurate as near it. */
static void directions(const system_of_rods *s, const double *restrict x, double *restrict d)
{
    static const double nothing[3] = {0.0, 0.0, 0.0};
    for (int64_t r = 0; r < s->rods; r++) {
        double low[3];
        difference(s->rod_ends + 2 * r, s->rod_anchor + 3 * r, x, d + 3 * r);
        difference(s->rod_ends + 2 * r, nothing, s->low_x, low);
        for (int i = 0; i < 3; i++)
            d[3 * r + i] += low[i];
    }
}

/* Pull over length, F/|d| [N/m], of a spring between points |d| = `distance` [m] apart: F = k
 * |s|^exponent sgn(s), s = |d| - length. `law`: stiffness k, length, exponent. */
static double pull_per_length(const double *restrict law, double distance)
{
    const double stiffness = law[0];
    const double length = law[1];
    const double exponent = law[2];
    double stretch = distance - length;
    if (length == 0.0 && exponent == 1.0) /* F = k d: no direction is needed */
        return stiffness;
    if (!(distance > 0.0)) /* it has no direction */
        return 0.0;
    if (exponent == 1.0)
        return stiffness * stretch / distance;
    return stiffness * copysign(pow(fabs(stretch), exponent), stretch) / distance;
}

/* Accelerations (n, 3) by gravity and springs [m/s^2]. */
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
        difference(ends, s->spring_anchor + 3 * k, x, d);
        double pull = pull_per_length(law, sqrt(dot(d, d)));
        /* a_a -= F d/(|d| m_a), a_b += F d/(|d| m_b), with d from the second end b to the first. */
        double sense[2] = {pull, -pull};
        for (int end = 0; end < 2; end++) {
            if (ends[end] < 0) /* the world */
                continue;
            for (int i = 0; i < 3; i++)
                a[3 * ends[end] + i] -= sense[end] * d[i] / s->mass[ends[end]];
        }
    }
}

/* The entry of G M^-1 G^T for unit vectors: the sum of 1/m over the points that two rods share,
 * negative where the first end of one is the second of the other. */
static double shared_inverse_mass(const system_of_rods *s, const int64_t *restrict one,
                                  const int64_t *restrict other)
{
    double shared = 0.0;
    for (int p = 0; p < 2; p++) {
        if (one[p] < 0) /* the world has infinite mass */
            continue;
        for (int q = 0; q < 2; q++) {
            if (one[p] != other[q])
                continue;
            double inverse_mass = 1.0 / s->mass[one[p]];
            if (p == q)
                shared += inverse_mass;
            else
                shared -= inverse_mass;
        }
    }
    return shared;
}

/* matrix (rods, rods) = G(d1) M^-1 G(d0)^T. */
static void set_matrix(const system_of_rods *s, const double *restrict d1,
                       const double *restrict d0)
{
    for (int64_t i = 0; i < s->rods; i++) {
        for (int64_t j = 0; j < s->rods; j++) {
            double shared = shared_inverse_mass(s, s->rod_ends + 2 * i, s->rod_ends + 2 * j);
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

/* Solves matrix solution = rhs by elimination with complete pivoting. Pivots below 1e-11 of the
 * largest belong to redundant rods, whose multipliers are set to 0: rounding leaves there 1e-16
 * times the condition number of the other rods. `unknown`: the unknown of each exchanged column. */
static void solve(const system_of_rods *s)
{
    const int64_t n = s->rods;
    double *a = s->matrix;
    double *b = s->rhs;
    double largest = 0.0;
    int64_t rank = 0;
    for (int64_t i = 0; i < n; i++) {
        s->unknown[i] = i;
        s->solution[i] = 0.0;
    }
    for (; rank < n; rank++) {
        /* The pivot: the largest entry of the rows and columns that are left. */
        int64_t row = rank;
        int64_t col = rank;
        for (int64_t i = rank; i < n; i++)
            for (int64_t j = rank; j < n; j++)
                if (fabs(a[i * n + j]) > fabs(a[row * n + col])) {
                    row = i;
                    col = j;
                }
        if (rank == 0) /* the first pivot is the largest entry */
            largest = fabs(a[row * n + col]);
        if (!(fabs(a[row * n + col]) > 1e-11 * largest)) /* the rest is redundant */
            break;
        for (int64_t j = 0; j < n; j++)
            swap(&a[row * n + j], &a[rank * n + j]);
        for (int64_t i = 0; i < n; i++)
            swap(&a[i * n + col], &a[i * n + rank]);
        swap(&b[row], &b[rank]);
        int64_t swapped = s->unknown[col];
        s->unknown[col] = s->unknown[rank];
        s->unknown[rank] = swapped;
        /* Rows below lose the pivot's column. */
        for (int64_t i = rank + 1; i < n; i++) {
            double factor = a[i * n + rank] / a[rank * n + rank];
            for (int64_t j = rank; j < n; j++)
                a[i * n + j] -= factor * a[rank * n + j];
            b[i] -= factor * b[rank];
        }
    }
    /* Back substitution, from the last row that has a pivot. */
    for (int64_t i = rank - 1; i >= 0; i--) {
        double sum = b[i];
        for (int64_t j = i + 1; j < rank; j++)
            sum -= a[i * n + j] * s->solution[s->unknown[j]];
        s->solution[s->unknown[i]] = sum / a[i * n + i];
    }
}

/* value += by, with what rounding loses kept in `low`. */
static inline void add_compensated(double *restrict value, double *restrict low, double by)
{
    dd sum = two_sum(*value, by + *low);
    *value = sum.hi;
    *low = sum.lo;
}

/* values -= scale M^-1 G(d)^T solution: impulses of the rods on both ends. */
static void apply_multipliers(const system_of_rods *s, const double *restrict d, double scale,
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
                add_compensated(&values[3 * b + i], &low[3 * b + i], change);
            }
        }
    }
}

enum { MAX_SWEEPS = 60 }; /* Newton's method needs a few, or does not converge at all */
#define ROUND_OFF 2.3e-16 /* a relative error of a length that is one rounding */
#define STALLED 1e-14     /* one within the accumulated roundings of a chain of rods */

/* Newton's method for the multipliers, G(d) M^-1 G(d0)^T lambda = (|d|^2 - l^2)/2, until the
 * lengths of the rods are correct to round-off. Returns 0, or 1 if the method does not converge. */
static int hold_lengths(const system_of_rods *s, double h, double *restrict x, double *restrict v)
{
    double worst_before = INFINITY;
    for (int sweep = 0; sweep < MAX_SWEEPS; sweep++) {
        double worst = 0.0;
        directions(s, x, s->new);
        for (int64_t r = 0; r < s->rods; r++) {
            double l = s->rod_length[r];
            double distance = sqrt(dot(s->new + 3 * r, s->new + 3 * r));
            /* (|d|^2 - l^2)/2 without cancellation. */
            s->rhs[r] = 0.5 * (distance - l) * (distance + l);
            worst = fmax(worst, fabs(distance - l) / l);
            if (!isfinite(distance)) /* it has diverged */
                return 1;
        }
        /* Converged to round-off, or to where a further sweep no longer reduces the error. */
        if (worst <= ROUND_OFF || (worst < STALLED && worst >= worst_before))
            return 0;
        worst_before = worst;
        set_matrix(s, s->new, s->old);
        solve(s);
        /* x -= M^-1 G(d0)^T lambda,  v -= 1/h M^-1 G(d0)^T lambda */
        apply_multipliers(s, s->old, 1.0, x, s->low_x);
        apply_multipliers(s, s->old, 1.0 / h, v, s->low_v);
    }
    return worst_before > STALLED;
}

/* Makes the relative velocity along every rod zero: G M^-1 G^T mu = G v, v -= M^-1 G^T mu. */
static void hold_rates(const system_of_rods *s, const double *restrict x, double *restrict v)
{
    directions(s, x, s->new);
    for (int64_t r = 0; r < s->rods; r++) {
        static const double still[3] = {0.0, 0.0, 0.0};
        double relative[3];
        difference(s->rod_ends + 2 * r, still, v, relative);
        s->rhs[r] = dot(s->new + 3 * r, relative);
    }
    set_matrix(s, s->new, s->new);
    solve(s);
    apply_multipliers(s, s->new, 1.0, v, s->low_v);
}

/* Tension (rods) [N] of the state: G M^-1 G^T T/l = G a + |v_a - v_b|^2, from d'' . d + |d'|^2 = 0.
 */
static void tension(const system_of_rods *s, const double *restrict x, const double *restrict v,
                    double *restrict out)
{
    static const double still[3] = {0.0, 0.0, 0.0};
    accelerate(s, x);
    directions(s, x, s->new);
    for (int64_t r = 0; r < s->rods; r++) {
        double pull[3], relative[3];
        difference(s->rod_ends + 2 * r, still, s->acceleration, pull);
        difference(s->rod_ends + 2 * r, still, v, relative);
        s->rhs[r] = dot(s->new + 3 * r, pull) + dot(relative, relative);
    }
    set_matrix(s, s->new, s->new);
    solve(s);
    for (int64_t r = 0; r < s->rods; r++)
        out[r] = s->solution[r] * s->rod_length[r];
}

/* v += h a. */
static void kick(const system_of_rods *s, double h, double *restrict v)
{
    for (int64_t i = 0; i < 3 * s->n; i++)
        add_compensated(&v[i], &s->low_v[i], h * s->acceleration[i]);
}

/* One step h; 0, or 1 if the rods could not be held. */
static int step(const system_of_rods *s, double h, double *restrict x, double *restrict v)
{
    directions(s, x, s->old);
    kick(s, 0.5 * h, v);
    /* Drift: x += h v. */
    for (int64_t i = 0; i < 3 * s->n; i++)
        add_compensated(&x[i], &s->low_x[i], h * v[i]);
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
                  int64_t *unknown, double *position, double *velocity, double *force)
{
    assert(n >= 1 && mass && gravity && samples >= 1 && stride >= 1);
    assert(rods == 0 || (rod_ends && rod_anchor && rod_length));
    assert(springs == 0 || (spring_ends && spring_anchor && spring_law));
    assert(work && position && velocity && force); /* `work`: 9 n + 8 rods + rods^2 doubles */
    assert(rods == 0 || unknown);
    system_of_rods s = {
        .n = n,
        .rods = rods,
        .springs = springs,
        .mass = mass,
        .gravity = gravity,
        .rod_ends = rod_ends,
        .rod_anchor = rod_anchor,
        .rod_length = rod_length,
        .spring_ends = spring_ends,
        .spring_anchor = spring_anchor,
        .spring_law = spring_law,
        .unknown = unknown,
    };
    /* The arrays lie one after the other in the work space. */
    s.acceleration = work;
    s.low_x = s.acceleration + 3 * n;
    s.low_v = s.low_x + 3 * n;
    s.old = s.low_v + 3 * n;
    s.new = s.old + 3 * rods;
    s.rhs = s.new + 3 * rods;
    s.solution = s.rhs + rods;
    s.matrix = s.solution + rods;
    /* The low parts are 0 at the start; low_x and low_v are adjacent. */
    memset(s.low_x, 0, (size_t)(6 * n) * sizeof(double));
    tension(&s, position, velocity, force);
    for (int64_t k = 1; k < samples; k++) {
        double *x = position + 3 * n * k;
        double *v = velocity + 3 * n * k;
        /* Steps are made in the row of the sample, from the state of the row before. */
        memcpy(x, x - 3 * n, (size_t)(3 * n) * sizeof(double));
        memcpy(v, v - 3 * n, (size_t)(3 * n) * sizeof(double));
        for (int64_t m = 0; m < stride; m++)
            if (step(&s, h, x, v)) /* the rods could not be held */
                return (int)k + 1;
        tension(&s, x, v, force + rods * k);
    }
    return 0;
}
