/* Threads that go through one piece of work side by side and wait for each other at barriers.
 *
 * A waiting thread first polls the barrier, since barriers are microseconds apart, and later yields
 * its core to other threads.
 */
#ifndef REFDEM_GAS_TEAM_H
#define REFDEM_GAS_TEAM_H

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>

#define PATIENCE 4096 /* reads of a barrier before the thread yields its core: about 10 us */
#define MOST_THREADS 64

/* Members; those that have arrived at the barrier, barriers passed; 1 to begin, -1 to end. */
typedef struct {
    int members;
    atomic_int arrived, round, go;
} team;

/* Hint to the processor that this thread waits in a loop. */
static inline void pause_a_moment(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

/* A barrier: returns when all members have called it. The last one to arrive increments `round`,
 * for which the others wait. Release and acquire order the memory: what a member wrote before the
 * barrier is visible to all members after it. */
static void wait_for_all(team *t)
{
    if (t->members == 1)
        return;
    int round = atomic_load_explicit(&t->round, memory_order_relaxed);
    if (atomic_fetch_add_explicit(&t->arrived, 1, memory_order_acq_rel) + 1 == t->members) {
        atomic_store_explicit(&t->arrived, 0, memory_order_relaxed);
        atomic_store_explicit(&t->round, round + 1, memory_order_release);
        return;
    }
    for (int looks = 0; atomic_load_explicit(&t->round, memory_order_acquire) == round; looks++) {
        if (looks < PATIENCE)
            pause_a_moment();
        else
            sched_yield();
    }
}

/* What a thread is started with. */
typedef struct {
    team *team;
    void (*work)(void *shared, int rank);
    void *shared;
    int rank;
} duty;

/* A thread waits until all have started, then does its work; it ends at once if one is missing. */
static void *member_thread(void *given)
{
    duty *d = given;
    int go;
    while ((go = atomic_load_explicit(&d->team->go, memory_order_acquire)) == 0)
        sched_yield();
    if (go > 0)
        d->work(d->shared, d->rank);
    return NULL;
}

/* Calls work(shared, rank) on every member, rank 0 on the caller's own thread; returns 0. If a
 * thread cannot be started the others end without work; returns 1. */
static int run_team(team *t, int members, void (*work)(void *shared, int rank), void *shared)
{
    pthread_t thread[MOST_THREADS];
    duty given[MOST_THREADS];
    int had = 1; /* members that have a thread, the caller among them */
    t->members = members;
    atomic_init(&t->arrived, 0);
    atomic_init(&t->round, 0);
    atomic_init(&t->go, 0);
    for (; had < members; had++) {
        given[had] = (duty){t, work, shared, had};
        if (pthread_create(&thread[had], NULL, member_thread, &given[had]))
            break;
    }
    int go = -1; /* one is missing: the others end */
    if (had == members)
        go = 1;
    atomic_store_explicit(&t->go, go, memory_order_release);
    if (had == members)
        work(shared, 0);
    for (int k = 1; k < had; k++)
        pthread_join(thread[k], NULL);
    return had != members;
}

#endif
