! Rebounds at one hit by direct simulation, in a call with all particles.
!
!     direct_hit TABLE.rbt IMPACTS N RESULTS
!
! IMPACTS has 7 numbers for each particle: velocity, normal, half-size. RESULTS gets 10 numbers for each:
! velocity, omega, inertia, works, code.
program direct_hit
  use, intrinsic :: iso_c_binding, only: c_double, c_int, c_int32_t, c_int64_t
  use rebound_sampler
  implicit none

  character(len=1000) :: words(4)
  type(rbt_table) :: table
  real(c_double), allocatable :: given(:, :), results(:, :)
  integer(c_int), allocatable :: codes(:)
  integer(c_int64_t), allocatable :: index(:)
  integer(c_int32_t), allocatable :: hit(:)
  integer(c_int) :: code
  integer :: file, k, n

  do k = 1, 4
    call get_command_argument(k, words(k))
  end do
  read (words(3), *) n
  allocate (given(7, n), results(10, n), codes(n), index(n), hit(n))
  open (newunit=file, file=words(2), access="stream", status="old")
  read (file) given
  close (file)
  index = [(int(k, c_int64_t), k = 0, n - 1)]
  hit = 0

  code = rbt_open(trim(words(1)), table)
  if (code == RBT_OK) code = rbt_use_direct(table, rebound_direct)
  if (code < 0) then
    print "(i0, 1x, a)", code, rbt_strerror(code)
    stop 1
  end if
  code = rbt_rebound(table, given(:3, :), given(4:6, :), given(7, :), index=index, hit=hit, &
      seed=7_c_int64_t, new_velocity=results(:3, :), new_omega=results(4:6, :), &
      new_inertia=results(7, :), works=results(8:9, :), codes=codes)
  if (code < 0) stop 2
  results(10, :) = codes
  call rbt_close(table)

  open (newunit=file, file=words(4), access="stream", status="replace")
  write (file) results
  close (file)
end program direct_hit
