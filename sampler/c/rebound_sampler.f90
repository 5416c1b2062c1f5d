! Rebounds of non-spherical particles, drawn from a table, in Fortran 2008.
!
! A module over rebound_sampler.h. Compile rebound_sampler.c as well, and link both with the C mathematics
! library (-lm). The header describes what the functions do and return; names, their order and codes are the
! same here. Fields of C's records are arguments here. Leave out an argument that is NULL or 0 in C:
!
!     code = rbt_rebound(table, v, normal, a, omega=spin, inertia=k, index=particle, hit=hit, &
!         seed=seed, new_velocity=new_v, new_omega=new_spin, new_inertia=new_k)
!
! Results must be other variables than arguments. For n particles, arrays have the shapes (n), (3, n) for
! vectors, and (2, n) for works. If shapes do not agree, the code is RBT_ERR_MISSING and nothing is written.
!
! Angles are in radians, everything else is in SI units. Rows, and the variables of a state, count from 1.
! Unsigned integers of C are integers of the same size with the same bits: index -1 is the largest index.
module rebound_sampler
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_funloc, &
      c_funptr, c_int, c_int32_t, c_int64_t, c_loc, c_null_char, c_null_ptr, c_ptr, c_size_t
  implicit none
  private

  public :: rbt_table, rbt_range
  public :: rbt_open, rbt_close, rbt_strerror, rbt_is_open
  public :: rbt_covered, rbt_has_spin_law, rbt_variables, rbt_pair
  public :: rbt_sample, rbt_rebound, rbt_grains
  public :: rbt_use_direct, rebound_direct
  public :: rbt_wall_tilt, rbt_gas_torque, rbt_spin_after
  public :: rbt_half_size, rbt_mean_inertia, rbt_sphericity, rbt_mean_half_size, rbt_moment_of_inertia
  public :: rbt_critical_speed, rbt_deposits

  ! Codes, and places of the variables in a state; by `python tools/generated_code.py`.
  ! begin constants
  integer(c_int), parameter, public :: &
      RBT_OK = 0, RBT_ANGLE = 1, RBT_SPEED = 2, RBT_SPIN = 4, RBT_EXTRAPOLATED = 8, &
      RBT_ERR_MISSING = -1, RBT_ERR_NOT_FINITE = -2, RBT_ERR_NOT_APPROACHING = -3, &
      RBT_ERR_SPEED_NOT_POSITIVE = -4, RBT_ERR_NORMAL_NOT_USABLE = -5, RBT_ERR_HALF_SIZE = -6, &
      RBT_ERR_ROUGHNESS_NOT_USABLE = -7, RBT_ERR_CASCADE_NOT_ENDED = -8, &
      RBT_ERR_REBOUND_NOT_ENDED = -9, RBT_ERR_NO_SPIN_LAW = -10, RBT_ERR_GRAIN_NOT_KNOWN = -11, &
      RBT_ERR_NO_WORKS = -12, RBT_ERR_DIRECT_VERSION = -13, RBT_ERR_DIRECT_PAIR = -14, &
      RBT_ERR_NOT_OPENED = -15, RBT_ERR_NOT_READ = -16, RBT_ERR_NO_MEMORY = -17, &
      RBT_ERR_BIG_ENDIAN = -18, RBT_ERR_FORMAT = -19, RBT_ERR_VERSION = -20, RBT_ERR_SIZE = -21, &
      RBT_ERR_CHECKSUM = -22, RBT_ERR_DIMENSIONS = -23, RBT_ERR_NAMES = -24, &
      RBT_ERR_OFFSETS = -25, RBT_ERR_INDICES = -26, RBT_OUTSIDE = 7, RBT_ELLIPSOID = 0, &
      RBT_PRISM = 1, RBT_TRUNCATED_PRISM = 2, RBT_TETRAHEDRON = 3, RBT_SPHERE = 4, &
      RBT_FIRST_MESH = 64
  integer, parameter, public :: &
      RBT_U = 1, RBT_V = 2, RBT_W = 3, RBT_OMEGA_X = 4, RBT_OMEGA_Y = 5, RBT_OMEGA_Z = 6, &
      RBT_ROTATIONAL_ENERGY = 7, RBT_COLLISIONS = 8, RBT_WORK_NORMAL = 9, RBT_WORK_SHEAR = 10, &
      RBT_VALUES = 10
  ! end constants

  ! A table in memory. rbt_open opens it and rbt_close ends it. A copy of this is the same table.
  type :: rbt_table
    private
    type(c_ptr) :: handle = c_null_ptr
  end type rbt_table

  ! What a table covers, smallest and largest: impact angles, rad, speeds, m/s, spins, V/a, and the speeds
  ! at which the material pair was measured, m/s.
  type, bind(c) :: rbt_range
    real(c_double), dimension(2) :: alpha1, speed, spin, measured
  end type rbt_range

  ! The records of C.
  ! begin records
  type, bind(c) :: c_conditions
    type(c_ptr) :: alpha1 = c_null_ptr, speed = c_null_ptr, spin = c_null_ptr, &
        inertia = c_null_ptr, grain = c_null_ptr, index = c_null_ptr, hit = c_null_ptr, &
        inertia_after = c_null_ptr
    integer(c_int) :: fresh = 0
  end type c_conditions

  type, bind(c) :: c_impacts
    type(c_ptr) :: velocity = c_null_ptr, normal = c_null_ptr, half_size = c_null_ptr, &
        wall_velocity = c_null_ptr, omega = c_null_ptr, inertia = c_null_ptr, &
        roughness = c_null_ptr, grain = c_null_ptr, index = c_null_ptr, hit = c_null_ptr
    integer(c_int) :: fresh = 0, isotropic = 0
  end type c_impacts

  type, bind(c) :: c_rebounds
    type(c_ptr) :: velocity = c_null_ptr, omega = c_null_ptr, inertia = c_null_ptr, &
        works = c_null_ptr, codes = c_null_ptr
    integer(c_size_t) :: bad = 0, first_bad = 0, flagged(8) = 0
  end type c_rebounds
  ! end records

  ! Rebound one particle, with numbers and vectors, or n particles, with arrays, in the lab frame.
  interface rbt_rebound
    module procedure rebound_one, rebound_many
  end interface rbt_rebound

  ! The grain of a particle, or the grains of n particles: code of the shape, b/a and c/b. It is the grain
  ! that the particle keeps, or, with `hit`, the grain that `fresh` gives it at that hit.
  interface rbt_grains
    module procedure grains_one, grains_many
  end interface rbt_grains

  interface
    ! Direct simulation, in the object that `tablegen export-direct` writes, for rbt_use_direct. It is data
    ! of C, so never call it. It is declared as a procedure because then only programs that name it need
    ! the object.
    subroutine rebound_direct() bind(c)
    end subroutine rebound_direct

    function c_use_direct(table, law) result(code) bind(c, name="rbt_use_direct")
      import :: c_funptr, c_int, c_ptr
      type(c_ptr), value :: table
      type(c_funptr), value :: law
      integer(c_int) :: code
    end function c_use_direct

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

    pure function c_strlen(text) result(length) bind(c, name="strlen")
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
      integer(c_size_t) :: length
    end function c_strlen

    function c_covered(table, range) result(code) bind(c, name="rbt_covered")
      import :: c_int, c_ptr, rbt_range
      type(c_ptr), value :: table
      type(rbt_range), intent(inout) :: range
      integer(c_int) :: code
    end function c_covered

    function c_has_spin_law(table) result(answer) bind(c, name="rbt_has_spin_law")
      import :: c_int, c_ptr
      type(c_ptr), value :: table
      integer(c_int) :: answer
    end function c_has_spin_law

    function c_variables(table, columns) result(n) bind(c, name="rbt_variables")
      import :: c_int, c_ptr
      type(c_ptr), value :: table, columns
      integer(c_int) :: n
    end function c_variables

    function c_sample(table, n, conditions, seed, states, codes) result(code) &
        bind(c, name="rbt_sample")
      import :: c_conditions, c_int, c_int64_t, c_ptr, c_size_t
      type(c_ptr), value :: table, states, codes
      integer(c_size_t), value :: n
      type(c_conditions), intent(in) :: conditions
      integer(c_int64_t), value :: seed
      integer(c_int) :: code
    end function c_sample

    function c_rebound(table, n, impacts, seed, rebounds) result(code) bind(c, name="rbt_rebound")
      import :: c_impacts, c_int, c_int64_t, c_ptr, c_rebounds, c_size_t
      type(c_ptr), value :: table
      integer(c_size_t), value :: n
      type(c_impacts), intent(in) :: impacts
      integer(c_int64_t), value :: seed
      type(c_rebounds), intent(inout) :: rebounds
      integer(c_int) :: code
    end function c_rebound

    function c_grains(table, n, seed, index, hit, grains) result(code) bind(c, name="rbt_grains")
      import :: c_double, c_int, c_int64_t, c_ptr, c_size_t
      type(c_ptr), value :: table, hit
      integer(c_size_t), value :: n
      integer(c_int64_t), value :: seed
      integer(c_int64_t), intent(in) :: index(*)
      real(c_double), intent(inout) :: grains(3, *)
      integer(c_int) :: code
    end function c_grains

    ! Standard deviation of the tilt of facets, rad, of a wall with a measured profile, by the formula in
    ! the header. All lengths are in the same unit. After an error `tilt` is as it was.
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

    function c_half_size(table, diameter, grain) result(half_size) bind(c, name="rbt_half_size")
      import :: c_double, c_ptr
      type(c_ptr), value :: table
      real(c_double), value :: diameter
      real(c_double), intent(in) :: grain(3)
      real(c_double) :: half_size
    end function c_half_size

    function c_mean_inertia(table, grain) result(inertia) bind(c, name="rbt_mean_inertia")
      import :: c_double, c_ptr
      type(c_ptr), value :: table
      real(c_double), intent(in) :: grain(3)
      real(c_double) :: inertia
    end function c_mean_inertia

    function c_moment_of_inertia(table, seed, index, inertia, mass, half_size, diameter) result(moment) &
        bind(c, name="rbt_moment_of_inertia")
      import :: c_double, c_int64_t, c_ptr
      type(c_ptr), value :: table
      integer(c_int64_t), value :: seed, index
      real(c_double), value :: inertia, mass, half_size, diameter
      real(c_double) :: moment
    end function c_moment_of_inertia

    function c_sphericity(table, grain) result(sphericity) bind(c, name="rbt_sphericity")
      import :: c_double, c_ptr
      type(c_ptr), value :: table
      real(c_double), intent(in) :: grain(3)
      real(c_double) :: sphericity
    end function c_sphericity

    ! Normal speed, m/s, below which a smooth dry elastic sphere stays on a wall (Brach & Dunn 1992);
    ! NaN if an argument cannot be used. Moduli of elasticity are in Pa.
    function rbt_critical_speed(diameter, density, young, poisson, wall_young, wall_poisson) &
        result(speed) bind(c)
      import :: c_double
      real(c_double), value :: diameter, density, young, poisson, wall_young, wall_poisson
      real(c_double) :: speed
    end function rbt_critical_speed

    function c_deposits(velocity, normal, critical_speed, wall_velocity) result(stays) &
        bind(c, name="rbt_deposits")
      import :: c_double, c_int, c_ptr
      real(c_double), intent(in) :: velocity(3), normal(3)
      real(c_double), value :: critical_speed
      type(c_ptr), value :: wall_velocity
      integer(c_int) :: stays
    end function c_deposits

    subroutine c_gas_torque(omega, diameter, density, viscosity, gas_rotation, torque) &
        bind(c, name="rbt_gas_torque")
      import :: c_double, c_ptr
      real(c_double), intent(in) :: omega(3)
      real(c_double), value :: diameter, density, viscosity
      type(c_ptr), value :: gas_rotation
      real(c_double), intent(out) :: torque(3)
    end subroutine c_gas_torque

    subroutine c_spin_after(omega, time, moment, diameter, density, viscosity, gas_rotation, &
        new_omega) bind(c, name="rbt_spin_after")
      import :: c_double, c_ptr
      real(c_double), intent(in) :: omega(3)
      real(c_double), value :: time, moment, diameter, density, viscosity
      type(c_ptr), value :: gas_rotation
      real(c_double), intent(out) :: new_omega(3)
    end subroutine c_spin_after
  end interface

contains

  ! Open a binary table (.rbt) and check everything in it.
  function rbt_open(path, table) result(code)
    character(len=*), intent(in) :: path  ! trailing blanks do not count
    type(rbt_table), intent(out) :: table
    integer(c_int) :: code

    code = c_open(trim(path) // c_null_char, table%handle)
  end function rbt_open

  ! Whether a table is open.
  function rbt_is_open(table) result(answer)
    type(rbt_table), intent(in) :: table
    logical :: answer

    answer = c_associated(table%handle)
  end function rbt_is_open

  ! Close a table. It may be closed already.
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

  ! Let rebounds and states of the table be those of direct simulation from now on:
  !
  !     code = rbt_use_direct(table, rebound_direct)
  !
  ! After an error the table draws as before.
  function rbt_use_direct(table, law) result(code)
    type(rbt_table), intent(in) :: table
    procedure(rebound_direct) :: law
    integer(c_int) :: code

    code = c_use_direct(table%handle, c_funloc(law))
  end function rbt_use_direct

  ! What the table covers.
  function rbt_covered(table, range) result(code)
    type(rbt_table), intent(in) :: table
    type(rbt_range), intent(inout) :: range       ! as it was after an error
    integer(c_int) :: code

    code = c_covered(table%handle, range)
  end function rbt_covered

  ! Whether the table has the law of particles that arrive with spin.
  function rbt_has_spin_law(table) result(answer)
    type(rbt_table), intent(in) :: table
    logical :: answer

    answer = c_has_spin_law(table%handle) /= 0
  end function rbt_has_spin_law

  ! Variables in the rows of a state, from RBT_U = 1 to RBT_WORK_SHEAR = 10.
  function rbt_variables(table) result(places)
    type(rbt_table), intent(in) :: table
    integer, allocatable :: places(:)
    integer(c_int), target :: columns(RBT_VALUES), n

    n = c_variables(table%handle, c_loc(columns))
    places = columns(:n) + 1
  end function rbt_variables

  ! Largest half-size, m, of a grain whose volume is that of a sphere of the diameter; 0: not in the table.
  function rbt_half_size(table, diameter, grain) result(half_size)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in) :: diameter, grain(3)
    real(c_double) :: half_size

    half_size = c_half_size(table%handle, diameter, grain)
  end function rbt_half_size

  ! Mean moment of inertia of a grain over m a**2; 0: not in the table.
  function rbt_mean_inertia(table, grain) result(inertia)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in) :: grain(3)
    real(c_double) :: inertia

    inertia = c_mean_inertia(table%handle, grain)
  end function rbt_mean_inertia

  ! Surface of the sphere of equal volume over that of a grain; 0: not in the table.
  function rbt_sphericity(table, grain) result(sphericity)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in) :: grain(3)
    real(c_double) :: sphericity

    sphericity = c_sphericity(table%handle, grain)
  end function rbt_sphericity

  ! Moment of inertia of a particle about its spin, kg m**2, for rbt_spin_after. If the inertia k is 0, not
  ! known, it is the mean moment of the particle's grain.
  function rbt_moment_of_inertia(table, seed, index, inertia, mass, half_size, diameter) result(moment)
    type(rbt_table), intent(in) :: table
    integer(c_int64_t), intent(in) :: seed, index
    real(c_double), intent(in) :: inertia, mass, half_size, diameter
    real(c_double) :: moment

    moment = c_moment_of_inertia(table%handle, seed, index, inertia, mass, half_size, diameter)
  end function rbt_moment_of_inertia

  ! Mean of rbt_half_size over the particles of the table; 0: it has no spin law.
  function rbt_mean_half_size(table, diameter) result(half_size)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in) :: diameter
    real(c_double) :: half_size

    half_size = c_mean_half_size(table%handle, diameter)
  end function rbt_mean_half_size

  ! Whether a particle stays on the wall, 1 or 0; ask before the draw. Without wall_velocity the wall is
  ! at rest.
  function rbt_deposits(velocity, normal, critical_speed, wall_velocity) result(stays)
    real(c_double), intent(in) :: velocity(3), normal(3), critical_speed
    real(c_double), intent(in), target, optional :: wall_velocity(3)
    integer(c_int) :: stays

    stays = c_deposits(velocity, normal, critical_speed, address_of(wall_velocity))
  end function rbt_deposits

  ! Torque of the gas on a spinning particle, N m; gas_rotation: half the curl of the gas velocity, none
  ! if it is left out.
  subroutine rbt_gas_torque(omega, diameter, density, viscosity, gas_rotation, torque)
    real(c_double), intent(in) :: omega(3), diameter, density, viscosity
    real(c_double), intent(in), target, optional :: gas_rotation(3)
    real(c_double), intent(out) :: torque(3)

    call c_gas_torque(omega, diameter, density, viscosity, address_of(gas_rotation), torque)
  end subroutine rbt_gas_torque

  ! Angular velocity that this torque leaves after a time; new_omega must be another variable than omega.
  subroutine rbt_spin_after(omega, time, moment, diameter, density, viscosity, gas_rotation, &
      new_omega)
    real(c_double), intent(in) :: omega(3), time, moment, diameter, density, viscosity
    real(c_double), intent(in), target, optional :: gas_rotation(3)
    real(c_double), intent(out) :: new_omega(3)

    call c_spin_after(omega, time, moment, diameter, density, viscosity, address_of(gas_rotation), &
        new_omega)
  end subroutine rbt_spin_after

  function grains_one(table, seed, index, hit, grain) result(code)
    type(rbt_table), intent(in) :: table
    integer(c_int64_t), intent(in) :: seed, index
    integer(c_int32_t), intent(in), target, optional :: hit
    real(c_double), intent(inout) :: grain(3)
    integer(c_int) :: code
    type(c_ptr) :: address_of_hit

    address_of_hit = c_null_ptr
    if (present(hit)) address_of_hit = c_loc(hit)
    code = c_grains(table%handle, 1_c_size_t, seed, [index], address_of_hit, grain)
  end function grains_one

  function grains_many(table, seed, index, hit, grains) result(code)
    type(rbt_table), intent(in) :: table
    integer(c_int64_t), intent(in) :: seed
    integer(c_int64_t), intent(in), contiguous :: index(:)
    integer(c_int32_t), intent(in), contiguous, target, optional :: hit(:)
    real(c_double), intent(inout), contiguous :: grains(:, :)
    integer(c_int) :: code
    integer :: n
    logical :: agree
    type(c_ptr) :: hits

    n = size(index)
    agree = all(shape(grains) == [3, n])
    if (present(hit)) agree = agree .and. size(hit) == n
    code = merge(RBT_OK, RBT_ERR_MISSING, agree)
    if (n == 0 .or. .not. agree) return
    hits = c_null_ptr
    if (present(hit)) hits = c_loc(hit)
    code = c_grains(table%handle, int(n, c_size_t), seed, index, hits, grains)
  end function grains_many

  ! Draw a state for each column of `states`, whose rows are those of rbt_variables, and the inertias about
  ! the spins after the rebounds.
  function rbt_sample(table, alpha1, speed, spin, inertia, grain, index, hit, inertia_after, fresh, &
      seed, states, codes) result(code)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in), contiguous, target :: alpha1(:), speed(:)
    real(c_double), intent(in), contiguous, target, optional :: spin(:, :), inertia(:), grain(:, :)
    integer(c_int64_t), intent(in), contiguous, target :: index(:)
    integer(c_int32_t), intent(in), contiguous, target :: hit(:)
    real(c_double), intent(inout), contiguous, target, optional :: inertia_after(:)
    logical, intent(in), optional :: fresh
    integer(c_int64_t), intent(in) :: seed
    real(c_double), intent(inout), contiguous, target, optional :: states(:, :)
    integer(c_int), intent(inout), contiguous, target, optional :: codes(:)
    integer(c_int) :: code
    integer :: n, height
    logical :: agree
    type(c_conditions) :: given
    type(c_ptr) :: new_states, new_codes

    n = size(alpha1)
    height = c_variables(table%handle, c_null_ptr)
    agree = all([size(speed), size(index), size(hit)] == n)
    if (present(spin)) agree = agree .and. all(shape(spin) == [3, n])
    if (present(inertia)) agree = agree .and. size(inertia) == n
    if (present(inertia_after)) agree = agree .and. size(inertia_after) == n
    if (present(grain)) agree = agree .and. all(shape(grain) == [3, n])
    if (present(states)) agree = agree .and. all(shape(states) == [height, n])
    if (present(codes)) agree = agree .and. size(codes) == n
    code = merge(RBT_OK, RBT_ERR_MISSING, agree)
    if (n == 0 .or. .not. agree) return
    given = c_conditions(alpha1=c_loc(alpha1), speed=c_loc(speed), index=c_loc(index), &
        hit=c_loc(hit), fresh=as_int(fresh))
    if (present(spin)) given%spin = c_loc(spin)
    if (present(inertia)) given%inertia = c_loc(inertia)
    if (present(inertia_after)) given%inertia_after = c_loc(inertia_after)
    if (present(grain)) given%grain = c_loc(grain)
    new_states = c_null_ptr
    if (present(states)) new_states = c_loc(states)
    new_codes = c_null_ptr
    if (present(codes)) new_codes = c_loc(codes)
    code = c_sample(table%handle, int(n, c_size_t), given, seed, new_states, new_codes)
  end function rbt_sample

  function rebound_one(table, velocity, normal, half_size, wall_velocity, omega, inertia, roughness, &
      grain, index, hit, fresh, isotropic, seed, new_velocity, new_omega, new_inertia, works) &
      result(code)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in), target :: velocity(3), normal(3), half_size
    real(c_double), intent(in), target, optional :: wall_velocity(3), omega(3), inertia, roughness, &
        grain(3)
    integer(c_int64_t), intent(in), target :: index
    integer(c_int32_t), intent(in), target :: hit
    logical, intent(in), optional :: fresh, isotropic
    integer(c_int64_t), intent(in) :: seed
    real(c_double), intent(inout), target, optional :: new_velocity(3), new_omega(3), new_inertia, &
        works(2)
    integer(c_int) :: code
    type(c_impacts) :: given
    type(c_rebounds) :: results

    given = c_impacts(velocity=c_loc(velocity), normal=c_loc(normal), half_size=c_loc(half_size), &
        index=c_loc(index), hit=c_loc(hit), fresh=as_int(fresh), isotropic=as_int(isotropic))
    if (present(wall_velocity)) given%wall_velocity = c_loc(wall_velocity)
    if (present(omega)) given%omega = c_loc(omega)
    if (present(inertia)) given%inertia = c_loc(inertia)
    if (present(roughness)) given%roughness = c_loc(roughness)
    if (present(grain)) given%grain = c_loc(grain)
    if (present(new_velocity)) results%velocity = c_loc(new_velocity)
    if (present(new_omega)) results%omega = c_loc(new_omega)
    if (present(new_inertia)) results%inertia = c_loc(new_inertia)
    if (present(works)) results%works = c_loc(works)
    code = c_rebound(table%handle, 1_c_size_t, given, seed, results)
  end function rebound_one

  function rebound_many(table, velocity, normal, half_size, wall_velocity, omega, inertia, roughness, &
      grain, index, hit, fresh, isotropic, seed, new_velocity, new_omega, new_inertia, works, codes, &
      bad, first_bad, flagged) result(code)
    type(rbt_table), intent(in) :: table
    real(c_double), intent(in), contiguous, target :: velocity(:, :), normal(:, :), half_size(:)
    real(c_double), intent(in), contiguous, target, optional :: wall_velocity(:, :), omega(:, :)
    real(c_double), intent(in), contiguous, target, optional :: inertia(:), roughness(:), grain(:, :)
    integer(c_int64_t), intent(in), contiguous, target :: index(:)
    integer(c_int32_t), intent(in), contiguous, target :: hit(:)
    logical, intent(in), optional :: fresh, isotropic
    integer(c_int64_t), intent(in) :: seed
    real(c_double), intent(inout), contiguous, target, optional :: new_velocity(:, :)
    real(c_double), intent(inout), contiguous, target, optional :: new_omega(:, :), new_inertia(:)
    real(c_double), intent(inout), contiguous, target, optional :: works(:, :)
    integer(c_int), intent(inout), contiguous, target, optional :: codes(:)
    integer, intent(out), optional :: bad, first_bad  ! rows with an error; first of them, 0: none
    integer, intent(out), optional :: flagged(8)  ! rows with the flag 2**(k - 1), in place k
    integer(c_int) :: code
    integer :: n
    logical :: agree
    type(c_impacts) :: given
    type(c_rebounds) :: results

    n = size(half_size)
    agree = all([shape(velocity), shape(normal), size(index), size(hit)] == [3, n, 3, n, n, n])
    if (present(wall_velocity)) agree = agree .and. all(shape(wall_velocity) == [3, n])
    if (present(omega)) agree = agree .and. all(shape(omega) == [3, n])
    if (present(inertia)) agree = agree .and. size(inertia) == n
    if (present(new_inertia)) agree = agree .and. size(new_inertia) == n
    if (present(roughness)) agree = agree .and. size(roughness) == n
    if (present(grain)) agree = agree .and. all(shape(grain) == [3, n])
    if (present(new_velocity)) agree = agree .and. all(shape(new_velocity) == [3, n])
    if (present(new_omega)) agree = agree .and. all(shape(new_omega) == [3, n])
    if (present(works)) agree = agree .and. all(shape(works) == [2, n])
    if (present(codes)) agree = agree .and. size(codes) == n
    code = merge(RBT_OK, RBT_ERR_MISSING, agree)
    if (agree .and. n > 0) then
      given = c_impacts(velocity=c_loc(velocity), normal=c_loc(normal), half_size=c_loc(half_size), &
          index=c_loc(index), hit=c_loc(hit), fresh=as_int(fresh), isotropic=as_int(isotropic))
      if (present(wall_velocity)) given%wall_velocity = c_loc(wall_velocity)
      if (present(omega)) given%omega = c_loc(omega)
      if (present(inertia)) given%inertia = c_loc(inertia)
      if (present(roughness)) given%roughness = c_loc(roughness)
      if (present(grain)) given%grain = c_loc(grain)
      if (present(new_velocity)) results%velocity = c_loc(new_velocity)
      if (present(new_omega)) results%omega = c_loc(new_omega)
      if (present(new_inertia)) results%inertia = c_loc(new_inertia)
      if (present(works)) results%works = c_loc(works)
      if (present(codes)) results%codes = c_loc(codes)
      code = c_rebound(table%handle, int(n, c_size_t), given, seed, results)
    end if
    if (present(bad)) bad = int(results%bad)
    if (present(first_bad)) first_bad = merge(int(results%first_bad) + 1, 0, results%bad > 0)
    if (present(flagged)) flagged = int(results%flagged)
  end function rebound_many

  ! Address of a vector, NULL if it is absent.
  function address_of(vector) result(address)
    real(c_double), intent(in), target, optional :: vector(3)
    type(c_ptr) :: address

    address = c_null_ptr
    if (present(vector)) address = c_loc(vector)
  end function address_of

  ! 1 for true, else 0.
  function as_int(flag) result(number)
    logical, intent(in), optional :: flag
    integer(c_int) :: number

    number = 0
    if (present(flag)) number = merge(1, 0, flag)
  end function as_int

  ! Copy of a text of C, which ends with a null character.
  function fortran_text(from_c) result(text)
    type(c_ptr), intent(in) :: from_c
    character(len=c_strlen(from_c)) :: text
    character(kind=c_char), pointer :: characters(:)

    call c_f_pointer(from_c, characters, [len(text)])
    text = transfer(characters, text)
  end function fortran_text

end module rebound_sampler
