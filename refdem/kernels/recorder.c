/* Recorder: one compiled loop over any engine's own step function, which copies its state from the
 * engine's own memory. */
#include <assert.h>
#include <string.h>

#include "kernels.h"

/* The engine's step: kind 0, 1 and 2 of refdem_record (kernels.h). */
typedef void (*step_with_two)(void *, void *);
typedef void (*step_with_h)(void *, double);
typedef void (*steps_at_once)(void *, uint32_t);

/* Copies size[i] doubles from each source to `row`; returns the place of the next row. */
static double *copy_state(int64_t n_source, void *const *source, const int64_t *size, double *row)
{
    for (int64_t i = 0; i < n_source; i++) {
        memcpy(row, source[i], (size_t)size[i] * sizeof(double));
        row += size[i];
    }
    return row;
}

int refdem_record(int kind, void *step, void *a, void *b, double h, int64_t samples, int64_t stride,
                  int64_t n_source, void *const *source, const int64_t *size, double *out)
{
    assert(step && samples >= 1 && stride >= 0 && kind >= 0 && kind <= 2);
    assert(n_source == 0 || (source && size && out));
    out = copy_state(n_source, source, size, out);
    for (int64_t k = 1; k < samples; k++) {
        if (kind == 2) /* one call makes all steps up to the sample */
            ((steps_at_once)step)(a, (uint32_t)stride);
        else
            for (int64_t j = 0; j < stride; j++) {
                if (kind == 0)
                    ((step_with_two)step)(a, b);
                else
                    ((step_with_h)step)(a, h);
            }
        out = copy_state(n_source, source, size, out);
    }
    return 0;
}
