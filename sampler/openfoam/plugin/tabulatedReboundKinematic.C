// Registers the model for basicKinematicCloud. Two clouds need two files: what the macro defines has
// the same name in both.

#include "basicKinematicCloud.H"
#include "TabulatedRebound.H"

makePatchInteractionModelType(TabulatedRebound, basicKinematicCloud);
