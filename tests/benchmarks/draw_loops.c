/* What bench_draw.py times beside rbt_draw_batch: calls one by one, and the floor of any table. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

int one_by_one(const rbt_table *table, size_t n, const double *alpha1, const double *speed,
               const double *spin, uint64_t seed, const uint64_t *index, const uint32_t *hit,
               double *states);
uint32_t floor_of_draws(const rbt_table *table, size_t n, uint64_t seed, const uint64_t *index);

int one_by_one(const rbt_table *table, size_t n, const double *alpha1, const double *speed,
               const double *spin, uint64_t seed, const uint64_t *index, const uint32_t *hit,
               double *states)
{
    int codes = 0;
    for (size_t k = 0; k < n; k++)
        codes |= rbt_draw(table, alpha1[k], speed[k], spin ? spin + 3 * k : NULL, seed, index[k],
                          hit[k], states + 6 * k);
    return codes;
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
