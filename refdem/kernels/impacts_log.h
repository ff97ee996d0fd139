/* The impacts that are reported, and when a run ends early (impacts.c). */
#ifndef REFDEM_IMPACTS_LOG_H
#define REFDEM_IMPACTS_LOG_H

#include <stdint.h>

/* Why a run ends early: more impacts than the caller wants, or spheres that come to rest. */
enum { GOES_ON = 0, TOO_MANY = 1, RESTS = 2 };

/* The impacts so far: `event` (most, 3) is the table that is filled. */
typedef struct {
    double *event;
    int64_t most, longest, events;
} event_log;

/* Notes an impact, unless there are too many. */
static inline int record(event_log *log, double when, int64_t i, int64_t j)
{
    if (log->events == log->longest)
        return TOO_MANY;
    if (log->events < log->most) {
        double *row = log->event + 3 * log->events;
        row[0] = when;
        row[1] = (double)i;
        row[2] = (double)j;
    }
    log->events++;
    return GOES_ON;
}

#endif
