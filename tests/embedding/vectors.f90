! Known-answer vectors through the Fortran module: vectors TABLE.rbt VECTORS.txt
program vectors
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: iostat_end
  use rebound_sampler
  implicit none

  real(c_double), parameter :: untouched = 12345.0_c_double
  ! of atan2, cos and sin of the C library, which rebounds call
  real(c_double), parameter :: library_rounding = 1.0e-13_c_double
  real(c_double), parameter :: rough_rounding = 1.0e-12_c_double
  ! a last digit of an angle may turn the last digit of a feature, in single precision
  real(c_double), parameter :: spin_rounding = 1.0e-5_c_double
  type(rbt_table) :: table
  character(len=512) :: image, file
  character(len=1024) :: line
  integer :: unit, status, cases, at
  integer(c_int) :: code
  logical :: holds

  interface
    function strtod(text, end) result(number) bind(c)
      import :: c_double, c_ptr
      type(c_ptr), value :: text
      type(c_ptr), intent(out) :: end
      real(c_double) :: number
    end function strtod
    function strtoull(text, end, base) result(number) bind(c)
      import :: c_int, c_int64_t, c_ptr
      type(c_ptr), value :: text
      type(c_ptr), intent(out) :: end
      integer(c_int), value :: base
      integer(c_int64_t) :: number
    end function strtoull
  end interface

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
    read (unit, "(a)", iostat=status) line
    if (status == iostat_end) exit
    cases = cases + 1
    if (line(:5) == "draw ") then
      at = 6
      holds = draw_holds()
    else if (line(:10) == "spin-draw ") then
      at = 11
      holds = spin_draw_holds()
    else if (line(:13) == "spin-rebound ") then
      at = 14
      holds = spin_rebound_holds()
    else if (line(:14) == "rough-rebound ") then
      at = 15
      holds = rough_rebound_holds(.false.)
    else if (line(:11) == "spin-rough ") then
      at = 12
      holds = rough_rebound_holds(.true.)
    else
      at = 9
      holds = rebound_holds()
    end if
    if (.not. holds) then
      print "(a, i0, 2a)", "case ", cases, " fails: ", trim(line)
      stop 1
    end if
  end do
  close (unit)
  call rbt_close(table)
  if (rbt_is_open(table)) stop 1
  print "(i0, a)", cases, " cases"

contains

  function draw_holds() result(holds)
    logical :: holds
    real(c_double) :: given(2), expected(RBT_VALUES), values(RBT_VALUES), state(6), states(6, 1)
    integer(c_int64_t) :: seed, index
    integer(c_int32_t) :: hit
    integer(c_int) :: code, codes(3)
    type(rbt_report) :: report

    call read_reals(given)
    call read_keys(seed, index, hit, code)
    call read_reals(expected(:8))
    expected(9:) = 0  ! what a table without the work of the impulses gives for it
    if (at <= len_trim(line)) call read_reals(expected(9:))
    values = untouched
    state = untouched
    states = untouched
    codes(1) = rbt_draw_all(table, given(1), given(2), seed, index, hit, values)
    codes(2) = rbt_draw(table, given(1), given(2), seed, index, hit, state)
    codes(3) = rbt_draw_batch(table, given(1:1), given(2:2), seed, [index], [hit], states, report)
    if (code < 0) expected = untouched
    holds = all(codes == code) .and. agree(values, expected, 0.0_c_double) &
        .and. agree(state, expected(:6), 0.0_c_double) &
        .and. agree(states(:, 1), expected(:6), 0.0_c_double) &
        .and. report%row == merge(1, 0, code < 0) .and. report%clamped == merge(1, 0, code > 0) &
        .and. report%clamped_row == report%clamped
  end function draw_holds

  function rebound_holds() result(holds)
    logical :: holds
    real(c_double) :: given(10), expected(6), velocity(3), omega(3), row(3, 2)
    type(rbt_report) :: report
    integer(c_int64_t) :: seed, index
    integer(c_int32_t) :: hit
    integer(c_int) :: code, got

    call read_reals(given)
    call read_keys(seed, index, hit, code)
    call read_reals(expected)
    velocity = untouched
    omega = untouched
    got = rbt_rebound(table, given(:3), given(4:6), given(7), given(8:), seed, index, hit, &
        velocity, omega)
    row = untouched
    holds = got == rbt_rebound_batch(table, reshape(given(:3), [3, 1]), &
        reshape(given(4:6), [3, 1]), given(7:7), seed, [index], [hit], row(:, :1), row(:, 2:), &
        wall_velocity=reshape(given(8:), [3, 1]), report=report)
    holds = holds .and. agree(row(:, 1), velocity, 0.0_c_double) &
        .and. agree(row(:, 2), omega, 0.0_c_double) &
        .and. report%row == merge(1, 0, code < 0) .and. report%clamped == merge(1, 0, code > 0)
    if (code < 0) expected = untouched
    holds = holds .and. got == code .and. agree(velocity, expected(:3), library_rounding) &
        .and. agree(omega, expected(4:), library_rounding)
  end function rebound_holds

  function spin_draw_holds() result(holds)
    logical :: holds
    real(c_double) :: given(5), expected(6), state(6), states(6, 1), valid(2)
    logical :: outside
    integer(c_int64_t) :: seed, index
    integer(c_int32_t) :: hit
    integer(c_int) :: code, codes(2)
    type(rbt_report) :: report

    call read_reals(given)
    call read_keys(seed, index, hit, code)
    call read_reals(expected)
    state = untouched
    states = untouched
    codes(1) = rbt_draw(table, given(1), given(2), seed, index, hit, state, spin=given(3:))
    codes(2) = rbt_draw_batch(table, given(1:1), given(2:2), seed, [index], [hit], states, report, &
        spin=reshape(given(3:), [3, 1]))
    if (code < 0) expected = untouched
    valid = rbt_valid_speed(table)
    outside = code >= 0 .and. (given(2) < valid(1) .or. given(2) > valid(2))
    holds = all(codes == code) .and. agree(state, expected, 0.0_c_double) &
        .and. agree(states(:, 1), expected, 0.0_c_double) &
        .and. report%row == merge(1, 0, code < 0) .and. report%clamped == merge(1, 0, code > 0) &
        .and. report%extrapolated == merge(1, 0, outside)
  end function spin_draw_holds

  function spin_rebound_holds() result(holds)
    logical :: holds
    real(c_double) :: given(13), expected(6), velocity(3), omega(3), row(3, 2)
    integer(c_int64_t) :: seed, index
    integer(c_int32_t) :: hit
    integer(c_int) :: code, got, batch

    call read_reals(given)
    call read_keys(seed, index, hit, code)
    call read_reals(expected)
    velocity = untouched
    omega = untouched
    got = rbt_rebound(table, given(:3), given(4:6), given(7), given(8:10), seed, index, hit, &
        velocity, omega, omega=given(11:))
    row = untouched
    batch = rbt_rebound_batch(table, reshape(given(:3), [3, 1]), &
        reshape(given(4:6), [3, 1]), given(7:7), seed, [index], [hit], row(:, :1), row(:, 2:), &
        wall_velocity=reshape(given(8:10), [3, 1]), omega=reshape(given(11:), [3, 1]))
    holds = got == code .and. batch == code .and. agree(row(:, 1), velocity, 0.0_c_double) &
        .and. agree(row(:, 2), omega, 0.0_c_double)
    if (code < 0) expected = untouched
    holds = holds .and. agree(velocity, expected(:3), spin_rounding) &
        .and. agree(omega, expected(4:), spin_rounding)
  end function spin_rebound_holds

  function rough_rebound_holds(spins) result(holds)
    logical, intent(in) :: spins
    logical :: holds
    real(c_double) :: given(11), expected(6), velocity(3), omega(3), row(3, 2), tolerance
    real(c_double), target :: turning(3, 1)            ! angular velocity before the impact
    real(c_double), pointer, contiguous :: before(:, :) ! the same, or none
    integer(c_int64_t) :: seed, index
    integer(c_int32_t) :: hit
    integer(c_int) :: code, codes(2)

    call read_reals(given)
    before => null()
    tolerance = rough_rounding
    if (spins) then
      call read_reals(turning(:, 1))
      before => turning
      tolerance = spin_rounding
    end if
    call read_keys(seed, index, hit, code)
    call read_reals(expected)
    velocity = untouched
    omega = untouched
    row = untouched
    if (spins) then
      codes(1) = rbt_rough_rebound(table, given(:3), given(4:6), given(7), given(8:10), given(11), &
          seed, index, hit, velocity, omega, omega=turning(:, 1))
    else
      codes(1) = rbt_rough_rebound(table, given(:3), given(4:6), given(7), given(8:10), given(11), &
          seed, index, hit, velocity, omega)
    end if
    codes(2) = rbt_rebound_batch(table, reshape(given(:3), [3, 1]), &
        reshape(given(4:6), [3, 1]), given(7:7), seed, [index], [hit], row(:, :1), row(:, 2:), &
        wall_velocity=reshape(given(8:10), [3, 1]), omega=before, roughness=given(11:11))
    holds = all(codes == code) .and. agree(row(:, 1), velocity, 0.0_c_double) &
        .and. agree(row(:, 2), omega, 0.0_c_double)
    if (code < 0) expected = untouched
    holds = holds .and. agree(velocity, expected(:3), tolerance) &
        .and. agree(omega, expected(4:), tolerance)
  end function rough_rebound_holds

  function agree(got, expected, tolerance) result(answer)
    real(c_double), intent(in) :: got(:), expected(:), tolerance
    logical :: answer

    answer = all(abs(got - expected) <= tolerance * max(1.0_c_double, maxval(abs(expected))))
  end function agree

  ! The C library reads hexadecimal floating point, and integers of 64 bits without a sign.
  subroutine read_reals(numbers)
    real(c_double), intent(out) :: numbers(:)
    character(kind=c_char), target :: word(64)
    type(c_ptr) :: end
    integer :: k

    do k = 1, size(numbers)
      call read_word(word)
      numbers(k) = strtod(c_loc(word), end)
    end do
  end subroutine read_reals

  function read_integer() result(number)
    integer(c_int64_t) :: number
    character(kind=c_char), target :: word(64)
    type(c_ptr) :: end

    call read_word(word)
    number = strtoull(c_loc(word), end, 10_c_int)
  end function read_integer

  subroutine read_keys(seed, index, hit, code)
    integer(c_int64_t), intent(out) :: seed, index
    integer(c_int32_t), intent(out) :: hit
    integer(c_int), intent(out) :: code

    seed = read_integer()
    index = read_integer()
    hit = transfer(read_integer(), hit)  ! its lower half
    code = int(read_integer(), c_int)
  end subroutine read_keys

  subroutine read_word(word)
    character(kind=c_char), intent(out) :: word(:)
    integer :: length, k

    length = index(line(at:), " ") - 1
    word = c_null_char
    do k = 1, length
      word(k) = line(at + k - 1:at + k - 1)
    end do
    at = at + length + 1
  end subroutine read_word

end program vectors
