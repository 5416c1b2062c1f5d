/* A stand-in for the header of Fluent's user-defined functions: the documented macros that our function
   uses, for one particle and one face. RP_3D is 1 in three dimensions. */
#ifndef UDF_H
#define UDF_H

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

typedef double real;
typedef int face_t, cell_t, cxboolean;

enum { PATH_ABORT, PATH_END, PATH_ACTIVE };
enum { SV_WALL_GRID_V, SV_WALL_V };

typedef struct {
    int moving;
    real velocity[3], grid_velocity[3];
} Thread;

typedef struct {
    long id;
    real diameter, position[3], velocity[3], velocity_before[3], user[5];
} Tracked_Particle;

#define TP_ID(tp) ((tp)->id)
#define TP_DIAM(tp) ((tp)->diameter)
#define TP_POS(tp) ((tp)->position)
#define TP_VEL(tp) ((tp)->velocity)
#define TP_VEL0(tp) ((tp)->velocity_before)
#define TP_USER_REAL(tp, i) ((tp)->user[i])

#define SV_ALLOCATED_P(t, variable) ((void)(variable), (t)->moving)
#define WALL_F_VV(f, t) ((void)(f), (t)->velocity)
#define WALL_F_GRID_VV(f, t) ((void)(f), (t)->grid_velocity)

#define DEFINE_DPM_BC(name, tp, t, f, normal, dim)                                                   \
    int name(Tracked_Particle *tp, Thread *t, face_t f, real normal[], int dim)
#define DEFINE_DPM_SCALAR_UPDATE(name, cell, thread, initialize, tp)                                 \
    void name(cell_t cell, Thread *thread, int initialize, Tracked_Particle *tp)

static int rp_axi_swirl = 0;

static inline void Message(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vprintf(format, arguments);
    va_end(arguments);
}

#endif
