/* A compiled loop that calls the step function of any engine, and copies the engine's state from
 * the engine's memory after every `stride` steps. */
#include <assert.h>
#include <string.h>

#include "kernels.h"

typedef void (*engine_step)(void *, void *);

/* Copies size[i] doubles from source[i] to `row`, for all i one after the other; returns the
 * address of the next row. */
static double *copy_state(int64_t n_source, void *const *source, const int64_t *size, double *row)
{
    for (int64_t i = 0; i < n_source; i++) {
        memcpy(row, source[i], (size_t)size[i] * sizeof(double));
        row += size[i];
    }
    return row;
}

/* Writes row k of `out`, the state after k stride calls of step(a, b), for all samples k. */
int refdem_record(void *step, void *a, void *b, int64_t samples, int64_t stride, int64_t n_source,
                  void *const *source, const int64_t *size, double *out)
{
    assert(step && samples >= 1 && stride >= 0);
    assert(n_source == 0 || (source && size && out));
    out = copy_state(n_source, source, size, out);
    for (int64_t k = 1; k < samples; k++) {
        for (int64_t j = 0; j < stride; j++)
            ((engine_step)step)(a, b);
        out = copy_state(n_source, source, size, out);
    }
    return 0;
}
