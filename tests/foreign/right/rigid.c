/* Rigid spheres and walls with impulses: from event to event (`event-driven`), at the end of a step
 * that saw an overlap (`late`), or by Moreau's time stepping (`moreau`). */
#include "scene.h"

/* A gap of so many radii is none: rounding alone may have made it. */
#ifdef SINGLE
#define NEAR ((real)1e-5)
#define SLOW ((real)1e-6)
#else
#define NEAR ((real)1e-12)
#define SLOW ((real)1e-9)
#endif

static real gravity[3];
static const struct element *law;

static real closing_speed(const struct body *a, const struct body *b, const real *n)
{
    real closing = 0;
    for (int k = 0; k < 3; k++)
        closing += (a->v[k] - (b ? b->v[k] : 0)) * n[k];
    return closing;
}

/* The gap between surfaces and the unit normal from a to b, or to the wall (b = NULL). */
static real gap_of(const struct body *a, const struct body *b, const struct element *wall, real *n)
{
    if (!b) {
        real height = 0;
        for (int k = 0; k < 3; k++) {
            height += (a->r[k] - wall->end[k]) * wall->axis[k];
            n[k] = -wall->axis[k];
        }
        return height - a->radius;
    }
    for (int k = 0; k < 3; k++)
        n[k] = b->r[k] - a->r[k];
    const real distance = size_of(n);
    for (int k = 0; k < 3; k++)
        n[k] /= distance;
    return distance - a->radius - b->radius;
}

/* Velocity of the surface of a against that of b, across the normal. */
static void slip_of(const struct body *a, const struct body *b, const real *n, real *slip)
{
    real reach[3], spin[3];
    const real closing = closing_speed(a, b, n);
    for (int k = 0; k < 3; k++)
        reach[k] = a->radius * a->w[k] + (b ? b->radius * b->w[k] : 0);
    cross(spin, reach, n);
    for (int k = 0; k < 3; k++)
        slip[k] = a->v[k] - (b ? b->v[k] : 0) - closing * n[k] + spin[k];
}

/* Masses against an impulse along and across the normal. */
static void masses(const struct body *a, const struct body *b, real *along, real *across)
{
    const real inverse = 1 / a->m + (b ? 1 / b->m : 0);
    real turning = a->J[0] > 0 ? a->radius * a->radius / a->J[0] : 0;
    if (b && b->J[0] > 0)
        turning += b->radius * b->radius / b->J[0];
    *along = 1 / inverse;
    *across = 1 / (inverse + turning);
}

/* The impulse p on a, and -p on b, at the point of contact. */
static void strike(struct body *a, struct body *b, const real *n, const real *p)
{
    real torque[3];
    cross(torque, n, p);
    for (int k = 0; k < 3; k++) {
        a->v[k] += p[k] / a->m;
        a->w[k] += a->J[k] > 0 ? a->radius * torque[k] / a->J[k] : 0;
        if (!b)
            continue;
        b->v[k] -= p[k] / b->m;
        b->w[k] += b->J[k] > 0 ? b->radius * torque[k] / b->J[k] : 0;
    }
}

/* Walton 1993: (1 + e) m v along the normal; across it what leaves -beta of the slip, cut at
 * friction times the normal part. */
static void impact(struct body *a, struct body *b, const real *n)
{
    real along, across, slip[3], p[3];
    masses(a, b, &along, &across);
    slip_of(a, b, n, slip);
    const real normal = (1 + law->restitution) * along * closing_speed(a, b, n);
    const real size = size_of(slip);
    const real wanted = (1 + law->slip_restitution) * across * size;
    const real rub = fmin(wanted, law->friction * normal);
    for (int k = 0; k < 3; k++)
        p[k] = -normal * n[k] - (size > 0 ? rub * slip[k] / size : 0);
    strike(a, b, n, p);
}

static void fly(real h)
{
    for (struct body *b = body; b < body + bodies; b++) {
        for (int k = 0; k < 3; k++) {
            b->r[k] += h * (b->v[k] + h / 2 * gravity[k]);
            b->v[k] += h * gravity[k];
        }
        turn_in_space(b->q, b->w, h);
    }
}

/* The partners of a sphere: the spheres behind it, then the walls. */
struct pair {
    struct body *a, *b;
    const struct element *wall;
    real last; /* impulse of the last step */
};
static struct pair pair[MOST * MOST];
static int pairs;

static void list_pairs(void)
{
    pairs = 0;
    for (int i = 0; i < bodies; i++) {
        if (body[i].radius == 0)
            continue;
        for (int j = i + 1; j < bodies; j++)
            if (body[j].radius > 0)
                pair[pairs++] = (struct pair){&body[i], &body[j], NULL, 0};
        for (int w = 0; w < elements; w++)
            if (is_kind(&element[w], "plane"))
                pair[pairs++] = (struct pair){&body[i], NULL, &element[w], 0};
    }
}

/* True if two surfaces stay together, but for a closing speed that rounding made. */
static int is_together(const struct pair *p, real gap, real closing)
{
    const real unit = sizeof(real) == sizeof(double) ? (real)1e-15 : (real)1e-6;
    const real speed = size_of(p->a->v) + (p->b ? size_of(p->b->v) : 0);
    return gap <= 100 * unit * p->a->radius && closing <= 10 * unit * speed;
}

/* The time until a pair meets; infinity if it does not. */
static real meeting(const struct pair *p)
{
    real n[3];
    const real gap = gap_of(p->a, p->b, p->wall, n);
    if (p->b && is_together(p, gap, closing_speed(p->a, p->b, n)))
        return INFINITY;
    if (!p->b) {
        /* gap - c t - g t^2/2 = 0 on the way towards the wall. */
        const real c = closing_speed(p->a, NULL, n);
        const real g = dot(gravity, n);
        const real distance = fmax(gap, 0);
        const real square = c * c + 2 * g * distance;
        if (square < 0)
            return INFINITY;
        const real root = sqrt(square);
        if (c > 0)
            return 2 * distance / (c + root);
        if (g > 0)
            return (root - c) / g;
        return INFINITY;
    }
    /* |d + u t| = R, d and u being relative place and velocity. */
    real d[3], u[3], across[3];
    for (int k = 0; k < 3; k++) {
        d[k] = p->b->r[k] - p->a->r[k];
        u[k] = p->b->v[k] - p->a->v[k];
    }
    const real towards = -dot(d, u);
    if (!(towards > 0))
        return INFINITY;
    const real reach = p->a->radius + p->b->radius;
    const real distance = size_of(d);
    const real outside = fmax(distance - reach, 0) * (distance + reach);
    cross(across, d, u);
    /* towards^2 - u^2 (d^2 - R^2) = u^2 R^2 - |d x u|^2. */
    const real speed = size_of(u);
    const real miss = size_of(across);
    const real square = (speed * reach - miss) * (speed * reach + miss);
    if (square < 0)
        return INFINITY;
    return outside / (towards + sqrt(square));
}

/* Contacts that last, or come ever faster, have no next event. */
static void refuse_lasting(const struct pair *p)
{
    real n[3];
    const real gap = gap_of(p->a, p->b, p->wall, n);
    const real closing = closing_speed(p->a, p->b, n);
    const real pressed = p->b ? 0 : dot(gravity, n);
    const real near = NEAR * p->a->radius;
    if (gap <= near && pressed > 0 && closing * closing <= SLOW * pressed * p->a->radius)
        refuse("contacts that last");
}

static void event_driven(void)
{
    const double start = atof(text("times.0"));
    const long samples = atol(text("times.count"));
    long impacts = 0;
    double t = start;
    for (int i = 0; i < pairs; i++)
        refuse_lasting(&pair[i]);
    add_sample(start);
    for (long sample = 1; sample < samples; sample++) {
        const double until = atof(text("times.%ld", sample));
        for (;;) {
            struct pair *first = NULL;
            real soonest = INFINITY;
            for (int i = 0; i < pairs; i++) {
                const real wait = meeting(&pair[i]);
                if (wait < soonest) {
                    soonest = wait;
                    first = &pair[i];
                }
            }
            if (!first || t + soonest > until)
                break;
            fly(soonest);
            t += soonest;
            if (++impacts > 10000)
                refuse("more than 10000 impacts");
            real n[3];
            gap_of(first->a, first->b, first->wall, n);
            event(t, "contact", (int)(first->a - body));
            impact(first->a, first->b, n);
            refuse_lasting(first);
        }
        fly((real)(until - t));
        t = until;
        add_sample(t);
    }
}

static void late(double t, real h)
{
    fly(h);
    for (struct pair *p = pair; p < pair + pairs; p++) {
        real n[3];
        if (gap_of(p->a, p->b, p->wall, n) > 0 || !(closing_speed(p->a, p->b, n) > 0))
            continue;
        event(t + h, "contact", (int)(p->a - body));
        impact(p->a, p->b, n);
    }
}

/* Moreau 1988: places in the middle of the step say which contacts act; their impulses are implicit
 * in the velocities at its end. */
static void moreau(double t, real h)
{
    enum { SWEEPS = 200 };
    static real normal[MOST * MOST][3], before[MOST * MOST], pressed[MOST * MOST];
    static real rubbed[MOST * MOST][3];
    static int is_active[MOST * MOST];
    for (struct body *b = body; b < body + bodies; b++) {
        for (int k = 0; k < 3; k++)
            b->r[k] += h / 2 * b->v[k];
        turn_in_space(b->q, b->w, h / 2);
    }
    for (int i = 0; i < pairs; i++) {
        const struct pair *p = &pair[i];
        const real gap = gap_of(p->a, p->b, p->wall, normal[i]);
        is_active[i] = gap <= NEAR * p->a->radius;
        before[i] = closing_speed(p->a, p->b, normal[i]);
        pressed[i] = 0;
        memset(rubbed[i], 0, sizeof rubbed[i]);
    }
    for (struct body *b = body; b < body + bodies; b++)
        for (int k = 0; k < 3; k++)
            b->v[k] += h * gravity[k];
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        int is_changed = 0;
        for (int i = 0; i < pairs; i++) {
            struct pair *p = &pair[i];
            const real *n = normal[i];
            real along, across, slip[3], impulse[3], total[3];
            if (!is_active[i])
                continue;
            masses(p->a, p->b, &along, &across);
            /* The closing speed after the step is -e times that before, or less. */
            const real excess
                = closing_speed(p->a, p->b, n) + law->restitution * fmax(before[i], 0);
            const real wanted = fmax(pressed[i] + along * excess, 0);
            const real added = wanted - pressed[i];
            pressed[i] = wanted;
            slip_of(p->a, p->b, n, slip);
            for (int k = 0; k < 3; k++)
                total[k] = rubbed[i][k] + across * slip[k];
            const real size = size_of(total);
            const real most = law->friction * pressed[i];
            const real part = size > most ? most / size : 1;
            for (int k = 0; k < 3; k++) {
                impulse[k] = -added * n[k] - (part * total[k] - rubbed[i][k]);
                rubbed[i][k] = part * total[k];
                is_changed |= p->a->v[k] + impulse[k] / p->a->m != p->a->v[k];
            }
            strike(p->a, p->b, n, impulse);
        }
        if (!is_changed)
            break;
    }
    for (int i = 0; i < pairs; i++) {
        if (pressed[i] > 0 && pair[i].last == 0)
            event(t + h, "contact", (int)(pair[i].a - body));
        pair[i].last = pressed[i];
    }
    for (struct body *b = body; b < body + bodies; b++) {
        for (int k = 0; k < 3; k++)
            b->r[k] += h / 2 * b->v[k];
        turn_in_space(b->q, b->w, h / 2);
    }
}

static void solve(const char *method)
{
    memset(gravity, 0, sizeof gravity);
    law = NULL;
    for (int i = 0; i < elements; i++) {
        if (is_kind(&element[i], "uniform_gravity"))
            memcpy(gravity, element[i].end, sizeof gravity);
        else if (is_kind(&element[i], "contact"))
            law = &element[i];
        else if (!is_kind(&element[i], "plane"))
            refuse("elements other than contact, walls and gravity");
    }
    if (!law || !is_law(law, "rigid"))
        refuse("contacts that are not rigid");
    for (int i = 0; i < bodies; i++)
        if (!is_isotropic(&body[i]))
            refuse("bodies with unequal moments of inertia");
    if (strcmp(method, "moreau") == 0 && law->slip_restitution > 0)
        refuse("tangential restitution");
    list_pairs();
    if (strcmp(method, "event-driven") == 0) {
        event_driven();
        return;
    }
    const int is_late = strcmp(method, "late") == 0;
    if (is_late)
        for (int i = 0; i < pairs; i++)
            refuse_lasting(&pair[i]);
    const struct schedule s = asked_schedule();
    march(&s, is_late ? late : moreau, NULL);
}
