/* One free rigid body, step by step: by a splitting into exact rotations, by the classical
 * Runge-Kutta method and by Gear's, for the angular momentum l in body axes and the attitude q, or
 * Euler's angles in its place:
 *
 *   l' = l x w,   q' = q w/2,   w = J^-1 l.
 *
 * The splitting separates a part that commutes with all others: with J_m the middle moment,
 *
 *   H = |l|^2/(2 J_m) + sum of l_i^2/2 (1/J_i - 1/J_m).
 *
 * The first part turns the body about L in space by |L| t/J_m, in one rotation for any time; of
 * the sum two axes are left, and turn in each other's flow: a half step, a whole one, a half
 * (Fasso, J. Comput. Phys. 189 (2003) 527). A splitting into rotations about all three axes would
 * have an error that grows as J_3/J_1: for a needle two large rotations nearly cancel.
 */
#include <assert.h>

#include <string.h>

#include "double_double.h"
#include "gear.h"
#include "kernels.h"
#include "quaternion.h"

/* Angular momentum l in body axes and the attitude q, each with the rounding errors of its sums. */
typedef struct {
    double l[3], l_low[3], q[4], q_low[4];
} spinning;

/* value += by, with what rounding loses kept in `low`. */
static inline void add_compensated(double *restrict value, double *restrict low, double by)
{
    dd sum = two_sum(*value, by + *low);
    *value = sum.hi;
    *low = sum.lo;
}

/* The exact flow of l_i^2/(2 J_i) over h, rate = h/J_i: the body turns about axis i by the angle =
 * rate l_i, and l in body axes by -angle. As increments, so that |l| and |q| stay: with s =
 * sin(angle/2), c = cos(angle/2), cos(angle) - 1 = -2 s^2 and c - 1 = -s^2/(1 + c). */
static inline void turn_about(spinning *b, int i, double rate)
{
    int j = (i + 1) % 3;
    int k = (i + 2) % 3;
    double half = 0.5 * rate * b->l[i];
    /* dl_j = sin(angle) l_k - (1 - cos(angle)) l_j,  dl_k = -sin(angle) l_j - (1 - cos(angle)) l_k,
     * dq = q (c - 1, s e_i), with the unit vector e_i. */
    double s = sin(half);
    double c = cos(half);
    double c_minus_1 = c - 1.0;
    if (c > 0.0) /* without cancellation */
        c_minus_1 = -s * s / (1.0 + c);
    /* sin(angle) = 2 s c and 1 - cos(angle) = 2 s^2. */
    double sine_angle = 2.0 * s * (1.0 + c_minus_1);
    double one_minus_cosine = 2.0 * s * s;
    double lj = b->l[j];
    double lk = b->l[k];
    add_compensated(&b->l[j], &b->l_low[j], sine_angle * lk - one_minus_cosine * lj);
    add_compensated(&b->l[k], &b->l_low[k], -sine_angle * lj - one_minus_cosine * lk);
    double w = b->q[0];
    double x = b->q[1 + i];
    double y = b->q[1 + j];
    double z = b->q[1 + k];
    add_compensated(&b->q[0], &b->q_low[0], c_minus_1 * w - s * x);
    add_compensated(&b->q[1 + i], &b->q_low[1 + i], c_minus_1 * x + s * w);
    add_compensated(&b->q[1 + j], &b->q_low[1 + j], c_minus_1 * y + s * z);
    add_compensated(&b->q[1 + k], &b->q_low[1 + k], c_minus_1 * z - s * y);
}

/* The state from attitude and omega in space axes: q = attitude/|attitude|, l = J omega_body. */
static void begin(spinning *b, const double *restrict inertia, const double *restrict attitude,
                  const double *restrict omega)
{
    dd q[4], w[3];
    quaternion_body(attitude, omega, q, w);
    for (int i = 0; i < 4; i++) {
        b->q[i] = q[i].hi;
        b->q_low[i] = q[i].lo;
    }
    for (int i = 0; i < 3; i++) {
        dd l = dd_scale(w[i], inertia[i]);
        b->l[i] = l.hi;
        b->l_low[i] = l.lo;
    }
}

/* Writes the unit attitude and omega in space axes, q (J^-1 l) q*; an axis without inertia does not
 * turn. */
static void finish(const spinning *b, const double *restrict inertia, double *restrict attitude,
                   double *restrict omega)
{
    double w[3];
    for (int i = 0; i < 3; i++) {
        w[i] = 0.0;
        if (inertia[i] > 0.0)
            w[i] = b->l[i] / inertia[i];
    }
    for (int i = 0; i < 4; i++)
        attitude[i] = b->q[i];
    quaternion_normalised(attitude);
    quaternion_rotated(attitude, w, omega);
}

/* The axes of the least and of the largest moment. */
static void find_extremes(const double *restrict inertia, int *least, int *most)
{
    *least = 0;
    *most = 0;
    for (int i = 1; i < 3; i++) {
        if (inertia[i] < inertia[*least])
            *least = i;
        if (inertia[i] >= inertia[*most])
            *most = i;
    }
}

/* h (1/J_i - 1/J_m); an axis without inertia does not turn. */
static double rate_about(double inertia, double middle, double h)
{
    if (!(inertia > 0.0))
        return 0.0;
    return h * ((middle - inertia) / inertia) / middle;
}

/* The turn about the angular momentum: its axis in space, its rate |L|/J_m [rad/s]. */
typedef struct {
    double axis[3];
    dd rate;
} precession;

/* The turn about L of body b with the middle moment J_m. */
static precession precession_of(const spinning *b, double middle)
{
    dd w[3];
    double direction[3];
    precession p;
    for (int i = 0; i < 3; i++) {
        /* w = l/J_m; the rate is |w|, and the axis in space is q (w/|w|) q*. */
        w[i] = dd_of(0.0); /* nothing turns without inertia */
        if (middle > 0.0)
            w[i] = dd_div(two_sum(b->l[i], b->l_low[i]), dd_of(middle));
    }
    p.rate = dd_sqrt(dd_dot(w, w));
    for (int i = 0; i < 3; i++) {
        direction[i] = 0.0; /* what does not turn has no axis */
        if (p.rate.hi > 0.0)
            direction[i] = w[i].hi / p.rate.hi;
    }
    quaternion_rotated(b->q, direction, p.axis);
    return p;
}

/* Writes the state at a sample, `since` the start: the remaining half of the outer turn, then the
 * turn about the angular momentum in space, q = (cos a, sin a axis) q, a = rate since/2. */
static void record(const spinning *now, int axis, double last_turn, const precession *p, dd since,
                   const double *restrict inertia, double *restrict attitude,
                   double *restrict omega)
{
    spinning b = *now;
    double turn[4], inner[4], sine;
    turn_about(&b, axis, last_turn);
    memcpy(inner, b.q, sizeof inner);
    turned(dd_scale(dd_mul(p->rate, since), 0.5), turn, &sine);
    for (int i = 0; i < 3; i++)
        turn[i + 1] = sine * p->axis[i];
    quaternion_product(turn, inner, b.q);
    finish(&b, inertia, attitude, omega);
}

int refdem_rigid_body_splitting(const double *inertia, const double *attitude, const double *omega,
                                double h, int64_t samples, int64_t stride, double *out_attitude,
                                double *out_omega)
{
    assert(inertia && attitude && omega && samples >= 1 && stride >= 0);
    assert(out_attitude && out_omega); /* (samples, 4), (samples, 3) doubles */
    spinning b;
    int least, most;
    begin(&b, inertia, attitude, omega);
    finish(&b, inertia, out_attitude, out_omega);
    find_extremes(inertia, &least, &most);
    /* The angles of the turns are these rates times l_i: h (1/J_i - 1/J_m), with the axis i of the
     * largest moment inside and that of the least one outside: U(h/2) W(h) U(h/2). */
    double middle = inertia[3 - least - most];
    double inner = rate_about(inertia[most], middle, h);
    double outer = rate_about(inertia[least], middle, h);
    precession p = precession_of(&b, middle);
    turn_about(&b, least, 0.5 * outer);
    /* The half turns at the end of a step and at the start of the next one are made as one; a
     * sample adds the last half to a copy. */
    for (int64_t k = 1; k < samples; k++) {
        for (int64_t n = 0; n < stride; n++) {
            if (k > 1 || n > 0) /* the very first half turn has been made */
                turn_about(&b, least, outer);
            turn_about(&b, most, inner);
        }
        dd since = two_product(h, (double)(k * stride));
        record(&b, least, 0.5 * outer, &p, since, inertia, out_attitude + 4 * k, out_omega + 3 * k);
    }
    return 0;
}

/* dy for y = (q, l): q' = q w/2, l' = l x w, w = per l with per = 1/J. The variable w holds (0,
 * w/2).
 */
static void rates(const double *restrict y, const double *restrict per, double *restrict dy)
{
    const double *l = y + 4;
    double w[4] = {0.0, 0.5 * per[0] * l[0], 0.5 * per[1] * l[1], 0.5 * per[2] * l[2]};
    quaternion_product(y, w, dy);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        int k = (i + 2) % 3;
        dy[4 + i] = 2.0 * (l[j] * w[1 + k] - l[k] * w[1 + j]);
    }
}

/* Writes the rates dy of a state y, of a body with per = 1/J. */
typedef void rates_of(const double *restrict y, const double *restrict per, double *restrict dy);

/* One step of the classical method of order 4 (Kutta 1901) for `count` values, at most 7: y += h/6
 * (k1 + 2 k2 + 2 k3 + k4). */
static inline void rk4_step(rates_of *rate, int count, double *restrict y, double *restrict low,
                            const double *restrict per, double h)
{
    double k[4][7], stage[7];
    static const double fraction[4] = {0.0, 0.5, 0.5, 1.0};
    rate(y, per, k[0]);
    for (int s = 1; s < 4; s++) {
        for (int i = 0; i < count; i++)
            stage[i] = fma(h * fraction[s], k[s - 1][i], y[i]);
        rate(stage, per, k[s]);
    }
    for (int i = 0; i < count; i++)
        add_compensated(&y[i], &low[i],
                        h / 6.0 * ((k[0][i] + k[3][i]) + 2.0 * (k[1][i] + k[2][i])));
}

/* Brings |q| back to 1: with excess e = (|q|^2 - 1)/2, q -= (e - 3/2 e^2) q. */
static inline void restore_length(double *restrict q, double *restrict low)
{
    /* |q| = sqrt(1 + 2 e), so that 1/|q| = 1 - e + 3/2 e^2 up to e^3. */
    double excess = 0.5 * ((q[0] * q[0] + q[1] * q[1] - 1.0) + (q[2] * q[2] + q[3] * q[3]));
    for (int i = 0; i < 4; i++)
        add_compensated(&q[i], &low[i], -excess * (1.0 - 1.5 * excess) * q[i]);
}

/* 1/J_i, or 0 about an axis without inertia, about which nothing turns. */
static void invert(const double *restrict inertia, double *restrict per)
{
    for (int i = 0; i < 3; i++) {
        per[i] = 0.0;
        if (inertia[i] > 0.0)
            per[i] = 1.0 / inertia[i];
    }
}

int refdem_rigid_body_rk4(const double *inertia, const double *attitude, const double *omega,
                          double h, int64_t samples, int64_t stride, double *out_attitude,
                          double *out_omega)
{
    assert(inertia && attitude && omega && samples >= 1 && stride >= 0);
    assert(out_attitude && out_omega); /* (samples, 4), (samples, 3) doubles */
    spinning b;
    double y[7], low[7], per[3];
    begin(&b, inertia, attitude, omega);
    finish(&b, inertia, out_attitude, out_omega);
    invert(inertia, per);
    for (int i = 0; i < 3; i++) {
        y[4 + i] = b.l[i];
        low[4 + i] = b.l_low[i];
    }
    for (int i = 0; i < 4; i++) {
        y[i] = b.q[i];
        low[i] = b.q_low[i];
    }
    for (int64_t k = 1; k < samples; k++) {
        for (int64_t n = 0; n < stride; n++) {
            rk4_step(rates, 7, y, low, per, h);
            restore_length(y, low);
        }
        memcpy(b.q, y, sizeof b.q);
        memcpy(b.l, y + 4, sizeof b.l);
        finish(&b, inertia, out_attitude + 4 * k, out_omega + 3 * k);
    }
    return 0;
}

/* The frames of Euler's angles, each as the quaternion that turns it into space: space itself, and
 * space with its axes renamed (120 degrees about (1, 1, 1)), so that z of the frame is x of space.
 */
static const double FRAME[2][4] = {{1.0, 0.0, 0.0, 0.0}, {0.5, 0.5, 0.5, 0.5}};

/* dy for y = (phi, theta, psi, l), angles about z, x, z from a frame to the body. With w = per l in
 * body axes,
 *
 *   w_1 = phi' sin theta sin psi + theta' cos psi,
 *   w_2 = phi' sin theta cos psi - theta' sin psi,
 *   w_3 = phi' cos theta + psi',
 *
 * solved for the rates of the angles, which the poles sin theta = 0 do not allow; l' = l x w. */
static void angle_rates(const double *restrict y, const double *restrict per, double *restrict dy)
{
    double cosine = cos(y[1]);
    double sine = sin(y[1]);
    double cosine_psi = cos(y[2]);
    double sine_psi = sin(y[2]);
    const double *l = y + 3;
    double w[3] = {per[0] * l[0], per[1] * l[1], per[2] * l[2]};
    dy[0] = (w[0] * sine_psi + w[1] * cosine_psi) / sine;
    dy[1] = w[0] * cosine_psi - w[1] * sine_psi;
    dy[2] = w[2] - dy[0] * cosine;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        int k = (i + 2) % 3;
        dy[3 + i] = l[j] * w[k] - l[k] * w[j];
    }
}

/* The attitude of angles in a frame: (1.76) to (1.79), then the turn of the frame into space. */
static void angles_to_attitude(const double *restrict angle, int frame, double *restrict q)
{
    /* With S = (phi + psi)/2 and D = (phi - psi)/2: q = (cos(theta/2) cos S, sin(theta/2) cos D,
     * sin(theta/2) sin D, cos(theta/2) sin S). */
    double half_sum = 0.5 * (angle[0] + angle[2]);
    double half_difference = 0.5 * (angle[0] - angle[2]);
    double cosine = cos(0.5 * angle[1]);
    double sine = sin(0.5 * angle[1]);
    double in_frame[4] = {cosine * cos(half_sum), sine * cos(half_difference),
                          sine * sin(half_difference), cosine * sin(half_sum)};
    quaternion_product(FRAME[frame], in_frame, q);
}

/* The angles of an attitude in a frame, phi and psi in [-2 pi, 2 pi]. */
static void attitude_to_angles(const double *restrict q, int frame, double *restrict angle)
{
    const double *turn = FRAME[frame];
    double back[4] = {turn[0], -turn[1], -turn[2], -turn[3]};
    double p[4];
    quaternion_product(back, q, p);
    /* With p = (cos(theta/2) cos S, sin(theta/2) cos D, sin(theta/2) sin D, cos(theta/2) sin S) in
     * the frame, S = (phi + psi)/2 and D = (phi - psi)/2. */
    double half_sum = atan2(p[3], p[0]);
    double half_difference = atan2(p[2], p[1]);
    angle[0] = half_sum + half_difference;
    angle[1] = 2.0 * atan2(hypot(p[1], p[2]), hypot(p[0], p[3]));
    angle[2] = half_sum - half_difference;
}

/* The frame whose pole is at least 45 degrees from the body's z axis n: space while n_z^2 <= 1/2,
 * else the other one, whose y axis is z of space. In a frame n = (sin phi sin theta, -cos phi sin
 * theta, cos theta). */
static int frame_away_from_pole(const double *angle, int frame)
{
    double n_z = cos(angle[1]);
    if (frame == 1)
        n_z = -cos(angle[0]) * sin(angle[1]);
    return n_z * n_z > 0.5;
}

/* Replaces the angles by those in the other frame where this frame is close to its pole. The change
 * is made between two steps and exactly up to round-off: every step is then a step of the method in
 * coordinates that are smooth there, so that its order is preserved. */
static void change_frame(double *restrict y, double *restrict low, int *frame)
{
    int next = frame_away_from_pole(y, *frame);
    if (next == *frame)
        return;
    double q[4];
    angles_to_attitude(y, *frame, q);
    attitude_to_angles(q, next, y);
    memset(low, 0, 3 * sizeof *low);
    *frame = next;
}

int refdem_rigid_body_euler_angles(const double *inertia, const double *attitude,
                                   const double *omega, double h, int64_t samples, int64_t stride,
                                   double *out_attitude, double *out_omega)
{
    assert(inertia && attitude && omega && samples >= 1 && stride >= 0);
    assert(out_attitude && out_omega); /* (samples, 4), (samples, 3) doubles */
    spinning b;
    double y[6], per[3];
    double low[6] = {0.0};
    int frame = 0;
    begin(&b, inertia, attitude, omega);
    finish(&b, inertia, out_attitude, out_omega);
    invert(inertia, per);
    attitude_to_angles(b.q, frame, y);
    memcpy(y + 3, b.l, sizeof b.l);
    memcpy(low + 3, b.l_low, sizeof b.l_low);
    for (int64_t k = 1; k < samples; k++) {
        for (int64_t n = 0; n < stride; n++) {
            change_frame(y, low, &frame);
            rk4_step(angle_rates, 6, y, low, per, h);
        }
        angles_to_attitude(y, frame, b.q);
        memcpy(b.l, y + 3, sizeof b.l);
        finish(&b, inertia, out_attitude + 4 * k, out_omega + 3 * k);
    }
    return 0;
}

/* Rates of omega in body axes from Euler's equations, J_i w_i' = (J_j - J_k) w_j w_k, with the
 * factor w_j of `a` and the factor w_k of `b`. */
static void body_rates(const double *restrict inertia, const double *restrict a,
                       const double *restrict b, double *restrict rate)
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        int k = (i + 2) % 3;
        rate[i] = (inertia[j] - inertia[k]) / inertia[i] * (a[j] * b[k]);
    }
}

/* w = 2 q^-1 q': the rate of ln |q|^2, which vanishes but for errors, and omega in body axes. */
static void body_omega(const double *restrict q, const double *restrict dq, double *restrict w)
{
    double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    double back[4] = {q[0], -q[1], -q[2], -q[3]};
    quaternion_product(back, dq, w);
    for (int i = 0; i < 4; i++)
        w[i] *= 2.0 / square;
}

/* q'' = q' w/2 + q w'/2 of a free body with the moments `system` (3). With all four parts of w, so
 * that (q^-1 q')' = w'/2 whatever |q| is: without the first, a length that drifts at the rate s
 * would slow omega by s omega. */
static void quaternion_acceleration(void *system, const double *q, const double *dq, double *ddq)
{
    double w[4];
    double dw[4] = {0.0};
    double by_w[4], by_dw[4];
    body_omega(q, dq, w);
    body_rates(system, w + 1, w + 1, dw + 1);
    quaternion_product(dq, w, by_w);
    quaternion_product(q, dw, by_dw);
    for (int i = 0; i < 4; i++)
        ddq[i] = 0.5 * (by_w[i] + by_dw[i]);
}

/* Fills Nordsieck's rows h^i q_i with Taylor's coefficients from the products (Cauchy) in
 *   (n + 1) q_(n+1) = sum of q_m w_(n-m)/2,   (n + 1) w_(n+1) = sum of J^-1 (J w_m x w_(n-m)). */
static void fill_rows(gear *g, const double *restrict inertia, const spinning *b, double h)
{
    double w[MOST_VALUES][4] = {{0.0}};
    double q[MOST_VALUES][4] = {{0.0}};
    double term[4];
    /* w_0 = J^-1 l and q_0 = q; row n is h^n q_n. */
    double power = 1.0;
    for (int i = 0; i < 3; i++)
        w[0][1 + i] = b->l[i] / inertia[i];
    memcpy(q[0], b->q, sizeof b->q);
    for (int n = 0; n + 1 < g->values; n++) {
        for (int m = 0; m <= n; m++) {
            quaternion_product(q[m], w[n - m], term);
            for (int i = 0; i < 4; i++)
                q[n + 1][i] += 0.5 * term[i] / (n + 1);
            body_rates(inertia, w[m] + 1, w[n - m] + 1, term + 1);
            for (int i = 1; i < 4; i++)
                w[n + 1][i] += term[i] / (n + 1);
        }
    }
    for (int n = 0; n < g->values; n++, power *= h)
        for (int i = 0; i < 4; i++)
            g->row[4 * n + i] = power * q[n][i];
}

int refdem_rigid_body_gear(const double *inertia, const double *attitude, const double *omega,
                           int values, const double *corrector, double h, int64_t samples,
                           int64_t stride, double *out_attitude, double *out_omega)
{
    assert(inertia && attitude && omega && corrector && samples >= 1 && stride >= 0);
    assert(values >= 3 && values <= MOST_VALUES);
    assert(out_attitude && out_omega); /* (samples, 4), (samples, 3) doubles */
    enum { WORK = (MOST_VALUES + 2 * COMPENSATED + 3) * 4 };
    double work[WORK];
    double moments[3] = {inertia[0], inertia[1], inertia[2]};
    spinning b;
    begin(&b, inertia, attitude, omega);
    finish(&b, inertia, out_attitude, out_omega);
    gear g = gear_in(work, values, 4, corrector);
    fill_rows(&g, inertia, &b, h);
    for (int64_t k = 1; k < samples; k++) {
        for (int64_t n = 0; n < stride; n++)
            gear_step(&g, h, quaternion_acceleration, moments);
        /* Nordsieck's rows: r_0 = q, r_1 = h q'; then w = 2 q^-1 q', and omega = q w q* with
         * q/|q|. */
        double dq[4], w[4];
        double *q = out_attitude + 4 * k;
        for (int i = 0; i < 4; i++) {
            q[i] = g.row[i];
            dq[i] = g.row[4 + i] / h;
        }
        body_omega(q, dq, w);
        quaternion_normalised(q);
        quaternion_rotated(q, w + 1, out_omega + 3 * k);
    }
    return 0;
}
