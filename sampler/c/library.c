/* The library that Python loads: the functions of the header, and what Python alone needs. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

/* As rbt_open_memory, for an image that Python has just made of a table that it has checked: it has no
   checksum. */
RBT_API int rbt_open_image(const void *image, size_t size, rbt_table **table);

RBT_API int rbt_open_image(const void *image, size_t size, rbt_table **table)
{
    return rbti_open(image, size, 0, table);
}
