/* What rebound_sampler.h and rebound_device.h use of HIP's own headers, so that clang compiles them for
   a device of AMD where HIP is not installed: put before all else (clang++ -include). */
#pragma once
#include <math.h>
#include <stddef.h>
#include <string.h>

#define __host__ __attribute__((host))
#define __device__ __attribute__((device))
#define __global__ __attribute__((global))

#define HIP_FUNCTION(name) __device__ double name(double);
HIP_FUNCTION(atan) HIP_FUNCTION(cos) HIP_FUNCTION(erfc) HIP_FUNCTION(exp)
HIP_FUNCTION(expm1) HIP_FUNCTION(log) HIP_FUNCTION(asin) HIP_FUNCTION(sin) HIP_FUNCTION(tan)
HIP_FUNCTION(cbrt)
__device__ double atan2(double, double), pow(double, double);

#define HIP_BUILTIN(type, name)                                                                    \
    __device__ static inline type name(type x) { return __builtin_##name(x); }
HIP_BUILTIN(double, fabs) HIP_BUILTIN(double, floor)
HIP_BUILTIN(double, sqrt) HIP_BUILTIN(float, sqrtf)

__device__ static inline void *memcpy(void *to, const void *from, size_t size)
{
    return __builtin_memcpy(to, from, size);
}

__device__ static inline void *memset(void *memory, int byte, size_t size)
{
    return __builtin_memset(memory, byte, size);
}

struct hip_place {
    unsigned x;
};
extern const __device__ __attribute__((weak)) hip_place gridDim, blockDim, blockIdx, threadIdx;

int hipMalloc(void **, size_t);
int hipMemcpy(void *, const void *, size_t, int);
int hipFree(void *);
static const int hipMemcpyDefault = 4;
