/* One hit in the stand-in for Fluent. Arguments: dimensions, 1 for axisymmetric swirl, 1 for a moving
   wall; then, for the particle, position and velocity, the normal of the face out of the gas, and the
   velocity of the wall, three numbers each. Prints the status, velocity, and the five user scalars. */
#include "fluent_udf.c"

#include <stdlib.h>

int main(int count, char **words)
{
    Thread wall = {0, {0, 0, 0}, {0, 0, 0}};
    Tracked_Particle p = {3, 50e-6, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {9, 9, 9, 9, 9}};
    real normal[3];
    if (count != 16)
        return 2;
    const int dim = atoi(words[1]);
    rp_axi_swirl = atoi(words[2]);
    wall.moving = atoi(words[3]);
    for (int k = 0; k < 3; k++) {
        p.position[k] = atof(words[4 + k]);
        p.velocity[k] = p.velocity_before[k] = atof(words[7 + k]);
        normal[k] = atof(words[10 + k]);
        wall.velocity[k] = 0.75 * atof(words[13 + k]);
        wall.grid_velocity[k] = 0.25 * atof(words[13 + k]);
    }
    start_particle(0, &wall, 1, &p);
    const int status = rebound_wall(&p, &wall, 0, normal, dim);
    printf("%d", status == PATH_ACTIVE);
    for (int k = 0; k < 3; k++)
        printf(" %.17g", p.velocity[k]);
    for (int k = 0; k < 5; k++)
        printf(" %.17g", p.user[k]);
    printf("\n");
    return 0;
}
