/* A particle loop in C with OpenMP: gas drives particles from plate to plate, where they rebound.

   sampler export corundum-steel --output corundum-steel.rbt
   gcc -O3 -march=native -ffp-contract=off -fopenmp -I$(python -m sampler --include-dir) \
       particles.c -o particles -lm
   ./particles corundum-steel.rbt 100000 20 0.05

   The last number is the roughness of the plates, the standard deviation of the tilt of their facets in
   rad; left out, they are smooth. Prints what became of the particles, rebounds per second, and a
   digest of all rebounds. The particles are the same on any number of threads: a rebound depends on the
   impact, and on seed, particle and number of its wall hits. If the table has a spin law, particles
   keep their spin from wall to wall. particles.f90 and docs/examples/particles.py do the same with the
   same digest, if no compiler fuses the products and sums below. */

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
    uint64_t digest;
} fate;

/* The bits of some numbers, by exclusive or. */
static uint64_t digest_of(size_t n, const double *numbers)
{
    uint64_t digest = 0, bits;
    for (size_t k = 0; k < n; k++) {
        memcpy(&bits, numbers + k, sizeof bits);
        digest ^= bits;
    }
    return digest;
}

/* Particles from `first` on, at most BATCH of them, through all their wall hits. */
static fate follow(const rbt_table *table, long first, long particles, uint32_t hits,
                   double wall_roughness)
{
    double velocity[3 * BATCH], omega[3 * BATCH], normal[3 * BATCH], half_size[BATCH];
    double roughness[BATCH];
    uint64_t index[BATCH];
    uint32_t hit[BATCH];
    rbt_impacts impacts = {0}; /* walls at rest */
    rbt_report report;
    const size_t n = (size_t)(particles - first < BATCH ? particles - first : BATCH);
    fate end = {0.0, 0.0, 0, 0, 0};
    impacts.velocity = velocity;
    impacts.omega = rbt_has_spin_law(table) ? omega : NULL;
    impacts.normal = normal;
    impacts.half_size = half_size;
    impacts.roughness = roughness; /* NULL would be smooth walls */
    impacts.index = index;
    impacts.hit = hit;
    for (size_t k = 0; k < n; k++) {
        index[k] = (uint64_t)first + k;
        half_size[k] = HALF_SIZE;
        roughness[k] = wall_roughness;
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
        end.digest ^= digest_of(3 * n, velocity) ^ digest_of(3 * n, omega);
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
    if (argc != 4 && argc != 5) {
        fprintf(stderr, "usage: particles TABLE.rbt PARTICLES HITS [ROUGHNESS]\n");
        return 2;
    }
    rbt_table *table;
    const int code = rbt_open(argv[1], &table);
    if (code < RBT_OK) {
        fprintf(stderr, "%s: %s\n", argv[1], rbt_strerror(code));
        return 2;
    }
    const long particles = atol(argv[2]), hits = atol(argv[3]);
    const double roughness = argc == 5 ? atof(argv[4]) : 0.0;
    double along = 0.0, spin = 0.0;
    long failed = 0, clamped = 0;
    uint64_t digest = 0;
    const double start = omp_get_wtime();
#pragma omp parallel for reduction(+ : along, spin, failed, clamped) reduction(^ : digest)
    for (long first = 0; first < particles; first += BATCH) {
        const fate end = follow(table, first, particles, (uint32_t)hits, roughness);
        along += end.along;
        spin += end.spin;
        failed += end.failed;
        clamped += end.clamped;
        digest ^= end.digest;
    }
    const double seconds = omp_get_wtime() - start;
    const double n = (double)particles;
    printf("mean velocity along the plates %.3f m/s, mean spin %.4g rad/s, failed %ld\n", along / n,
           spin / n, failed);
    printf("%.3g rebounds per second on %d threads\n", n * (double)hits / seconds,
           omp_get_max_threads());
    printf("digest %016llX\n", (unsigned long long)digest);
    if (clamped > 0)
        printf("%ld rebounds lay outside the table and took its nearest condition\n", clamped);
    rbt_close(table);
    return failed > 0;
}
