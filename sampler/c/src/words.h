/* -- random words and normal numbers --------------------------------------------------------------

   Random words of 32 bits by Philox4x32-10 (Salmon et al., SC11, 2011), keyed by seed, index, hit and
   block, and uniform and normal numbers from them. Each word has one use, named where it is read.

   How draws are written, here and in the sections below: each step is written once, for m draws side by
   side; the compiler knows m, which is 1 for a single draw and RBTI_BLOCK for a batch. A step is a loop
   over arrays of fixed length without branches, which compilers turn into vector instructions. Memory
   that it reads at scattered places was prefetched by the step before, so that the draws of a block wait
   for memory together. Number k of draw r of an array stands at k m + r. */

#if defined(RBTI_GPU) || defined(RBT_DEVICE_ONLY)
#define RBTI_BLOCK ((size_t)1) /* threads of a device draw one by one, with little memory each */
#else
#define RBTI_BLOCK ((size_t)32)
#define RBTI_BLOCKS 1
#endif
#define RBTI_EACH_DRAW(r) for (size_t r = 0; r < m; r++)

/* Draws are vectorised and unrolled whatever flags the program is compiled with. Passes of gcc from which
   draws gain nothing are turned off, because draws then compile in two thirds of the time. Attributes of
   functions would not do: gcc 12 forgets them for some functions that have versions. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(RBTI_GPU)
#pragma GCC push_options
#ifndef __SANITIZE_ADDRESS__ /* gcc would compile checked draws for four times as long */
#pragma GCC optimize("O3", "fp-contract=off")
#pragma GCC optimize("no-ipa-cp-clone", "no-tree-pre", "no-gcse", "no-gcse-after-reload")
#pragma GCC optimize("no-split-paths", "no-peel-loops", "no-split-loops")
#pragma GCC optimize("no-loop-interchange", "no-loop-unroll-and-jam", "no-predictive-commoning")
#pragma GCC optimize("no-version-loops-for-strides", "no-schedule-insns2")
#endif
#endif

/* Word of normal number `row` of a draw: 2 to 7, 9 and 10. Words 0 and 1 choose a part of the law, and
   word 8 gives the azimuth of a normal impact. */
RBTI_INLINE RBT_DEVICE size_t rbti_word_of_normal(size_t row)
{
    return row < 6 ? 2 + row : 3 + row;
}

/* Uniform number in (0, 1) from a random word. */
RBTI_INLINE RBT_DEVICE double rbti_uniform(uint32_t word)
{
    return ((double)word + 0.5) * (1.0 / 4294967296.0);
}

/* Four random words of each draw, number `block` of its blocks of words. If there are fewer than m draws,
   the last one is repeated. */
RBTI_INLINE RBT_DEVICE void rbti_fill_words(size_t m, uint32_t block, uint64_t seed,
                                            const uint64_t *index, const uint32_t *hit,
                                            size_t count, uint32_t *words)
{
    uint32_t *c0 = words, *c1 = words + m, *c2 = words + 2 * m, *c3 = words + 3 * m;
    uint32_t key0 = (uint32_t)seed, key1 = (uint32_t)(seed >> 32);
    RBTI_EACH_DRAW(r) {
        const size_t k = r < count ? r : count - 1;
        c0[r] = (uint32_t)index[k];
        c1[r] = (uint32_t)(index[k] >> 32);
        c2[r] = hit[k];
        c3[r] = block;
    }
    for (int round = 0; round < 10; round++) {
        RBTI_EACH_DRAW(r) {
            const uint64_t p0 = (uint64_t)c0[r] * 0xD2511F53u, p1 = (uint64_t)c2[r] * 0xCD9E8D57u;
            c0[r] = (uint32_t)(p1 >> 32) ^ c1[r] ^ key0;
            c1[r] = (uint32_t)p1;
            c2[r] = (uint32_t)(p0 >> 32) ^ c3[r] ^ key1;
            c3[r] = (uint32_t)p0;
        }
        key0 += 0x9E3779B9u;
        key1 += 0xBB67AE85u;
    }
}

/* Normal numbers from words by a table of cubics, one for each eighth of an octave of the distance to the
   nearer end of the words. The octave is the exponent of a floating-point number, because that can be
   vectorised and a count of leading zeros cannot. */
RBTI_INLINE RBT_DEVICE void rbti_fill_normals(size_t m, const float *table, const uint32_t *words,
                                              float *normals)
{
    int32_t rows[RBTI_BLOCK] RBTI_ALIGNED;
    float t[RBTI_BLOCK] RBTI_ALIGNED, sign[RBTI_BLOCK] RBTI_ALIGNED;
    float cubic[4 * RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        const int32_t upper = (int32_t)(words[r] >> 31);
        const uint32_t mask = (uint32_t)-upper;
        /* half the distance from the nearer end, in units of 2^-32: from 1/2 to 2^31 */
        float half = (float)(int32_t)((words[r] ^ mask) & 0x7fffffffu) + 0.5f;
        uint32_t bits;
        memcpy(&bits, &half, sizeof bits);
        rows[r] = (int32_t)(bits >> 20) - 8 * 126;
        bits = (bits << 3 & 0x7fffffu) | 0x3f800000u;
        memcpy(&half, &bits, sizeof half);
        t[r] = half - 1.0f;
        sign[r] = 1.0f - 2.0f * (float)upper;
    }
    RBTI_EACH_DRAW(r) {
        const float *row = table + 4 * rows[r];
        cubic[r] = row[0];
        cubic[m + r] = row[1];
        cubic[2 * m + r] = row[2];
        cubic[3 * m + r] = row[3];
    }
    RBTI_EACH_DRAW(r) {
        const float *c = cubic + r;
        normals[r] = sign[r] * (c[0] + t[r] * (c[m] + t[r] * (c[2 * m] + t[r] * c[3 * m])));
    }
}
