// Registers the model for kinematic parcels. Two clouds need two files: what the macro defines has
// the same name in both. The cloud comes first, since headers of its models use what it includes.

#ifdef OPENFOAM
    #include "basicKinematicCloud.H"
#else
    #include "momentumCloud.H"
#endif

#include "TabulatedRebound.H"

#ifdef OPENFOAM
    makePatchInteractionModelType(TabulatedRebound, basicKinematicCloud);
#else
    makePatchInteractionModelType(TabulatedRebound, momentumCloud);
#endif
