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

/* == end == */
#endif
