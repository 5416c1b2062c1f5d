! Rebounds of non-spherical particles, drawn from a table, in Fortran 2008.
!
! A module over rebound_sampler.h; compile that as well, from a C file of two lines:
!
!     #define REBOUND_SAMPLER_IMPLEMENTATION
!     #include "rebound_sampler.h"
!
! and link both with the C mathematics library (-lm). What functions do, and what they return, is
! said in the header; names, order of arguments and codes are the same, and null() is NULL. Angles are
! in radians, everything else is in SI units. Unsigned integers of C are the integers of equal size
! here, with the same bits: index -1 is the largest there.
!
! Any number of threads may draw from one table at once; rbt_open and rbt_close of one table must not
! run beside other calls with it.
module rebound_sampler
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_int, &
      c_int32_t, c_int64_t, c_loc, c_null_char, c_null_ptr, c_ptr, c_size_t
  implicit none
  private

  public :: rbt_table, rbt_report
  public :: rbt_open, rbt_close, rbt_strerror, rbt_is_open
  public :: rbt_alpha_range, rbt_speed_range, rbt_valid_speed, rbt_components, rbt_pair
  public :: rbt_has_spin_law, rbt_keep_grains, rbt_grain
  public :: rbt_half_size, rbt_mean_half_size, rbt_deposits
  public :: rbt_draw, rbt_draw_all, rbt_draw_batch
  public :: rbt_rebound, rbt_rough_rebound, rbt_rebound_batch, rbt_wall_tilt
  public :: rbt_gas_torque, rbt_spin_after

  ! Codes, and most variables that a state can have; from sampler/formats/binary_layout.py, by
  ! `python -m sampler.formats.generated_code`.
  ! begin constants
  integer(c_int), parameter, public :: &
      RBT_OK = 0, RBT_ANGLE = 1, RBT_SPEED = 2, RBT_SPIN = 4, RBT_EXTRAPOLATED = 8, &
      RBT_ERR_MISSING = -1, RBT_ERR_NOT_FINITE = -2, RBT_ERR_NOT_APPROACHING = -3, &
      RBT_ERR_SPEED_NOT_POSITIVE = -4, RBT_ERR_NORMAL_NOT_USABLE = -5, RBT_ERR_HALF_SIZE = -6, &
      RBT_ERR_ROUGHNESS_NOT_USABLE = -7, RBT_ERR_TILT_NOT_FOUND = -8, &
      RBT_ERR_CASCADE_NOT_ENDED = -9, RBT_ERR_NO_SPIN_LAW = -10, RBT_ERR_GRAIN_NOT_KNOWN = -11, &
      RBT_ERR_NOT_OPENED = -20, RBT_ERR_NOT_READ = -21, RBT_ERR_NO_MEMORY = -22, &
      RBT_ERR_BIG_ENDIAN = -23, RBT_ERR_FORMAT = -24, RBT_ERR_VERSION = -25, RBT_ERR_SIZE = -26, &
      RBT_ERR_CHECKSUM = -27, RBT_ERR_DIMENSIONS = -28, RBT_ERR_NAMES = -29, &
      RBT_ERR_OFFSETS = -30, RBT_ERR_INDICES = -31
  integer, parameter, public :: RBT_VALUES = 10
  ! end constants

  ! A table in memory: opened by rbt_open, ended by rbt_close. Copies are the same table.
  type :: rbt_table
    private
    type(c_ptr) :: handle = c_null_ptr
  end type rbt_table

  ! What a batch reports. Rows count from 1; 0 stands for none.
  type :: rbt_report
    integer(c_size_t) :: row = 0          ! first row with an error
    integer(c_size_t) :: clamped_row = 0  ! first clamped row
    integer(c_size_t) :: clamped = 0      ! number of clamped rows
    integer(c_size_t) :: extrapolated = 0 ! number of rows with a speed outside of rbt_valid_speed
    integer(c_size_t) :: extrapolated_row = 0  ! first of them
  end type rbt_report

  type, bind(c) :: c_report
    integer(c_size_t) :: row, clamped_row, clamped, extrapolated, extrapolated_row
  end type c_report

  type, bind(c) :: c_impacts
    type(c_ptr) :: velocity, normal, half_size, wall_velocity, index, hit, omega, roughness
    type(c_ptr) :: grain = c_null_ptr  ! those of the keys
    integer(c_int) :: fresh_grains = 0, isotropic = 0
  end type c_impacts

  interface
    function c_open(path, table) result(code) bind(c, name="rbt_open")
      import :: c_char, c_int, c_ptr
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), intent(out) :: table
      integer(c_int) :: code
    end function c_open

    subroutine c_close(table) bind(c, name="rbt_close")
      import :: c_ptr
      type(c_ptr), value :: table
    end subroutine c_close

    function c_strerror(code) result(text) bind(c, name="rbt_strerror")
      import :: c_int, c_ptr
      integer(c_int), value :: code
      type(c_ptr) :: text
    end function c_strerror

    function c_pair(table) result(text) bind(c, name="rbt_pair")
      import :: c_ptr
      type(c_ptr), value :: table
      type(c_ptr) :: text
    end function c_pair

    function c_strlen(text) result(length) bind(c, name="strlen")
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
      integer(c_size_t) :: length
    end function c_strlen

    subroutine c_alpha_range(table, range) bind(c, name="rbt_alpha_range")
      import :: c_double, c_ptr
      type(c_ptr), value :: table
      real(c_double), intent(out) :: range(2)
    end subroutine c_alpha_range

    subroutine c_speed_range(table, range) bind(c, name="rbt_speed_range")
      import :: c_double, c_ptr
      type(c_ptr), value :: table
      real(c_double), intent(out) :: range(2)
    end subroutine c_speed_range

    subroutine c_valid_speed(table, range) bind(c, name="rbt_valid_speed")
      import :: c_double, c_ptr
      type(c_ptr), value :: table
      real(c_double), intent(out) :: range(2)
    end subroutine c_valid_speed

    function c_has_spin_law(table) result(answer) bind(c, name="rbt_has_spin_law")
      import :: c_int, c_ptr
      type(c_ptr), value :: table
      integer(c_int) :: answer
    end function c_has_spin_law

    subroutine c_keep_grains(table, kept) bind(c, name="rbt_keep_grains")
      import :: c_int, c_ptr
      type(c_ptr), value :: table
      integer(c_int), value :: kept
    end subroutine c_keep_grains

    function c_grain(table, seed, index, hit, grain) result(code) bind(c, name="rbt_grain")
      import :: c_double, c_int, c_int32_t, c_int64_t, c_ptr
      type(c_ptr), value :: table
      integer(c_int64_t), value :: seed, index
      integer(c_int32_t), value :: hit
      real(c_double), intent(inout) :: grain(3)
      integer(c_int) :: code
    end function c_grain

    function c_components(table, columns) result(n) bind(c, name="rbt_components")
      import :: c_int, c_ptr, RBT_VALUES
      type(c_ptr), value :: table
      integer(c_int), intent(out) :: columns(RBT_VALUES)
      integer(c_int) :: n
    end function c_components

    function c_draw_all(table, alpha1, speed, spin, grain, seed, index, hit, values) &
        result(code) bind(c, name="rbt_draw_all")
      import :: c_double, c_int, c_int32_t, c_int64_t, c_ptr, RBT_VALUES
      type(c_ptr), value :: table, spin, grain
      real(c_double), value :: alpha1, speed
      integer(c_int64_t), value :: seed, index
      integer(c_int32_t), value :: hit
      real(c_double), intent(inout) :: values(RBT_VALUES)
      integer(c_int) :: code
    end function c_draw_all

    function c_draw_batch(table, n, alpha1, speed, spin, seed, index, hit, states, report) &
        result(code) bind(c, name="rbt_draw_batch")
      import :: c_double, c_int, c_int32_t, c_int64_t, c_ptr, c_report, c_size_t
      type(c_ptr), value :: table, spin
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: alpha1(*), speed(*)
      integer(c_int64_t), value :: seed
      integer(c_int64_t), intent(in) :: index(*)
      integer(c_int32_t), intent(in) :: hit(*)
      real(c_double), intent(inout) :: states(6, *)
      type(c_report), intent(out) :: report
      integer(c_int) :: code
    end function c_draw_batch

    ! Standard deviation of the tilt of facets, rad, of a wall with a measured profile, as the header
    ! says; all lengths in the same unit. `tilt` is as it was after an error.
    function rbt_wall_tilt(ra, rq, rsm, diameter, tilt) result(code) bind(c)
      import :: c_double, c_int
      real(c_double), value :: ra, rq, rsm, diameter
      real(c_double), intent(inout) :: tilt
      integer(c_int) :: code
    end function rbt_wall_tilt

    function c_mean_half_size(table, diameter) result(half_size) bind(c, name="rbt_mean_half_size")
      import :: c_double, c_ptr
      type(c_ptr), value :: table
      real(c_double), value :: diameter
      real(c_double) :: half_size
    end function c_mean_half_size

    ! Largest half-size, m, of a grain whose volume is that of a sphere of the diameter; 0: not known.
    function rbt_half_size(diameter, grain) result(half_size) bind(c)
      import :: c_double
      real(c_double), value :: diameter
      real(c_double), intent(in) :: grain(3)
      real(c_double) :: half_size
    end function rbt_half_size

    ! Whether a particle stays on the wall, 1 or 0; ask before the draw.
    function rbt_deposits(velocity, normal, critical_speed, wall_velocity) result(stays) bind(c)
      import :: c_double, c_int
      real(c_double), intent(in) :: velocity(3), normal(3), wall_velocity(3)
      real(c_double), value :: critical_speed
      integer(c_int) :: stays
    end function rbt_deposits

    function c_rebound_grain(table, velocity, normal, half_size, wall_velocity, roughness, &
        isotropic, omega, grain, seed, index, hit, new_velocity, new_omega) result(code) &
        bind(c, name="rbt_rebound_grain")
      import :: c_double, c_int, c_int32_t, c_int64_t, c_ptr
      type(c_ptr), value :: table, omega, grain
      integer(c_int), value :: isotropic
      real(c_double), intent(in) :: velocity(3), normal(3), wall_velocity(3)
      real(c_double), value :: half_size, roughness
      integer(c_int64_t), value :: seed, index
      integer(c_int32_t), value :: hit
      real(c_double), intent(inout) :: new_velocity(3), new_omega(3)
      integer(c_int) :: code
    end function c_rebound_grain

    function c_rebound_batch(table, n, impacts, seed, new_velocity, new_omega, report) &
        result(code) bind(c, name="rbt_rebound_batch")
      import :: c_double, c_impacts, c_int, c_int64_t, c_ptr, c_report, c_size_t
      type(c_ptr), value :: table
      integer(c_size_t), value :: n
      type(c_impacts), intent(in) :: impacts
      integer(c_int64_t), value :: seed
      real(c_double), intent(inout) :: new_velocity(3, *), new_omega(3, *)
      type(c_report), intent(out) :: report
      integer(c_int) :: code
    end function c_rebound_batch

    ! Torque of the gas on a spinning particle, N m; gas_rotation: half the curl of the gas velocity.
    subroutine rbt_gas_torque(omega, diameter, density, viscosity, gas_rotation, torque) bind(c)
      import :: c_double
      real(c_double), intent(in) :: omega(3), gas_rotation(3)
      real(c_double), value :: diameter, density, viscosity
      real(c_double), intent(out) :: torque(3)
    end subroutine rbt_gas_torque

    ! Angular velocity that it leaves after a time; the result must be another variable than omega.
    subroutine rbt_spin_after(omega, time, inertia, diameter, density, viscosity, gas_rotation, &
        new_omega) bind(c)
      import :: c_double
      real(c_double), intent(in) :: omega(3), gas_rotation(3)
      real(c_double), value :: time, inertia, diameter, density, viscosity
      real(c_double), intent(out) :: new_omega(3)
    end subroutine rbt_spin_after
  end interface

contains

  ! Open a binary table (.rbt) and check everything in it.
  function rbt_open(path, table) result(code)
    character(len=*), intent(in) :: path  ! trailing blanks do not count
    type(rbt_table), intent(out) :: table
    integer(c_int) :: code
    character(kind=c_char) :: text(len_trim(path) + 1)
    integer :: k

    do k = 1, len_trim(path)
      text(k) = path(k:k)
    end do
    text(len_trim(path) + 1) = c_null_char
    code = c_open(text, table%handle)
  end function rbt_open

  ! Whether a table is open.
  function rbt_is_open(table) result(answer)
    type(rbt_table), intent(in) :: table
    logical :: answer

    answer = c_associated(table%handle)
  end function rbt_is_open

  ! End a table, which is closed afterwards; one that is closed may be given.
  subroutine rbt_close(table)
    type(rbt_table), intent(inout) :: table

    call c_close(table%handle)
    table%handle = c_null_ptr
  end subroutine rbt_close

  ! One line on a return code.
  function rbt_strerror(code) result(text)
    integer(c_int), intent(in) :: code
    character(len=:), allocatable :: text

    text = fortran_text(c_strerror(code))
  end function rbt_strerror

  ! Name of the material pair.
  function rbt_pair(table) result(text)
    type(rbt_table), intent(in) :: table
    character(len=:), allocatable :: text

    text = fortran_text(c_pair(table%handle))
  end function rbt_pair

  ! Smallest and largest impact angle, rad.
  function rbt_alpha_range(table) result(range)
    type(rbt_table), intent(in) :: table
    real(c_double) :: range(2)

    call c_alpha_range(table%handle, range)
  end function rbt_alpha_range

  ! Smallest and largest impact speed, m/s.
  function rbt_speed_range(table) result(range)
    type(rbt_table), intent(in) :: table
    real(c_double) :: range(2)

    call c_speed_range(table%handle, range)
  end function rbt_speed_range

  ! Speeds at which the law of the pair was measured, m/s; beyond them it is extrapolated.
  function rbt_valid_speed(table) result(range)
    type(rbt_table), intent(in) :: table
    real(c_double) :: range(2)

    call c_valid_speed(table%handle, range)
  end function rbt_valid_speed

  ! Whether the table has the law of particles that arrive with spin.
  function rbt_has_spin_law(table) result(answer)
    type(rbt_table), intent(in) :: table
    logical :: answer

    answer = c_has_spin_law(table%handle) /= 0
  end function rbt_has_spin_law

  ! Whether particles keep their grain from hit to hit, as they do unless told otherwise; not beside
  ! other calls with the table.
  subroutine rbt_keep_grains(table, kept)
    type(rbt_table), intent(in) :: table
    logical, intent(in) :: kept

    call c_keep_grains(table%handle, merge(1_c_int, 0_c_int, kept))
  end subroutine rbt_keep_grains

  ! Grain of a particle at a hit: code of its shape, b/a and c/b.
  function rbt_grain(table, seed, index, hit, grain) result(code)
    type(rbt_table), intent(in) :: table
    integer(c_int64_t), intent(in) :: seed, index
    integer(c_int32_t), intent(in) :: hit
    real(c_double), intent(inout) :: grain(3)     ! as it was after an error
    integer(c_int) :: code

    code = c_grain(table%handle, seed, index, hit, grain)
  end function rbt_grain

  ! Mean of rbt_half_size over the particles of the table; 0: not known.
  function rbt_mean_half_size(table, diameter) result(half_size)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in) :: diameter
    real(c_double) :: half_size

    half_size = c_mean_half_size(table%handle, diameter)
  end function rbt_mean_half_size

  ! Variables that the table gives, as places in a state from 1 (u) to 10 (work_shear).
  function rbt_components(table) result(places)
    type(rbt_table), intent(in) :: table
    integer, allocatable :: places(:)
    integer(c_int) :: columns(RBT_VALUES), n

    n = c_components(table%handle, columns)
    places = columns(:n) + 1
  end function rbt_components

  ! Draw one state: u, v, w over V and omega_x, omega_y, omega_z times a/V.
  function rbt_draw(table, alpha1, speed, spin, seed, index, hit, state) result(code)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in) :: alpha1, speed   ! rad from the wall; m/s
    real(c_double), intent(in), optional :: spin(3) ! before the impact, times a/V
    integer(c_int64_t), intent(in) :: seed, index
    integer(c_int32_t), intent(in) :: hit
    real(c_double), intent(inout) :: state(6)     ! as it was after an error
    integer(c_int) :: code
    real(c_double) :: values(RBT_VALUES)

    code = rbt_draw_all(table, alpha1, speed, seed, index, hit, values, spin)
    if (code >= RBT_OK) state = values(:6)
  end function rbt_draw

  ! The same with all variables that a table can have.
  function rbt_draw_all(table, alpha1, speed, seed, index, hit, values, spin) result(code)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in) :: alpha1, speed
    integer(c_int64_t), intent(in) :: seed, index
    integer(c_int32_t), intent(in) :: hit
    real(c_double), intent(inout) :: values(RBT_VALUES)
    real(c_double), intent(in), target, optional :: spin(3) ! before the impact, times a/V
    integer(c_int) :: code
    type(c_ptr) :: given

    given = c_null_ptr
    if (present(spin)) given = c_loc(spin)
    code = c_draw_all(table%handle, alpha1, speed, given, c_null_ptr, seed, index, hit, values)
  end function rbt_draw_all

  ! Draw a state for each column of states(6, n); faster than one by one.
  function rbt_draw_batch(table, alpha1, speed, spin, seed, index, hit, states, report) result(code)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in), contiguous :: alpha1(:), speed(:)
    real(c_double), intent(in), contiguous, target, optional :: spin(:, :) ! (3, n)
    integer(c_int64_t), intent(in) :: seed
    integer(c_int64_t), intent(in), contiguous :: index(:)
    integer(c_int32_t), intent(in), contiguous :: hit(:)
    real(c_double), intent(inout), contiguous :: states(:, :)
    type(rbt_report), intent(out), optional :: report
    integer(c_int) :: code
    integer(c_size_t) :: n
    type(c_report) :: found
    type(c_ptr) :: given

    n = size(alpha1, kind=c_size_t)
    if (size(states, 1) /= 6 .or. any([size(speed), size(index), size(hit), size(states, 2)] &
        /= size(alpha1))) error stop "rbt_draw_batch: arrays of unequal length"
    given = c_null_ptr
    if (present(spin)) then
      if (any(shape(spin) /= [3, size(alpha1)])) error stop "rbt_draw_batch: spin"
      if (n > 0) given = c_loc(spin)
    end if
    code = c_draw_batch(table%handle, n, alpha1, speed, given, seed, index, hit, states, found)
    if (present(report)) report = fortran_report(found, n)
  end function rbt_draw_batch

  ! Rebound one particle, in the lab frame; results must be other variables than arguments.
  function rbt_rebound(table, velocity, normal, half_size, wall_velocity, omega, seed, index, hit, &
      new_velocity, new_omega) result(code)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in) :: velocity(3), normal(3)  ! m/s; from the wall into the gas
    real(c_double), intent(in) :: half_size               ! largest half-size of the particle, m
    real(c_double), intent(in) :: wall_velocity(3)        ! m/s
    real(c_double), intent(in), optional :: omega(3)      ! before the impact, rad/s; none: no spin
    integer(c_int64_t), intent(in) :: seed, index
    integer(c_int32_t), intent(in) :: hit
    real(c_double), intent(inout) :: new_velocity(3), new_omega(3)  ! m/s, rad/s
    integer(c_int) :: code

    code = rbt_rough_rebound(table, velocity, normal, half_size, wall_velocity, 0.0_c_double, omega, &
        seed, index, hit, new_velocity, new_omega)
  end function rbt_rebound

  ! Rebound one particle from a rough wall, in the lab frame; otherwise as rbt_rebound.
  function rbt_rough_rebound(table, velocity, normal, half_size, wall_velocity, roughness, omega, &
      seed, index, hit, new_velocity, new_omega, isotropic) result(code)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in) :: velocity(3), normal(3)  ! m/s; of the mean wall into the gas
    real(c_double), intent(in) :: half_size               ! largest half-size of the particle, m
    real(c_double), intent(in) :: wall_velocity(3)        ! m/s
    real(c_double), intent(in) :: roughness  ! standard deviation of the tilt of facets, rad, 0 to 0.5
    real(c_double), intent(in), target, optional :: omega(3)  ! before the impact, rad/s; none: no spin
    integer(c_int64_t), intent(in) :: seed, index
    integer(c_int32_t), intent(in) :: hit
    real(c_double), intent(inout) :: new_velocity(3), new_omega(3)  ! m/s, rad/s
    logical, intent(in), optional :: isotropic  ! tilts across the plane of incidence too; none: no
    integer(c_int) :: code
    type(c_ptr) :: given

    given = c_null_ptr
    if (present(omega)) given = c_loc(omega)
    code = c_rebound_grain(table%handle, velocity, normal, half_size, wall_velocity, roughness, &
        as_int(isotropic), given, c_null_ptr, seed, index, hit, new_velocity, new_omega)
  end function rbt_rough_rebound

  ! Rebound the particle of each column; faster than one by one. Results must be other variables than
  ! arguments.
  function rbt_rebound_batch(table, velocity, normal, half_size, wall_velocity, roughness, omega, &
      seed, index, hit, new_velocity, new_omega, report, isotropic) result(code)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in), contiguous, target :: velocity(:, :), normal(:, :)  ! (3, n)
    real(c_double), intent(in), contiguous, target :: half_size(:)
    real(c_double), intent(in), contiguous, target, optional :: wall_velocity(:, :) ! none: at rest
    ! tilts of facets, rad, of rough walls; none: smooth ones
    real(c_double), intent(in), contiguous, target, optional :: roughness(:)
    real(c_double), intent(in), contiguous, target, optional :: omega(:, :) ! before; none: no spin
    integer(c_int64_t), intent(in) :: seed
    integer(c_int64_t), intent(in), contiguous, target :: index(:)
    integer(c_int32_t), intent(in), contiguous, target :: hit(:)
    real(c_double), intent(inout), contiguous :: new_velocity(:, :), new_omega(:, :) ! (3, n)
    type(rbt_report), intent(out), optional :: report
    logical, intent(in), optional :: isotropic
    integer(c_int) :: code
    integer(c_size_t) :: n
    integer :: wanted(2)
    type(c_impacts) :: impacts
    type(c_report) :: found

    n = size(half_size, kind=c_size_t)
    code = RBT_OK
    wanted = [3, size(half_size)]
    if (any([shape(velocity), shape(normal), shape(new_velocity), shape(new_omega)] &
        /= [wanted, wanted, wanted, wanted]) .or. size(index) /= n .or. size(hit) /= n) &
        error stop "rbt_rebound_batch: arrays of unequal length"
    impacts%wall_velocity = c_null_ptr
    if (present(wall_velocity)) then
      if (any(shape(wall_velocity) /= wanted)) error stop "rbt_rebound_batch: wall_velocity"
      if (n > 0) impacts%wall_velocity = c_loc(wall_velocity)
    end if
    impacts%omega = c_null_ptr
    if (present(omega)) then
      if (any(shape(omega) /= wanted)) error stop "rbt_rebound_batch: omega"
      if (n > 0) impacts%omega = c_loc(omega)
    end if
    impacts%roughness = c_null_ptr
    if (present(roughness)) then
      if (size(roughness) /= n) error stop "rbt_rebound_batch: roughness"
      if (n > 0) impacts%roughness = c_loc(roughness)
    end if
    impacts%isotropic = as_int(isotropic)
    if (n == 0) return
    impacts%velocity = c_loc(velocity)
    impacts%normal = c_loc(normal)
    impacts%half_size = c_loc(half_size)
    impacts%index = c_loc(index)
    impacts%hit = c_loc(hit)
    code = c_rebound_batch(table%handle, n, impacts, seed, new_velocity, new_omega, found)
    if (present(report)) report = fortran_report(found, n)
  end function rbt_rebound_batch

  ! 1 for true, else 0.
  function as_int(flag) result(number)
    logical, intent(in), optional :: flag
    integer(c_int) :: number

    number = 0
    if (present(flag)) number = merge(1, 0, flag)
  end function as_int

  ! A report with rows that count from 1.
  function fortran_report(found, n) result(report)
    type(c_report), intent(in) :: found
    integer(c_size_t), intent(in) :: n
    type(rbt_report) :: report

    report%clamped = found%clamped
    report%extrapolated = found%extrapolated
    if (found%row < n) report%row = found%row + 1
    if (found%clamped_row < n) report%clamped_row = found%clamped_row + 1
    if (found%extrapolated_row < n) report%extrapolated_row = found%extrapolated_row + 1
  end function fortran_report

  ! Copy of a text of C, which ends with a null character.
  function fortran_text(pointer_to_c) result(text)
    type(c_ptr), intent(in) :: pointer_to_c
    character(len=:), allocatable :: text
    character(kind=c_char), pointer :: characters(:)
    integer :: k

    call c_f_pointer(pointer_to_c, characters, [c_strlen(pointer_to_c)])
    allocate (character(len=size(characters)) :: text)
    do k = 1, size(characters)
      text(k:k) = characters(k)
    end do
  end function fortran_text

end module rebound_sampler
