! A particle loop in Fortran with OpenMP: gas drives particles from plate to plate.
!
!   sampler export corundum-steel --output corundum-steel.rbt
!   I=$(python -m sampler --include-dir)
!   printf '#define REBOUND_SAMPLER_IMPLEMENTATION\n#include "rebound_sampler.h"\n' > library.c
!   gcc -O3 -march=native -I$I -c library.c
!   gfortran -O3 -fopenmp $I/rebound_sampler.f90 particles.f90 library.o -o particles -lm
!   ./particles corundum-steel.rbt 100000 20
! It does what particles.c does.
program particles
  use, intrinsic :: iso_c_binding, only: c_double, c_int, c_int32_t, c_int64_t
  use omp_lib, only: omp_get_max_threads, omp_get_wtime
  use rebound_sampler
  implicit none

  real(c_double), parameter :: rest(3) = 0.0_c_double, half_size = 20.0e-6_c_double
  integer(c_int64_t), parameter :: seed = 7
  type(rbt_table) :: table
  character(len=512) :: word
  integer(c_int64_t) :: particle, n_particles
  integer(c_int32_t) :: n_hits
  integer(c_int) :: code
  integer :: failed
  integer(c_int64_t) :: clamped
  real(c_double) :: along, spin, start, seconds, velocity(3), omega(3)

  if (command_argument_count() /= 3) error stop "usage: particles TABLE.rbt PARTICLES HITS"
  call get_command_argument(1, word)
  code = rbt_open(word, table)
  if (code < RBT_OK) then
    print "(3a)", trim(word), ": ", rbt_strerror(code)
    error stop 2
  end if
  call get_command_argument(2, word)
  read (word, *) n_particles
  call get_command_argument(3, word)
  read (word, *) n_hits

  along = 0; spin = 0; failed = 0; clamped = 0
  start = omp_get_wtime()
  !$omp parallel do private(velocity, omega, code) reduction(+:along, spin, failed, clamped)
  do particle = 0, n_particles - 1
    call follow(particle, velocity, omega, clamped, code)
    along = along + velocity(1)
    spin = spin + omega(3)
    if (code < RBT_OK) failed = failed + 1
  end do
  !$omp end parallel do
  seconds = omp_get_wtime() - start
  print "(a, f0.3, a, es11.3, a, i0)", "mean velocity along the plates ", along / n_particles, &
      " m/s, mean spin ", spin / n_particles, " rad/s, failed ", failed
  print "(es9.2, a, i0, a)", n_particles * real(n_hits, c_double) / seconds, &
      " rebounds per second on ", omp_get_max_threads(), " threads"
  if (clamped > 0) print "(i0, a)", clamped, &
      " rebounds lay outside the table and took its nearest condition"
  call rbt_close(table)
  if (failed > 0) error stop 1

contains

  ! One particle through all its wall hits; counts those outside the table.
  subroutine follow(particle, velocity, omega, clamped, code)
    integer(c_int64_t), intent(in) :: particle
    real(c_double), intent(out) :: velocity(3), omega(3)
    integer(c_int64_t), intent(inout) :: clamped
    integer(c_int), intent(out) :: code
    integer(c_int32_t) :: hit
    real(c_double) :: side, before(3)

    velocity = [150.0_c_double, -80.0_c_double, 0.0_c_double]
    omega = 0
    code = RBT_OK
    do hit = 0, n_hits - 1
      side = merge(1, -1, mod(hit, 2) == 0)  ! lower and upper plate take turns
      before = velocity
      code = rbt_rebound(table, before, [0.0_c_double, side, 0.0_c_double], half_size, rest, &
          seed, particle, hit, velocity, omega)
      if (code < RBT_OK) exit
      if (code == RBT_CLAMPED) clamped = clamped + 1
      ! on the way to the other plate drag makes up most of the difference from the gas
      velocity = velocity + 0.8_c_double * ([150.0_c_double, 80 * side, 0.0_c_double] - velocity)
    end do
  end subroutine follow

end program particles
