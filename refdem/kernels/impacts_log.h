/* The impacts that are told, and when a run ends early (impacts.c). */
#ifndef REFDEM_IMPACTS_LOG_H
#define REFDEM_IMPACTS_LOG_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Why a run goes no further: more impacts than the caller wants, or time that stands still. */
enum { GOES_ON = 0, TOO_MANY = 1, STANDS_STILL = 2 };

/* Part of the time by which it has to go on, and impacts of each body (and of all together, for
 * few) in which it has to: between spheres that come to rest against each other, times between
 * impacts shrink geometrically, and soon the time is rounded to the same number. Of chains of
 * spheres that touch, impacts at one time have an end: every body passes on every other's blow. */
static const double STILL = 0x1p-47;
enum { AT_ONCE_EACH = 100, AT_ONCE = 10000 };

/* The impacts so far: `event` (most, 3) is the table that is filled; `at_once` of them have come
 * since the time was `stood`. */
typedef struct {
    double *event;
    int64_t most, longest, events, bodies;
    double stood;
    int64_t at_once;
} event_log;

/* Notes an impact, unless the run ends with it. */
static inline int record(event_log *log, double when, int64_t i, int64_t j)
{
    if (log->events == log->longest)
        return TOO_MANY;
    if (when > log->stood + STILL * fabs(log->stood)) {
        log->stood = when;
        log->at_once = 0;
    }
    log->at_once++;
    if (log->at_once > AT_ONCE + AT_ONCE_EACH * log->bodies)
        return STANDS_STILL;
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
