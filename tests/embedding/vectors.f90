! Known-answer vectors through the Fortran module: vectors TABLE.rbt CASES.txt, lines of write_cases in
! known_vectors.py
program vectors
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: iostat_end
  use rebound_sampler
  implicit none

  type(rbt_table) :: table
  character(len=512) :: image, file
  integer :: unit, status, cases, flags(3)

  ! the case of a line
  logical :: draws, rough, spins, holds
  real(c_double) :: given(11), spin(3), inertia, expected(RBT_VALUES), after_spin
  integer(c_int64_t) :: seed, index_
  integer(c_int32_t) :: hit
  integer(c_int) :: code

  call get_command_argument(1, image)
  call get_command_argument(2, file)
  code = rbt_open(image, table)
  if (code < 0) then
    print "(a)", rbt_strerror(code)
    stop 1
  end if
  open (newunit=unit, file=file, status="old", action="read")
  cases = 0
  do
    read (unit, *, iostat=status) flags, given, spin, inertia, seed, index_, hit, code, expected, &
        after_spin
    if (status == iostat_end) exit
    cases = cases + 1
    draws = flags(1) == 1
    rough = flags(2) == 1
    spins = flags(3) == 1
    if (draws) then
      holds = draw_holds()
    else
      holds = rebound_holds()
    end if
    if (.not. holds) then
      print "(a, i0, a)", "case ", cases, " fails"
      stop 1
    end if
  end do
  close (unit)
  if (.not. others_hold()) error stop "range, grains or shapes"
  if (.not. optional_arguments_hold()) error stop "optional arguments"
  if (.not. ends_hold()) error stop "a head-on angle in single precision"
  call rbt_close(table)
  if (rbt_is_open(table)) stop 1
  print "(i0, a)", cases, " cases"

contains

  function draw_holds() result(holds)
    logical :: holds
    real(c_double), allocatable :: spins_before(:, :), states(:, :)
    real(c_double) :: after(1)
    integer, allocatable :: places(:)
    integer(c_int) :: codes(2)

    if (spins) spins_before = reshape(spin, [3, 1])  ! else absent
    places = rbt_variables(table)
    allocate (states(size(places), 1))
    codes(1) = rbt_sample(table, given(1:1), given(2:2), spins_before, [inertia], index=[index_], &
        hit=[hit], inertia_after=after, seed=seed, states=states, codes=codes(2:))
    holds = all(codes == code) .and. agree(states(:, 1), expected(places), 0.0_c_double) .and. &
        agree(after, [after_spin], 0.0_c_double)
  end function draw_holds

  ! One particle, and two that are equal.
  function rebound_holds() result(holds)
    logical :: holds, fresh
    real(c_double) :: after(7), rows(7, 2), tolerance
    real(c_double), allocatable :: omega(:), omegas(:, :), k_before, ks_before(:), roughness, tilts(:)
    integer(c_int) :: codes(4)
    integer :: bad, first, flagged(8), k

    if (spins) omega = spin  ! else absent
    if (spins) omegas = spread(spin, 2, 2)
    if (spins) k_before = inertia
    if (spins) ks_before = spread(inertia, 1, 2)
    if (rough) roughness = given(11)
    if (rough) tilts = spread(given(11), 1, 2)
    fresh = .not. rbt_has_spin_law(table)
    rows = 0
    codes(1) = rbt_rebound(table, given(:3), given(4:6), given(7), given(8:10), omega, k_before, &
        roughness, index=index_, hit=hit, fresh=fresh, seed=seed, new_velocity=after(:3), &
        new_omega=after(4:6), new_inertia=after(7))
    codes(2) = rbt_rebound(table, spread(given(:3), 2, 2), spread(given(4:6), 2, 2), &
        spread(given(7), 1, 2), spread(given(8:10), 2, 2), omegas, ks_before, tilts, &
        index=[index_, index_], hit=[hit, hit], fresh=fresh, seed=seed, new_velocity=rows(:3, :), &
        new_omega=rows(4:6, :), new_inertia=rows(7, :), codes=codes(3:), bad=bad, first_bad=first, &
        flagged=flagged)
    ! of atan2, cos and sin of the C library, whose last digit may turn that of a feature of a spin draw
    tolerance = merge(1.0e-5_c_double, merge(1.0e-12_c_double, 1.0e-13_c_double, rough), spins)
    holds = all(codes == code) .and. bad == merge(2, 0, code < 0) .and. &
        first == merge(1, 0, code < 0) .and. all(flagged == [(2 * ibits(max(code, 0), k, 1), k=0, 7)])
    if (code == RBT_ERR_NOT_APPROACHING) then  ! what was before; a spin may be none
      holds = holds .and. all(abs(after(:3) - given(:3)) <= 0) .and. &
          all(abs(rows(:3, 2) - given(:3)) <= 0)
      if (spins .and. .not. any(ieee_is_nan(spin))) holds = holds .and. &
          all(abs([after(4:), rows(4:, 2)] - [spin, inertia, spin, inertia]) <= 0)
      return
    end if
    holds = holds .and. agree(rows(:, 1), after, 0.0_c_double) .and. &
        agree(rows(:, 2), after, 0.0_c_double) .and. agree(after(:3), expected(:3), tolerance) .and. &
        agree(after(4:6), expected(4:6), tolerance)
    if (spins) holds = holds .and. agree(after(7:), [after_spin], tolerance)
  end function rebound_holds

  ! The range, grains, sizes, deposits, and arrays whose shapes do not agree.
  function others_hold() result(holds)
    logical :: holds, spinning
    type(rbt_range) :: range
    real(c_double), parameter :: v(3) = [9, -1, 0], up(3) = [0, 2, 0], still(3) = 0, mass = 2, size = 5
    real(c_double) :: grains(3, 2), mean, half, moment, roundness, known, unknown
    integer(c_int) :: codes(4), stays, bounces

    grains = -1
    spinning = rbt_has_spin_law(table)
    codes(1) = rbt_covered(table, range)
    codes(2) = rbt_grains(table, seed, [index_, index_], grains=grains)
    codes(3) = rbt_grains(table, seed, [index_], grains=grains)
    codes(4) = rbt_rebound(table, grains, grains, [1.0_c_double], index=[index_], hit=[hit], seed=seed)
    mean = rbt_mean_half_size(table, 2.0_c_double)
    half = rbt_half_size(table, 2.0_c_double, grains(:, 1))
    moment = rbt_mean_inertia(table, grains(:, 1))
    roundness = rbt_sphericity(table, grains(:, 1))
    known = rbt_moment_of_inertia(table, seed, index_, 0.3_c_double, mass, size, 7.0_c_double)
    unknown = rbt_moment_of_inertia(table, seed, index_, 0.0_c_double, mass, size, 7.0_c_double)
    stays = rbt_deposits(v, up, 1.01_c_double, still)
    bounces = rbt_deposits(v, up, 0.99_c_double, still)
    holds = all(codes == [RBT_OK, merge(RBT_OK, RBT_ERR_NO_SPIN_LAW, spinning), RBT_ERR_MISSING, &
        RBT_ERR_MISSING]) .and. (range%spin(2) > 0 .eqv. spinning) .and. &
        all(abs(grains(:, 1) - grains(:, 2)) <= 0) .and. (all(grains >= 0) .eqv. spinning) .and. &
        stays == 1 .and. bounces == 0
    holds = holds .and. (mean > 1 .eqv. spinning) .and. (half > 0.8 .eqv. spinning) .and. &
        (moment > 0.1 .eqv. spinning) .and. (roundness > 0.3 .eqv. spinning)
    if (.not. spinning) moment = 0.1_c_double * (7 / size)**2  ! of the sphere of equal volume
    holds = holds .and. abs(known - 0.3_c_double * mass * size**2) < 1e-9 .and. &
        abs(unknown - moment * mass * size**2) < 1e-9
  end function others_hold

  ! What is left out is 0, and grains of one particle are those of several.
  function optional_arguments_hold() result(holds)
    logical :: holds
    real(c_double), parameter :: v(3) = [9, -1, 0], up(3) = [0, 2, 0], omega(3) = [3000, -10000, 500]
    real(c_double), parameter :: d = 5e-5_c_double, density = 1.2_c_double, viscosity = 1.8e-5_c_double
    real(c_double), parameter :: time = 1e-3_c_double, moment = 1e-15_c_double, still(3) = 0
    real(c_double) :: one(3), many(3, 1), speed, expected
    integer(c_int) :: answers(2)

    one = -1
    many = -1
    answers(1) = rbt_deposits(v, up, 1.01_c_double)
    answers(2) = rbt_deposits(v, up, 0.99_c_double)
    holds = answers(1) == 1 .and. answers(2) == 0
    answers(1) = rbt_grains(table, seed, index_, grain=one)
    answers(2) = rbt_grains(table, seed, [index_], grains=many)
    holds = holds .and. answers(1) == answers(2) .and. all(abs(one - many(:, 1)) <= 0)
    answers(1) = rbt_grains(table, seed, index_, hit, one)
    answers(2) = rbt_grains(table, seed, [index_], [hit], many)
    holds = holds .and. answers(1) == answers(2) .and. all(abs(one - many(:, 1)) <= 0)
    call rbt_spin_after(omega, time, moment, d, density, viscosity, still, one)
    call rbt_spin_after(omega, time, moment, d, density, viscosity, new_omega=many(:, 1))
    holds = holds .and. all(abs(one - many(:, 1)) <= 0) .and. all(abs(one) < abs(omega))
    call rbt_gas_torque(omega, d, density, viscosity, still, one)
    call rbt_gas_torque(omega, d, density, viscosity, torque=many(:, 1))
    holds = holds .and. all(abs(one - many(:, 1)) <= 0) .and. all(abs(one) > 0)
    ! silica on steel, computed by hand: tests/sampler/test_wall.py
    speed = rbt_critical_speed(1e-6_c_double, 2200.0_c_double, 7e10_c_double, 0.17_c_double, &
        2.1e11_c_double, 0.3_c_double)
    expected = (2 * 4.4038e-7_c_double / 1e-6_c_double)**(10 / 7.0_c_double)
    holds = holds .and. abs(speed / expected - 1) < 1e-4
  end function optional_arguments_hold

  ! A head-on impact in single precision is above pi/2.
  function ends_hold() result(holds)
    logical :: holds
    real(c_double) :: head_on(1)
    integer(c_int) :: answer

    head_on = real(asin(1.0), c_double)
    answer = rbt_sample(table, head_on, [100.0_c_double], index=[index_], hit=[hit], seed=seed)
    holds = answer >= 0 .and. head_on(1) > 2 * atan(1.0_c_double)
  end function ends_hold

  ! After an error code results are not a number.
  function agree(got, wanted, tolerance) result(answer)
    real(c_double), intent(in) :: got(:), wanted(:), tolerance
    logical :: answer

    if (code < 0) then
      answer = all(ieee_is_nan(got))
    else
      answer = all(abs(got - wanted) <= tolerance * max(1.0_c_double, maxval(abs(wanted))))
    end if
  end function agree

end program vectors
