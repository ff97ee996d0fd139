/* Recorder: one compiled loop over any engine's own step function. */
#include <string.h>

#include "kernels.h"

typedef void (*step_pair)(void *, void *);
typedef void (*step_size)(void *, double);
typedef void (*step_count)(void *, uint32_t);

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
    out = copy_state(n_source, source, size, out);
    for (int64_t k = 1; k < samples; k++) {
        if (kind == 2)
            ((step_count)step)(a, (uint32_t)stride);
        else
            for (int64_t j = 0; j < stride; j++) {
                if (kind == 0)
                    ((step_pair)step)(a, b);
                else
                    ((step_size)step)(a, h);
            }
        out = copy_state(n_source, source, size, out);
    }
    return 0;
}
