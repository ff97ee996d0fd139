/* Forces between soft bodies: springs, dashpots, fields, drag, drives and contacts of spheres that
 * overlap, with sliding friction of full size. Bodies that turn have three equal moments. */
#include "scene.h"

/* The period of space, 0 if it has none: spheres meet by their nearest images. */
static real box_size;

/* Refuses what these forces leave out, and takes what they all need. */
static void refuse_scene(void)
{
    int is_rubbing = 0;
    box_size = 0;
    for (int i = 0; i < elements; i++)
        if (is_kind(&element[i], "periodic_box"))
            box_size = element[i].box_size;
    for (int i = 0; i < elements; i++)
        is_rubbing |= is_kind(&element[i], "contact") && element[i].friction > 0;
    for (int i = 0; i < bodies; i++) {
        const int turns = is_rubbing || size_of(body[i].w) > 0;
        if (turns && !is_isotropic(&body[i]))
            refuse("bodies with unequal moments of inertia that turn");
    }
    for (int i = 0; i < elements; i++)
        if (is_kind(&element[i], "contact") && is_law(&element[i], "rigid"))
            refuse("rigid contacts");
}

/* True if some force depends on a velocity. */
static inline int is_velocity_in_forces(void)
{
    for (int i = 0; i < elements; i++) {
        const struct element *e = &element[i];
        if (is_kind(e, "dashpot") || is_kind(e, "drag"))
            return 1;
        if (is_kind(e, "contact") && (e->damping > 0 || e->friction > 0))
            return 1;
    }
    return 0;
}

static inline int is_friction_in_forces(void)
{
    for (int i = 0; i < elements; i++)
        if (is_kind(&element[i], "contact") && element[i].friction > 0)
            return 1;
    return 0;
}

/* Adds a force on a, and the opposite one on b unless that is the world. */
static void push(const struct element *e, const real *f)
{
    for (int k = 0; k < 3; k++) {
        body[e->a].f[k] += f[k];
        if (e->b >= 0)
            body[e->b].f[k] -= f[k];
    }
}

/* The place and the velocity of the end b relative to a. */
static void relative(const struct element *e, real *to, real *velocity)
{
    const struct body *a = &body[e->a];
    const struct body *b = e->b < 0 ? NULL : &body[e->b];
    for (int k = 0; k < 3; k++) {
        to[k] = (b ? b->r[k] : e->end[k]) - a->r[k];
        velocity[k] = (b ? b->v[k] : 0) - a->v[k];
    }
}

static void spring(const struct element *e)
{
    real to[3], velocity[3], f[3] = {0, 0, 0};
    relative(e, to, velocity);
    const real distance = size_of(to);
    const real s = distance - e->length;
    /* k sgn(s) |s|^n + a s^2 + b s^3. */
    const real power = e->n == 1 ? e->k * s : copysign(e->k * pow(fabs(s), e->n), e->k * s);
    const real pull = power + (e->quadratic + e->cubic * s) * s * s;
    for (int k = 0; k < 3 && distance > 0; k++)
        f[k] = pull * to[k] / distance;
    push(e, f);
}

static void dashpot(const struct element *e)
{
    real to[3], velocity[3], f[3];
    relative(e, to, velocity);
    const real coefficient = e->damping + e->van_der_pol * dot(to, to);
    for (int k = 0; k < 3; k++)
        f[k] = coefficient * velocity[k];
    push(e, f);
}

static void drag(const struct element *e)
{
    real to[3], velocity[3], f[3];
    relative(e, to, velocity);
    for (int k = 0; k < 3; k++)
        f[k] = e->coefficient * size_of(velocity) * velocity[k];
    push(e, f);
}

static void drive(const struct element *e, double t)
{
    real f[3];
    for (int k = 0; k < 3; k++)
        f[k] = e->amplitude * cos(e->frequency * (real)t + e->phase) * e->axis[k];
    push(e, f);
}

static int is_field(const struct element *e)
{
    return is_kind(e, "uniform_gravity") || is_kind(e, "central_field")
           || is_kind(e, "piecewise_field");
}

static void field(const struct element *e)
{
    for (int i = 0; i < bodies; i++) {
        struct body *b = &body[i];
        const real distance = size_of(b->r);
        real from_point[3];
        for (int k = 0; k < 3; k++)
            from_point[k] = b->r[k] - e->end[k];
        const real s = dot(from_point, e->axis);
        real piece = 0;
        if (s > e->x1 && s < e->x2)
            piece = s <= 0 ? e->k1 * (s - e->x1) : e->k2 * (s - e->x2);
        for (int k = 0; k < 3; k++) {
            if (is_kind(e, "uniform_gravity"))
                b->f[k] += b->m * e->end[k];
            else if (is_kind(e, "central_field"))
                b->f[k] -= b->m * e->gm * b->r[k] / (distance * distance * distance);
            else
                b->f[k] += piece * e->axis[k];
        }
    }
}

/* Where two spheres, or a sphere and a wall (b = NULL), touch: the overlap, the unit normal from a
 * to b, and the speed at which they close. */
static real overlap_of(const struct body *a, const struct body *b, const struct element *wall,
                       real *n, real *closing)
{
    real overlap;
    if (b) {
        for (int k = 0; k < 3; k++) {
            n[k] = b->r[k] - a->r[k];
            if (box_size > 0)
                n[k] -= box_size * round(n[k] / box_size);
        }
        const real distance = size_of(n);
        overlap = a->radius + b->radius - distance;
        for (int k = 0; k < 3; k++)
            n[k] /= distance > 0 ? distance : 1;
    } else {
        real height = 0;
        for (int k = 0; k < 3; k++) {
            height += (a->r[k] - wall->end[k]) * wall->axis[k];
            n[k] = -wall->axis[k];
        }
        overlap = a->radius - height;
    }
    *closing = 0;
    for (int k = 0; k < 3; k++)
        *closing += (a->v[k] - (b ? b->v[k] : 0)) * n[k];
    return overlap;
}

static real normal_force(const struct element *e, real overlap, real closing)
{
    if (overlap <= 0)
        return 0;
    if (is_law(e, "hertz"))
        return e->k * overlap * sqrt(overlap);
    const real force = e->k * overlap + e->damping * closing;
    return strcmp(e->cutoff, "zero_force") == 0 ? fmax(force, 0) : force;
}

static real arm_of(const struct element *e, const struct body *b, real overlap)
{
    if (strcmp(e->branch, "R") == 0)
        return b->radius;
    if (strcmp(e->branch, "R-d") == 0)
        return b->radius - overlap;
    return b->radius - overlap / 2;
}

static void contact(const struct element *e, struct body *a, struct body *b,
                    const struct element *wall)
{
    real n[3], closing, reach[3], spin[3], slip[3], f[3], torque[3];
    if (a->radius == 0 || (b && b->radius == 0))
        return;
    const real overlap = overlap_of(a, b, wall, n, &closing);
    if (overlap <= 0)
        return;
    const real force = normal_force(e, overlap, closing);
    const real arm_a = arm_of(e, a, overlap);
    const real arm_b = b ? arm_of(e, b, overlap) : 0;
    for (int k = 0; k < 3; k++)
        reach[k] = arm_a * a->w[k] + (b ? arm_b * b->w[k] : 0);
    cross(spin, reach, n);
    for (int k = 0; k < 3; k++)
        slip[k] = a->v[k] - (b ? b->v[k] : 0) - closing * n[k] + spin[k];
    const real size = size_of(slip);
    const real rub = size > 0 ? e->friction * fmax(force, 0) / size : 0;
    for (int k = 0; k < 3; k++) {
        f[k] = -force * n[k] - rub * slip[k];
        a->f[k] += f[k];
        if (b)
            b->f[k] -= f[k];
    }
    cross(torque, n, f);
    for (int k = 0; k < 3; k++) {
        a->torque[k] += arm_a * torque[k];
        if (b)
            b->torque[k] += arm_b * torque[k];
    }
}

static void forces(double t)
{
    for (int i = 0; i < bodies; i++) {
        memset(body[i].f, 0, sizeof body[i].f);
        memset(body[i].torque, 0, sizeof body[i].torque);
    }
    for (struct element *e = element; e < element + elements; e++) {
        if (is_kind(e, "spring"))
            spring(e);
        else if (is_kind(e, "dashpot"))
            dashpot(e);
        else if (is_kind(e, "drag"))
            drag(e);
        else if (is_kind(e, "force"))
            drive(e, t);
        else if (is_kind(e, "contact")) {
            for (int j = 0; j < bodies; j++)
                for (int i = 0; i < j; i++)
                    contact(e, &body[i], &body[j], NULL);
            for (int w = 0; w < elements; w++)
                for (int i = 0; i < bodies && is_kind(&element[w], "plane"); i++)
                    contact(e, &body[i], NULL, &element[w]);
        } else if (is_field(e))
            field(e);
    }
}

/* Contacts that the last step has begun or ended are told at its end. */
static inline void tell(double t)
{
    for (struct element *e = element; e < element + elements; e++) {
        for (int i = 0; is_kind(e, "contact") && i < bodies; i++)
            for (int j = i + 1; j <= bodies; j++) {
                const struct element *wall = NULL;
                for (int w = 0; j == bodies && w < elements; w++)
                    if (is_kind(&element[w], "plane"))
                        wall = &element[w];
                const struct body *b = j < bodies ? &body[j] : NULL;
                if (body[i].radius == 0 || (b ? b->radius == 0 : !wall))
                    continue;
                real n[3], closing;
                const real overlap = overlap_of(&body[i], b, wall, n, &closing);
                int touches = overlap > 0;
                if (strcmp(e->cutoff, "zero_force") == 0)
                    touches = normal_force(e, overlap, closing) > 0;
                if (touches != e->touched[i][j])
                    event(t, touches ? "contact" : "release", i);
                e->touched[i][j] = touches;
            }
    }
}
