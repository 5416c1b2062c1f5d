// Registers the model for colliding parcels. Two clouds need two files: what the macro defines has
// the same name in both. The cloud comes first, since headers of its models use what it includes.

#ifdef OPENFOAM
    #include "basicKinematicCollidingCloud.H"
#else
    #include "collidingCloud.H"
#endif

#include "TabulatedRebound.H"

#ifdef OPENFOAM
    makePatchInteractionModelType(TabulatedRebound, basicKinematicCollidingCloud);
#else
    makePatchInteractionModelType(TabulatedRebound, collidingCloud);
#endif
