! Known-answer vectors through the Fortran module: vectors TABLE.rbt VECTORS.txt
program vectors
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: iostat_end
  use rebound_sampler
  implicit none

  real(c_double), parameter :: untouched = 12345.0_c_double
  type(rbt_table) :: table
  character(len=512) :: image, file
  character(len=1024) :: line
  integer :: unit, status, cases, at
  logical :: holds

  ! the case of a line; spin and omega are null where there are none
  logical :: draws, rough
  real(c_double), target :: given(14), turning(3, 1)
  real(c_double), pointer, contiguous :: omega(:), omegas(:, :)
  real(c_double) :: expected(RBT_VALUES)
  integer(c_int64_t) :: seed, index_
  integer(c_int32_t) :: hit
  integer(c_int) :: code

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
    call read_case()
    if (draws) then
      holds = draw_holds()
    else
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

  subroutine read_case()
    character(len=16) :: kind
    integer :: n, k

    at = index(line, " ") + 1
    kind = line(:at - 1)
    draws = index(kind, "draw") > 0
    rough = index(kind, "rough") > 0
    n = merge(2, merge(11, 10, rough), draws)
    omega => null()
    omegas => null()
    call read_reals(given(:n))
    if (index(kind, "spin") > 0) then
      call read_reals(turning(:, 1))
      omega => turning(:, 1)
      omegas => turning
    end if
    seed = read_integer()
    index_ = read_integer()
    hit = transfer(read_integer(), hit)  ! its lower half
    code = int(read_integer(), c_int)
    expected = 0  ! what a table without the work of the impulses gives for it
    do k = 1, RBT_VALUES
      if (at <= len_trim(line)) call read_reals(expected(k:k))
    end do
    if (code < 0) expected = untouched
  end subroutine read_case

  function draw_holds() result(holds)
    logical :: holds
    real(c_double) :: values(RBT_VALUES), state(6), states(6, 1)
    integer(c_int) :: codes(2), flags
    type(rbt_report) :: report

    values = untouched
    state = untouched
    states = untouched
    codes(1) = rbt_draw(table, given(1), given(2), omega, seed, index_, hit, state)
    codes(2) = rbt_draw_batch(table, given(1:1), given(2:2), omegas, seed, [index_], [hit], &
        states, report)
    flags = max(code, 0)
    holds = all(codes == code) .and. agree(state, expected(:6), 0.0_c_double) &
        .and. agree(states(:, 1), expected(:6), 0.0_c_double) &
        .and. report%row == merge(1, 0, code < 0) .and. report%clamped == iand(flags, RBT_CLAMPED) &
        .and. report%clamped_row == report%clamped &
        .and. report%extrapolated == iand(flags, RBT_EXTRAPOLATED) / RBT_EXTRAPOLATED &
        .and. report%extrapolated_row == report%extrapolated
    codes(1) = rbt_draw_all(table, given(1), given(2), seed, index_, hit, values, spin=omega)
    holds = holds .and. codes(1) == code .and. agree(values, expected, 0.0_c_double)
  end function draw_holds

  function rebound_holds() result(holds)
    logical :: holds
    real(c_double) :: velocity(3), spin(3), row(3, 2), other(3, 4), tolerance
    real(c_double), pointer, contiguous :: roughness(:)
    integer(c_int) :: codes(2)
    type(rbt_report) :: report

    velocity = untouched
    spin = untouched
    row = untouched
    roughness => null()
    if (rough) then
      roughness => given(11:11)
      codes(1) = rbt_rough_rebound(table, given(:3), given(4:6), given(7), given(8:10), given(11), &
          omega, seed, index_, hit, velocity, spin)
    else
      codes(1) = rbt_rebound(table, given(:3), given(4:6), given(7), given(8:10), omega, seed, &
          index_, hit, velocity, spin)
    end if
    codes(2) = rbt_rebound_batch(table, reshape(given(:3), [3, 1]), reshape(given(4:6), [3, 1]), &
        given(7:7), reshape(given(8:10), [3, 1]), roughness, omegas, seed, [index_], [hit], &
        row(:, :1), row(:, 2:), report)
    ! of atan2, cos and sin of the C library, whose last digit may turn that of a feature of a spin draw
    tolerance = merge(1.0e-5_c_double, merge(1.0e-12_c_double, 1.0e-13_c_double, rough), &
        associated(omega))
    holds = all(codes == code) .and. agree(row(:, 1), velocity, 0.0_c_double) &
        .and. agree(row(:, 2), spin, 0.0_c_double) &
        .and. agree(velocity, expected(:3), tolerance) .and. agree(spin, expected(4:6), tolerance) &
        .and. report%row == merge(1, 0, code < 0) .and. report%clamped == merge(1, 0, code > 0)
    if (.not. (holds .and. rough .and. code >= 0)) return
    codes(1) = rbt_rough_rebound(table, given(:3), given(4:6), given(7), given(8:10), given(11), &
        omega, seed, index_, hit, other(:, 1), other(:, 2), isotropic=.true.)
    codes(2) = rbt_rebound_batch(table, reshape(given(:3), [3, 1]), reshape(given(4:6), [3, 1]), &
        given(7:7), reshape(given(8:10), [3, 1]), roughness, omegas, seed, [index_], [hit], &
        other(:, 3:3), other(:, 4:), isotropic=.true.)
    holds = codes(1) == codes(2) .and. all(abs(other(:, 1:2) - other(:, 3:4)) <= 0) &
        .and. (any(abs(other(:, 1) - velocity) > 0) .neqv. given(11) <= 0)
  end function rebound_holds

  function agree(got, wanted, tolerance) result(answer)
    real(c_double), intent(in) :: got(:), wanted(:), tolerance
    logical :: answer

    answer = all(abs(got - wanted) <= tolerance * max(1.0_c_double, maxval(abs(wanted))))
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
