/* Device code on the host: put before rebound_sampler.h (g++ -include device_on_host.h), it makes
   rebound_device.h a source of C++ whose kernels run thread by thread, in loops over the grid. Compile
   with -DRBTI_GPU -ffp-contract=off, which take the way of a device through the draw, and its bits. */
#pragma once
#include <cstdlib>
#include <cstring>

#define __host__
#define __device__
#define __global__

extern "C" {
struct place {
    unsigned x;
} gridDim, blockDim, blockIdx, threadIdx;
}

static inline void atomicAdd(double *sum, double x) { *sum += x; }

/* The first thread, and the next one, until none is left. */
static inline bool first_thread(unsigned blocks, unsigned threads)
{
    gridDim.x = blocks;
    blockDim.x = threads;
    blockIdx.x = threadIdx.x = 0;
    return blocks > 0 && threads > 0;
}

static inline bool next_thread()
{
    if (++threadIdx.x == blockDim.x) {
        threadIdx.x = 0;
        blockIdx.x++;
    }
    return blockIdx.x < gridDim.x;
}

#define RBT_LAUNCH(kernel, blocks, threads, ...)                                                   \
    for (bool more = first_thread(blocks, threads); more; more = next_thread())                    \
    kernel(__VA_ARGS__)

static inline int host_malloc(void **memory, size_t size)
{
    *memory = std::aligned_alloc(256, (size + 255) / 256 * 256);
    return *memory == nullptr;
}

#define RBT_DEVICE_MALLOC(memory, size) host_malloc(memory, size)
#define RBT_DEVICE_COPY(to, from, size) (std::memcpy(to, from, size) == nullptr)
#define RBT_DEVICE_FREE(memory) (std::free(memory), 0)
