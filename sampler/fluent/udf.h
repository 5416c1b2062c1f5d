/* udf.h - the few names of Fluent's udf.h that rebound_bc.c needs, declared by us.

   With this file rebound_bc.c compiles, and can be called, on a machine without Fluent; that is all
   that it is for. It holds no code of Fluent. Names, arguments and meaning are those of Fluent's UDF
   manual (chapters on DEFINE_DPM_BC, DEFINE_DPM_SCALAR_UPDATE, DEFINE_EXECUTE_ON_LOADING and on the
   macros of particles), in the spelling TP_... of newer versions, which older ones have as P_... .
   What stands behind a name is ours: in Fluent a Tracked_Particle is another, larger structure.

   | name                        | meaning                                                      |
   |-----------------------------|--------------------------------------------------------------|
   | real                        | double, or float in single precision                         |
   | RP_2D                       | 1 in a 2D build, else 0                                      |
   | rp_axi_swirl                | whether the 2D case is axisymmetric with swirl               |
   | TP_POS, TP_VEL, TP_VEL0     | position; velocity; velocity before the step; [0] to [2]     |
   | TP_DIAM, TP_ID, TP_TYPE     | diameter; identity; kind (DPM_TYPE_INERT: no mass transfer)  |
   | TP_RHO, TP_DT               | density; time step                                           |
   | TP_USER_REAL(tp, i)         | user scalar i of the particle                                |
   | C_MU_L(c, t)                | viscosity of the gas in a cell                               |
   | PATH_ACTIVE, PATH_ABORT     | what a boundary condition returns: go on; give the track up  |
   | Message                     | print, with a format as printf                               |

   Do not copy this file to Fluent: there its own udf.h must be found. */

#ifndef REBOUND_STAND_IN
#error "sampler/fluent/udf.h stands in for Fluent's own; copy rebound_bc.c without it"
#endif

#ifndef REBOUND_UDF_H
#define REBOUND_UDF_H

#include <math.h>
#include <stdio.h>

#ifndef RP_2D
#define RP_2D 0
#endif
#ifndef REBOUND_REAL
#define REBOUND_REAL double
#endif

typedef REBOUND_REAL real;
typedef int face_t;
typedef int cell_t;

typedef struct Thread {
    int id;
    real viscosity;
} Thread;

typedef struct Tracked_Particle {
    real position[3], velocity[3], velocity_before[3], diameter, density, time_step;
    real user[6];
    real omega[3]; /* for REBOUND_SPIN of rebound_bc.c */
    long long id;
    int type;
} Tracked_Particle;

enum { DPM_TYPE_INERT = 1, DPM_TYPE_DROPLET = 2 };
enum { PATH_ABORT = -1, PATH_ACTIVE = 0 };

extern int rp_axi_swirl;

#define TP_POS(tp) ((tp)->position)
#define TP_VEL(tp) ((tp)->velocity)
#define TP_VEL0(tp) ((tp)->velocity_before)
#define TP_DIAM(tp) ((tp)->diameter)
#define TP_ID(tp) ((tp)->id)
#define TP_TYPE(tp) ((tp)->type)
#define TP_RHO(tp) ((tp)->density)
#define TP_DT(tp) ((tp)->time_step)
#define TP_USER_REAL(tp, i) ((tp)->user[i])

#define C_MU_L(c, t) ((void)(c), (t)->viscosity)

#define Message printf

/* Each definition is preceded by its own declaration, as compilers with strict warnings want it. */
#define DEFINE_DPM_BC(name, tp, t, f, f_normal, dim)                                               \
    int name(Tracked_Particle *tp, Thread *t, face_t f, real f_normal[], int dim);                 \
    int name(Tracked_Particle *tp, Thread *t, face_t f, real f_normal[], int dim)

#define DEFINE_DPM_SCALAR_UPDATE(name, c, t, initialize, tp)                                       \
    void name(cell_t c, Thread *t, int initialize, Tracked_Particle *tp);                          \
    void name(cell_t c, Thread *t, int initialize, Tracked_Particle *tp)

#define DEFINE_EXECUTE_ON_LOADING(name, libname)                                                   \
    void name(char *libname);                                                                      \
    void name(char *libname)

#define DEFINE_EXECUTE_AT_EXIT(name)                                                               \
    void name(void);                                                                               \
    void name(void)

#endif
