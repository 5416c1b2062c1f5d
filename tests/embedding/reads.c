/* Reads of a table by draws, counted: clang calls a function before every load that it compiles.

   Prints the least and the largest number of reads of the image that a draw made, and of bytes. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

static uintptr_t image_first, image_end;
static size_t reads, bytes;

__attribute__((no_sanitize("coverage"))) static void note(const void *place, size_t size)
{
    const uintptr_t at = (uintptr_t)place;
    if (at >= image_first && at < image_end) {
        reads += 1;
        bytes += size;
    }
}

#define COUNTED(type, size)                                                                        \
    void __sanitizer_cov_load##size(const type *place);                                            \
    __attribute__((no_sanitize("coverage"))) void __sanitizer_cov_load##size(const type *place)    \
    {                                                                                              \
        note(place, size);                                                                         \
    }
COUNTED(uint8_t, 1)
COUNTED(uint16_t, 2)
COUNTED(uint32_t, 4)
COUNTED(uint64_t, 8)
COUNTED(void, 16)

int main(int argc, char **argv)
{
    rbt_table *table;
    const size_t draws = argc > 2 ? strtoul(argv[2], NULL, 10) : 0;
    size_t size, least = SIZE_MAX, most = 0, least_bytes = SIZE_MAX, most_bytes = 0;
    if (argc != 3 || rbt_open(argv[1], &table) != RBT_OK)
        return 2;
    image_first = (uintptr_t)rbt_image(table, &size);
    image_end = image_first + size;
    for (size_t k = 0; k < draws; k++) {
        const double part = ((double)k + 0.5) / (double)draws;
        const double turned = 7.0 * part - (double)(int)(7.0 * part);
        const double alpha1 = table->alpha.first + part * (table->alpha.last - table->alpha.first);
        const double speed = table->speed.first + turned * (table->speed.last - table->speed.first);
        double values[RBT_VALUES];
        reads = bytes = 0;
        if (rbt_draw_all(table, alpha1, speed, 7, k, 0, values) < RBT_OK)
            return 3;
        least = reads < least ? reads : least;
        most = reads > most ? reads : most;
        least_bytes = bytes < least_bytes ? bytes : least_bytes;
        most_bytes = bytes > most_bytes ? bytes : most_bytes;
    }
    printf("%zu %zu %zu %zu\n", least, most, least_bytes, most_bytes);
    rbt_close(table);
    return 0;
}
