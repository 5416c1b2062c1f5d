! A particle loop in Fortran with OpenMP: gas drives particles from plate to plate.
!
!   sampler export corundum-steel --output corundum-steel.rbt
!   I=$(python -m sampler --include-dir)
!   printf '#define REBOUND_SAMPLER_IMPLEMENTATION\n#include "rebound_sampler.h"\n' > library.c
!   gcc -O3 -march=native -I$I -c library.c
!   gfortran -O3 -ffp-contract=off -fopenmp $I/rebound_sampler.f90 particles.f90 library.o \
!       -o particles -lm
!   ./particles corundum-steel.rbt 100000 20 0.05
! It does what particles.c does.
program particles
  use, intrinsic :: iso_c_binding, only: c_double, c_int, c_int32_t, c_int64_t
  use omp_lib, only: omp_get_max_threads, omp_get_wtime
  use rebound_sampler
  implicit none

  real(c_double), parameter :: half_size = 20.0e-6_c_double
  integer(c_int64_t), parameter :: seed = 7
  type(rbt_table) :: table
  character(len=512) :: word
  integer(c_int64_t), parameter :: batch = 256
  integer(c_int64_t) :: first, n_particles
  integer(c_int32_t) :: n_hits
  integer(c_int) :: code
  integer :: failed
  integer(c_int64_t) :: clamped
  integer(c_int64_t) :: digest
  real(c_double) :: along, spin, start, seconds, roughness

  if (command_argument_count() /= 3 .and. command_argument_count() /= 4) &
      error stop "usage: particles TABLE.rbt PARTICLES HITS [ROUGHNESS]"
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

  roughness = 0
  if (command_argument_count() == 4) then
    call get_command_argument(4, word)
    read (word, *) roughness
  end if

  along = 0; spin = 0; failed = 0; clamped = 0; digest = 0
  start = omp_get_wtime()
  !$omp parallel do reduction(+:along, spin, failed, clamped) reduction(ieor:digest)
  do first = 0, n_particles - 1, batch
    call follow(first, min(batch, n_particles - first), along, spin, failed, clamped, digest)
  end do
  !$omp end parallel do
  seconds = omp_get_wtime() - start
  print "(a, f0.3, a, es11.3, a, i0)", "mean velocity along the plates ", along / n_particles, &
      " m/s, mean spin ", spin / n_particles, " rad/s, failed ", failed
  print "(es9.2, a, i0, a)", n_particles * real(n_hits, c_double) / seconds, &
      " rebounds per second on ", omp_get_max_threads(), " threads"
  print "(a, z16.16)", "digest ", digest
  if (clamped > 0) print "(i0, a)", clamped, &
      " rebounds lay outside the table and took its nearest condition"
  call rbt_close(table)
  if (failed > 0) error stop 1

contains

  ! The bits of some numbers, by exclusive or.
  pure function digest_of(numbers) result(digest)
    real(c_double), intent(in) :: numbers(:, :)
    integer(c_int64_t) :: digest

    digest = iparity(transfer(numbers, [0_c_int64_t]))
  end function digest_of

  ! Particles first to first + n - 1 through all their wall hits; adds to the sums and counts.
  subroutine follow(first, n, along, spin, failed, clamped, digest)
    integer(c_int64_t), intent(in) :: first, n
    real(c_double), intent(inout) :: along, spin
    integer, intent(inout) :: failed
    integer(c_int64_t), intent(inout) :: clamped, digest
    integer(c_int64_t) :: index(n), k
    integer(c_int32_t) :: hit, hits(n)
    real(c_double) :: side, velocity(3, n), before(3, n), omega(3, n), normal(3, n), sizes(n), tilts(n)
    real(c_double), target :: turning(3, n)            ! angular velocities before the impact
    real(c_double), pointer, contiguous :: given(:, :) ! the same, or none
    type(rbt_report) :: report

    index = [(first + k, k = 0, n - 1)]
    sizes = half_size
    tilts = roughness
    velocity = spread([150.0_c_double, -80.0_c_double, 0.0_c_double], 2, int(n))
    omega = 0
    given => null()
    if (rbt_has_spin_law(table)) given => turning
    do hit = 0, n_hits - 1
      side = merge(1, -1, mod(hit, 2) == 0)  ! lower and upper plate take turns
      normal = spread([0.0_c_double, side, 0.0_c_double], 2, int(n))
      hits = hit
      before = velocity
      turning = omega
      if (rbt_rebound_batch(table, before, normal, sizes, seed, index, hits, velocity, omega, &
          report=report, omega=given, roughness=tilts) < RBT_OK) then
        failed = failed + int(n - report%row + 1)
        exit
      end if
      clamped = clamped + report%clamped
      digest = ieor(digest, ieor(digest_of(velocity), digest_of(omega)))
      ! on the way to the other plate drag makes up most of the difference from the gas
      velocity = velocity + 0.8_c_double &
          * (spread([150.0_c_double, 80 * side, 0.0_c_double], 2, int(n)) - velocity)
    end do
    along = along + sum(velocity(1, :))
    spin = spin + sum(omega(3, :))
  end subroutine follow

end program particles
