! Everything that programs compile is found in one folder; the module itself has a room of its own.
include '../fortran/rebound_sampler.f90'
