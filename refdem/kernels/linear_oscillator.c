/* A point on a line: linear spring, linear damping, constant and periodic forces, in closed form.
 *
 * About the equilibrium, with s = t - t0 and W^2 = |w0^2 - b^2|:
 *
 *   X'' + 2 b X' + w0^2 X = sum f cos(w s + psi).
 *
 * Free motion from X0, V0:
 *
 *   X = X0 C + (b X0 + V0) D,   V = V0 C - (w0^2 X0 + b V0) D,
 *   C = exp(-b s) cos W s,   D = exp(-b s) sin W s/W     for b < w0,
 *
 * with cosh and sinh for b > w0, 1 and s for b = w0. A drive, from rest, where damping is light,
 * with L = -b + i W:
 *
 *   X = f/(2 W) Im Z,   V = f/(2 W) Im(L Z),   Z = exp(i psi) K(L, i w) + exp(-i psi) K(L, -i w),
 *   K(L, M) = exp(M s) (exp((L - M) s) - 1)/(L - M),
 *
 * which does not cancel at resonance, where L = M. Where damping is heavy: the steady motion, less
 * the free motion that has the state of the steady one at the start.
 */
#include <assert.h>
#include <complex.h>

#include "double_double.h"
#include "kernels.h"

enum { CRITICAL, UNDER, OVER }; /* damping: b = w0, b < w0, b > w0 */

typedef struct {
    dd rate, decay, width; /* w0, b, W [1/s] */
    int kind;
} linear;

/* w0^2 = k/m, b = c/(2 m). */
static linear prepare(double mass, double stiffness, double damping)
{
    /* gap = w0^2 - b^2 = +-W^2. */
    dd m = dd_of(mass);
    dd square = dd_div(dd_of(stiffness), m);
    dd b = dd_div(dd_scale(dd_of(damping), 0.5), m);
    dd gap = dd_sub(square, dd_square(b));
    int kind = CRITICAL;
    if (gap.hi > 0.0)
        kind = UNDER;
    else if (gap.hi < 0.0)
        kind = OVER;
    return (linear){dd_sqrt(square), b, dd_sqrt(dd_abs(gap)), kind};
}

/* C and D at s [s]. */
static void shapes(const linear *p, dd s, double *restrict c, double *restrict d)
{
    dd phase = dd_mul(p->width, s);
    if (p->kind == UNDER) {
        double sine;
        double fade = exp(-dd_round(dd_mul(p->decay, s)));
        turned(phase, c, &sine);
        *c *= fade;
        *d = fade * sine / p->width.hi;
    } else if (p->kind == CRITICAL) {
        *c = exp(-dd_round(dd_mul(p->decay, s)));
        *d = *c * dd_round(s);
    } else {
        /* With the slow rate b - W = w0^2/(b + W), without cancellation, and for either sign of s,
         *   C = exp(-(b - W) s) (1 + exp(-2 W s))/2,   D = exp(-(b - W) s) (1 - exp(-2 W s))/(2 W).
         */
        dd slow = dd_div(dd_square(p->rate), dd_add(p->decay, p->width));
        double fade = exp(-dd_round(dd_mul(slow, s)));
        double rest = expm1(-2.0 * dd_round(phase));
        *c = fade * (1.0 + 0.5 * rest);
        *d = -0.5 * fade * rest / p->width.hi;
    }
}

/* The free motion after s [s] from X0, V0 in `from`, `speed`. */
static void free_motion(const linear *p, dd s, double from, double speed, double *restrict x,
                        double *restrict v)
{
    double c, d;
    double b = p->decay.hi;
    /* X = X0 C + (b X0 + V0) D,   V = V0 C - (w0^2 X0 + b V0) D. */
    double square = p->rate.hi * p->rate.hi;
    shapes(p, s, &c, &d);
    *x = fma(from, c, fma(b, from, speed) * d);
    *v = fma(speed, c, -fma(square, from, b * speed) * d);
}

/* K(L, i w) = exp(i w s) (exp(z s) - 1)/z for z = L - i w = -b + i gap, gap in double-double; s
 * where z = 0. exp(z s) - 1 = expm1(-b s) cos(gap s) - 2 sin^2(gap s/2) + i exp(-b s) sin(gap s).
 */
static double complex response(dd decay, dd gap, dd w, dd s)
{
    double cw, sw, c, sine, half, unused;
    double a = -dd_round(dd_mul(decay, s));
    turned(dd_mul(w, s), &cw, &sw);
    turned(dd_mul(gap, s), &c, &sine);
    turned(dd_scale(dd_mul(gap, s), 0.5), &unused, &half);
    double complex z = CMPLX(-decay.hi, gap.hi);
    double complex top = CMPLX(fma(expm1(a), c, -2.0 * half * half), exp(a) * sine);
    double complex ratio = dd_round(s);
    if (z != 0.0)
        ratio = top / z;
    return CMPLX(cw, sw) * ratio;
}

/* Adds the motion that a drive makes from rest under light damping: f [m/s^2], w [rad/s], cos and
 * sin of psi. */
static void add_lightly_damped(const linear *p, dd s, double f, double w, double c0, double s0,
                               double *restrict x, double *restrict v)
{
    /* Z = exp(i psi) K(L, i w) + exp(-i psi) K(L, -i w), X += f/(2 W) Im Z, V += f/(2 W) Im(L Z).
     */
    dd up = dd_of(w);
    dd b = p->decay;
    dd wide = p->width;
    double complex sum = CMPLX(c0, s0) * response(b, dd_sub(wide, up), up, s)
                         + CMPLX(c0, -s0) * response(b, dd_add(wide, up), dd_neg(up), s);
    double scale = 0.5 * f / wide.hi;
    *x += scale * cimag(sum);
    *v += scale * cimag(CMPLX(-b.hi, wide.hi) * sum);
}

/* The steady motion at a phase with the given cosine and sine, with N = (w0^2 - w^2)^2 + (2 b w)^2:
 *
 *   x = f ((w0^2 - w^2) cos + 2 b w sin)/N,   v = f w (2 b w cos - (w0^2 - w^2) sin)/N. */
static void steady_motion(const linear *p, double f, double w, double c, double s,
                          double *restrict x, double *restrict v)
{
    dd up = dd_of(w);
    double gap = dd_round(dd_sub(dd_square(p->rate), dd_square(up)));
    double drag = 2.0 * p->decay.hi * w;
    double denominator = gap * gap + drag * drag;
    *x = f * fma(gap, c, drag * s) / denominator;
    *v = f * w * fma(drag, c, -gap * s) / denominator;
}

/* Adds the motion after s [s] that the drive d (F, w, phase) makes from rest. */
static void add_drive(const linear *p, dd s, double mass, const double *restrict d, double t0,
                      double *restrict x, double *restrict v)
{
    double c0, s0;
    double f = d[0] / mass;
    double w = d[1];
    dd start = dd_add(two_product(w, t0), dd_of(d[2])); /* psi = w t0 + phase */
    turned(start, &c0, &s0);
    if (p->kind == UNDER && p->decay.hi < 0.5 * p->rate.hi) {
        add_lightly_damped(p, s, f, w, c0, s0, x, v);
        return;
    }
    /* Steady motion at s, less the free motion from the steady state x0, v0 at s = 0. */
    double c, sine, x0, v0, x1, v1;
    turned(dd_add(start, dd_scale(s, w)), &c, &sine);
    steady_motion(p, f, w, c0, s0, &x0, &v0);
    steady_motion(p, f, w, c, sine, &x1, &v1);
    *x += x1;
    *v += v1;
    free_motion(p, s, x0, v0, &x1, &v1);
    *x -= x1;
    *v -= v1;
}

int refdem_linear_oscillator(const refdem_linear *p, double x0, double v0, double t0,
                             int64_t samples, const double *t, double *out)
{
    assert(p && (p->drives == 0 || p->drive)); /* (drives, 3) doubles */
    assert(samples == 0 || (t && out));        /* (samples, 2) doubles */
    linear b = prepare(p->mass, p->linear, p->damping);
    dd middle = dd_div(dd_of(p->weight), dd_of(p->linear));
    double from = dd_round(dd_sub(dd_of(x0), middle));
    for (int64_t row = 0; row < samples; row++, out += 2) {
        double x = x0;
        double v = v0;
        if (t[row] != t0) { /* else the start as it was given */
            dd s = two_sum(t[row], -t0);
            free_motion(&b, s, from, v0, &x, &v);
            for (int64_t k = 0; k < p->drives; k++)
                add_drive(&b, s, p->mass, p->drive + 3 * k, t0, &x, &v);
            x = dd_round(dd_add(middle, dd_of(x)));
        }
        out[0] = x;
        out[1] = v;
    }
    return 0;
}
