/* Calls the wall condition of sampler/fluent with made-up particles, one wall after the other. */

#include <stddef.h>

#include "udf.h"

int rp_axi_swirl = 0;

int rebound_wall(Tracked_Particle *tp, Thread *t, face_t f, real f_normal[], int dim);
void rebound_flight(cell_t c, Thread *t, int initialize, Tracked_Particle *tp);
void rebound_open(char *libname);
void rebound_close(void);

size_t particle_size(void);
size_t particle_size(void)
{
    return sizeof(Tracked_Particle);
}

/* The scalar update of a new particle, or of one that has flown for a time step in a gas. */
void fly(Tracked_Particle *particle, int is_new, double viscosity);
void fly(Tracked_Particle *particle, int is_new, double viscosity)
{
    Thread cells = {1, 0};
    cells.viscosity = (real)viscosity;
    rebound_flight(0, &cells, is_new, particle);
}

/* Status of the track after a wall whose normal points out of the gas. */
int meet(Tracked_Particle *particle, double x, double y, double z, int dim);
int meet(Tracked_Particle *particle, double x, double y, double z, int dim)
{
    Thread wall = {2, 0};
    real f_normal[3];
    f_normal[0] = (real)x;
    f_normal[1] = (real)y;
    f_normal[2] = (real)z;
    return rebound_wall(particle, &wall, 0, f_normal, dim);
}
