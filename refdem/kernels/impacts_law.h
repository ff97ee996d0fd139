/* The impulses of an impact of rigid spheres (impacts.c).
 *
 * With n from i to j, the relative velocity g of the points in contact, its component c along n and
 * its part s across n, the slip,
 *
 *     P = -p n - k s,   p = (1 + e) c / (1/m_i + 1/m_j),
 *     k = min((1 + b) / (1/m_i + 1/m_j + R_i^2/J_i + R_j^2/J_j), mu p / |s|)   (Walton 1993).
 */
#ifndef REFDEM_IMPACTS_LAW_H
#define REFDEM_IMPACTS_LAW_H

#include "impacts_state.h"

/* The impulse on a body, and the change of its spin: v += side P/m, omega += (R/J) n x P. */
static inline void push(const refdem_impacts *p, motion *m, int64_t i, double side,
                        const double *restrict impulse, const double *restrict turning)
{
    add_scaled(m->flight[i].velocity, side / p->mass[i], impulse);
    add_scaled(m->spin[i].omega, p->radius[i] / p->inertia[i], turning);
}

/* 1/m_i + 1/m_j of body i and body j, or a wall (j < 0). */
static inline double ease_along(const refdem_impacts *p, int64_t i, int64_t j)
{
    double ease = 1.0 / p->mass[i];
    if (j >= 0)
        ease += 1.0 / p->mass[j];
    return ease;
}

/* The impact of smooth spheres: P = -(1 + e) m_n c n, with 1/m_n = 1/m_i + 1/m_j. */
static inline void collide_smooth(const refdem_impacts *p, motion *m, int64_t i, int64_t j,
                                  const double *restrict normal)
{
    double relative[3];
    const double ease = ease_along(p, i, j);
    memcpy(relative, m->flight[i].velocity, sizeof relative);
    if (j >= 0)
        add_scaled(relative, -1.0, m->flight[j].velocity);
    /* P = -(1 + e) m_n c n on i, the opposite on j; c = (v_i - v_j).n. */
    const double closing = dot(relative, normal);
    const double along = (1.0 + p->restitution) * closing / ease;
    double impulse[3];
    for (int c = 0; c < 3; c++)
        impulse[c] = -along * normal[c];
    add_scaled(m->flight[i].velocity, 1.0 / p->mass[i], impulse);
    if (j >= 0)
        add_scaled(m->flight[j].velocity, -1.0 / p->mass[j], impulse);
    /* Work lost: (1 - e^2) m_n c^2/2. */
    const double left = p->restitution * p->restitution;
    m->work += 0.5 * ((1.0 - left) * closing * closing / ease);
}

/* The impact of spheres with friction, which changes their spins. */
static inline void collide_rough(const refdem_impacts *p, motion *m, int64_t i, int64_t j,
                                 const double *restrict normal)
{
    double relative[3], surface[3], swept[3], slip[3], impulse[3], turning[3];
    const double ease = ease_along(p, i, j);
    double turn_ease = p->radius[i] * p->radius[i] / p->inertia[i];
    for (int c = 0; c < 3; c++) {
        relative[c] = m->flight[i].velocity[c];
        surface[c] = p->radius[i] * m->spin[i].omega[c];
    }
    if (j >= 0) {
        turn_ease += p->radius[j] * p->radius[j] / p->inertia[j];
        for (int c = 0; c < 3; c++) {
            relative[c] -= m->flight[j].velocity[c];
            surface[c] += p->radius[j] * m->spin[j].omega[c];
        }
    }
    /* g = v_i - v_j + (R_i omega_i + R_j omega_j) x n; the last term has no component along n:
     * c = (v_i - v_j).n,  s = g - c n. */
    cross(surface, normal, swept);
    const double closing = dot(relative, normal);
    for (int c = 0; c < 3; c++)
        slip[c] = relative[c] - closing * normal[c] + swept[c];
    const double speed = size(slip);
    /* p = (1 + e) m_n c with 1/m_n = 1/m_i + 1/m_j; k = min((1 + b) m_t, mu p/|s|) with
     * 1/m_t = 1/m_n + R_i^2/J_i + R_j^2/J_j; P = -p n - k s. */
    const double across_mass = 1.0 / (ease + turn_ease);
    const double along = (1.0 + p->restitution) * closing / ease;
    double factor = (1.0 + p->tangential_restitution) * across_mass;
    if (factor * speed > p->friction * along)
        factor = p->friction * along / speed;
    for (int c = 0; c < 3; c++)
        impulse[c] = -along * normal[c] - factor * slip[c];
    cross(normal, impulse, turning);
    push(p, m, i, 1.0, impulse, turning);
    if (j >= 0)
        push(p, m, j, -1.0, impulse, turning);
    /* Work lost: (1 - e^2) m_n c^2/2 + (1 - (1 - k/m_t)^2) m_t s^2/2. */
    const double left = 1.0 - factor / across_mass;
    const double lost_along = (1.0 - p->restitution * p->restitution) * closing * closing / ease;
    const double lost_across = (1.0 - left * left) * speed * speed * across_mass;
    m->work += 0.5 * (lost_along + lost_across);
}

/* The impact of body i with body j, or with a wall (j < 0), along the unit normal from i on. */
static inline void collide(const refdem_impacts *p, motion *m, int64_t i, int64_t j,
                           const double *restrict normal)
{
    if (p->friction > 0.0)
        collide_rough(p, m, i, j, normal);
    else
        collide_smooth(p, m, i, j, normal);
}

/* The unit normal from body i to body j, or into the plane j < 0. */
static inline void normal_of(const refdem_impacts *p, const motion *m, int64_t i, int64_t j,
                             double *restrict normal)
{
    if (j < 0) {
        const double *plane = p->plane + 6 * (-1 - j);
        for (int c = 0; c < 3; c++)
            normal[c] = -plane[3 + c];
        return;
    }
    branch(m, m->flight[i].place, m->flight[j].place, normal);
    const double distance = size(normal);
    for (int c = 0; c < 3; c++)
        normal[c] /= distance;
}

/* Time since the last impact of body i or of body j, whichever was later. Fixed bodies and planes
 * do not count. */
static inline double flown(const refdem_impacts *p, const motion *m, int64_t i, int64_t j,
                           double now)
{
    double last = -INFINITY;
    if (!is_fixed(p, i))
        last = m->flight[i].since;
    if (j >= 0 && !is_fixed(p, j))
        last = fmax(last, m->flight[j].since);
    return now - last;
}

/* Advances a body to its impact. Without friction its spin is constant, and its attitude is not
 * needed before the next sample. */
static inline void advance_to_impact(const refdem_impacts *p, motion *m, int64_t i, double now)
{
    advance(m, i, now);
    if (p->friction > 0.0)
        turn(m, i, now);
}

/* The number of successive impacts of body i between which it has moved by less than the rounding
 * of its position, this impact included. */
static inline int64_t creeping(motion *m, int64_t i, double way)
{
    const flight *f = m->flight + i;
    const double far = fabs(f->place[0]) + fabs(f->place[1]) + fabs(f->place[2]) + f->radius;
    m->creeping[i]++;
    if (way > ROUNDINGS * far)
        m->creeping[i] = 0;
    return m->creeping[i];
}

/* The impact of body i with body j, or with a plane (j < 0), at the time now. False if they come to
 * rest against each other in infinitely many impacts: the times between impacts shrink
 * geometrically, and the distance moved between them is below the rounding of positions in more
 * than CREEPING + CREEPING_EACH bodies successive impacts. (The limit grows with the number of
 * bodies because in a chain of spheres in contact each may pass on the impulse of every other one,
 * by finitely many impacts without motion between them.) */
static inline bool strike(const refdem_impacts *p, motion *m, int64_t i, int64_t j, double now)
{
    enum { CREEPING = 1000, CREEPING_EACH = 10 };
    const double elapsed = flown(p, m, i, j, now);
    double normal[3], relative[3];
    advance_to_impact(p, m, i, now);
    memcpy(relative, m->flight[i].velocity, sizeof relative);
    if (j >= 0) {
        advance_to_impact(p, m, j, now);
        add_scaled(relative, -1.0, m->flight[j].velocity);
    }
    normal_of(p, m, i, j, normal);
    /* Distance moved along the normal since the last impact: (v_i - v_j).n elapsed. */
    const double way = dot(relative, normal) * elapsed;
    int64_t count = creeping(m, i, way);
    if (j >= 0)
        count = count < creeping(m, j, way) ? count : m->creeping[j];
    collide(p, m, i, j, normal);
    return count <= CREEPING + CREEPING_EACH * m->bodies;
}

#endif
