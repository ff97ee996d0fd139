/* Chipmunk (the engine of pymunk): a loop over its own steps that records the bodies.
 *
 * The engine's functions come as addresses; no header of Chipmunk is used. Its numbers are doubles
 * (the adapter checks), its vectors are passed by value.
 */
#include <assert.h>

#include "kernels.h"

enum { COLUMNS = 6 }; /* of a body: position (2), velocity (2), angle, omega */

/* Writes the columns of one body; those of its rotation stay as they are in a scene in which
 * nothing can turn. */
static void record(const refdem_chipmunk_engine *engine, void *body, double *restrict out)
{
    refdem_vector2 position = engine->position(body);
    refdem_vector2 velocity = engine->velocity(body);
    out[0] = position.x;
    out[1] = position.y;
    out[2] = velocity.x;
    out[3] = velocity.y;
    if (engine->omega) { /* something can turn */
        out[4] = engine->angle(body);
        out[5] = engine->omega(body);
    }
}

int refdem_chipmunk_record(const refdem_chipmunk_engine *engine, int64_t bodies, void *const *body,
                           double h, int64_t samples, int64_t stride, double *out)
{
    assert(engine && engine->step && engine->position && engine->velocity);
    assert(!engine->omega || engine->angle);
    assert(samples >= 1 && stride >= 0);
    assert(bodies == 0 || (body && out)); /* `out`: (samples, bodies, COLUMNS) doubles */
    for (int64_t k = 0; k < samples; k++) {
        int64_t steps = stride;
        if (k == 0) /* the first sample is the start */
            steps = 0;
        for (int64_t j = 0; j < steps; j++)
            engine->step(engine->space, h);
        for (int64_t i = 0; i < bodies; i++)
            record(engine, body[i], out + COLUMNS * (bodies * k + i));
    }
    return 0;
}
