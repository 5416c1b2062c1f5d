/* What bench_direct.py times: rebounds by direct simulation, in calls of some rows. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include "rebound_direct.h"

int use_direct(rbt_table *table);
int rebound_in_batches(const rbt_table *table, size_t n, size_t batch, const rbt_impacts *all,
                       uint64_t seed, const rbt_rebounds *results);

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
        some.omega += 3 * k;
        some.inertia += k;
        some.index += k;
        some.hit += k;
        after.velocity += 3 * k;
        after.omega += 3 * k;
        after.inertia += k;
        flags |= rbt_rebound(table, n - k < batch ? n - k : batch, &some, seed, &after);
    }
    return flags;
}
