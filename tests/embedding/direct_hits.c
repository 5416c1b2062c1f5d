/* Rebounds along three hits by direct simulation, in a program without Python.

       direct_hits TABLE.rbt IMPACTS N ROUGHNESS ISOTROPIC BATCH RESULTS

   IMPACTS has 7 numbers for each particle: velocity, normal, half-size. RESULTS gets, hit after hit, 10
   numbers for each particle: velocity, omega, inertia, works, code. At each hit BATCH particles go into a
   call. The next wall is tilted against the path of the particle. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include "rebound_direct.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HITS = 3, GIVEN = 7, WRITTEN = 10 };

static void *allocated(size_t count, size_t size)
{
    void *memory = calloc(count, size);
    if (!memory)
        exit(3);
    return memory;
}

static void write_results(FILE *file, size_t n, const rbt_rebounds *after)
{
    for (size_t k = 0; k < n; k++) {
        double row[WRITTEN];
        for (size_t c = 0; c < 3; c++) {
            row[c] = after->velocity[3 * k + c];
            row[3 + c] = after->omega[3 * k + c];
        }
        row[6] = after->inertia[k];
        row[7] = after->works[2 * k];
        row[8] = after->works[2 * k + 1];
        row[9] = (double)after->codes[k];
        if (fwrite(row, sizeof *row, WRITTEN, file) != WRITTEN)
            exit(3);
    }
}

int main(int argc, char **argv)
{
    if (argc != 8)
        return 2;
    rbt_table *table;
    int code = rbt_open(argv[1], &table);
    if (code == RBT_OK)
        code = rbt_use_direct(table, &rebound_direct);
    if (code < 0) {
        printf("%d %s\n", code, rbt_strerror(code));
        return 1;
    }
    const size_t n = strtoul(argv[3], NULL, 10), batch = strtoul(argv[6], NULL, 10);
    double *given = allocated(GIVEN * n, sizeof *given), *velocity = allocated(3 * n, sizeof *velocity);
    double *normal = allocated(3 * n, sizeof *normal), *half_size = allocated(n, sizeof *half_size);
    double *omega = allocated(3 * n, sizeof *omega), *inertia = allocated(n, sizeof *inertia);
    double *roughness = allocated(n, sizeof *roughness), *works = allocated(2 * n, sizeof *works);
    uint64_t *index = allocated(n, sizeof *index);
    uint32_t *hit = allocated(n, sizeof *hit);
    int *codes = allocated(n, sizeof *codes);
    FILE *impacts = fopen(argv[2], "rb"), *results = fopen(argv[7], "wb");
    if (!impacts || !results || fread(given, sizeof *given, GIVEN * n, impacts) != GIVEN * n)
        return 3;
    for (size_t k = 0; k < n; k++) {
        memcpy(velocity + 3 * k, given + GIVEN * k, 3 * sizeof *given);
        memcpy(normal + 3 * k, given + GIVEN * k + 3, 3 * sizeof *given);
        half_size[k] = given[GIVEN * k + 6];
        roughness[k] = strtod(argv[4], NULL);
        index[k] = k;
    }
    for (uint32_t h = 0; h < HITS; h++) {
        for (size_t k = 0; k < n && h > 0; k++) {
            const double *v = velocity + 3 * k;
            normal[3 * k] = -v[0] - 0.6 * v[1];
            normal[3 * k + 1] = -v[1] + 0.6 * v[0];
            normal[3 * k + 2] = -v[2];
        }
        for (size_t first = 0; first < n; first += batch) {
            const size_t count = n - first < batch ? n - first : batch;
            rbt_impacts impact = {0};
            rbt_rebounds after = {0};
            for (size_t k = first; k < first + count; k++)
                hit[k] = h;
            impact.velocity = after.velocity = velocity + 3 * first;
            impact.omega = after.omega = omega + 3 * first;
            impact.inertia = after.inertia = inertia + first;
            impact.normal = normal + 3 * first;
            impact.half_size = half_size + first;
            impact.roughness = roughness + first;
            impact.isotropic = (int)strtol(argv[5], NULL, 10);
            impact.index = index + first;
            impact.hit = hit + first;
            after.works = works + 2 * first;
            after.codes = codes + first;
            if (rbt_rebound(table, count, &impact, 7, &after) < 0)
                return 4;
        }
        rbt_rebounds all = {0};
        all.velocity = velocity;
        all.omega = omega;
        all.inertia = inertia;
        all.works = works;
        all.codes = codes;
        write_results(results, n, &all);
    }
    rbt_close(table);
    return fclose(results) == 0 && fclose(impacts) == 0 ? 0 : 3;
}
