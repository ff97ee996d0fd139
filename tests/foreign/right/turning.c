/* Bodies of any moments of inertia that turn and fall freely, by several formulas: the method is
 * named by the request. Uniform gravity makes no torque about a centre. */
#include "scene.h"

/* From space to body axes (way = -1) or back (way = 1). */
static void turned(real *out, const real *q, const real *a, int way)
{
    const real u[3] = {way * q[1], way * q[2], way * q[3]};
    real t[3], s[3];
    cross(t, u, a);
    for (int k = 0; k < 3; k++)
        t[k] *= 2;
    cross(s, u, t);
    for (int k = 0; k < 3; k++)
        out[k] = a[k] + q[0] * t[k] + s[k];
}

static real gravity[3], momentum[MOST][3]; /* momentum: angular, in space axes */
static real turning[MOST][3];              /* omega in body axes */

/* omega = R J^-1 R^T L, in space axes. */
static void omega_of_momentum(real *w, const struct body *b, const real *q, const real *L)
{
    real l[3];
    turned(l, q, L, -1);
    for (int k = 0; k < 3; k++)
        l[k] /= b->J[k];
    turned(w, q, l, 1);
}

/* Euler's equations in body axes: J w' = (J w) x w; q' = q (0, w)/2. */
static void euler_rates(const struct body *b, const real *q, const real *w, real *dq, real *dw)
{
    const real L[3] = {b->J[0] * w[0], b->J[1] * w[1], b->J[2] * w[2]};
    const real half[4] = {0, w[0] / 2, w[1] / 2, w[2] / 2};
    cross(dw, L, w);
    for (int k = 0; k < 3; k++)
        dw[k] /= b->J[k];
    product(dq, q, half);
}

static void euler(int i, real h)
{
    struct body *b = &body[i];
    real dq[4], dw[3];
    euler_rates(b, b->q, turning[i], dq, dw);
    for (int k = 0; k < 4; k++)
        b->q[k] += h * dq[k];
    for (int k = 0; k < 3; k++)
        turning[i][k] += h * dw[k];
    unit_quaternion(b->q);
}

static void rk4(int i, real h)
{
    struct body *b = &body[i];
    static const real PLACE[4] = {0, 0.5, 0.5, 1};
    static const real WEIGHT[4] = {1, 2, 2, 1};
    real dq[4] = {0}, dw[3] = {0}, sum_q[4] = {0}, sum_w[3] = {0};
    for (int s = 0; s < 4; s++) {
        real q[4], w[3];
        for (int k = 0; k < 4; k++)
            q[k] = b->q[k] + h * PLACE[s] * dq[k];
        for (int k = 0; k < 3; k++)
            w[k] = turning[i][k] + h * PLACE[s] * dw[k];
        euler_rates(b, q, w, dq, dw);
        for (int k = 0; k < 4; k++)
            sum_q[k] += WEIGHT[s] * dq[k];
        for (int k = 0; k < 3; k++)
            sum_w[k] += WEIGHT[s] * dw[k];
    }
    for (int k = 0; k < 4; k++)
        b->q[k] += h * sum_q[k] / 6;
    for (int k = 0; k < 3; k++)
        turning[i][k] += h * sum_w[k] / 6;
    unit_quaternion(b->q);
}

/* An exact turn about the principal axis i: the angular momentum turns the other way in the body.
 */
static void about(struct body *b, real *w, int i, real h)
{
    const int j = (i + 1) % 3;
    const int k = (i + 2) % 3;
    const real angle = h * w[i];
    const real c = cos(angle);
    const real s = sin(angle);
    const real lj = b->J[j] * w[j];
    const real lk = b->J[k] * w[k];
    real turn[4] = {cos(angle / 2), 0, 0, 0};
    turn[1 + i] = sin(angle / 2);
    product(b->q, b->q, turn);
    w[j] = (lj * c + lk * s) / b->J[j];
    w[k] = (lk * c - lj * s) / b->J[k];
}

/* Dullweber, Leimkuhler and McLachlan 1997. */
static void splitting(int i, real h)
{
    struct body *b = &body[i];
    static const int AXIS[5] = {0, 1, 2, 1, 0};
    for (int s = 0; s < 5; s++)
        about(b, turning[i], AXIS[s], s == 2 ? h : h / 2);
    unit_quaternion(b->q);
}

/* Buss 2000, the augmented method of second order: a turn with
 * w + h/2 w' + h^2/12 (w' x w), the angular momentum stays in space. */
static void buss(int i, real h)
{
    struct body *b = &body[i];
    real w[3], dw[3], turn[3], mixed[3];
    omega_of_momentum(w, b, b->q, momentum[i]);
    cross(dw, w, momentum[i]);
    for (int k = 0; k < 3; k++)
        dw[k] = -dw[k];
    /* w' = J^-1 (L x w), J^-1 in space axes. */
    real rate[3];
    omega_of_momentum(rate, b, b->q, dw);
    cross(mixed, rate, w);
    for (int k = 0; k < 3; k++)
        turn[k] = w[k] + h / 2 * rate[k] + h * h / 12 * mixed[k];
    turn_in_space(b->q, turn, h);
}

/* Omelyan 1998: Cayley's form of a turn with the angular velocity in the middle of the step, that
 * of the mean of both attitudes, solved by iteration. */
static void omelyan(int i, real h)
{
    struct body *b = &body[i];
    enum { ITERATIONS = 100 };
    real next[4], middle[4], w[3];
    memcpy(next, b->q, sizeof next);
    for (int n = 0; n < ITERATIONS; n++) {
        real change = 0;
        for (int k = 0; k < 4; k++)
            middle[k] = (b->q[k] + next[k]) / 2;
        unit_quaternion(middle);
        omega_of_momentum(w, b, middle, momentum[i]);
        /* (1 + h w/4) over (1 - h w/4), w being the quaternion (0, w). */
        const real square = h * h / 16 * dot(w, w);
        const real below = 1 + square;
        const real turn[4] = {(1 - square) / below, h / 2 * w[0] / below, h / 2 * w[1] / below,
                              h / 2 * w[2] / below};
        real value[4];
        product(value, turn, b->q);
        for (int k = 0; k < 4; k++) {
            change = fmax(change, fabs(value[k] - next[k]));
            next[k] = value[k];
        }
        if (change == 0)
            break;
    }
    memcpy(b->q, next, sizeof next);
    unit_quaternion(b->q);
}

/* The angular momentum in space is all that moves the attitude: the explicit midpoint rule. */
static void momentum_midpoint(int i, real h)
{
    struct body *b = &body[i];
    real w[3], middle[4];
    memcpy(middle, b->q, sizeof middle);
    omega_of_momentum(w, b, b->q, momentum[i]);
    turn_in_space(middle, w, h / 2);
    omega_of_momentum(w, b, middle, momentum[i]);
    turn_in_space(b->q, w, h);
}

/* The same by the method of Runge and Kutta of order 4, on the four numbers of the attitude. */
static void momentum_rk4(int i, real h)
{
    struct body *b = &body[i];
    static const real PLACE[4] = {0, 0.5, 0.5, 1};
    static const real WEIGHT[4] = {1, 2, 2, 1};
    real dq[4] = {0}, sum[4] = {0};
    for (int s = 0; s < 4; s++) {
        real q[4], unit[4], w[3];
        for (int k = 0; k < 4; k++)
            unit[k] = q[k] = b->q[k] + h * PLACE[s] * dq[k];
        unit_quaternion(unit);
        omega_of_momentum(w, b, unit, momentum[i]);
        const real half[4] = {0, w[0] / 2, w[1] / 2, w[2] / 2};
        product(dq, half, q);
        for (int k = 0; k < 4; k++)
            sum[k] += WEIGHT[s] * dq[k];
    }
    for (int k = 0; k < 4; k++)
        b->q[k] += h * sum[k] / 6;
    unit_quaternion(b->q);
}

static const struct rule {
    const char *name;
    void (*step)(int i, real h);
    int is_in_space;
} METHODS[] = {
    {"euler", euler, 0},
    {"rk4", rk4, 0},
    {"splitting", splitting, 0},
    {"buss", buss, 1},
    {"omelyan", omelyan, 1},
    {"momentum-midpoint", momentum_midpoint, 1},
    {"momentum-rk4", momentum_rk4, 1},
};

/* The method of this request. */
static const struct rule *chosen;

/* Centres fall exactly; bodies that have moments of inertia turn by the chosen rule. */
static void fall_and_turn(double t, real h)
{
    (void)t;
    for (int i = 0; i < bodies; i++) {
        struct body *b = &body[i];
        for (int k = 0; k < 3; k++) {
            b->r[k] += h * (b->v[k] + h / 2 * gravity[k]);
            b->v[k] += h * gravity[k];
        }
        if (!(b->J[0] > 0))
            continue;
        chosen->step(i, h);
        if (chosen->is_in_space)
            omega_of_momentum(b->w, b, b->q, momentum[i]);
        else
            turned(b->w, b->q, turning[i], 1);
    }
}

static void solve(const char *method)
{
    size_t m = 0;
    while (m < sizeof METHODS / sizeof *METHODS && strcmp(METHODS[m].name, method))
        m++;
    if (m == sizeof METHODS / sizeof *METHODS)
        refuse("this method");
    chosen = &METHODS[m];
    memset(gravity, 0, sizeof gravity);
    for (int i = 0; i < elements; i++) {
        if (!is_kind(&element[i], "uniform_gravity"))
            refuse("elements other than gravity");
        memcpy(gravity, element[i].end, sizeof gravity);
    }
    for (int i = 0; i < bodies; i++) {
        struct body *b = &body[i];
        turned(turning[i], b->q, b->w, -1);
        const real L[3]
            = {b->J[0] * turning[i][0], b->J[1] * turning[i][1], b->J[2] * turning[i][2]};
        turned(momentum[i], b->q, L, 1);
    }
    const struct schedule s = asked_schedule();
    march(&s, fall_and_turn, NULL);
}
