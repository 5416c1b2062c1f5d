! Walls on all sides of the box, for the gas.
subroutine cs_f_user_boundary_conditions(nvar, nscal, icodcl, itrifb, itypfb, izfppp, dt, rcodcl)
  use mesh, only: nfabor, ncelet
  use paramx, only: iparoi
  implicit none
  integer :: nvar, nscal
  integer :: icodcl(nfabor, nvar), itrifb(nfabor), itypfb(nfabor), izfppp(nfabor)
  double precision :: dt(ncelet), rcodcl(nfabor, nvar, 3)

  itypfb(:) = iparoi
end subroutine cs_f_user_boundary_conditions
