/* The C kernels of refdem. One section a family, which is one .c file and one extension module.
 *
 * Conventions: SI units, binary64, quaternions (w, x, y, z) body to space, omega in space axes unless a name says body.
 * Arrays are C-contiguous; sizes stand beside them; outputs come last and are filled in place. No allocation, no globals.
 * A function that can fail returns 0, or the 1-based number of the sample at which it failed.
 * Every section must end before the next marker; the glue is generated from these declarations.
 */
#ifndef REFDEM_KERNELS_H
#define REFDEM_KERNELS_H

#include <stddef.h>
#include <stdint.h>

/* == recorder == */

/* Steps any engine in a compiled loop and copies its state after every `stride` steps.
 *
 * step: address of `void step(void *a, void *b)` (kind 0) or `void step(void *a, double h)` (kind 1) or
 *       `void step(void *a, uint32_t n)` (kind 2: one call makes all `stride` steps).
 * source: n_source addresses of doubles to copy; size[i] doubles from each.
 * out (samples, sum of size): row 0 is the state at the start. Returns 0.
 */
int refdem_record(int kind, void *step, void *a, void *b, double h, int64_t samples, int64_t stride,
                  int64_t n_source, void *const *source, const int64_t *size, double *out);

/* == chipmunk == */

typedef struct { double x, y; } refdem_vector2;

/* Addresses in the engine: its space, its step, and what reads a body's state; angle and omega are NULL if nothing can turn. */
typedef struct {
    void *space;
    void (*step)(void *space, double h);
    refdem_vector2 (*position)(void *body);
    refdem_vector2 (*velocity)(void *body);
    double (*angle)(void *body);
    double (*omega)(void *body);
} refdem_chipmunk_engine;

/* Steps Chipmunk `stride` times a sample. out (samples, bodies, 6): x, y [m], vx, vy [m/s], angle [rad], omega [rad/s];
 * row 0 is the state at the start; angle and omega are left alone if nothing can turn. Returns 0. */
int refdem_chipmunk_record(const refdem_chipmunk_engine *engine, int64_t bodies, void *const *body, double h, int64_t samples,
                           int64_t stride, double *out);

/* == rebound_forces == */

/* What REBOUND's callbacks need. particle: address of the scene's first body in the engine's array; size and offsets of a
 * particle's columns in bytes. Ends are pairs of bodies, -1 the world. spring (springs, 6): stiffness [N/m^exponent],
 * length [m], exponent, anchor in the world (3) [m]. tension (rods) [N] is written by every evaluation of the forces.
 * inertia (turning, 3) [kg m^2], one row for each body that turns. */
typedef struct {
    char *particle;
    int64_t size, position, velocity, acceleration;
    int64_t bodies;
    const double *mass;
    const int64_t *fixed;
    const double *gravity;
    int64_t springs;
    const int64_t *spring_end;
    const double *spring;
    int64_t rods;
    const int64_t *rod_end;
    const double *rod_anchor;
    double *tension;
    int64_t turning;
    const double *inertia;
} refdem_rebound_scene;

/* Addresses in the engine: its simulation and functions, its clock [s], and the state of the further equations. */
typedef struct {
    void *simulation;
    int (*steps)(void *simulation, size_t count);
    int (*integrate)(void *simulation, double until);
    void (*update)(void *simulation);
    const double *clock;
    double *const *equations;
} refdem_rebound_engine;

/* The callback `void (void *simulation)` for an engine that keeps its user's pointer (to a refdem_rebound_scene) at byte
 * `place` of a simulation; NULL if there is none. Adds gravity, springs and rods to the accelerations. */
void *refdem_rebound_forces(int64_t place);

/* The callback `void (void *ode, double *rate, const double *y, double t)`: q' = q omega/2 and Euler's equations. */
void *refdem_rebound_euler(int64_t place);

/* Records a run: `stride` steps a sample, or (stride 0) integration to each of `times` (samples) [s].
 * out (samples, 1 + 6 bodies + 7 turning + rods): clock; position, velocity of every body; attitude, omega (body axes) of
 * every body that turns; tension of every rod. Returns 0, or the sample at which the engine gave up. */
int refdem_rebound_record(const refdem_rebound_engine *engine, const refdem_rebound_scene *scene, int64_t stride,
                          int64_t samples, const double *times, double *out);

/* == free_body == */

/* Attitude (samples, 4) and omega (samples, 3) of one free rigid body at times t [s], in closed form (error: a few ulp, plus
 * half an ulp of the inputs times the motion's own sensitivity); the state holds at t0. inertia (3) >= 0 [kg m^2], principal.
 * Returns 0. */
int refdem_free_body(const double *inertia, const double *attitude, const double *omega, double t0, int64_t samples,
                     const double *t, double *out_attitude, double *out_omega);

/* == rigid_body == */

/* The same body by steps h [s] of either sign, a sample after every `stride` steps; row 0 is the start. Returns 0.
 * splitting: order 2, symmetric, symplectic, keeps L in space to round-off. rk4: order 4. */
int refdem_rigid_body_splitting(const double *inertia, const double *attitude, const double *omega, double h, int64_t samples,
                                int64_t stride, double *out_attitude, double *out_omega);
int refdem_rigid_body_rk4(const double *inertia, const double *attitude, const double *omega, double h, int64_t samples,
                          int64_t stride, double *out_attitude, double *out_omega);

/* == pendulum == */

/* A point on a rod of `length` [m] from `anchor` (3), in the plane of rod and gravity (3) [m/s^2] (of rod and velocity without
 * gravity), at times t [s]; the state holds at t0. Position, velocity (samples, 3), force (samples) [N], positive in tension.
 * Closed form; errors are a few ulp of the motion's size for any number of periods. Returns 0. */
int refdem_pendulum(double mass, double length, const double *gravity, const double *anchor, const double *position,
                    const double *velocity, double t0, int64_t samples, const double *t, double *out_position, double *out_velocity,
                    double *out_force);

/* == oscillator == */

/* A point on a linear spring of natural length 0 [N/m] from `anchor` (3) in uniform gravity (3) [m/s^2]; as above. Returns 0. */
int refdem_harmonic(double mass, double stiffness, const double *gravity, const double *anchor, const double *position,
                    const double *velocity, double t0, int64_t samples, const double *t, double *out_position, double *out_velocity);

/* == kepler == */

/* A point about the origin with gravity parameter gm [m^3/s^2]; as above. Returns 0, or 1 if the orbit is not bound or straight. */
int refdem_kepler(double gm, const double *position, const double *velocity, double t0, int64_t samples, const double *t,
                  double *out_position, double *out_velocity);

/* == rattle == */

/* n points of mass (n) (infinite: fixed) in uniform gravity (3), on rods and springs; ends (.., 2) are numbers of points, the second
 * -1 for the world, where anchor (.., 3) is the place; spring_law (springs, 3): stiffness, length, exponent. Steps h [s] of either
 * sign, a sample after every `stride`. work: 9 n + 9 rods + rods^2 doubles. position, velocity (samples, n, 3): row 0 is the start;
 * force (samples, rods) [N], tension. Returns 0, or the sample (from 1) before which the rods could not be held. */
int refdem_rattle(int64_t n, const double *mass, const double *gravity, int64_t rods, const int64_t *rod_ends, const double *rod_anchor,
                  const double *rod_length, int64_t springs, const int64_t *spring_ends, const double *spring_anchor,
                  const double *spring_law, double h, int64_t samples, int64_t stride, double *work, double *position, double *velocity,
                  double *force);

/* == particles == */

/* Points and spheres. ease (bodies): 1/mass [1/kg], 0 for a fixed body; turn_ease (bodies): 1/inertia, 0 where nothing turns.
 * spring (springs, 6): stiffness [N/m^exponent], length [m], exponent, anchor in the world (3) [m]; its ends are pairs of
 * bodies, -1 the world. plane (planes, 6): point [m], unit normal. pair: bodies i and j that can meet, j = -1 - k for plane k.
 * branch: lever arm R - branch * overlap. no_pull: the contact ends when its force would pull. */
typedef struct {
    int64_t bodies;
    const double *mass, *ease, *turn_ease, *radius;
    const double *gravity;
    double gm;
    int64_t springs;
    const int64_t *spring_end;
    const double *spring;
    const double *plane;
    int64_t pairs;
    const int64_t *pair;
    double stiffness, damping, tangential_stiffness, friction, branch;
    int no_pull, turning;
} refdem_particles;

/* Numbers in a state: position, velocity (3 each a body); omega (3) and attitude (4) if `turning`; 3 a pair if there is
 * friction; the work done against damping and friction [J]. And numbers that a run needs as work space. */
int64_t refdem_particles_size(const refdem_particles *p);
int64_t refdem_particles_work(const refdem_particles *p);

/* Steps of size h [s], `stride` a sample, by velocity Verlet (method 0), classical Runge-Kutta (1) or extrapolation to
 * round-off (2). out (samples, size): row 0 is the state at the start. mode (pairs), work (see above): work space.
 * event (most, 3): time [s] after the start, 1 contact or 2 release, body. channel (samples, 4): pairs that press, largest
 * overlap [m], largest normal force [N], work lost [J]. Returns the number of events kept. */
int64_t refdem_particles_run(const refdem_particles *p, int method, double h, int64_t samples, int64_t stride, int64_t most,
                             int64_t *mode, double *work, double *event, double *channel, double *out);

/* == coulomb == */

/* m x'' + f Sgn(x') + k x = m g with f = friction normal_force > 0, k > 0: x, v at the samples t (samples) [s], t[i] >= t0,
 * from x0 [m], v0 [m/s] at t0. out (samples, 3): x [m], v [m/s], work done against friction [J]. stop: when it stops for
 * ever [s]. Errors: a few ulp of the amplitude, however long it lasts. Returns 0. */
int refdem_coulomb(double mass, double stiffness, double friction, double normal_force, double gravity, double x0, double v0,
                   double t0, int64_t samples, const double *t, double *stop, double *out);

/* == head_on == */

/* Two spheres that meet along the line of their centres under the linear law, no friction acting: from `overlap` <= 0 [m],
 * growing at `closing` [m/s], at the times t (samples) >= 0 [s] after the start. touch (2): when they touch and part [s].
 * out (samples, 5): overlap [m], its rate [m/s], 1 while they press, normal force [N], work lost [J]. Returns 0. */
int refdem_head_on(double mass1, double mass2, double stiffness, double damping, int no_pull, double overlap, double closing,
                   int64_t samples, const double *t, double *touch, double *out);

/* == end == */
#endif
