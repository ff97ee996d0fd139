/* Soft bodies by methods that look back over earlier steps, and by implicit methods of structural
 * dynamics: the method is named by the request.
 *
 * Places r and velocities v obey r'' = a(t, r, v); the whole state y obeys y' = f(t, y). A prime
 * below marks the end of a step of length h, an index -1 the step before. */
#include "runge_kutta.h"

/* One vector a body. */
typedef real vectors[MOST][3];

/* Steps taken since the start, as far as a method has to know. */
static int known;

/* The acceleration of every body where it is now. */
static void accelerations(double t, vectors a)
{
    forces(t);
    for (int i = 0; i < bodies; i++)
        for (int k = 0; k < 3; k++)
            a[i][k] = body[i].f[k] / body[i].m;
}

/* Attitudes after a step without torques: only friction turns a sphere. */
static void turn(real h)
{
    for (int i = 0; i < bodies; i++)
        turn_in_space(body[i].q, body[i].w, h);
}

/* Stoermer 1907: places follow from places alone.
 *
 *     r'   = 2 r - r_-1 + h^2 a(r)
 *     v'   = (r' - r)/h + h a(r')/2
 *     r_-1 = r - h v + h^2 a(r)/2          at the start
 *
 * The last two lines are inverse to each other: a place and a velocity are the complete state. The
 * difference of two places loses digits, so momentum is not conserved to round-off. */
static void stoermer(double t, real h)
{
    static vectors before, a;
    accelerations(t, a);
    for (int i = 0; i < bodies; i++)
        for (int k = 0; k < 3; k++) {
            const real r = body[i].r[k];
            if (known == 0)
                before[i][k] = r - h * body[i].v[k] + h * h / 2 * a[i][k];
            body[i].r[k] = 2 * r - before[i][k] + h * h * a[i][k];
            before[i][k] = r;
        }
    known = 1;
    accelerations(t + h, a);
    for (int i = 0; i < bodies; i++)
        for (int k = 0; k < 3; k++)
            body[i].v[k] = (body[i].r[k] - before[i][k]) / h + h / 2 * a[i][k];
    turn(h);
}

/* The acceleration one step before the start, from a Taylor step back. */
static void acceleration_before(double t, real h, const vectors a, vectors before)
{
    static struct body start[MOST];
    memcpy(start, body, sizeof start);
    for (int i = 0; i < bodies; i++)
        for (int k = 0; k < 3; k++) {
            body[i].r[k] += -h * body[i].v[k] + h * h / 2 * a[i][k];
            body[i].v[k] -= h * a[i][k];
        }
    accelerations(t - h, before);
    memcpy(body, start, sizeof start);
}

/* Beeman 1976: the places of Verlet, with better velocities.
 *
 *     r' = r + h v + h^2 (4 a - a_-1)/6
 *     v' = v + h (3 a - a_-1)/2            predicted, for forces that depend on velocities
 *     v' = v + h (2 a' + 5 a - a_-1)/6     corrected */
static void beeman(double t, real h)
{
    enum { CORRECTIONS = 3 };
    static vectors before, a, next;
    static struct body start[MOST];
    accelerations(t, a);
    if (known == 0)
        acceleration_before(t, h, a, before);
    known = 1;
    memcpy(start, body, sizeof start);
    for (int i = 0; i < bodies; i++)
        for (int k = 0; k < 3; k++) {
            body[i].r[k] += h * body[i].v[k] + h * h / 6 * (4 * a[i][k] - before[i][k]);
            body[i].v[k] += h / 2 * (3 * a[i][k] - before[i][k]);
        }
    turn(h);
    const int corrections = is_velocity_in_forces() ? CORRECTIONS : 1;
    for (int n = 0; n < corrections; n++) {
        accelerations(t + h, next);
        for (int i = 0; i < bodies; i++)
            for (int k = 0; k < 3; k++) {
                const real sum = 2 * next[i][k] + 5 * a[i][k] - before[i][k];
                body[i].v[k] = start[i].v[k] + h / 6 * sum;
            }
    }
    memcpy(before, a, sizeof before);
}

/* The weights of generalized-alpha. */
struct alpha {
    real mass, force, beta, gamma;
};

/* Newmark 1959 and Chung and Hulbert 1993, solved by iteration for the acceleration a' at the end,
 * from the acceleration a that the last step has left:
 *
 *     r' = r + h v + h^2 ((1/2 - beta) a + beta a')
 *     v' = v + h ((1 - gamma) a + gamma a')
 *     (1 - alpha_m) a' + alpha_m a = force/mass at the time, the place and the velocity between
 *                                    start and end with the weights alpha_f and 1 - alpha_f */
static void alpha_step(const struct alpha *alpha, double t, real h, vectors a)
{
    enum { ITERATIONS = 200 };
    static struct body start[MOST], end[MOST];
    static vectors next, between;
    memcpy(start, body, sizeof start);
    memcpy(next, a, sizeof next);
    const real late = 1 - alpha->force;
    real change = 1;
    for (int n = 0; n < ITERATIONS && change > 0; n++) {
        change = 0;
        for (int i = 0; i < bodies; i++)
            for (int k = 0; k < 3; k++) {
                const real r = start[i].r[k];
                const real v = start[i].v[k];
                const real of_place = (0.5 - alpha->beta) * a[i][k] + alpha->beta * next[i][k];
                const real of_velocity = (1 - alpha->gamma) * a[i][k] + alpha->gamma * next[i][k];
                end[i].r[k] = r + h * v + h * h * of_place;
                end[i].v[k] = v + h * of_velocity;
                body[i].r[k] = late * end[i].r[k] + alpha->force * r;
                body[i].v[k] = late * end[i].v[k] + alpha->force * v;
            }
        accelerations(t + late * h, between);
        for (int i = 0; i < bodies; i++)
            for (int k = 0; k < 3; k++) {
                const real value = (between[i][k] - alpha->mass * a[i][k]) / (1 - alpha->mass);
                change = fmax(change, fabs(value - next[i][k]));
                next[i][k] = value;
            }
    }
    for (int i = 0; i < bodies; i++) {
        memcpy(body[i].r, end[i].r, sizeof body[i].r);
        memcpy(body[i].v, end[i].v, sizeof body[i].v);
    }
    turn(h);
    memcpy(a, next, sizeof next);
}

/* Newmark with beta = 1/4 and gamma = 1/2, which is the trapezoidal rule: of one step. */
static void newmark(double t, real h)
{
    static const struct alpha weights = {.mass = 0, .force = 0, .beta = 0.25, .gamma = 0.5};
    static vectors a;
    accelerations(t, a);
    alpha_step(&weights, t, h, a);
}

/* Generalized-alpha, whose acceleration is not that of the forces: it remembers its own.
 *
 *     alpha_m = (2 rho - 1)/(rho + 1),   alpha_f = rho/(rho + 1)
 *     gamma = 1/2 - alpha_m + alpha_f,   beta = (1 - alpha_m + alpha_f)^2/4
 *
 * rho is the spectral radius at infinite frequency. */
static void generalized_alpha(double t, real h)
{
    static vectors a;
    const real rho = 0.8;
    const real mass = (2 * rho - 1) / (rho + 1);
    const real force = rho / (rho + 1);
    const real shift = force - mass;
    const real beta = (1 + shift) * (1 + shift) / 4;
    const real gamma = 0.5 + shift;
    const struct alpha weights = {.mass = mass, .force = force, .beta = beta, .gamma = gamma};
    if (known == 0)
        accelerations(t, a);
    known = 1;
    alpha_step(&weights, t, h, a);
}

/* Rates f of the earlier steps, the last one first. */
enum { KEPT = 3 };
static real past[KEPT][STATE];

static void remember(const real *f)
{
    memmove(past[1], past[0], (KEPT - 1) * sizeof past[0]);
    memcpy(past[0], f, sizeof past[0]);
    if (known < KEPT)
        known++;
}

/* Adams and Bashforth of order 2, after a first step of Heun's.
 *
 *     y' = y + h (3 f - f_-1)/2 */
static void adams_bashforth(double t, real h)
{
    static real y[STATE], f[STATE], next[STATE];
    packed(y);
    rate(t, y, f);
    if (known == 0) {
        by_table(&HEUN, t, h);
    } else {
        for (int i = 0; i < SLOTS * bodies; i++)
            next[i] = y[i] + h / 2 * (3 * f[i] - past[0][i]);
        unpacked(next);
        unit_quaternions();
    }
    remember(f);
}

/* Adams, Bashforth and Moulton of order 4: predict, evaluate, correct, evaluate, after three steps
 * of Runge and Kutta.
 *
 *     p  = y + h (55 f - 59 f_-1 + 37 f_-2 - 9 f_-3)/24
 *     y' = y + h (9 f(p) + 19 f - 5 f_-1 + f_-2)/24 */
static void adams_moulton(double t, real h)
{
    static real y[STATE], f[STATE], predicted[STATE], end[STATE], next[STATE];
    const int n = SLOTS * bodies;
    packed(y);
    rate(t, y, f);
    if (known < 3) {
        by_table(&RK4, t, h);
    } else {
        for (int i = 0; i < n; i++) {
            const real earlier = -59 * past[0][i] + 37 * past[1][i] - 9 * past[2][i];
            predicted[i] = y[i] + h / 24 * (55 * f[i] + earlier);
        }
        rate(t + h, predicted, end);
        for (int i = 0; i < n; i++) {
            const real earlier = -5 * past[0][i] + past[1][i];
            next[i] = y[i] + h / 24 * (9 * end[i] + 19 * f[i] + earlier);
        }
        unpacked(next);
        unit_quaternions();
    }
    remember(f);
}

/* The backward differentiation formula of order 2, solved by iteration, after a first step of the
 * trapezoidal rule.
 *
 *     y' = (4 y - y_-1)/3 + 2 h f(y')/3 */
static void backward_differences(double t, real h)
{
    enum { ITERATIONS = 200 };
    static real before[STATE], y[STATE], f[STATE], next[STATE];
    packed(y);
    if (known == 0) {
        newmark(t, h);
        memcpy(before, y, sizeof before);
        known = 1;
        return;
    }
    memcpy(next, y, sizeof next);
    real change = 1;
    for (int n = 0; n < ITERATIONS && change > 0; n++) {
        change = 0;
        rate(t + h, next, f);
        for (int i = 0; i < SLOTS * bodies; i++) {
            const real value = y[i] + (y[i] - before[i] + 2 * h * f[i]) / 3;
            change = fmax(change, fabs(value - next[i]));
            next[i] = value;
        }
    }
    memcpy(before, y, sizeof before);
    unpacked(next);
    unit_quaternions();
}

/* What a method leaves out. */
enum omission { NOTHING, VELOCITIES, FRICTION };

static const struct {
    const char *name;
    void (*step)(double t, real h);
    enum omission omission;
} METHODS[] = {
    {"stoermer", stoermer, VELOCITIES},
    {"beeman", beeman, FRICTION},
    {"newmark", newmark, FRICTION},
    {"generalized-alpha", generalized_alpha, FRICTION},
    {"adams-bashforth-2", adams_bashforth, NOTHING},
    {"adams-bashforth-moulton-4", adams_moulton, NOTHING},
    {"bdf2", backward_differences, FRICTION},
};

static void solve(const char *method)
{
    refuse_scene();
    size_t m = 0;
    while (m < sizeof METHODS / sizeof *METHODS && strcmp(METHODS[m].name, method))
        m++;
    if (m == sizeof METHODS / sizeof *METHODS)
        refuse("this method");
    if (METHODS[m].omission == VELOCITIES && is_velocity_in_forces())
        refuse("forces that depend on velocities");
    if (METHODS[m].omission == FRICTION && is_friction_in_forces())
        refuse("friction");
    known = 0;
    tell(atof(text("times.0")));
    const struct schedule s = asked_schedule();
    march(&s, METHODS[m].step, tell);
}
