/* A particle loop in C with OpenMP: gas drives particles from plate to plate, where they rebound.

   sampler export corundum-steel --output corundum-steel.rbt
   gcc -O3 -march=native -fopenmp -I$(python -m sampler --include-dir) particles.c -o particles -lm
   ./particles corundum-steel.rbt 100000 20

   Prints what became of the particles, and rebounds per second. The particles are the same on any
   number of threads: a rebound depends on seed, particle and number of its wall hits only. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include <omp.h>
#include <stdio.h>

#define SEED 7
#define HALF_SIZE 20e-6

typedef struct fate {
    double along, spin;
    long clamped; /* rebounds outside the table */
    int code;
} fate;

/* One particle through all its wall hits. */
static fate follow(const rbt_table *table, uint64_t particle, uint32_t hits)
{
    const double rest[3] = {0.0, 0.0, 0.0};
    double velocity[3] = {150.0, -80.0, 0.0}, omega[3] = {0.0, 0.0, 0.0};
    fate end = {0.0, 0.0, 0, RBT_OK};
    for (uint32_t hit = 0; hit < hits && end.code >= RBT_OK; hit++) {
        /* lower and upper plate take turns */
        const double side = hit % 2 == 0 ? 1.0 : -1.0;
        const double normal[3] = {0.0, side, 0.0}, gas[3] = {150.0, 80.0 * side, 0.0};
        end.code = rbt_rebound(table, velocity, normal, HALF_SIZE, rest, SEED, particle, hit,
                               velocity, omega);
        end.clamped += end.code == RBT_CLAMPED;
        /* on the way to the other plate drag makes up most of the difference from the gas */
        for (int k = 0; k < 3; k++)
            velocity[k] += 0.8 * (gas[k] - velocity[k]);
    }
    end.along = velocity[0];
    end.spin = omega[2];
    return end;
}

int main(int argc, char **argv)
{
    if (argc != 4) {
        fprintf(stderr, "usage: particles TABLE.rbt PARTICLES HITS\n");
        return 2;
    }
    rbt_table *table;
    const int code = rbt_open(argv[1], &table);
    if (code < RBT_OK) {
        fprintf(stderr, "%s: %s\n", argv[1], rbt_strerror(code));
        return 2;
    }
    const long particles = atol(argv[2]), hits = atol(argv[3]);
    double along = 0.0, spin = 0.0;
    long failed = 0, clamped = 0;
    const double start = omp_get_wtime();
#pragma omp parallel for reduction(+ : along, spin, failed, clamped)
    for (long particle = 0; particle < particles; particle++) {
        const fate end = follow(table, (uint64_t)particle, (uint32_t)hits);
        along += end.along;
        spin += end.spin;
        failed += end.code < RBT_OK;
        clamped += end.clamped;
    }
    const double seconds = omp_get_wtime() - start;
    const double n = (double)particles;
    printf("mean velocity along the plates %.3f m/s, mean spin %.4g rad/s, failed %ld\n", along / n,
           spin / n, failed);
    printf("%.3g rebounds per second on %d threads\n", n * (double)hits / seconds,
           omp_get_max_threads());
    if (clamped > 0)
        printf("%ld rebounds lay outside the table and took its nearest condition\n", clamped);
    rbt_close(table);
    return failed > 0;
}
