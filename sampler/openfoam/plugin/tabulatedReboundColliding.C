// Registers the model for basicKinematicCollidingCloud. Two clouds need two files: what the macro defines has
// the same name in both.

#include "basicKinematicCollidingCloud.H"
#include "TabulatedRebound.H"

makePatchInteractionModelType(TabulatedRebound, basicKinematicCollidingCloud);
