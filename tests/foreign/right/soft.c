/* Soft bodies by the usual methods of time integration: the method is named by the request. */
#include "runge_kutta.h"

static void add(real *sum, real *lost, real term)
{
#ifdef COMPENSATED
    /* Kahan 1965: what the last addition lost is added to the next term. */
    const real wanted = term - *lost;
    const real next = *sum + wanted;
    *lost = (next - *sum) - wanted;
    *sum = next;
#else
    (void)lost;
    *sum += term;
#endif
}

static void kick(real h)
{
    for (struct body *b = body; b < body + bodies; b++)
        for (int k = 0; k < 3; k++) {
            add(&b->v[k], &b->lost_v[k], h * b->f[k] / b->m);
            b->w[k] += b->J[k] > 0 ? h * b->torque[k] / b->J[k] : 0;
        }
}

static void drift(real h)
{
    for (struct body *b = body; b < body + bodies; b++) {
        for (int k = 0; k < 3; k++)
            add(&b->r[k], &b->lost_r[k], h * b->v[k]);
        turn_in_space(b->q, b->w, h);
    }
}

/* Symplectic Euler: v' = v + h a(x), x' = x + h v'. */
static void kick_drift(double t, real h)
{
    forces(t);
    kick(h);
    drift(h);
}

/* Symplectic Euler in the other order: x' = x + h v, v' = v + h a(x'). */
static void drift_kick(double t, real h)
{
    drift(h);
    forces(t + h);
    kick(h);
}

/* The velocities of all bodies before some trial of them. */
static struct body kept[MOST];

static void keep(void)
{
    memcpy(kept, body, sizeof kept);
}

static void take_back_velocities(void)
{
    for (int i = 0; i < bodies; i++) {
        memcpy(body[i].v, kept[i].v, sizeof body[i].v);
        memcpy(body[i].w, kept[i].w, sizeof body[i].w);
        memcpy(body[i].lost_v, kept[i].lost_v, sizeof body[i].lost_v);
    }
}

/* Velocity Verlet, whose second force is that of velocities predicted with the first. */
static void verlet_predicted(double t, real h)
{
    kick(h / 2);
    drift(h);
    keep();
    kick(h / 2);
    forces(t + h);
    take_back_velocities();
    kick(h / 2);
}

/* Velocity Verlet, whose forces are those of the velocities in the middle of a step. */
static void verlet_half_step(double t, real h)
{
    kick(h / 2);
    drift(h);
    forces(t + h);
    kick(h / 2);
}

/* Velocity Verlet, whose second force is that of the velocities at the end: solved by iteration. */
static void verlet_iterated(double t, real h)
{
    enum { ITERATIONS = 60 };
    forces(t);
    kick(h / 2);
    drift(h);
    keep();
    for (int i = 0; i < ITERATIONS; i++) {
        real change = 0;
        struct body before[MOST];
        memcpy(before, body, sizeof before);
        forces(t + h);
        take_back_velocities();
        kick(h / 2);
        for (int j = 0; j < bodies; j++)
            for (int k = 0; k < 3; k++) {
                change = fmax(change, fabs(body[j].v[k] - before[j].v[k]));
                change = fmax(change, fabs(body[j].w[k] - before[j].w[k]));
            }
        if (change == 0 || (i > 0 && !is_velocity_in_forces()))
            break;
    }
}

/* Leapfrog: velocities live half a step before the places. */
static void leapfrog(double t, real h)
{
    forces(t);
    kick(h);
    drift(h);
}

/* Yoshida 1990: three steps of Verlet, of order 4. */
static void yoshida(double t, real h)
{
    const double root = cbrt(2.0);
    const double outer = 1 / (2 - root);
    const double weight[3] = {outer, -root * outer, outer};
    for (int i = 0; i < 3; i++) {
        const real piece = (real)weight[i] * h;
        forces(t);
        kick(piece / 2);
        drift(piece);
        t += piece;
        forces(t);
        kick(piece / 2);
    }
}

/* The explicit midpoint rule. */
static const struct table MIDPOINT = {2, {0, 0.5}, {{0}, {0.5}}, {0, 1}, {0}};
/* Dormand and Prince 1980, with the weights of order 4 for the error. */
static const struct table DORMAND_PRINCE
    = {7,
       {0, 1. / 5, 3. / 10, 4. / 5, 8. / 9, 1, 1},
       {{0},
        {1. / 5},
        {3. / 40, 9. / 40},
        {44. / 45, -56. / 15, 32. / 9},
        {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
        {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656},
        {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84}},
       {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84, 0},
       {5179. / 57600, 0, 7571. / 16695, 393. / 640, -92097. / 339200, 187. / 2100, 1. / 40}};

static void midpoint(double t, real h)
{
    by_table(&MIDPOINT, t, h);
}

static void heun(double t, real h)
{
    by_table(&HEUN, t, h);
}

static void rk4(double t, real h)
{
    by_table(&RK4, t, h);
}

static void dormand_prince(double t, real h)
{
    by_table(&DORMAND_PRINCE, t, h);
}

/* The implicit midpoint rule y' = y + h f((y + y')/2), solved by iteration. */
static void implicit_midpoint(double t, real h)
{
    enum { ITERATIONS = 100 };
    static real y[STATE], next[STATE], middle[STATE], dy[STATE];
    const int n = SLOTS * bodies;
    packed(y);
    memcpy(next, y, sizeof next);
    for (int i = 0; i < ITERATIONS; i++) {
        real change = 0;
        for (int j = 0; j < n; j++)
            middle[j] = (y[j] + next[j]) / 2;
        rate(t + h / 2, middle, dy);
        for (int j = 0; j < n; j++) {
            const real value = y[j] + h * dy[j];
            change = fmax(change, fabs(value - next[j]));
            next[j] = value;
        }
        if (change == 0)
            break;
    }
    unpacked(next);
    unit_quaternions();
}

/* Dormand and Prince with steps chosen by a tolerance, relative to the largest displacement,
 * velocity and angular velocity so far; it ends a step at each sample. */
static void adaptive(void)
{
    static real y[STATE], start[STATE], next[STATE], error[STATE];
    const real tolerance = (real)atof(text("tolerance"));
    const long samples = atol(text("times.count"));
    const int n = SLOTS * bodies;
    double t = atof(text("times.0"));
    real largest[SLOTS] = {0};
    packed(start);
    memcpy(y, start, sizeof y);
    add_sample(t);
    double h = (atof(text("times.1")) - t) / 64;
    for (long sample = 1; sample < samples; sample++) {
        const double until = atof(text("times.%ld", sample));
        /* Across a jump of a force no step is short enough: one of this length is taken as it is.
         */
        const double shortest = 1e-9 * fabs(until - t);
        while (t != until) {
            const int is_last = fabs(until - t) <= fmax(1.0000001 * fabs(h), shortest);
            if (fabs(h) < shortest)
                h = copysign(shortest, h);
            const double piece = is_last ? until - t : h;
            stages(&DORMAND_PRINCE, t, (real)piece, y, next, error);
            real wrong = 0;
            real scale[4] = {0, 0, 1, 0};
            for (int i = 0; i < n; i++) {
                const int slot = i % SLOTS;
                const int kind = slot < 3 ? 0 : slot < 6 ? 1 : slot < 10 ? 2 : 3;
                const real moved = kind == 0 ? next[i] - start[i] : next[i];
                scale[kind] = fmax(scale[kind], fmax(largest[slot], fabs(moved)));
            }
            for (int i = 0; i < n; i++) {
                const int slot = i % SLOTS;
                const int kind = slot < 3 ? 0 : slot < 6 ? 1 : slot < 10 ? 2 : 3;
                /* Without friction nothing turns a sphere: its omega has rounding errors alone. */
                if (error[i] != 0 && kind != 3)
                    wrong = fmax(wrong, fabs(error[i]) / scale[kind]);
            }
            const real ratio = wrong / tolerance;
            const double factor = ratio > 0 ? 0.9 * pow((double)ratio, -0.2) : 5;
            if (!(ratio <= 1) && fabs(piece) > shortest) {
                h = piece * fmax(0.2, isfinite(ratio) ? factor : 0.2);
                continue;
            }
            t = is_last ? until : t + piece;
            for (int slot = 0; slot < SLOTS; slot++)
                largest[slot] = slot < 3   ? scale[0]
                                : slot < 6 ? scale[1]
                                           : scale[slot < 10 ? 2 : 3];
            memcpy(y, next, sizeof y);
            unpacked(y);
            unit_quaternions();
            packed(y);
            tell(t);
            const double longer = piece * fmin(5, fmax(0.2, factor));
            if (!is_last || fabs(longer) < fabs(h))
                h = longer;
        }
        add_sample(t);
    }
}

static const struct {
    const char *name;
    void (*step)(double t, real h);
} METHODS[] = {
    {"kick-drift", kick_drift},
    {"drift-kick", drift_kick},
    {"verlet-predicted", verlet_predicted},
    {"verlet-half-step", verlet_half_step},
    {"verlet-iterated", verlet_iterated},
    {"leapfrog", leapfrog},
    {"yoshida", yoshida},
    {"midpoint", midpoint},
    {"heun", heun},
    {"rk4", rk4},
    {"dormand-prince", dormand_prince},
    {"implicit-midpoint", implicit_midpoint},
};

static void solve(const char *method)
{
    refuse_scene();
    if (strcmp(method, "yoshida") == 0 && is_velocity_in_forces())
        refuse("forces that depend on velocities");
    const int is_solved = strcmp(method, "implicit-midpoint") == 0;
    const int is_adaptive = strcmp(method, "adaptive") == 0;
    if ((is_solved || is_adaptive) && is_friction_in_forces())
        refuse("friction");
    tell(atof(text("times.0")));
    if (is_adaptive) {
        adaptive();
        return;
    }
    size_t m = 0;
    while (m < sizeof METHODS / sizeof *METHODS && strcmp(METHODS[m].name, method))
        m++;
    if (m == sizeof METHODS / sizeof *METHODS)
        refuse("this method");
    const struct schedule s = asked_schedule();
    forces(s.start);
    if (strcmp(method, "leapfrog") == 0)
        kick((real)(-s.h / 2));
    march(&s, METHODS[m].step, tell);
}
