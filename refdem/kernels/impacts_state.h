/* The state of rigid spheres, and the times at which they meet (impacts.c).
 *
 * The position and velocity of a sphere are kept at a time of its own, that of its last impact:
 *
 *     r(t) = r + v s + g s^2/2,   v(t) = v + g s,   s = t - since,
 *
 * and are advanced only when it takes part in an impact.
 */
#ifndef REFDEM_IMPACTS_STATE_H
#define REFDEM_IMPACTS_STATE_H

#include <assert.h>
#include <stdbool.h>
#include <string.h>

#include "impacts_kernel.h"
#include "quaternion.h"
#include "space.h"

/* Partners of an impact: a sphere by its number, plane k as -1 - k, NOBODY if there is none. */
enum { NOBODY = INT32_MIN };

/* Bound, relative to the speeds, on a closing speed that is 0 up to the rounding of the velocities
 * after an impact and of their components along the normal. */
static const double ROUNDINGS = 16.0 * 0x1p-53;

/* The flight of a sphere: all that the search for impacts reads, in one cache line. */
typedef struct {
    double place[3], velocity[3], since, radius;
} flight;

/* The rotation of a sphere: spin and attitude at a time of its own. */
typedef struct {
    double omega[3], attitude[4], since;
} spin;

/* The state of all bodies. In a periodic box positions are kept in the box, and `boxes` (bodies, 3)
 * counts the whole periods that a body has moved. `creeping` is the number of successive impacts of
 * each body between which it moves by less than the rounding of its position. `next` and `partner`
 * are the next impact of each body where every pair is examined (impacts_pairs.h). */
typedef struct {
    int64_t bodies;
    bool falls;
    double gravity[3];
    double period;
    int64_t *boxes;
    flight *flight;
    spin *spin;
    int64_t *creeping;
    double *next, *partner;
    double work;
} motion;

/* True for a fixed body, of infinite mass. */
static inline bool is_fixed(const refdem_impacts *p, int64_t i)
{
    return isinf(p->mass[i]);
}

/* Place r + v s + g s^2/2 of a body at the time now, s = now - since. */
static inline void place(const motion *m, int64_t i, double now, double *restrict out)
{
    const flight *f = m->flight + i;
    const double elapsed = now - f->since;
    for (int c = 0; c < 3; c++)
        out[c] = fma(f->velocity[c], elapsed, f->place[c]);
    if (m->falls)
        add_scaled(out, 0.5 * elapsed * elapsed, m->gravity);
}

/* Place of a body at the time now in unbounded space, place + boxes period. */
static inline void place_beyond(const motion *m, int64_t i, double now, double *restrict out)
{
    place(m, i, now, out);
    if (!(m->period > 0.0))
        return;
    for (int c = 0; c < 3; c++)
        out[c] += (double)m->boxes[3 * i + c] * m->period;
}

/* Velocity v + g s of a body at the time now. */
static inline void velocity(const motion *m, int64_t i, double now, double *restrict out)
{
    const flight *f = m->flight + i;
    memcpy(out, f->velocity, sizeof f->velocity);
    if (m->falls)
        add_scaled(out, now - f->since, m->gravity);
}

/* Attitude of a body at the time now, after a rotation by |omega| s about a fixed axis:
 * q = (cos(|omega| s/2), sin(|omega| s/2) omega/|omega|) q_since. */
static inline void faced(const motion *m, int64_t i, double now, double *restrict out)
{
    const spin *s = m->spin + i;
    const double rate = size(s->omega);
    const double half = 0.5 * rate * (now - s->since);
    double turn[4] = {cos(half), 0.0, 0.0, 0.0};
    if (rate == 0.0) {
        memcpy(out, s->attitude, sizeof s->attitude);
        return;
    }
    for (int c = 0; c < 3; c++)
        turn[1 + c] = sin(half) * (s->omega[c] / rate);
    quaternion_product(turn, s->attitude, out);
    quaternion_normalised(out);
}

/* Brings the flight of a body to the time now. */
static inline void advance(motion *m, int64_t i, double now)
{
    double r[3], v[3];
    place(m, i, now, r);
    velocity(m, i, now, v);
    memcpy(m->flight[i].place, r, sizeof r);
    memcpy(m->flight[i].velocity, v, sizeof v);
    m->flight[i].since = now;
}

/* Brings the attitude of a body to the time now. */
static inline void turn(motion *m, int64_t i, double now)
{
    double q[4];
    faced(m, i, now, q);
    memcpy(m->spin[i].attitude, q, sizeof q);
    m->spin[i].since = now;
}

/* r_j - r_i; in a periodic box to the nearest image of j, of places less than a period and a half
 * apart. */
static inline void branch(const motion *m, const double *restrict ri, const double *restrict rj,
                          double *restrict out)
{
    const double half = 0.5 * m->period;
    for (int c = 0; c < 3; c++) {
        out[c] = rj[c] - ri[c];
        if (!(half > 0.0))
            continue;
        if (out[c] > half)
            out[c] -= m->period;
        else if (out[c] < -half)
            out[c] += m->period;
    }
}

/* Time from now until two spheres meet, or infinity. Gravity is the same for both, so that their
 * relative velocity w is constant: with R = R_i + R_j, d = (r_j - r_i)/R, u = w/|w|, b = d.u,
 *
 *   s = (R/|w|) (|d| - 1) (|d| + 1)/(-b + sqrt(q)),   q = 1 - |d x u|^2   (impacts.c).
 *
 * They do not meet if b >= 0 (up to rounding) or q <= 0. */
static inline double until_spheres(const refdem_impacts *p, const motion *m, int64_t i, int64_t j,
                                   double now)
{
    /* R = R_i + R_j, d = (r_j - r_i)/R, w = v_j - v_i. */
    const double reach = p->radius[i] + p->radius[j];
    double vi[3], vj[3], ri[3], rj[3], apart[3], relative[3], swept[3];
    velocity(m, i, now, vi);
    velocity(m, j, now, vj);
    place(m, i, now, ri);
    place(m, j, now, rj);
    branch(m, ri, rj, apart);
    for (int c = 0; c < 3; c++) {
        apart[c] /= reach;
        relative[c] = vj[c] - vi[c];
    }
    const double speed = size(relative);
    if (!(speed > 0.0))
        return INFINITY;
    for (int c = 0; c < 3; c++)
        relative[c] /= speed;
    /* b = d.w/|w|: they approach if it is below zero. */
    const double distance = size(apart);
    const double b = dot(apart, relative);
    if (!(-b * speed > ROUNDINGS * distance * (size(vi) + size(vj))))
        return INFINITY;
    cross(apart, relative, swept);
    const double q = 1.0 - dot(swept, swept);
    if (!(q > 0.0))
        return INFINITY;
    /* s = (R/|w|) (|d| - 1) (|d| + 1)/(sqrt(q) - b). */
    const double gap = (distance - 1.0) * (distance + 1.0);
    return fmax(0.0, gap / (sqrt(q) - b)) * (reach / speed);
}

/* The first time s >= 0 with v s + a s^2/2 = D = max(0, ahead), passed in the positive direction,
 * or infinity. With q = v^2 + 2 a D, s = 2 D/(v + sqrt(q)) if v > 0, else (sqrt(q) - v)/a if a > 0,
 * each without cancellation. A negative `ahead` is a rounding, and counts as 0. */
static inline double until_passed(double ahead, double v, double a)
{
    const double way = fmax(0.0, ahead);
    const double square = v * v + 2.0 * a * way;
    if (!(square >= 0.0))
        return INFINITY;
    if (v > 0.0)
        return 2.0 * way / (v + sqrt(square));
    if (a > 0.0)
        return (sqrt(square) - v) / a;
    return INFINITY;
}

/* Time until a sphere at r with velocity v meets a plane (6), or infinity: h - c t - a t^2/2 = 0
 * with the height h, the closing speed c and the pull a towards the plane. The first root is 2 h/(c
 * + sqrt(q)) with q = c^2 + 2 a h, and (sqrt(q) - c)/a if the sphere moves away and is pulled back.
 */
static inline double until_plane(const motion *m, const double *restrict plane,
                                 const double *restrict r, const double *restrict v, double radius)
{
    const double *normal = plane + 3;
    double from[3];
    for (int c = 0; c < 3; c++)
        from[c] = r[c] - plane[c];
    /* c = -v.n, h = (r - P).n - R with the point P of the plane, a = -g.n. */
    const double closing = -dot(v, normal);
    const double height = dot(from, normal) - radius;
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

#endif
