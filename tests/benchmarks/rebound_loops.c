/* What bench_times.py times: rebounds from a table or by direct simulation, in calls of some rows. */

#define _POSIX_C_SOURCE 200809L
#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include "rebound_direct.h"

#include <pthread.h>

int use_direct(rbt_table *table);
int rebound_in_batches(const rbt_table *table, size_t n, size_t batch, const rbt_impacts *all,
                       uint64_t seed, const rbt_rebounds *results);
size_t stack_of_a_call(const rbt_table *table, size_t n, const rbt_impacts *impacts,
                       rbt_rebounds *results);

int use_direct(rbt_table *table)
{
    return rbt_use_direct(table, &rebound_direct);
}

int rebound_in_batches(const rbt_table *table, size_t n, size_t batch, const rbt_impacts *all,
                       uint64_t seed, const rbt_rebounds *results)
{
    int flags = 0;
    for (size_t k = 0; k < n; k += batch) {
        rbt_impacts some = *all;
        rbt_rebounds after = *results;
        some.velocity += 3 * k;
        some.normal += 3 * k;
        some.half_size += k;
        some.omega = all->omega ? all->omega + 3 * k : NULL;
        some.inertia = all->inertia ? all->inertia + k : NULL;
        some.index += k;
        some.hit += k;
        after.velocity += 3 * k;
        after.omega += 3 * k;
        after.inertia += k;
        flags |= rbt_rebound(table, n - k < batch ? n - k : batch, &some, seed, &after);
    }
    return flags;
}

/* A call on a stack of its own, and what it takes and gives. */
enum { STACK = 1 << 21, UNTOUCHED = 0xa5 };
static unsigned char stack[STACK] __attribute__((aligned(4096)));
static struct {
    const rbt_table *table;
    size_t n;
    const rbt_impacts *impacts;
    rbt_rebounds *results;
    int code;
} call;

static void *make_call(void *unused)
{
    call.code = rbt_rebound(call.table, call.n, call.impacts, 1, call.results);
    return unused;
}

/* Bytes of the stack that a call writes, with the few thousand of a thread; 0 if it fails. */
size_t stack_of_a_call(const rbt_table *table, size_t n, const rbt_impacts *impacts,
                       rbt_rebounds *results)
{
    pthread_attr_t attributes;
    pthread_t thread;
    size_t untouched = 0;
    call.table = table;
    call.n = n;
    call.impacts = impacts;
    call.results = results;
    memset(stack, UNTOUCHED, sizeof stack);
    if (pthread_attr_init(&attributes) || pthread_attr_setstack(&attributes, stack, sizeof stack) ||
        pthread_create(&thread, &attributes, make_call, NULL) || pthread_join(thread, NULL) ||
        call.code < 0)
        return 0;
    while (stack[untouched] == UNTOUCHED)
        untouched++;
    return sizeof stack - untouched;
}
