/* Loops over many samples: compiled for each kind of processor, and without calls or branches, so
 * that the compiler makes vectors of them.
 *
 * Every product that is added to something is an explicit fma(), and nothing is reordered: all
 * kinds of processor give the same bits.
 */
#ifndef REFDEM_SIMD_H
#define REFDEM_SIMD_H

#include <stdint.h>
#include <string.h>

#include "double_double.h"

/* Before a function: all that it calls becomes part of it, and the processor that it meets
 * (AVX-512, AVX2 with FMA, or any) chooses among its versions when the extension is loaded.
 * Instrumented code cannot choose so early. REFDEM_ONE_CPU=x86-64-v3 builds one version alone, so
 * that a test can hold each of them on one processor (ci/testing/test_machines.py). */
#ifdef REFDEM_ONE_CPU
#define REFDEM_AS_TEXT(words) #words
#define REFDEM_OF_ARCH(name) "arch=" REFDEM_AS_TEXT(name)
#define REFDEM_EVERY_CPU __attribute__((target(REFDEM_OF_ARCH(REFDEM_ONE_CPU)), flatten))
#elif defined(__x86_64__) && defined(__ELF__) && defined(__GNUC__) && __GNUC__ >= 12               \
    && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define REFDEM_EVERY_CPU                                                                           \
    __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default"), flatten))
#elif defined(__GNUC__)
#define REFDEM_EVERY_CPU __attribute__((flatten))
#else
#define REFDEM_EVERY_CPU
#endif

/* Samples that are in work at one time: their columns stay in the first cache. */
enum { BLOCK = 128 };

/* The whole number nearest to x, |x| < 2^51, ties to even: a sum near 1.5 * 2^52 has no fraction.
 */
static inline double nearest(double x)
{
    return (x + 0x1.8p52) - 0x1.8p52;
}

/* sin and cos of x in -pi/4..pi/4 [rad], under an ulp; coefficients of least largest error (as in
 * fdlibm's kernels). */
static inline void sine_cosine_octant(double x, double *restrict s, double *restrict c)
{
    double z = x * x;
    double p, q;
    p = fma(z, 1.58969099521155010221e-10, -2.50507602534068634195e-08);
    p = fma(z, p, 2.75573137070700676789e-06);
    p = fma(z, p, -1.98412698298579493134e-04);
    p = fma(z, p, 8.33333333332248946124e-03);
    p = fma(z, p, -1.66666666666666324348e-01);
    *s = fma(x * z, p, x);
    q = fma(z, -1.13596475577881948265e-11, 2.08757232129817482790e-09);
    q = fma(z, q, -2.75573143513906633035e-07);
    q = fma(z, q, 2.48015872894767294178e-05);
    q = fma(z, q, -1.38888888888741095749e-03);
    q = fma(z, q, 4.16666666666666019037e-02);
    double half = 0.5 * z;
    double whole = 1.0 - half;
    *c = whole + fma(z * z, q, (1.0 - whole) - half);
}

/* sin and cos of pi f, f in -1/2..1/2, by the half angle a: 2 sin a cos a and 1 - 2 sin^2 a. */
static inline void sine_cosine_pi(double f, double *restrict s, double *restrict c)
{
    double half_sine, half_cosine;
    sine_cosine_octant(0.5 * DD_PI.hi * f, &half_sine, &half_cosine);
    *s = 2.0 * half_sine * half_cosine;
    *c = fma(-2.0 * half_sine, half_sine, 1.0);
}

/* exp(x) for -700 < x < 1, under two ulps: 2^n exp(r) with n = x/ln 2 rounded and r = x - n ln 2,
 * |r| <= ln(2)/2, by the Taylor series of exp. 2^n is made from the bits of its exponent, n + 1023.
 */
static inline double exponential(double x)
{
    /* r = x - n ln 2, with ln 2 as the sum of a leading part, n times which is exact, and the rest;
     * p = exp(r) - 1 = r + r^2/2! + .. + r^13/13!. */
    double n = nearest(x * 1.4426950408889634);
    double r = fma(n, -1.9082149292705877e-10, fma(n, -6.93147180369123816490e-01, x));
    double p, scale;
    p = fma(r, 1.0 / 6227020800.0, 1.0 / 479001600.0);
    p = fma(r, p, 1.0 / 39916800.0);
    p = fma(r, p, 1.0 / 3628800.0);
    p = fma(r, p, 1.0 / 362880.0);
    p = fma(r, p, 1.0 / 40320.0);
    p = fma(r, p, 1.0 / 5040.0);
    p = fma(r, p, 1.0 / 720.0);
    p = fma(r, p, 1.0 / 120.0);
    p = fma(r, p, 1.0 / 24.0);
    p = fma(r, p, 1.0 / 6.0);
    p = fma(r, p, 0.5);
    p = fma(r * r, p, r);
    double shifted = n + 0x1.8p52;
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 1023) << 52;
    memcpy(&scale, &bits, sizeof scale);
    return fma(scale, p, scale);
}

/* A phase start + rate time, counted in its periods. */
typedef struct {
    dd rate, start;
} turns;

/* The fraction of a phase in -1/2..1/2, exact to the rounding of the result however many turns it
 * has made; `sign` is -1 after an odd number of turns, else 1. */
static inline double fraction(turns phase, dd time, double *restrict sign)
{
    /* rate time + start = (turns_rate + turns_start) + fraction, the whole turns taken off the two
     * terms separately. */
    dd turned = two_product(phase.rate.hi, time.hi);
    double small_terms = fma(phase.rate.hi, time.lo, fma(phase.rate.lo, time.hi, turned.lo));
    double turns_rate = nearest(turned.hi);
    double turns_start;
    dd sum = two_sum(turned.hi - turns_rate, phase.start.hi);
    turns_start = nearest(sum.hi);
    double whole = turns_rate + turns_start;
    double odd = whole - 2.0 * nearest(0.5 * whole);
    *sign = fma(-2.0, fabs(odd), 1.0);
    return (sum.hi - turns_start) + (sum.lo + (small_terms + phase.start.lo));
}

#endif
