/* The functions of rebound_sampler.h, for a program that defines REBOUND_SAMPLER_IMPLEMENTATION in no file of
   its own: a program in Fortran, for example. */
#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"
