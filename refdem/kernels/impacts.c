/* Rigid spheres that move on straight lines from impact to impact (Alder and Wainwright 1959).
 *
 * A body knows its place at its own time, that of its last impact, and its next event: the earliest
 * of those with every other body and plane. Let d = (r_j - r_i)/R with R = R_i + R_j, w = v_j - v_i
 * and u = w/|w|. With b = d.u < 0 two spheres meet when |d + u |w| s/R| = 1, at the first root
 *
 *     s = (R/|w|) c / (-b + sqrt(q)),   c = (|d| - 1) (|d| + 1),   q = 1 - |d x u|^2,
 *
 * without cancellation, and whatever the units; at a plane at s = (height - R)/closing speed. An
 * event is made by impulses: with n from i to j, the velocity g of the points that touch, its part
 * c along n and its slip s across,
 *
 *     P = -p n - k s,   p = (1 + e) c / (1/m_i + 1/m_j),
 *     k = min((1 + b) / (1/m_i + 1/m_j + R_i^2/J_i + R_j^2/J_j), mu p / |s|)   (Walton 1993).
 *
 * Only the bodies that met, and those that were to meet one of them, look for their next events
 * anew: O(bodies) an event.
 */
#include "impacts_kernel.h"

#include <assert.h>
#include <stdbool.h>
#include <string.h>

#include "quaternion.h"
#include "space.h"

enum { NOBODY = INT32_MIN };

/* Roundings of a closing speed that is none: those of the velocities that an impact left, and of
 * their part along the normal. */
static const double ROUNDINGS = 16.0 * 0x1p-53;

/* The state of all bodies: `since` is each one's own time, `next` and `partner` its next event. */
typedef struct {
    int64_t bodies;
    double *position, *velocity, *omega, *attitude, *since, *next, *partner;
    const double *gravity;
    double work;
} motion;

enum { NUMBERS = 3 + 3 + 3 + 4 + 3 };

int64_t refdem_impacts_room(int64_t bodies)
{
    return NUMBERS * bodies;
}

static motion laid_out(double *room, int64_t bodies)
{
    motion m = {.bodies = bodies};
    m.position = room;
    m.velocity = m.position + 3 * bodies;
    m.omega = m.velocity + 3 * bodies;
    m.attitude = m.omega + 3 * bodies;
    m.since = m.attitude + 4 * bodies;
    m.next = m.since + bodies;
    m.partner = m.next + bodies;
    return m;
}

/* Place of a body at the time now. */
static void place(const motion *m, int64_t i, double now, double *restrict out)
{
    const double elapsed = now - m->since[i];
    for (int c = 0; c < 3; c++)
        out[c] = fma(m->velocity[3 * i + c], elapsed, m->position[3 * i + c]);
    add_scaled(out, 0.5 * elapsed * elapsed, m->gravity);
}

/* Velocity of a body at the time now. */
static void pace(const motion *m, int64_t i, double now, double *restrict out)
{
    memcpy(out, m->velocity + 3 * i, 3 * sizeof *out);
    add_scaled(out, now - m->since[i], m->gravity);
}

/* Attitude of a body at the time now: it has turned by omega times the time about a fixed axis. */
static void faced(const motion *m, int64_t i, double now, double *restrict out)
{
    const double *omega = m->omega + 3 * i;
    const double rate = size(omega);
    const double half = 0.5 * rate * (now - m->since[i]);
    double turn[4] = {cos(half), 0.0, 0.0, 0.0};
    if (rate == 0.0) {
        memcpy(out, m->attitude + 4 * i, 4 * sizeof *out);
        return;
    }
    for (int c = 0; c < 3; c++)
        turn[1 + c] = sin(half) * (omega[c] / rate);
    quaternion_product(turn, m->attitude + 4 * i, out);
    quaternion_normalised(out);
}

/* Time from now until two spheres meet, or infinity; gravity moves both alike. */
static double until_spheres(const refdem_impacts *p, const motion *m, int64_t i, int64_t j,
                            double now)
{
    double vi[3], vj[3];
    pace(m, i, now, vi);
    pace(m, j, now, vj);
    const double reach = p->radius[i] + p->radius[j];
    double ri[3], rj[3], apart[3], relative[3], swept[3];
    place(m, i, now, ri);
    place(m, j, now, rj);
    for (int c = 0; c < 3; c++) {
        apart[c] = (rj[c] - ri[c]) / reach;
        relative[c] = vj[c] - vi[c];
    }
    const double speed = size(relative);
    if (!(speed > 0.0))
        return INFINITY;
    for (int c = 0; c < 3; c++)
        relative[c] /= speed;
    const double distance = size(apart);
    const double b = dot(apart, relative);
    if (!(-b * speed > ROUNDINGS * distance * (size(vi) + size(vj))))
        return INFINITY;
    cross(apart, relative, swept);
    const double q = 1.0 - dot(swept, swept);
    if (!(q > 0.0))
        return INFINITY;
    const double gap = (distance - 1.0) * (distance + 1.0);
    return fmax(0.0, gap / (sqrt(q) - b)) * (reach / speed);
}

/* Time from now until a sphere meets a plane, or infinity: h - c t - a t^2/2 = 0 with the height h,
 * the closing speed c and the pull a towards the plane. The first root is 2 h/(c + sqrt(q)) with
 * q = c^2 + 2 a h, and (sqrt(q) - c)/a if the sphere moves away and is pulled back. */
static double until_plane(const refdem_impacts *p, const motion *m, int64_t i, int64_t k,
                          double now)
{
    const double *point = p->plane + 6 * k;
    const double *normal = point + 3;
    double v[3], r[3], from[3];
    place(m, i, now, r);
    pace(m, i, now, v);
    for (int c = 0; c < 3; c++)
        from[c] = r[c] - point[c];
    const double closing = -dot(v, normal);
    const double height = dot(from, normal) - p->radius[i];
    const double pull = -dot(m->gravity, normal);
    const bool comes_near = closing > ROUNDINGS * size(v);
    if (pull == 0.0)
        return comes_near ? fmax(0.0, height / closing) : INFINITY;
    const double above = fmax(0.0, height);
    const double q = closing * closing + 2.0 * pull * above;
    if (comes_near && q >= 0.0)
        return 2.0 * above / (closing + sqrt(q));
    if (!comes_near && pull > 0.0)
        return (sqrt(q) - closing) / pull;
    return INFINITY;
}

/* Takes an event of body i if it is its earliest. */
static void offered(motion *m, int64_t i, double when, double partner)
{
    if (when < m->next[i]) {
        m->next[i] = when;
        m->partner[i] = partner;
    }
}

/* The next event of body i anew; the others hear of theirs with it. */
static void looked(const refdem_impacts *p, motion *m, int64_t i, double now)
{
    m->next[i] = INFINITY;
    m->partner[i] = NOBODY;
    for (int64_t j = 0; j < m->bodies; j++) {
        if (j == i || (isinf(p->mass[i]) && isinf(p->mass[j])))
            continue;
        const double when = now + until_spheres(p, m, i, j, now);
        offered(m, i, when, (double)j);
        offered(m, j, when, (double)i);
    }
    if (isinf(p->mass[i]))
        return;
    for (int64_t k = 0; k < p->planes; k++)
        offered(m, i, now + until_plane(p, m, i, k, now), -1.0 - (double)k);
}

/* Brings a body to the time now. */
static void advanced(motion *m, int64_t i, double now)
{
    double r[3], v[3], q[4];
    place(m, i, now, r);
    pace(m, i, now, v);
    faced(m, i, now, q);
    memcpy(m->position + 3 * i, r, sizeof r);
    memcpy(m->velocity + 3 * i, v, sizeof v);
    memcpy(m->attitude + 4 * i, q, sizeof q);
    m->since[i] = now;
}

/* The impulse on a body, and the turn that it gives: v += P/m, omega += (R/J) n x P. */
static void pushed(const refdem_impacts *p, motion *m, int64_t i, double side,
                   const double *restrict impulse, const double *restrict turning)
{
    add_scaled(m->velocity + 3 * i, side / p->mass[i], impulse);
    add_scaled(m->omega + 3 * i, p->radius[i] / p->inertia[i], turning);
}

/* The impact of body i with body j, or with a wall (j < 0), along the unit normal from i on. */
static void struck(const refdem_impacts *p, motion *m, int64_t i, int64_t j,
                   const double *restrict normal)
{
    double relative[3], surface[3], swept[3], slip[3], impulse[3], turning[3];
    double ease = 1.0 / p->mass[i];
    double turn_ease = p->radius[i] * p->radius[i] / p->inertia[i];
    for (int c = 0; c < 3; c++) {
        relative[c] = m->velocity[3 * i + c];
        surface[c] = p->radius[i] * m->omega[3 * i + c];
    }
    if (j >= 0) {
        ease += 1.0 / p->mass[j];
        turn_ease += p->radius[j] * p->radius[j] / p->inertia[j];
        for (int c = 0; c < 3; c++) {
            relative[c] -= m->velocity[3 * j + c];
            surface[c] += p->radius[j] * m->omega[3 * j + c];
        }
    }
    /* g = v_i - v_j + (R_i omega_i + R_j omega_j) x n; the last part has nothing along n. */
    cross(surface, normal, swept);
    const double closing = dot(relative, normal);
    for (int c = 0; c < 3; c++)
        slip[c] = relative[c] - closing * normal[c] + swept[c];
    const double speed = size(slip);
    const double across_mass = 1.0 / (ease + turn_ease);
    const double along = (1.0 + p->restitution) * closing / ease;
    double factor = (1.0 + p->tangential_restitution) * across_mass;
    if (factor * speed > p->friction * along)
        factor = p->friction * along / speed;
    for (int c = 0; c < 3; c++)
        impulse[c] = -along * normal[c] - factor * slip[c];
    cross(normal, impulse, turning);
    pushed(p, m, i, 1.0, impulse, turning);
    if (j >= 0)
        pushed(p, m, j, -1.0, impulse, turning);
    /* What is left of m_n c^2/2 is the part e^2, and of m_t s^2/2 the part (1 - k/m_t)^2. */
    const double left = 1.0 - factor / across_mass;
    const double lost_along = (1.0 - p->restitution * p->restitution) * closing * closing / ease;
    const double lost_across = (1.0 - left * left) * speed * speed * across_mass;
    m->work += 0.5 * (lost_along + lost_across);
}

/* The unit normal from body i to what it meets. */
static void normal_of(const refdem_impacts *p, const motion *m, int64_t i, int64_t j,
                      double *restrict normal)
{
    if (j < 0) {
        const double *plane = p->plane + 6 * (-1 - j);
        for (int c = 0; c < 3; c++)
            normal[c] = -plane[3 + c];
        return;
    }
    for (int c = 0; c < 3; c++)
        normal[c] = m->position[3 * j + c] - m->position[3 * i + c];
    const double distance = size(normal);
    for (int c = 0; c < 3; c++)
        normal[c] /= distance;
}

/* Makes the event of body i, and looks for those that follow. */
static void happened(const refdem_impacts *p, motion *m, int64_t i)
{
    const double now = m->next[i];
    const int64_t j = (int64_t)m->partner[i];
    double normal[3];
    advanced(m, i, now);
    if (j >= 0)
        advanced(m, j, now);
    normal_of(p, m, i, j, normal);
    struck(p, m, i, j, normal);
    for (int64_t k = 0; k < m->bodies; k++) {
        const int64_t other = (int64_t)m->partner[k];
        if (k == i || k == j || other == i || (j >= 0 && other == j))
            looked(p, m, k, now);
    }
}

/* The body with the earliest event. */
static int64_t earliest(const motion *m)
{
    int64_t first = 0;
    for (int64_t i = 1; i < m->bodies; i++)
        if (m->next[i] < m->next[first])
            first = i;
    return first;
}

static void begun(const refdem_impacts *p, motion *m, double now, const double *position,
                  const double *velocity, const double *omega, const double *attitude)
{
    const size_t rows = (size_t)m->bodies * sizeof *position;
    memcpy(m->position, position, 3 * rows);
    memcpy(m->velocity, velocity, 3 * rows);
    memcpy(m->omega, omega, 3 * rows);
    memcpy(m->attitude, attitude, 4 * rows);
    for (int64_t i = 0; i < m->bodies; i++) {
        m->since[i] = now;
        m->next[i] = INFINITY;
        m->partner[i] = NOBODY;
    }
    for (int64_t i = 0; i < m->bodies; i++)
        looked(p, m, i, now);
}

int64_t refdem_impacts_run(const refdem_impacts *p, int64_t samples, const double *t, int64_t most,
                           int64_t longest, double *room, double *event, double *work,
                           double *position, double *velocity, double *omega, double *attitude)
{
    assert(samples >= 1 && p->bodies >= 1 && room && work);
    motion m = laid_out(room, p->bodies);
    m.gravity = p->gravity;
    const int64_t n = p->bodies;
    int64_t events = 0;
    begun(p, &m, t[0], position, velocity, omega, attitude);
    work[0] = 0.0;
    for (int64_t row = 1; row < samples; row++) {
        for (int64_t i = earliest(&m); m.next[i] <= t[row]; i = earliest(&m)) {
            if (events == longest)
                return -row;
            if (events < most) {
                event[3 * events] = m.next[i];
                event[3 * events + 1] = (double)i;
                event[3 * events + 2] = m.partner[i];
            }
            events++;
            happened(p, &m, i);
        }
        for (int64_t i = 0; i < n; i++) {
            place(&m, i, t[row], position + 3 * (n * row + i));
            pace(&m, i, t[row], velocity + 3 * (n * row + i));
            faced(&m, i, t[row], attitude + 4 * (n * row + i));
        }
        memcpy(omega + 3 * n * row, m.omega, 3 * (size_t)n * sizeof *omega);
        work[row] = m.work;
    }
    return events;
}
