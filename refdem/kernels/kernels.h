/* The C kernels of refdem. One section a family, which is one .c file and one extension module.
 *
 * Conventions: SI units, binary64, quaternions (w, x, y, z) body to space, omega in space axes
 * unless a name says body. Arrays are C-contiguous; sizes stand beside them; outputs come last and
 * are filled in place. No allocation, no globals. A function that can fail returns 0, or the
 * 1-based number of the sample at which it failed. Every section must end before the next marker;
 * the glue is generated from these declarations.
 *
 * The files name their phases alike, and put them in this order, so that two of them can be laid
 * side by side.
 *
 * Contacts, from event to event: begin (state and modes of the start), measure (geometry, slip and
 * force of one contact), expand or rates (the motion within the modes), step_size, locate (the
 * first event within the step), record (samples), accept (the end of the step becomes the state),
 * change_mode (at the event).
 *
 * Taylor series: expand, step_size, record, accept.
 *
 * Steps of fixed size: begin, kick, drift, hold (constraints), finish.
 *
 * Closed forms: prepare (constants of the motion from its start), state_at (one time), run (all
 * samples).
 */
#ifndef REFDEM_KERNELS_H
#define REFDEM_KERNELS_H

#include <stddef.h>
#include <stdint.h>

/* == recorder == */

/* Steps any engine in a compiled loop and copies its state after every `stride` steps.
 *
 * step: address of `void step(void *a, void *b)`. source: n_source addresses of doubles to copy;
 * size[i] doubles from each. out (samples, sum of size): row 0 is the state at the start. Returns
 * 0.
 */
int refdem_record(void *step, void *a, void *b, int64_t samples, int64_t stride, int64_t n_source,
                  void *const *source, const int64_t *size, double *out);

/* == rebound_forces == */

/* What REBOUND's callbacks need. particle: address of the scene's first body in the engine's array;
 * size and offsets of a particle's columns in bytes. Ends are pairs of bodies, -1 the world. spring
 * (springs, 8): stiffness [N/m^exponent], length [m], exponent, anchor in the world (3) [m],
 * quadratic [N/m^2], cubic [N/m^3]. dashpot (dashpots, 8): damping [N s/m], van_der_pol [N s/m^3],
 * anchor, rate of the fluid (3) [rad/s]. contact (contacts, 5): sum of the radii [m], stiffness
 * [N/m^exponent], exponent, damping [N s/m], 1 if the force may pull, else 0. field (fields, 10):
 * k1, k2 [N/m], x1, x2 [m], point (3) [m], axis (3) of a piecewise field. drive (drives, 6): force
 * [N], frequency [rad/s], phase, axis (3); `clock` [s] is the engine's. tension (rods) [N] is
 * written by every evaluation of the forces. inertia (turning, 3) [kg m^2], one row for each body
 * that turns. */
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
    int64_t dashpots;
    const int64_t *dashpot_end;
    const double *dashpot;
    int64_t contacts;
    const int64_t *contact_end;
    const double *contact;
    int64_t fields;
    const double *field;
    int64_t drives;
    const int64_t *drive_end;
    const double *drive;
    const double *clock;
    int64_t rods;
    const int64_t *rod_end;
    const double *rod_anchor;
    double *tension;
    int64_t turning;
    const double *inertia;
} refdem_rebound_scene;

/* Addresses in the engine: its simulation and functions, its clock [s], and the state of the
 * further equations. */
typedef struct {
    void *simulation;
    int (*steps)(void *simulation, size_t count);
    int (*integrate)(void *simulation, double until);
    void (*update)(void *simulation);
    const double *clock;
    double *const *equations;
} refdem_rebound_engine;

/* The callback `void (void *simulation)` for an engine that keeps its user's pointer (to a
 * refdem_rebound_scene) at byte `place` of a simulation; NULL if there is none. Adds gravity,
 * springs, dashpots, contacts, fields, drives and rods to the accelerations. */
void *refdem_rebound_forces(int64_t place);

/* The callback `void (void *ode, double *rate, const double *y, double t)`: q' = q omega/2 and
 * Euler's equations. */
void *refdem_rebound_euler(int64_t place);

/* Records a run: `stride` steps a sample, or (stride 0) integration to each of `times` (samples)
 * [s]. out (samples, 1 + 6 bodies + 7 turning + rods): clock; position, velocity of every body;
 * attitude, omega (body axes) of every body that turns; tension of every rod. Returns 0, or the
 * sample at which the engine gave up. */
int refdem_rebound_record(const refdem_rebound_engine *engine, const refdem_rebound_scene *scene,
                          int64_t stride, int64_t samples, const double *times, double *out);

/* == free_body == */

/* Attitude (samples, 4) and omega (samples, 3) of one free rigid body at times t [s], in closed
 * form (error: a few ulp, plus half an ulp of the inputs times the motion's own sensitivity); the
 * state holds at t0. inertia (3) >= 0 [kg m^2], principal. In two parts, what the start decides
 * (into motion: as many doubles as _size says) and the samples; or in one. All return 0. */
int64_t refdem_free_body_size(void);
int refdem_free_body_prepare(const double *inertia, const double *attitude, const double *omega,
                             double t0, int64_t samples, const double *t, double *out_attitude,
                             double *out_omega, double *motion);
int refdem_free_body_run(const double *motion);
int refdem_free_body(const double *inertia, const double *attitude, const double *omega, double t0,
                     int64_t samples, const double *t, double *out_attitude, double *out_omega);

/* == rigid_body == */

/* The same body by steps h [s] of either sign, a sample after every `stride` steps; row 0 is the
 * start. Returns 0. splitting: order 2, symmetric, symplectic, keeps L in space to round-off. rk4:
 * order 4. */
int refdem_rigid_body_splitting(const double *inertia, const double *attitude, const double *omega,
                                double h, int64_t samples, int64_t stride, double *out_attitude,
                                double *out_omega);
int refdem_rigid_body_rk4(const double *inertia, const double *attitude, const double *omega,
                          double h, int64_t samples, int64_t stride, double *out_attitude,
                          double *out_omega);

/* The same by rk4's method on Euler's angles, in the one of two frames that is away from its pole.
 */
int refdem_rigid_body_euler_angles(const double *inertia, const double *attitude,
                                   const double *omega, double h, int64_t samples, int64_t stride,
                                   double *out_attitude, double *out_omega);

/* The same by Gear's predictor-corrector on the quaternion's own equation of second order, with
 * `values` rows of Nordsieck's (5 to 7) and the coefficients `corrector` (values) of gear.h; three
 * moments above 0. */
int refdem_rigid_body_gear(const double *inertia, const double *attitude, const double *omega,
                           int values, const double *corrector, double h, int64_t samples,
                           int64_t stride, double *out_attitude, double *out_omega);

/* == pendulum == */

/* A point on a rod of `length` [m] from `anchor` (3), in the plane of rod and gravity (3) [m/s^2]
 * (of rod and velocity without gravity), at times t [s]; the state holds at t0. Position, velocity
 * (samples, 3), force (samples) [N], positive in tension. Closed form; errors are a few ulp of the
 * motion's size for any number of periods. In two parts, as for a free body, or in one. All return
 * 0. */
int64_t refdem_pendulum_size(void);
int refdem_pendulum_prepare(double mass, double length, const double *gravity, const double *anchor,
                            const double *position, const double *velocity, double t0,
                            int64_t samples, const double *t, double *out_position,
                            double *out_velocity, double *out_force, double *motion);
int refdem_pendulum_run(const double *motion);
int refdem_pendulum(double mass, double length, const double *gravity, const double *anchor,
                    const double *position, const double *velocity, double t0, int64_t samples,
                    const double *t, double *out_position, double *out_velocity, double *out_force);

/* == oscillator == */

/* A point on a linear spring of natural length 0 [N/m] from `anchor` (3) in uniform gravity (3)
 * [m/s^2]; as above. Returns 0. */
int refdem_harmonic(double mass, double stiffness, const double *gravity, const double *anchor,
                    const double *position, const double *velocity, double t0, int64_t samples,
                    const double *t, double *out_position, double *out_velocity);

/* == kepler == */

/* A point about the origin with gravity parameter gm [m^3/s^2]; as above, in two parts or in one.
 * All return 0, or 1 if the orbit is not bound or straight. */
int64_t refdem_kepler_size(void);
int refdem_kepler_prepare(double gm, const double *position, const double *velocity, double t0,
                          int64_t samples, const double *t, double *out_position,
                          double *out_velocity, double *motion);
int refdem_kepler_run(const double *motion);
int refdem_kepler(double gm, const double *position, const double *velocity, double t0,
                  int64_t samples, const double *t, double *out_position, double *out_velocity);

/* == rattle == */

/* n points of mass (n) (infinite: fixed) in uniform gravity (3), on rods and springs; ends (.., 2)
 * are numbers of points, the second -1 for the world, where anchor (.., 3) is the place; spring_law
 * (springs, 3): stiffness, length, exponent. Steps h [s] of either sign, a sample after every
 * `stride`. work: 9 n + 8 rods + rods^2 doubles, unknown: rods integers. position, velocity
 * (samples, n, 3): row 0 is the start; force (samples, rods) [N], tension. Returns 0, or the sample
 * (from 1) before which the rods could not be held. */
int refdem_rattle(int64_t n, const double *mass, const double *gravity, int64_t rods,
                  const int64_t *rod_ends, const double *rod_anchor, const double *rod_length,
                  int64_t springs, const int64_t *spring_ends, const double *spring_anchor,
                  const double *spring_law, double h, int64_t samples, int64_t stride, double *work,
                  int64_t *unknown, double *position, double *velocity, double *force);

/* == rod_taylor == */

/* A point on a rod of `length` [m] from `anchor` (3) in uniform gravity (3) [m/s^2], in space, at
 * times t [s] that all lie on one side of t0 and each farther than the one before; outputs as for
 * the pendulum. |r| = length and r.v = 0 to round-off; errors: round-off times the motion's own
 * sensitivity. Returns 0, or the sample (from 1) before which the speed is no longer finite. */
int refdem_rod_taylor(double mass, double length, const double *gravity, const double *anchor,
                      const double *position, const double *velocity, double t0, int64_t samples,
                      const double *t, double *out_position, double *out_velocity,
                      double *out_force);

/* == joined_rods == */

/* `count` points on rods of `length` (count) [m] that hang from `pivot` (count, 2) in a plane, in
 * uniform gravity (2), joined by linear springs; aim (count, 2): sine and cosine of the angles at
 * the start. ends (springs, 2) are numbers of points, the second -1 for the place `fixed` (springs,
 * 2); stiffness [N/m], and length without force `rest` [m]. out (samples, 2 count + springs):
 * angles since the start [rad], rates [rad/s], and work space of the kernel; row 0 is the start,
 * given. Returns 0, or the sample (from 1) that was not reached: a spring that shrinks to nothing
 * has no direction. */
int refdem_joined_rods(int64_t count, const double *length, const double *mass, const double *aim,
                       const double *pivot, int64_t springs, const int64_t *ends,
                       const double *fixed, const double *stiffness, const double *rest,
                       const double *gravity, int64_t samples, const double *t, double *out);

/* == pendulum_ensemble == */

/* theta'' = -square sin theta, square [1/s^2], for all members at once, `steps` steps h [s] of
 * either sign: Verlet's method composed of an odd number of stages, at most 63, the parts of a step
 * in weight ((stages + 1) / 2), which the others mirror. angle (members) [rad], |angle| < 1e9, and
 * rate (members) [rad/s] are moved on in place. Returns 0, or 1 if there are too many stages. */
int refdem_pendulum_ensemble(int stages, const double *weight, double square, double h,
                             int64_t steps, int64_t members, double *angle, double *rate);

/* == lattice == */

/* m x'' = weight - stiffness |x|^exponent sgn x - cubic x^3 in SI units; the units of the lattice,
 * powers of two: place [m], speed [m/s], such that no place or velocity reaches 2^62 of them. */
typedef struct {
    double mass, stiffness, exponent, cubic, weight, place, speed;
} refdem_lattice;

/* x [m] and v [m/s] from x0, v0 by Verlet's method on the lattice, `stride` steps h [s] of either
 * sign a sample; out (samples, 2), row 0 the start as given. Returns 0. */
int refdem_lattice_verlet(const refdem_lattice *p, double x0, double v0, double h, int64_t samples,
                          int64_t stride, double *out);

/* == particles == */

/* Points and spheres. inverse_mass (bodies) [1/kg], 0 for a fixed body; inverse_inertia (bodies)
 * [1/(kg m^2)], 0 where nothing turns. spring (springs, 8): stiffness [N/m^exponent], length [m],
 * exponent, anchor in the world (3) [m], quadratic [N/m^2], cubic [N/m^3]; its ends are pairs of
 * bodies, -1 the world. plane (planes, 6): point [m], unit normal. pair: bodies i and j that can
 * meet, j = -1 - k for plane k. slip_shortening, torque_shortening: slip is measured at the lever R
 * - slip_shortening * overlap, and friction turns with R - torque_shortening * overlap. no_pull:
 * the contact ends when its force would pull. hertz: F = k d^(3/2), and the tangential spring has
 * the stiffness tangential_stiffness sqrt(d) (both [N/m^(3/2)]). */
typedef struct {
    int64_t bodies;
    const double *mass, *inverse_mass, *inverse_inertia, *radius;
    const double *gravity;
    double gm;
    int64_t springs;
    const int64_t *spring_end;
    const double *spring;
    const double *plane;
    int64_t pairs;
    const int64_t *pair;
    double stiffness, damping, tangential_stiffness, friction, slip_shortening, torque_shortening;
    int no_pull, turning, hertz;
} refdem_particles;

/* Numbers in a state: position, velocity (3 each a body); omega (3) and attitude (4) if `turning`;
 * 3 a pair if there is friction; the work done against damping and friction [J]. And numbers that a
 * run needs as work space. */
int64_t refdem_particles_size(const refdem_particles *p);
int64_t refdem_particles_work(const refdem_particles *p);

/* Steps of size h [s], `stride` a sample, by velocity Verlet (method 0), classical Runge-Kutta (1)
 * or extrapolation to round-off (2). out (samples, size): row 0 is the state at the start. mode
 * (pairs), work (see above): work space. event (most, 3): time [s] after the start, 1 contact or 2
 * release, body. channel (samples, 4): pairs that press, largest overlap [m], largest normal force
 * [N], work lost [J]. Returns the number of events kept. */
int64_t refdem_particles_run(const refdem_particles *p, int method, double h, int64_t samples,
                             int64_t stride, int64_t most, int64_t *mode, double *work,
                             double *event, double *channel, double *out);

/* The same without contacts, and without bodies that turn, by Gear's predictor-corrector with
 * `values` rows of Nordsieck's (5 to 7) and the coefficients `corrector` (values) of gear.h. out
 * (samples, size): row 0 is the state at the start. work: refdem_particles_gear_work doubles.
 * Returns 0. */
int64_t refdem_particles_gear_work(const refdem_particles *p);
int refdem_particles_gear(const refdem_particles *p, int values, const double *corrector, double h,
                          int64_t samples, int64_t stride, double *work, double *out);

/* == coulomb == */

/* m x'' + f Sgn(x') + k x = m g with f = friction normal_force > 0, k > 0: x, v at the samples t
 * (samples) [s], t[i] >= t0, from x0 [m], v0 [m/s] at t0. out (samples, 3): x [m], v [m/s], work
 * done against friction [J]. stop: when it stops for ever [s]. Errors: a few ulp of the amplitude,
 * however long it lasts. In two parts, as for a free body, or in one. All return 0. */
int64_t refdem_coulomb_size(void);
int refdem_coulomb_prepare(double mass, double stiffness, double friction, double normal_force,
                           double gravity, double x0, double v0, double t0, int64_t samples,
                           const double *t, double *stop, double *out, double *motion);
int refdem_coulomb_run(const double *motion);
int refdem_coulomb(double mass, double stiffness, double friction, double normal_force,
                   double gravity, double x0, double v0, double t0, int64_t samples,
                   const double *t, double *stop, double *out);

/* == head_on == */

/* Two spheres that meet along the line of their centres under the linear law, no friction acting:
 * from `overlap` <= 0 [m], growing at `closing` [m/s], at the times t (samples) >= 0 [s] after the
 * start. touch (2): when they touch and part [s]. out (samples, 5): overlap [m], its rate [m/s], 1
 * while they press, normal force [N], work lost [J]. Returns 0. */
int refdem_head_on(double mass1, double mass2, double stiffness, double damping, int no_pull,
                   double overlap, double closing, int64_t samples, const double *t, double *touch,
                   double *out);

/* == taylor_oscillator == */

/* A point on a line, X its way from where its spring is at rest:
 * m X'' = -(linear X + quadratic X^2 + cubic X^3) - (damping + van_der_pol (X + offset)^2) X' +
 * weight + sum F cos(w t + phase), in kg, N/m, N/m^2, N/m^3, N s/m, N s/m^3, m, N; drive (drives,
 * 3): F [N], w [rad/s], phase. */
typedef struct {
    double mass, linear, quadratic, cubic, damping, van_der_pol, offset, weight;
    int64_t drives;
    const double *drive;
} refdem_oscillator;

/* X, V from x0 [m], v0 [m/s] at t0, at the times t (samples) [s], all on one side of t0 and each
 * farther than the one before. out (samples, 3): X, V, and the work [J] done by the motion against
 * damping and drives. Errors: round-off times the motion's own sensitivity. Returns 0, or the
 * sample (from 1) before which the motion goes to infinity. */
int refdem_taylor_oscillator(const refdem_oscillator *p, double x0, double v0, double t0,
                             int64_t samples, const double *t, double *out);

/* == linear_oscillator == */

/* drive (drives, 3): F [N], w [rad/s], phase. */
typedef struct {
    double mass, linear, damping, weight;
    int64_t drives;
    const double *drive;
} refdem_linear;

/* m X'' = -linear X - damping X' + weight + sum F cos(w t + phase), linear > 0 [N/m], damping [N
 * s/m], weight [N], in closed form: X, V from x0 [m], v0 [m/s] at t0, at any times t (samples) [s].
 * out (samples, 2): X, V. Errors: a few ulp of the sizes of the free and of the driven motion,
 * however long it lasts. Returns 0. */
int refdem_linear_oscillator(const refdem_linear *p, double x0, double v0, double t0,
                             int64_t samples, const double *t, double *out);

/* == power_oscillator == */

/* m x'' + k |x|^n sgn x = 0, n >= 1 [N/m^n], from x0, v0 at t0, at any times t (samples) [s]; in
 * closed form. out (samples, 2): x, v. Errors: a few ulp, times the motion's own sensitivity.
 * Returns 0. */
int refdem_power_oscillator(double mass, double stiffness, double exponent, double x0, double v0,
                            double t0, int64_t samples, const double *t, double *out);

/* == maps == */

/* Iterates n (samples), whole numbers that do not fall, of x -> eta x (1 - x), and of the flow of
 * x' = eta x (1 - x) over one unit of time, from x0 in [0, 1]; out (samples). Each step rounds a
 * few times; the flow is taken in one. Returns 0. */
int refdem_logistic(double eta, double x0, int64_t samples, const double *n, double *out);
int refdem_logistic_flow(double eta, double x0, int64_t samples, const double *n, double *out);

/* Bounces n (samples), whole numbers that do not fall, in a table of width and height [m] centred
 * on the origin: a rectangle, or a stadium (width >= height). start (4): a place inside [m], a unit
 * direction; out (samples, 4): place [m] of the bounce, direction after it; bounce 0 is the start.
 * Errors: a few ulp, times the motion's own sensitivity. Returns 0, or 1 for a direction of length
 * 0. */
int refdem_rectangle(double width, double height, const double *start, int64_t samples,
                     const double *n, double *out);
int refdem_stadium(double width, double height, const double *start, int64_t samples,
                   const double *n, double *out);

/* == stick_slip == */

/* A point on a spring that rubs on a belt: m x'' in amplitude cos(frequency t + phase) + weight -
 * stiffness x - N mu(|u|) Sgn(u) with u = x' - belt, mu(s) = (mu0 - mu1)/(1 + lambda0 s) + mu1 +
 * lambda1 s^2 (`linear`: lambda1 s), in SI units; x from the spring's anchor. */
typedef struct {
    double mass, stiffness, weight, normal_force, mu0, mu1, lambda0, lambda1, belt, amplitude,
        frequency, phase;
    int linear;
} refdem_belt;

/* x [m], v [m/s] and the work [J] done against friction and drive, from x0, v0 at t0, at times t
 * (samples) >= t0 [s], rising. out (samples, 3): v is exactly the belt's while it sticks. event
 * (most, 2): time [s], 1 it comes to stick, 2 it is released. Errors: round-off times the motion's
 * own sensitivity; events to the last bits. Returns the number of events kept. */
int64_t refdem_stick_slip(const refdem_belt *p, double x0, double v0, double t0, int64_t samples,
                          const double *t, int64_t most, double *event, double *out);

/* The section v = 0, x + origin > 0 for n frequencies > 0 [rad/s] of the drive, each from x0, v0 at
 * t = 0: after `skip` periods of the drive, over `keep` more. out (n, most): x + origin in order,
 * counts (n) of them. sums (n, blocks): growth of the logarithm of a tangent over equal parts of
 * the time kept; none if blocks is 0. Returns 0. */
int refdem_stick_slip_section(const refdem_belt *p, int64_t n, const double *frequency,
                              double origin, double x0, double v0, int64_t skip, int64_t keep,
                              int64_t blocks, int64_t most, double *counts, double *sums,
                              double *out);

/* == oblique == */

/* Two spheres under the linear contact law with a tangential spring, or without friction.
 * inverse_mass: 1/m_i + 1/m_j [1/kg]; inverse_inertia: 1/J [1/(kg m^2)]; lever arms are radius -
 * branch d; no_pull: the contact ends where the force does. longest: no stretch is longer [s]. */
typedef struct {
    double radius_i, radius_j, inverse_mass, inverse_inertia_i, inverse_inertia_j, stiffness,
        damping, tangential_stiffness, friction, branch, longest;
    int no_pull;
} refdem_oblique_pair;

/* start (6): overlap, its rate, the transverse velocity of j relative to i, 0, and the spins about
 * the third axis; the spheres touch or overlap. t (samples): rising times, at least 0 [s]. out
 * (samples, 12): overlap, its rate, transverse velocity, the angle of the line of centres, spins,
 * angles turned, work done against damping and friction (with the energy of the spring), whether
 * it presses, the normal force, the work without that energy. release: the time at which the
 * spheres part [s], or infinity. Errors: a few ulp. Returns the number of samples reached. */
int64_t refdem_oblique(const refdem_oblique_pair *p, const double *start, int64_t samples,
                       const double *t, double *release, double *out);

/* == rod_chain == */

/* A planar chain of up to 8 points (mass, rods) [kg] on rods (length, rods) [m] below a pivot at
 * drive cos(frequency t + phase) (drive (2) [m], frequency [rad/s]) in uniform gravity (2) [m/s^2],
 * at the times t (samples) of either direction. Angles are from the direction (0, -1), positive
 * towards (1, 0); aim (rods, 2): their sines and cosines at the start, from which they count. out
 * (samples, 2 rods + 1): angles [rad], rates [rad/s], work [J] that the pivot has done on the
 * chain; row 0 is the start, given: 0, the rates, 0. Taylor series of order 20; errors are a few
 * ulp times the sensitivity of the motion. Returns 0, or the sample that was not reached. */
int refdem_rod_chain(int64_t rods, const double *length, const double *aim, const double *mass,
                     const double *gravity, const double *drive, double frequency, double phase,
                     int64_t samples, const double *t, double *out);

/* == dissipating_body == */

/* A body with principal moments inertia (3) [kg m^2] and a damping [s/(kg m^2)] inside, at the
 * times t (samples) of either direction. out (samples, 7): angular momentum in principal axes [kg
 * m^2/s], attitude (w, x, y, z); row 0 is the start, given. Taylor series of order 20; errors are a
 * few ulp times the sensitivity of the motion. Returns 0, or the sample that was not reached. */
int refdem_dissipating_body(const double *inertia, double damping, int64_t samples, const double *t,
                            double *out);

/* == string_wheel == */

/* A pendulum of `mass` [kg] on the free part of a string over a wheel of `radius` [m], `counter`
 * [kg] on the other side, `drag` = J/R^2 [kg], gravity [m/s^2]. out (samples, 4): r [m], theta
 * [rad], u = r' - R theta' [m/s], theta' [rad/s]; as above. */
int refdem_string_wheel(double mass, double counter, double drag, double radius, double gravity,
                        int64_t samples, const double *t, double *out);

/* == power_contact == */

/* m d'' = -k d^n from any overlap [m] and its rate [m/s], n > 0; `in` and `out_law` (2): k [N/m^n]
 * and n, up to the greatest overlap and from there on. touch (3): when they touch, turn and part
 * [s]. out (samples, 2): overlap (negative while apart), its rate, at the times t (samples) of
 * either sign [s]. Errors: a few ulp of the greatest overlap and of the speed. Returns 0. */
int refdem_power_contact(double mass, const double *in, const double *out_law, double overlap,
                         double rate, int64_t samples, const double *t, double *touch, double *out);

/* == piecewise_field == */

/* A point in the force F(x) of a tent: k1 (x - x1) for x1 <= x <= 0, k2 (x - x2) for 0 <= x <= x2,
 * k1 > 0 > k2, k1 x1 = k2 x2: x [m], v [m/s] at the times t (samples) >= 0, rising [s], from x0,
 * v0. out (samples, 2). Errors: round-off times the motion's own sensitivity. Returns 0. */
int refdem_piecewise_field(double mass, double k1, double k2, double x1, double x2, double x0,
                           double v0, int64_t samples, const double *t, double *out);

/* == spinning_top == */

/* A rigid body about a fixed point: inertia (3) > 0 [kg m^2], principal, about that point; arm (3)
 * [m] from it to the centre of mass, in body axes; weight (3) [N] in space. out (samples, 7):
 * attitude (w, x, y, z), omega in body axes [rad/s]; row 0 is the start, given. Taylor series of
 * order 20 as above. Returns 0, or the sample that was not reached. */
int refdem_spinning_top(const double *inertia, const double *arm, const double *weight,
                        int64_t samples, const double *t, double *out);

/* == tumbling_body == */

/* A convex body over a plane: mass [kg]; principal inertia (3) > 0 [kg m^2]; gravity (3) [m/s^2];
 * plane: a point (3) [m] and the unit normal (3) towards the body; corner (corners, 3) [m] in body
 * axes, at most 32; linear law with the cutoff zero_force and friction of full size against the
 * slip of every corner that presses: stiffness > 0 [N/m], damping [N s/m], friction. */
typedef struct {
    double mass;
    const double *inertia, *gravity, *plane;
    int64_t corners;
    const double *corner;
    double stiffness, damping, friction;
} refdem_tumbling_body;

/* States at times t [s], rising. out (samples, 14): attitude (w, x, y, z), omega [rad/s] and
 * velocity [m/s] in body axes, place [m] in space, lost work [J]; row 0 is the start, given.
 * channel (samples, 3): corners that touch, largest depth [m], largest push [N]. event (most, 3):
 * time [s], mode before (0 off, 1 presses, 2 idles), corner. Returns the number of events written,
 * or -k if sample k was not reached: a corner's slip came to an end. */
int64_t refdem_tumbling_body_run(const refdem_tumbling_body *given, int64_t samples,
                                 const double *t, int64_t most, double *event, double *channel,
                                 double *out);

/* == gas == */

/* Equal spheres: mass [kg], inertia [kg m^2], diameter [m]; stiffness [N/m], damping [kg/s],
 * tangential_stiffness [N/m], friction [1]; branch: the lever of friction is the radius less
 * `branch` overlaps; no_pull: the normal force is 0 where it would pull; turning: spins and
 * attitudes are part of the state, as friction > 0 needs. In a cubic periodic box of edge `size`
 * [m], at least 2.5 diameters (0: none), or between `planes` (planes, 6): point [m] and unit
 * normal. most_pairs: room for pairs closer than a diameter and a skin, most_contacts: for those
 * that touch. */
typedef struct {
    int64_t bodies, planes, most_pairs, most_contacts, no_pull, turning;
    double mass, inertia, diameter, stiffness, damping, tangential_stiffness, friction, branch,
        size;
    const double *plane;
} refdem_gas;

/* Bytes of memory that a run by so many threads needs. Of the part for pairs and contacts only as
 * much is written as there are any. */
int64_t refdem_gas_room(const refdem_gas *p, int64_t threads);

/* Velocity Verlet with signed `step` [s], `stride` steps a sample, by 1 to 64 threads: the bits are
 * the same for any number of them. position [m], which goes on beyond the box, velocity [m/s],
 * omega [1/s] (samples, bodies, 3) and attitude (samples, bodies, 4), the last two only if turning;
 * row 0 is the start, given. channel (samples, 2): number of contacts; dissipated work [J], less
 * what tangential springs hold. event (threads, most, 2): time since the start [s] and body of each
 * contact that begins, events (threads): how many, also beyond `most`. Momentum is kept exactly
 * while velocities lie on the grid (gas.c), else to round-off. Returns 0; 1 if there was no room
 * for the pairs or contacts, 2 if a thread could not be started, 3 if a body moved farther than 2e9
 * boxes, or if its position is not finite. */
int64_t refdem_gas_run(const refdem_gas *p, int64_t threads, double step, int64_t samples,
                       int64_t stride, int64_t most, uint8_t *memory, int64_t *events,
                       double *event, double *channel, double *position, double *velocity,
                       double *omega, double *attitude);

/* == end == */
#endif
