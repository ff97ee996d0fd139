/* Chipmunk (the engine of pymunk): a loop over its own step that records.
 *
 * The engine's functions come as addresses; no header of Chipmunk is used. Its numbers are doubles
 * (the adapter checks), its vectors are passed by value.
 */
#include <assert.h>

#include "kernels.h"

int refdem_chipmunk_record(const refdem_chipmunk_engine *engine, int64_t bodies, void *const *body,
                           double h, int64_t samples, int64_t stride, double *out)
{
    assert(engine && engine->step && engine->position && engine->velocity);
    assert(!engine->omega || engine->angle);
    assert(samples >= 1 && stride >= 0
           && (bodies == 0 || (body && out))); /* (samples, bodies, 6) */
    for (int64_t k = 0; k < samples; k++) {
        if (k > 0) /* row 0 is the start */
            for (int64_t j = 0; j < stride; j++)
                engine->step(engine->space, h);
        for (int64_t i = 0; i < bodies; i++, out += 6) {
            refdem_vector2 position = engine->position(body[i]);
            refdem_vector2 velocity = engine->velocity(body[i]);
            out[0] = position.x;
            out[1] = position.y;
            out[2] = velocity.x;
            out[3] = velocity.y;
            if (engine->omega) { /* something can turn */
                out[4] = engine->angle(body[i]);
                out[5] = engine->omega(body[i]);
            }
        }
    }
    return 0;
}
