#ifndef RBT_DEVICE_ONLY

/* -- checksum --------------------------------------------------------------------------------------

   SHA-256 of a binary table. Source: FIPS 180-4. */

/* A word rotated to the right by n bits. */
RBTI_INLINE uint32_t rbti_rotated(uint32_t x, unsigned n)
{
    return x >> n | x << (32 - n);
}

/* Add a block of 64 bytes to the state of a digest. */
static void rbti_sha_block(uint32_t state[8], const uint8_t *block)
{
    static const uint32_t constants[64] = {
        0x428a2f98u, 0x71374491u, 0xb5c0fbcfu, 0xe9b5dba5u, 0x3956c25bu, 0x59f111f1u, 0x923f82a4u,
        0xab1c5ed5u, 0xd807aa98u, 0x12835b01u, 0x243185beu, 0x550c7dc3u, 0x72be5d74u, 0x80deb1feu,
        0x9bdc06a7u, 0xc19bf174u, 0xe49b69c1u, 0xefbe4786u, 0x0fc19dc6u, 0x240ca1ccu, 0x2de92c6fu,
        0x4a7484aau, 0x5cb0a9dcu, 0x76f988dau, 0x983e5152u, 0xa831c66du, 0xb00327c8u, 0xbf597fc7u,
        0xc6e00bf3u, 0xd5a79147u, 0x06ca6351u, 0x14292967u, 0x27b70a85u, 0x2e1b2138u, 0x4d2c6dfcu,
        0x53380d13u, 0x650a7354u, 0x766a0abbu, 0x81c2c92eu, 0x92722c85u, 0xa2bfe8a1u, 0xa81a664bu,
        0xc24b8b70u, 0xc76c51a3u, 0xd192e819u, 0xd6990624u, 0xf40e3585u, 0x106aa070u, 0x19a4c116u,
        0x1e376c08u, 0x2748774cu, 0x34b0bcb5u, 0x391c0cb3u, 0x4ed8aa4au, 0x5b9cca4fu, 0x682e6ff3u,
        0x748f82eeu, 0x78a5636fu, 0x84c87814u, 0x8cc70208u, 0x90befffau, 0xa4506cebu, 0xbef9a3f7u,
        0xc67178f2u};
    uint32_t w[64], a[8];
    for (int k = 0; k < 16; k++)
        w[k] = (uint32_t)block[4 * k] << 24 | (uint32_t)block[4 * k + 1] << 16 |
               (uint32_t)block[4 * k + 2] << 8 | (uint32_t)block[4 * k + 3];
    for (int k = 16; k < 64; k++) {
        const uint32_t x = w[k - 15], y = w[k - 2];
        w[k] = w[k - 16] + w[k - 7] + (rbti_rotated(x, 7) ^ rbti_rotated(x, 18) ^ x >> 3) +
               (rbti_rotated(y, 17) ^ rbti_rotated(y, 19) ^ y >> 10);
    }
    memcpy(a, state, sizeof a);
    for (int k = 0; k < 64; k++) {
        const uint32_t s1 = rbti_rotated(a[4], 6) ^ rbti_rotated(a[4], 11) ^ rbti_rotated(a[4], 25);
        const uint32_t s0 = rbti_rotated(a[0], 2) ^ rbti_rotated(a[0], 13) ^ rbti_rotated(a[0], 22);
        const uint32_t t1 = a[7] + s1 + ((a[4] & a[5]) ^ (~a[4] & a[6])) + constants[k] + w[k];
        const uint32_t t2 = s0 + ((a[0] & a[1]) ^ (a[0] & a[2]) ^ (a[1] & a[2]));
        for (int m = 7; m > 0; m--)
            a[m] = a[m - 1];
        a[4] += t1;
        a[0] = t1 + t2;
    }
    for (int k = 0; k < 8; k++)
        state[k] += a[k];
}

/* Digest of two ranges of bytes, one behind the other. */
static void rbti_sha256(const uint8_t *first, size_t n_first, const uint8_t *second,
                        size_t n_second, uint8_t digest[32])
{
    uint32_t state[8] = {0x6a09e667u, 0xbb67ae85u, 0x3c6ef372u, 0xa54ff53au,
                         0x510e527fu, 0x9b05688cu, 0x1f83d9abu, 0x5be0cd19u};
    const size_t n = n_first + n_second, padded = (n + 8) / 64 * 64 + 64;
    for (size_t at = 0; at < padded; at += 64) {
        uint8_t block[64];
        if (at >= n_first && at + 64 <= n) {
            rbti_sha_block(state, second + (at - n_first));
            continue;
        }
        for (size_t k = at; k < at + 64; k++)
            block[k - at] = (uint8_t)(k < n_first       ? first[k]
                                      : k < n           ? second[k - n_first]
                                      : k == n          ? 0x80
                                      : k >= padded - 8 ? (uint64_t)n * 8 >> 8 * (padded - 1 - k)
                                                        : 0);
        rbti_sha_block(state, block);
    }
    for (int k = 0; k < 32; k++)
        digest[k] = (uint8_t)(state[k / 4] >> (24 - 8 * (k % 4)));
}

#endif
