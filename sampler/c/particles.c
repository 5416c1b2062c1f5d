/* A particle loop in C with OpenMP: gas drives particles from plate to plate, where they rebound.

   sampler export corundum-steel --output corundum-steel.rbt
   gcc -O3 -march=native -fopenmp -I$(python -m sampler --include-dir) particles.c -o particles -lm
   ./particles corundum-steel.rbt 100000 20

   Prints what became of the particles, and rebounds per second. The particles are the same on any
   number of threads: a rebound depends on the impact, and on seed, particle and number of its wall hits.
   If the table has a spin law, particles keep their spin from wall to wall. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include <omp.h>
#include <stdio.h>

#define SEED 7
#define HALF_SIZE 20e-6

#define BATCH 256

typedef struct fate {
    double along, spin;
    long failed, clamped; /* particles with an error; rebounds outside the table */
} fate;

/* Particles from `first` on, at most BATCH of them, through all their wall hits. */
static fate follow(const rbt_table *table, long first, long particles, uint32_t hits)
{
    double velocity[3 * BATCH], omega[3 * BATCH], normal[3 * BATCH], half_size[BATCH];
    uint64_t index[BATCH];
    uint32_t hit[BATCH];
    rbt_impacts impacts = {0}; /* walls at rest */
    rbt_report report;
    const size_t n = (size_t)(particles - first < BATCH ? particles - first : BATCH);
    fate end = {0.0, 0.0, 0, 0};
    impacts.velocity = velocity;
    impacts.omega = rbt_has_spin_law(table) ? omega : NULL; /* NULL: as if they did not spin */
    impacts.normal = normal;
    impacts.half_size = half_size;
    impacts.index = index;
    impacts.hit = hit;
    for (size_t k = 0; k < n; k++) {
        index[k] = (uint64_t)first + k;
        half_size[k] = HALF_SIZE;
        velocity[3 * k] = 150.0;
        velocity[3 * k + 1] = -80.0;
        velocity[3 * k + 2] = omega[3 * k] = omega[3 * k + 1] = omega[3 * k + 2] = 0.0;
    }
    for (uint32_t met = 0; met < hits; met++) {
        /* lower and upper plate take turns */
        const double side = met % 2 == 0 ? 1.0 : -1.0;
        const double gas[3] = {150.0, 80.0 * side, 0.0};
        for (size_t k = 0; k < n; k++) {
            hit[k] = met;
            normal[3 * k] = normal[3 * k + 2] = 0.0;
            normal[3 * k + 1] = side;
        }
        if (rbt_rebound_batch(table, n, &impacts, SEED, velocity, omega, &report) < RBT_OK) {
            end.failed = (long)(n - report.row);
            break;
        }
        end.clamped += (long)report.clamped;
        /* on the way to the other plate drag makes up most of the difference from the gas */
        for (size_t k = 0; k < 3 * n; k++)
            velocity[k] += 0.8 * (gas[k % 3] - velocity[k]);
    }
    for (size_t k = 0; k < n; k++) {
        end.along += velocity[3 * k];
        end.spin += omega[3 * k + 2];
    }
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
    for (long first = 0; first < particles; first += BATCH) {
        const fate end = follow(table, first, particles, (uint32_t)hits);
        along += end.along;
        spin += end.spin;
        failed += end.failed;
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
