/* The event queue: a tournament tree (Knuth, The Art of Computer Programming 3, 5.4.1).
 *
 * A complete binary tree has the bodies as its leaves, and in every node the earlier entry of its
 * two children, so that the root is the next event of all. A new time of a body updates the nodes
 * on its path to the root: O(log bodies), always the same number, and without branches that may be
 * mispredicted. Of equal times the body with the lower number wins.
 */
#ifndef REFDEM_IMPACTS_QUEUE_H
#define REFDEM_IMPACTS_QUEUE_H

#include <math.h>
#include <stdint.h>

/* A body and the time of its next event. */
typedef struct {
    double when;
    int64_t body;
} entry;

/* `node` (2 leaves): 1 is the root, the children of k are 2 k and 2 k + 1. */
typedef struct {
    int64_t leaves;
    entry *node;
} queue;

/* The leaves of a tree of so many bodies: a power of two, at least 2. */
static inline int64_t leaves_of(int64_t bodies)
{
    int64_t leaves = 2;
    while (leaves < bodies)
        leaves *= 2;
    return leaves;
}

/* A tree in which all times are infinite. */
static inline void empty_queue(queue *q, int64_t bodies)
{
    q->leaves = leaves_of(bodies);
    for (int64_t k = 0; k < 2 * q->leaves; k++) {
        q->node[k].when = INFINITY;
        q->node[k].body = bodies;
    }
}

/* The body with the next event, and its time. */
static inline entry next_event(const queue *q)
{
    return q->node[1];
}

/* Sets the time of the next event of body i. */
static inline void schedule(queue *q, int64_t i, double when)
{
    entry winner = {.when = when, .body = i};
    q->node[q->leaves + i] = winner;
    for (int64_t k = q->leaves + i; k > 1; k /= 2) {
        const entry rival = q->node[k ^ 1];
        const int is_earlier = rival.when < winner.when;
        const int is_equal = rival.when == winner.when;
        const int is_lower = rival.body < winner.body;
        /* All ones if the rival wins: a mask in place of a branch that would be mispredicted. */
        const int64_t mask = -(int64_t)(is_earlier | (is_equal & is_lower));
        winner.body ^= (winner.body ^ rival.body) & mask;
        winner.when = is_earlier ? rival.when : winner.when;
        q->node[k / 2] = winner;
    }
}

#endif
