/* A convex body whose corners press on a plane, from event to event: Taylor series of order 20 in
 * body axes.
 *
 * With attitude q (rotation matrix R), omega w and velocity V = R^T v in body axes, place r in
 * space:
 *
 *   q' = q w/2,   J w' = (J w) x w + sum a x F,   V' = V x w + R^T g + sum F/m,   r' = R V.
 *
 * A corner a (body axes) has, with the plane's normal n in body axes and the point P of the plane:
 *
 *   gap      n.(r + R a - P),      velocity  u = V + w x a,    closing speed  c = -n.u
 *   push     N = -k gap + damping c,         slip      s = u + c n
 *   force    F = N n - friction N s/|s|
 *
 * It presses from gap = 0 to N = 0 (cutoff zero_force), and then idles until it leaves the plane
 * or presses again. The last coordinate is the work lost, with the power damping c^2 + friction N
 * |s| while it presses, and k gap c, the rate at which k gap^2/2 falls without a force, while it
 * idles.
 *
 * Phases: begin, measure, expand, step_size, locate, record, accept, change_mode.
 */
#include <assert.h>

#include "kernels.h"
#include "double_double.h"
#include "series_zeros.h"

enum { STATES = 14, MOST_CORNERS = 32 };
enum { OFF = 0, PRESSES = 1, IDLES = 2 }; /* modes of a corner */
enum { NONE = 0, GAP = 1, PUSH = 2 };     /* guards, which end a mode at their zero */
typedef double line[ORDER + 1]; /* a Taylor series in the time since the start of the step */

/* exp(-2): the step over the radius of convergence, so that what is cut off is exp(-40) (Jorba and
 * Zou 2005). */
static const double STEP_PART = 0.1353352832366127;
/* Shortest step, over the interval of the samples: where a slip ends, s/|s| has a singularity, and
 * the steps tend to 0. */
static const double SHORTEST = 1e-10;

/* One corner: series of gap [m], N [N], c [m/s], |s|^2, 1/|s|, friction N/|s|, and of the vectors
 * s, u, F in body axes; its mode, and the guard that is zero at the start of the step, if one is.
 */
typedef struct {
    line gap, push, closing, slip_squared, inverse_slip, friction_over_slip;
    line slip[3], velocity[3], force[3];
    int mode, zero_guard;
} corner;

/* The motion: series of the state (q, w, V, r, work), of R and of n in body axes; what rounding has
 * lost of the state's sums. */
typedef struct {
    const refdem_tumbling_body *body;
    line y[STATES], rotation[3][3], normal[3];
    double low[STATES];
    corner corner[MOST_CORNERS];
} motion;

/* Coefficient k of the scalar product a.b of two vectors of series. */
static double dot_coefficient(line *a, line *b, int k)
{
    return product(a[0], b[0], k) + product(a[1], b[1], k) + product(a[2], b[2], k);
}

/* Coefficient k of R, quadratic in q: R_ii = q0^2 + q_i^2 - q_j^2 - q_l^2, R_jl = 2 (q_j q_l - q0
 * q_i), R_lj = 2 (q_j q_l + q0 q_i) for (i, j, l) cyclic; and of the normal in body axes, R^T n. */
static void expand_rotation(motion *m, int k)
{
    double qq[4][4];
    for (int i = 0; i < 4; i++)
        for (int j = i; j < 4; j++)
            qq[i][j] = product(m->y[i], m->y[j], k);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        int l = (i + 2) % 3;
        int lower = j + 1; /* qq has its upper half only */
        int upper = l + 1;
        if (j > l) {
            lower = l + 1;
            upper = j + 1;
        }
        double twice_qj_ql = 2.0 * qq[lower][upper];
        double twice_q0_qi = 2.0 * qq[0][i + 1];
        m->rotation[i][i][k] = qq[0][0] + qq[i + 1][i + 1] - qq[j + 1][j + 1] - qq[l + 1][l + 1];
        m->rotation[j][l][k] = twice_qj_ql - twice_q0_qi;
        m->rotation[l][j][k] = twice_qj_ql + twice_q0_qi;
    }
    const double *n = m->body->plane + 3;
    for (int j = 0; j < 3; j++)
        m->normal[j][k] = n[0] * m->rotation[0][j][k] + n[1] * m->rotation[1][j][k]
                          + n[2] * m->rotation[2][j][k];
}

/* Coefficient k of p = a^(-1/2), from 2 a p' = -a' p: p_k = sum over i >= 1 of (i/2 - k) a_i
 * p_(k-i) / (k a_0). */
static double inverse_root(const double *a, const double *power, int k)
{
    double sum = 0.0;
    if (k == 0)
        return 1.0 / sqrt(a[0]);
    for (int i = 1; i <= k; i++)
        sum += (0.5 * i - k) * a[i] * power[k - i];
    return sum * INVERSE[k] / a[0];
}

/* Coefficient k of the gap n.(r + R a - P) of the corner a. */
static double gap_coefficient(const motion *m, const double *arm, int k)
{
    const double *point = m->body->plane;
    const double *n = point + 3;
    double gap = 0.0;
    if (k == 0) /* the plane stays where it is */
        gap = -(n[0] * point[0] + n[1] * point[1] + n[2] * point[2]);
    for (int i = 0; i < 3; i++)
        gap += n[i] * m->y[10 + i][k] + m->normal[i][k] * arm[i];
    return gap;
}

/* Coefficient k of the friction -friction N s/|s| on a corner that presses, added to its force. */
static void add_friction(motion *m, corner *corner, int k)
{
    /* s = u + c n. */
    for (int i = 0; i < 3; i++)
        corner->slip[i][k] = corner->velocity[i][k] + product(m->normal[i], corner->closing, k);
    corner->slip_squared[k] = dot_coefficient(corner->slip, corner->slip, k);
    corner->inverse_slip[k] = inverse_root(corner->slip_squared, corner->inverse_slip, k);
    corner->friction_over_slip[k]
        = m->body->friction * product(corner->push, corner->inverse_slip, k);
    for (int i = 0; i < 3; i++)
        corner->force[i][k] -= product(corner->friction_over_slip, corner->slip[i], k);
}

/* Coefficient k of gap, velocity, push and force of a corner; returns that of the power lost [W].
 */
static double measure(motion *m, int number, int k)
{
    const refdem_tumbling_body *p = m->body;
    const double *arm = p->corner + 3 * number;
    corner *contact = &m->corner[number];
    line *omega = m->y + 4;
    line *velocity = m->y + 7;
    contact->gap[k] = gap_coefficient(m, arm, k);
    if (contact->mode == OFF) /* the gap alone decides */
        return 0.0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        int l = (i + 2) % 3;
        /* u = V + w x a. */
        contact->velocity[i][k] = velocity[i][k] + omega[j][k] * arm[l] - omega[l][k] * arm[j];
    }
    /* c = -n.u,   N = -k gap + damping c. */
    contact->closing[k] = -dot_coefficient(m->normal, contact->velocity, k);
    contact->push[k] = -p->stiffness * contact->gap[k] + p->damping * contact->closing[k];
    if (contact->mode == IDLES) /* no force */
        return p->stiffness * product(contact->gap, contact->closing, k);
    for (int i = 0; i < 3; i++)
        contact->force[i][k] = product(contact->push, m->normal[i], k);
    double lost = p->damping * product(contact->closing, contact->closing, k);
    if (p->friction > 0.0) {
        add_friction(m, contact, k);
        lost += product(contact->friction_over_slip, contact->slip_squared, k);
    }
    return lost;
}

/* The start, and the modes of the corners: with gap <= 0 a corner presses if N > 0, else it idles.
 */
static void begin(motion *m, const double *start)
{
    for (int i = 0; i < STATES; i++) {
        m->y[i][0] = start[i];
        m->low[i] = 0.0;
    }
    expand_rotation(m, 0);
    for (int number = 0; number < m->body->corners; number++) {
        corner *contact = &m->corner[number];
        contact->mode = IDLES;
        contact->zero_guard = NONE;
        measure(m, number, 0);
        if (contact->gap[0] > 0.0)
            contact->mode = OFF;
        else if (contact->push[0] > 0.0)
            contact->mode = PRESSES;
    }
}

/* Coefficients 1 to ORDER of the whole state, by the equations of motion above. */
static void expand(motion *m)
{
    const refdem_tumbling_body *p = m->body;
    line *q = m->y;
    line *w = m->y + 4;
    line *v = m->y + 7;
    line *r = m->y + 10;
    for (int k = 0; k < ORDER; k++) {
        double force[3] = {0.0};
        double torque[3] = {0.0};
        double lost = 0.0;
        double inverse = INVERSE[k + 1];
        expand_rotation(m, k);
        for (int number = 0; number < p->corners; number++) {
            corner *contact = &m->corner[number];
            const double *arm = p->corner + 3 * number;
            lost += measure(m, number, k);
            if (contact->mode != PRESSES)
                continue;
            for (int i = 0; i < 3; i++) {
                int j = (i + 1) % 3;
                int l = (i + 2) % 3;
                /* sum F, and sum a x F in body axes. */
                force[i] += contact->force[i][k];
                torque[i] += arm[j] * contact->force[l][k] - arm[l] * contact->force[j][k];
            }
        }
        /* q' = q (0, w)/2,  J_i w_i' = (J_j - J_l) w_j w_l + torque_i,  V' = V x w + R^T g + F/m,
         * r' = R V. */
        q[0][k + 1] = -0.5 * inverse * dot_coefficient(q + 1, w, k);
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3;
            int l = (i + 2) % 3;
            double gravity_i = 0.0;
            double turning = (p->inertia[j] - p->inertia[l]) * product(w[j], w[l], k) + torque[i];
            for (int axis = 0; axis < 3; axis++)
                gravity_i += p->gravity[axis] * m->rotation[axis][i][k];
            q[i + 1][k + 1] = 0.5 * inverse
                              * (product(q[0], w[i], k) + product(q[j + 1], w[l], k)
                                 - product(q[l + 1], w[j], k));
            w[i][k + 1] = inverse * turning / p->inertia[i];
            v[i][k + 1] = inverse
                          * (product(v[j], w[l], k) - product(v[l], w[j], k) + gravity_i
                             + force[i] / p->mass);
            r[i][k + 1] = inverse * dot_coefficient(m->rotation[i], v, k);
        }
        m->y[13][k + 1] = inverse * lost;
    }
    expand_rotation(m, ORDER);
    for (int number = 0; number < p->corners; number++)
        measure(m, number, ORDER);
}

/* exp(-2) times the radius of convergence |a_k/scale|^(-1/k) that the last two terms of attitude,
 * omega and velocity show [s]. */
static double step_size(const motion *m)
{
    static const int begins[4] = {0, 4, 7, 10};
    double radius = INFINITY;
    for (int k = ORDER - 1; k <= ORDER; k++) {
        double worst = 0.0;
        for (int block = 0; block < 3; block++) {
            /* max_i |y_i,k|/max_i |y_i,0| in the block. */
            double scale = 0.0;
            double last = 0.0;
            for (int i = begins[block]; i < begins[block + 1]; i++) {
                scale = fmax(scale, fabs(m->y[i][0]));
                last = fmax(last, fabs(m->y[i][k]));
            }
            if (scale > 0.0) /* what is at rest has no scale */
                worst = fmax(worst, last / scale);
        }
        if (worst > 0.0)
            radius = fmin(radius, pow(worst, -1.0 / k));
    }
    return radius * STEP_PART;
}

/* When the guard sign a(s) first falls through zero in (0, h]; -1 if it does not. A fresh guard is
 * zero at the start, exactly: that zero does not count. */
static double zero_of_guard(const double *a, double sign, int begins_at_zero, double h)
{
    line guard;
    for (int k = 0; k <= ORDER; k++)
        guard[k] = sign * a[k];
    if (begins_at_zero)
        guard[0] = 0.0;
    else if (guard[0] <= 0.0 && guard[1] < 0.0) /* it has failed already */
        return 0.0;
    return first_zero(guard, h);
}

/* The first event in (0, h]: returns its time, with the corner and the guard; h and NONE if there
 * is none. */
static double locate(motion *m, double h, int *which, int *guard)
{
    *guard = NONE;
    for (int number = 0; number < m->body->corners; number++) {
        corner *contact = &m->corner[number];
        for (int kind = GAP; kind <= PUSH; kind++) {
            /* A corner that presses ends with its push, one that is off begins with its gap. */
            if ((kind == GAP && contact->mode == PRESSES) || (kind == PUSH && contact->mode == OFF))
                continue;
            const double *series = contact->push;
            if (kind == GAP)
                series = contact->gap;
            double sign = 1.0;
            /* Gap and push are below zero: the corner leaves, or presses, where they rise to 0. */
            if (contact->mode == IDLES)
                sign = -1.0;
            double zero = zero_of_guard(series, sign, contact->zero_guard == kind, h);
            if (zero >= 0.0 && (zero < h || *guard == NONE)) {
                h = zero;
                *which = number;
                *guard = kind;
            }
        }
    }
    return h;
}

/* Writes the sample at `since` [s] in the step: the state (14), and the channels (3): corners that
 * touch, largest depth [m], largest push [N]. */
static void record(const motion *m, double since, double *out, double *channel)
{
    memset(channel, 0, 3 * sizeof *channel);
    for (int i = 0; i < STATES; i++)
        out[i] = m->y[i][0] + (m->low[i] + gained(m->y[i], since));
    for (int number = 0; number < m->body->corners; number++) {
        const corner *contact = &m->corner[number];
        if (contact->mode == OFF) /* it does not touch */
            continue;
        channel[0] += 1.0;
        channel[1] = fmax(channel[1], -value(contact->gap, since));
        if (contact->mode == PRESSES)
            channel[2] = fmax(channel[2], value(contact->push, since));
    }
}

/* The end of the step h becomes the state. */
static void accept(motion *m, double h)
{
    for (int i = 0; i < STATES; i++) {
        dd sum = two_sum(m->y[i][0], m->low[i] + gained(m->y[i], h));
        m->y[i][0] = sum.hi;
        m->low[i] = sum.lo;
    }
    if (!(h > 0.0)) /* two events at one time: guards that began at zero are still there */
        return;
    for (int number = 0; number < m->body->corners; number++)
        m->corner[number].zero_guard = NONE;
}

/* Goes through the event of a corner: the new mode, and the guard that is zero as it begins. */
static void change_mode(motion *m, corner *contact, int guard)
{
    int has_damping = m->body->damping > 0.0;
    int before = contact->mode;
    if (before == OFF || (before == IDLES && guard == PUSH)) { /* touches, or pushes again */
        contact->mode = PRESSES;
        contact->zero_guard = PUSH;
        if (before == OFF && has_damping) /* a dashpot pushes from the first touch */
            contact->zero_guard = NONE;
        return;
    }
    if (before == PRESSES && has_damping) { /* it overlaps still */
        contact->mode = IDLES;
        contact->zero_guard = PUSH;
        return;
    }
    contact->mode = OFF; /* leaves the plane */
    contact->zero_guard = GAP;
}

int64_t refdem_tumbling_body_run(const refdem_tumbling_body *given, int64_t samples,
                                 const double *t, int64_t most, double *event, double *channel,
                                 double *out)
{
    assert(given && given->corners >= 1 && given->corners <= MOST_CORNERS);
    assert(given->inertia && given->gravity && given->plane && given->corner);
    assert(samples >= 1 && t && channel && out); /* (samples, 14) and (samples, 3) doubles */
    assert(most == 0 || event);                  /* (most, 3) doubles */
    assert(t[samples - 1] >= t[0]);              /* events are looked for forward only */
    motion m = {.body = given};
    int64_t k = 1;
    int64_t events = 0;
    dd now = dd_of(t[0]);
    begin(&m, out);
    expand(&m);
    record(&m, 0.0, out, channel);
    while (k < samples) {
        int which = 0;
        int guard = NONE;
        double h = step_size(&m);
        if (!(h > SHORTEST * (t[1] - t[0]))) /* a slip has come to an end */
            return -k;
        h = locate(&m, fmin(h, t[samples - 1] - t[0]), &which, &guard);
        for (; k < samples && dd_round(dd_sub(dd_of(t[k]), now)) <= h; k++)
            record(&m, dd_round(dd_sub(dd_of(t[k]), now)), out + k * STATES, channel + 3 * k);
        accept(&m, h);
        now = dd_add(now, dd_of(h));
        if (guard != NONE) {
            if (events < most) {
                double *row = event + 3 * events;
                row[0] = dd_round(now);
                row[1] = m.corner[which].mode;
                row[2] = which;
            }
            events++;
            change_mode(&m, &m.corner[which], guard);
        }
        expand(&m);
    }
    if (events > most) /* there was room for so many only */
        return most;
    return events;
}
