/* A particle loop on a GPU: particles stay on the device from the first wall to the last.

   sampler export corundum-steel --output corundum-steel.rbt
   nvcc -O3 -fmad=false -I$(python -m sampler --include-dir) particles.cu -o particles_gpu
   ./particles_gpu corundum-steel.rbt 1000000 20 0.05

   The same as particles.c, with the same arguments; its digest is that of particles.c but for rebounds
   whose last digits are those of another atan2, sin or cos. Compiled, and run in loops of the host by
   tests; never run on a GPU. With hipcc: hip/hip_runtime.h comes before the header. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include "rebound_device.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#define SEED 7
#define HALF_SIZE 20e-6
#define THREADS 128

/* What became of all particles, and of one. */
struct fate {
    unsigned long long digest, failed, clamped; /* rebounds outside the table */
};

struct particle {
    double velocity[3], omega[3];
};

/* The bits of three numbers, by exclusive or. */
static __device__ unsigned long long digest_of(const double *numbers)
{
    unsigned long long digest = 0, bits;
    for (int k = 0; k < 3; k++) {
        memcpy(&bits, numbers + k, sizeof bits);
        digest ^= bits;
    }
    return digest;
}

/* One particle from plate to plate. */
static __device__ void follow(const rbt_table *table, unsigned long long index, unsigned hits,
                              double roughness, particle *of, fate *end)
{
    double *v = of->velocity, *omega = of->omega;
    const double *before = rbt_has_spin_law(table) ? omega : nullptr; /* as if it did not spin */
    v[0] = 150.0;
    v[1] = -80.0;
    v[2] = omega[0] = omega[1] = omega[2] = 0.0;
    for (unsigned hit = 0; hit < hits; hit++) {
        /* lower and upper plate take turns */
        const double side = hit % 2 == 0 ? 1.0 : -1.0;
        const double normal[3] = {0.0, side, 0.0}, gas[3] = {150.0, 80.0 * side, 0.0};
        const int code = rbt_rough_rebound(table, v, normal, HALF_SIZE, nullptr, roughness, before,
                                           SEED, index, hit, v, omega);
        if (code < RBT_OK) {
            end->failed++;
            return;
        }
        end->clamped += (code & RBT_CLAMPED) != 0;
        end->digest ^= digest_of(v) ^ digest_of(omega);
        /* on the way to the other plate drag makes up most of the difference from the gas */
        for (int k = 0; k < 3; k++)
            v[k] += 0.8 * (gas[k] - v[k]);
    }
}

RBT_KERNEL follow_all(RBT_TABLE_ARGUMENT table, unsigned long long n, unsigned hits,
                      double roughness, particle *particles, fate *ends)
{
    fate end = {0, 0, 0};
    RBT_EACH_ROW(k, n)
    {
        particle of;
        follow(&table, k, hits, roughness, &of, &end);
        particles[k] = of;
    }
    atomicXor(&ends->digest, end.digest);
    atomicAdd(&ends->failed, end.failed);
    atomicAdd(&ends->clamped, end.clamped);
}

/* Particles and their fate from the device; 0 if all is well. */
static int run(const rbt_table *on_device, unsigned hits, double roughness,
               std::vector<particle> &particles, fate &end)
{
    const size_t size = particles.size() * sizeof(particle);
    const unsigned long long n = particles.size(), blocks = (n + THREADS - 1) / THREADS;
    void *there = nullptr, *ends = nullptr;
    int failed = RBT_DEVICE_MALLOC(&there, size) | RBT_DEVICE_MALLOC(&ends, sizeof end);
    failed = failed || RBT_DEVICE_COPY(ends, &end, sizeof end);
    if (!failed)
        RBT_LAUNCH(follow_all, (unsigned)(blocks < 65535 ? blocks : 65535), THREADS, *on_device, n,
                   hits, roughness, static_cast<particle *>(there), static_cast<fate *>(ends));
    failed = failed || RBT_DEVICE_COPY(&end, ends, sizeof end) ||
             RBT_DEVICE_COPY(particles.data(), there, size);
    rbt_device_free(there);
    rbt_device_free(ends);
    return failed;
}

static void tell(const std::vector<particle> &particles, const fate &end, double hits,
                 double seconds)
{
    const double n = static_cast<double>(particles.size());
    double along = 0.0, spin = 0.0;
    for (const particle &of : particles) {
        along += of.velocity[0];
        spin += of.omega[2];
    }
    std::printf("mean velocity along the plates %.3f m/s, mean spin %.4g rad/s, failed %llu\n",
                along / n, spin / n, end.failed);
    std::printf("%.3g rebounds per second, with the copies of all particles\n", n * hits / seconds);
    std::printf("digest %016llX\n", end.digest);
    if (end.clamped > 0)
        std::printf("%llu rebounds lay outside the table and took its nearest condition\n",
                    end.clamped);
}

int main(int argc, char **argv)
{
    if (argc != 4 && argc != 5) {
        std::fprintf(stderr, "usage: particles_gpu TABLE.rbt PARTICLES HITS [ROUGHNESS]\n");
        return 2;
    }
    rbt_table *table, on_device;
    void *copy = nullptr;
    int code = rbt_open(argv[1], &table);
    if (code < RBT_OK) {
        std::fprintf(stderr, "%s: %s\n", argv[1], rbt_strerror(code));
        return 2;
    }
    code = rbt_to_device(table, &on_device, &copy);
    rbt_close(table); /* the device has all of it */
    if (code < RBT_OK) {
        std::fprintf(stderr, "device: there is none, or it has no room for the table\n");
        return 2;
    }
    std::vector<particle> particles(std::strtoull(argv[2], nullptr, 10));
    const unsigned hits = static_cast<unsigned>(std::strtoul(argv[3], nullptr, 10));
    fate end = {0, 0, 0};
    const auto start = std::chrono::steady_clock::now();
    const int failed = run(&on_device, hits, argc == 5 ? std::atof(argv[4]) : 0.0, particles, end);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    rbt_device_free(copy);
    if (failed) {
        std::fprintf(stderr, "the device failed: too many particles for its memory?\n");
        return 1;
    }
    tell(particles, end, hits, took.count());
    return end.failed > 0;
}
