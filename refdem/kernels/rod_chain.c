/* A planar chain of points on rigid rods that hangs from a pivot, at rest or moved along a line by
 * a law of time, in angles (Lagrange; Landau and Lifshitz, Mechanics, sec. 5).
 *
 * Points r_i = pivot + sum over j <= i of l_j (sin th_j, -cos th_j), loads mu_i = m_i + ... + m_N:
 *
 *   sum_j A_ij th_j'' = mu_i l_i G.(cos th_i, sin th_i) - sum_j B_ij th_j'^2,
 *   A_ij = mu_max(i,j) l_i l_j cos(th_i - th_j),   B_ij = mu_max(i,j) l_i l_j sin(th_i - th_j),
 *   G = gravity - pivot'',   pivot'' = -drive Omega^2 cos(Omega t + phase).
 *
 * The matrix A is factored once a step; its Taylor coefficients of higher order are moved to the
 * right side. The pivot does work at the rate F.pivot', F = sum mu_i l_i (sin th_i, -cos th_i)'' -
 * mu_1 G. State (2 N + 1): angles since the start [rad], rates [rad/s], work [J].
 */
#include <assert.h>

#include "kernels.h"
#include "taylor.h"

enum { MOST = 8 };

typedef struct {
    int n;
    const double *length, *aim; /* aim (n, 2): sine and cosine of each rod's angle at the start,
                                   from which angles count */
    double load[MOST];          /* mu */
    double gravity[2], drive[2], frequency, phase;
    double reach;      /* l_1 + ... + l_N [m] */
    double outer_rate; /* sqrt(g/l) + drive Omega/l [1/s] of the shortest rod: what gravity and the
                          pivot make of a chain at rest */
} chain;

/* Sine and cosine of th = th_0 + a from those of the angle a since the start:
 *   sin th = sin th_0 cos a + cos th_0 sin a,   cos th = cos th_0 cos a - sin th_0 sin a.
 * They are exact for a = 0, so that a chain that stands upright at rest stays so. */
static void add_start_angle(const double *restrict aim, double *restrict s, double *restrict c)
{
    double sine = *s;
    double cosine = *c;
    *s = aim[0] * cosine + aim[1] * sine;
    *c = aim[1] * cosine - aim[0] * sine;
}

/* mu_max(i,j) l_i l_j. */
static double coupling(const chain *p, int i, int j)
{
    int lower = i; /* the lower of both bobs: it and those below it move with both rods */
    if (j > i)
        lower = j;
    return p->load[lower] * p->length[i] * p->length[j];
}

/* Cholesky's factor L of a symmetric positive matrix L L^T, in its lower half, in place. */
static void factor(int n, double m[MOST][MOST])
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = m[i][j];
            for (int k = 0; k < j; k++)
                sum -= m[i][k] * m[j][k];
            if (i == j)
                m[i][j] = sqrt(sum);
            else
                m[i][j] = sum / m[j][j];
        }
    }
}

/* b = (L L^T)^-1 b: L z = b forwards, L^T x = z backwards. */
static void solve(int n, double m[MOST][MOST], double *b)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++)
            b[i] -= m[i][k] * b[k];
        b[i] /= m[i][i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            b[i] -= m[k][i] * b[k];
        b[i] /= m[i][i];
    }
}

/* G = gravity + drive Omega^2 cos(Omega t + phase) and the pivot's velocity -drive Omega sin(Omega
 * t + phase) along both axes of the plane, as series about a time. `power` is Omega^(k+1)/k!; the
 * derivatives of cos are -sin, -cos, sin, cos. */
static void expand_pivot(const chain *p, dd time, series *g, series *velocity)
{
    double cosine, sine;
    double power = p->frequency;
    turned(dd_add(dd_mul(dd_of(p->frequency), time), dd_of(p->phase)), &cosine, &sine);
    double derivative[4] = {cosine, -sine, -cosine, sine};
    for (int k = 0; k <= TERMS; k++) {
        for (int axis = 0; axis < 2; axis++) {
            double constant = 0.0;
            if (k == 0)
                constant = p->gravity[axis];
            g[axis][k] = constant + p->drive[axis] * p->frequency * power * derivative[k % 4];
        }
        for (int axis = 0; axis < 2; axis++)
            velocity[axis][k] = p->drive[axis] * power * derivative[(k + 1) % 4];
        power *= p->frequency / (k + 1);
    }
}

/* Scales of angles, rates and work, relative to which their last coefficients determine the step.
 * Angles alone would not suffice: a pivot of small amplitude a and high frequency moves them by
 * only a/l, and its work oscillates at twice its frequency. */
static void sizes(const chain *p, series *y, double *scale)
{
    double rate = 0.0;
    for (int i = 0; i < p->n; i++)
        rate = fmax(rate, fabs(y[p->n + i][0]));
    rate += p->outer_rate;
    /* rate = max |th_i'| + outer_rate, speed = (l_1 + .. + l_N) rate; the work over mu_1
     * speed^2. */
    double speed = p->reach * rate;
    for (int i = 0; i < p->n; i++) {
        scale[i] = 1.0;
        scale[p->n + i] = rate;
    }
    scale[2 * p->n] = p->load[0] * speed * speed;
}

/* Coefficients 1 to TERMS of the state, order by order k: sines and cosines, A and B, the right
 * side, th'' by the factored A_0, the work. */
static void expand(const void *system, dd time, series *y, double *scale)
{
    const chain *p = system;
    series g[2], pivot_velocity[2], pivot_force[2], sine[MOST], cosine[MOST], rate_squared[MOST],
        acceleration[MOST], b_matrix[MOST][MOST], a_matrix[MOST][MOST];
    double factored[MOST][MOST], right_side[MOST];
    int n = p->n;
    expand_pivot(p, time, g, pivot_velocity);
    for (int k = 0; k < TERMS; k++) {
        for (int i = 0; i < n; i++) {
            sine_cosine(y[i], y[n + i], sine[i], cosine[i], k);
            if (k == 0)
                add_start_angle(p->aim + 2 * i, &sine[i][0], &cosine[i][0]);
            rate_squared[i][k] = cauchy(y[n + i], y[n + i], k);
        }
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) {
                /* A_ij = mu l_i l_j (cos th_i cos th_j + sin th_i sin th_j), B_ij = mu l_i l_j
                 * (sin th_i cos th_j - cos th_i sin th_j), mu of max(i, j); A_ii = mu_i l_i^2,
                 * B_ii = 0. */
                double weight = coupling(p, i, j);
                if (i != j) { /* weight cos and sin of the angle between the rods */
                    a_matrix[i][j][k]
                        = weight * (cauchy(cosine[i], cosine[j], k) + cauchy(sine[i], sine[j], k));
                    b_matrix[i][j][k]
                        = weight * (cauchy(sine[i], cosine[j], k) - cauchy(cosine[i], sine[j], k));
                    continue;
                }
                a_matrix[i][i][k] = 0.0;
                b_matrix[i][i][k] = 0.0;
                if (k == 0)
                    a_matrix[i][i][k] = weight;
            }
        }
        for (int i = 0; i < n; i++) {
            /* mu_i l_i G.(cos th_i, sin th_i). */
            right_side[i] = p->load[i] * p->length[i]
                            * (cauchy(g[0], cosine[i], k) + cauchy(g[1], sine[i], k));
            /* - B th'^2, and - A th'' but for A_0 of this order. */
            for (int j = 0; j < n; j++)
                right_side[i] -= cauchy(b_matrix[i][j], rate_squared[j], k)
                                 + cauchy_rest(a_matrix[i][j], acceleration[j], k);
        }
        if (k == 0) { /* A_0, with which every order is solved */
            for (int i = 0; i < n; i++)
                for (int j = 0; j < n; j++)
                    factored[i][j] = a_matrix[i][j][0];
            factor(n, factored);
        }
        solve(n, factored, right_side);
        for (int i = 0; i < n; i++) {
            acceleration[i][k] = right_side[i];
            y[i][k + 1] = y[n + i][k] / (k + 1);
            y[n + i][k + 1] = right_side[i] / (k + 1);
        }
        /* The work of the pivot, W' = F.pivot', with
         *   F = sum mu_i l_i (th'' cos th - th'^2 sin th, th'' sin th + th'^2 cos th) - mu_1 G. */
        for (int axis = 0; axis < 2; axis++)
            pivot_force[axis][k] = -p->load[0] * g[axis][k];
        for (int i = 0; i < n; i++) {
            double weight = p->load[i] * p->length[i];
            pivot_force[0][k]
                += weight
                   * (cauchy(acceleration[i], cosine[i], k) - cauchy(rate_squared[i], sine[i], k));
            pivot_force[1][k]
                += weight
                   * (cauchy(acceleration[i], sine[i], k) + cauchy(rate_squared[i], cosine[i], k));
        }
        y[2 * n][k + 1] = (cauchy(pivot_force[0], pivot_velocity[0], k)
                           + cauchy(pivot_force[1], pivot_velocity[1], k))
                          / (k + 1);
    }
    sizes(p, y, scale);
}

int refdem_rod_chain(int64_t rods, const double *length, const double *aim, const double *mass,
                     const double *gravity, const double *drive, double frequency, double phase,
                     int64_t samples, const double *t, double *out)
{
    assert(length && aim && mass && gravity && drive);
    assert(samples >= 1 && t && out); /* (samples), (samples, 2 rods + 1) doubles */
    chain p
        = {.n = (int)rods, .length = length, .aim = aim, .frequency = frequency, .phase = phase};
    series y[2 * MOST + 1];
    double load = 0.0;
    double shortest = INFINITY;
    if (rods < 1 || rods > MOST) /* there is no room for them */
        return 1;
    for (int i = p.n - 1; i >= 0; i--) {
        /* mu_i = m_i + .. + m_N. */
        load += mass[i];
        p.load[i] = load;
        p.reach += length[i];
        shortest = fmin(shortest, length[i]);
    }
    for (int axis = 0; axis < 2; axis++) {
        p.gravity[axis] = gravity[axis];
        p.drive[axis] = drive[axis];
    }
    /* outer_rate = sqrt(|g|/l) + |drive| |Omega|/l of the shortest rod. */
    double pull = hypot(gravity[0], gravity[1]);
    double pivot_speed = hypot(drive[0], drive[1]) * fabs(frequency);
    p.outer_rate = sqrt(pull / shortest) + pivot_speed / shortest;
    return taylor_run(expand, &p, 2 * p.n + 1, y, samples, t, out);
}
