/* What bench_draw.py times beside batches: rows one by one, and the floor of any table. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

/* Draw each row by a call of its own, with a record of its own. */
int one_by_one(const rbt_table *table, size_t n, const rbt_conditions *all, uint64_t seed,
               double *states, int *codes);
uint32_t floor_of_draws(const rbt_table *table, size_t n, uint64_t seed, const uint64_t *index);

int one_by_one(const rbt_table *table, size_t n, const rbt_conditions *all, uint64_t seed,
               double *states, int *codes)
{
    int flags = 0;
    for (size_t k = 0; k < n; k++) {
        rbt_conditions one = {0};
        one.alpha1 = all->alpha1 + k;
        one.speed = all->speed + k;
        one.spin = all->spin ? all->spin + 3 * k : NULL;
        one.inertia = all->inertia ? all->inertia + k : NULL;
        one.index = all->index + k;
        one.hit = all->hit + k;
        flags |= rbt_sample(table, 1, &one, seed, states + 6 * k, codes + k);
    }
    return flags;
}

/* Two blocks of random words and one read of 16 bytes from memory of the table's size. */
uint32_t floor_of_draws(const rbt_table *table, size_t n, uint64_t seed, const uint64_t *index)
{
    size_t size;
    const char *image = (const char *)rbt_image(table, &size);
    uint32_t sum = 0;
    for (size_t k = 0; k < n; k++) {
        uint32_t words[8], read[4];
        const uint32_t hit = 0;
        rbti_fill_words(1, 0, seed, &index[k], &hit, 1, words);
        rbti_fill_words(1, 1, seed, &index[k], &hit, 1, words + 4);
        memcpy(read, image + (words[0] * (uint64_t)(size / 16) >> 32) * 16, sizeof read);
        for (int m = 0; m < 4; m++)
            sum += read[m] ^ words[4 + m];
    }
    return sum;
}
