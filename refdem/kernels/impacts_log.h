/* The list of impacts that is returned, and the reasons to end a run early (impacts.c). */
#ifndef REFDEM_IMPACTS_LOG_H
#define REFDEM_IMPACTS_LOG_H

#include <stdint.h>

/* Reasons to end a run early: more impacts than allowed, or spheres that come to rest. */
enum { GOES_ON = 0, TOO_MANY = 1, RESTS = 2 };

/* The impacts so far: their number `events`, of at most `longest`, and the table `event` (most, 3)
 * of the first ones. */
typedef struct {
    double *event;
    int64_t most, longest, events;
} event_log;

/* Adds an impact; returns TOO_MANY beyond the allowed number. */
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
