! Follow grains of corundum, in air of 100 m/s, through a channel with two plates.
!
! The gas exerts a drag and a torque on them. A grain keeps its index, the number of walls that it has
! met, its spin, and the inertia about its spin. All quantities are in SI units.
!
! The drag is that of Schiller & Naumann (Z. VDI 77 (1933) 318) on spheres of equal volume, which holds
! up to a Reynolds number of 800; the slip of these grains gives up to 570. rbt_sphericity is for drag
! laws of other grains.
program tracker
  use, intrinsic :: iso_c_binding, only: dp => c_double, c_int, c_int64_t
  use, intrinsic :: iso_fortran_env, only: error_unit
  use rebound_sampler
  implicit none

  integer(c_int64_t), parameter :: n_grains = 2000
  integer(c_int64_t), parameter :: seed = 7
  real(dp), parameter :: time_step = 2e-5_dp
  real(dp), parameter :: channel_length = 0.5_dp
  real(dp), parameter :: channel_height = 0.1_dp

  real(dp), parameter :: gas_velocity(3) = [100, 0, 0]
  real(dp), parameter :: gas_density = 1.2_dp
  real(dp), parameter :: viscosity = 1.8e-5_dp

  real(dp), parameter :: diameter = 60e-6_dp            ! of the sphere of equal volume
  real(dp), parameter :: mass = 4.5e-10_dp
  real(dp), parameter :: pi = 3.141592653589793_dp
  real(dp), parameter :: stokes_rate = 3 * pi * viscosity * diameter / mass ! of the drag at small slip

  type :: wall
    real(dp) :: x, y       ! one end
    real(dp) :: normal(3)  ! into the gas
    real(dp) :: length
  end type wall

  type :: grain
    real(dp) :: x = 0, y = 0
    real(dp) :: v(3) = gas_velocity
    real(dp) :: omega(3) = 0  ! mean angular velocity
    real(dp) :: inertia = 0   ! about it, over mass half_size**2; 0 is not known
    real(dp) :: flight = 0    ! time since the last wall
    integer(c_int64_t) :: index = 0
    integer(c_int) :: hit = 0 ! number of walls that it has met
    real(dp) :: half_size = 0 ! a, the largest
  end type grain

  ! floor and roof, then front and back of the plate on the floor and of the plate on the roof
  type(wall), parameter :: walls(6) = [ &
      wall(-9.0_dp, 0.0_dp, [0.0_dp, 1.0_dp, 0.0_dp], 18.0_dp), &
      wall(9.0_dp, 0.1_dp, [0.0_dp, -1.0_dp, 0.0_dp], 18.0_dp), &
      wall(0.1_dp, 0.0_dp, [-0.8660254_dp, 0.5_dp, 0.0_dp], 0.07_dp), &
      wall(0.135_dp, 0.06062178_dp, [0.8660254_dp, -0.5_dp, 0.0_dp], 0.07_dp), &
      wall(0.235_dp, 0.03937822_dp, [-0.8660254_dp, -0.5_dp, 0.0_dp], 0.07_dp), &
      wall(0.2_dp, 0.1_dp, [0.8660254_dp, 0.5_dp, 0.0_dp], 0.07_dp)]

  type(grain) :: g
  type(rbt_table) :: table
  real(dp) :: squared_velocity = 0, spin = 0
  real(dp) :: form(3)  ! code of the shape, b/a and c/b
  integer :: passed = 0, resting = 0, hits = 0, outside = 0
  integer(c_int64_t) :: k

  call check(rbt_open("corundum-steel.rbt", table), "corundum-steel.rbt")
  do k = 0, n_grains - 1
    g = grain(y=(k + 0.5_dp) * channel_height / n_grains, index=k)
    call check(rbt_grains(table, seed, k, grain=form), "grain")
    g%half_size = rbt_half_size(table, diameter, form)
    call follow(g)
    if (g%x >= channel_length) passed = passed + 1
    if (g%x >= 0 .and. g%x < channel_length) resting = resting + 1
    hits = hits + g%hit
    squared_velocity = squared_velocity + sum(g%v**2)
    spin = spin + g%omega(3)
  end do
  call rbt_close(table)
  print "(a, i0)", "grains that pass:      ", passed
  print "(a, i0)", "grains that rest:      ", resting
  print "(a, i0)", "hits of walls:         ", hits
  print "(a, g0)", "sum of v^2, m2/s2:     ", squared_velocity
  print "(a, g0)", "sum of omega_z, rad/s: ", spin
  print "(a, i0)", "outside the table:     ", outside

contains

  ! End the program if a code is an error.
  subroutine check(code, what)
    integer(c_int), intent(in) :: code
    character(len=*), intent(in) :: what

    if (code >= 0) return
    write (error_unit, "(3a)") what, ": ", rbt_strerror(code)
    stop 1
  end subroutine check

  ! Follow a grain until it leaves the channel or rests on a wall, and count impacts outside the table.
  subroutine follow(g)
    type(grain), intent(inout) :: g
    real(dp) :: normal(3), new_v(3), new_omega(3), new_inertia
    integer :: ahead
    integer(c_int) :: code

    do while (g%x >= 0 .and. g%x < channel_length)
      g%v = g%v + (1 - exp(-drag_rate(g) * time_step)) * (gas_velocity - g%v)
      g%flight = g%flight + time_step
      ahead = wall_ahead(g)
      if (ahead == 0) then
        g%x = g%x + time_step * g%v(1)
        g%y = g%y + time_step * g%v(2)
        cycle
      end if
      normal = walls(ahead)%normal
      if (rbt_deposits(g%v, normal, resting_speed(g, normal)) == 1) exit
      call slow_down_spin(g)
      code = rbt_rebound(table, g%v, normal, g%half_size, omega=g%omega, inertia=g%inertia, &
          index=g%index, hit=g%hit, seed=seed, new_velocity=new_v, new_omega=new_omega, &
          new_inertia=new_inertia)
      call check(code, "rebound")
      if (iand(code, RBT_OUTSIDE) /= 0) outside = outside + 1
      g%v = new_v
      g%omega = new_omega
      g%inertia = new_inertia
      g%hit = g%hit + 1
    end do
    call slow_down_spin(g)
  end subroutine follow

  ! Number of the wall that the next step of a grain crosses; 0 if there is none.
  function wall_ahead(g) result(ahead)
    type(grain), intent(in) :: g
    integer :: ahead, i
    real(dp) :: x, y, distance, along, approach

    ahead = 0
    do i = 1, size(walls)
      x = g%x - walls(i)%x
      y = g%y - walls(i)%y
      distance = walls(i)%normal(1) * x + walls(i)%normal(2) * y
      along = walls(i)%normal(2) * x - walls(i)%normal(1) * y
      approach = -dot_product(walls(i)%normal, g%v)
      if (distance >= 0 .and. distance < time_step * approach .and. along > 0 &
          .and. along < walls(i)%length) ahead = i
    end do
  end function wall_ahead

  ! The rate at which the drag takes the slip of a grain, 1/s.
  function drag_rate(g) result(rate)
    type(grain), intent(in) :: g
    real(dp) :: rate, reynolds

    reynolds = gas_density * diameter / viscosity * norm2(gas_velocity - g%v)
    rate = stokes_rate * (1 + 0.15_dp * reynolds**0.687_dp)
  end function drag_rate

  ! The normal speed below which a grain rests. Where the gas presses it to the wall, its next hop would
  ! be lower than a hundredth of its diameter.
  function resting_speed(g, normal) result(speed)
    type(grain), intent(in) :: g
    real(dp), intent(in) :: normal(3)
    real(dp) :: speed, towards_wall

    towards_wall = -drag_rate(g) * dot_product(normal, gas_velocity - g%v)  ! acceleration
    speed = sqrt(2 * max(towards_wall, 0.0_dp) * 0.01_dp * diameter)
  end function resting_speed

  ! Let the torque of the gas act on the spin. One call for the whole flight since the last wall is exact.
  subroutine slow_down_spin(g)
    type(grain), intent(inout) :: g
    real(dp) :: moment, new_omega(3)

    if (g%hit > 0) then  ! before its first wall the grain does not spin
      moment = g%inertia * mass * g%half_size**2
      call rbt_spin_after(g%omega, g%flight, moment, diameter, gas_density, viscosity, &
          new_omega=new_omega)
      g%omega = new_omega
    end if
    g%flight = 0
  end subroutine slow_down_spin
end program tracker
