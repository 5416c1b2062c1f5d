! Grains of corundum in a channel with two plates. A grain keeps its number, the number of walls that it
! has met, its spin, and the inertia about its spin.
program tracker
  use, intrinsic :: iso_c_binding, only: r => c_double, c_int, c_int64_t
  use rebound_sampler
  implicit none

  ! SI units: time step, gas, diameter, mass and largest half-size of a grain
  real(r), parameter :: dt = 2e-5_r, gas(3) = [100, 0, 0], density = 1.2_r, viscosity = 1.8e-5_r
  real(r), parameter :: diameter = 60e-6_r, mass = 4.5e-10_r, half_size = 0.63_r * diameter
  real(r), parameter :: drag = 9.42477796_r * viscosity * diameter / mass  ! of Stokes, 1/s

  ! floor, roof, two sides of each plate: x, y of an end, the normal into the gas, the length
  real(r), parameter :: walls(6, 6) = reshape([ &
      -9.0_r, 0.0_r, 0.0_r, 1.0_r, 0.0_r, 18.0_r, &
      9.0_r, 0.1_r, 0.0_r, -1.0_r, 0.0_r, 18.0_r, &
      0.1_r, 0.0_r, -0.8660254_r, 0.5_r, 0.0_r, 0.07_r, &
      0.135_r, 0.06062178_r, 0.8660254_r, -0.5_r, 0.0_r, 0.07_r, &
      0.235_r, 0.03937822_r, -0.8660254_r, -0.5_r, 0.0_r, 0.07_r, &
      0.2_r, 0.1_r, 0.8660254_r, 0.5_r, 0.0_r, 0.07_r], [6, 6])

  real(r) :: x(2), v(3), omega(3), inertia, new_v(3), new_omega(3), normal(3)
  real(r) :: flight  ! time since the last wall
  real(r) :: energy = 0, spin = 0
  integer :: passed = 0, back = 0, hits = 0, outside = 0
  integer(c_int) :: code, hit, wall
  integer(c_int64_t) :: index, seed = 7
  type(rbt_table) :: table

  code = rbt_open("corundum-steel.rbt", table)
  if (code < 0) error stop "corundum-steel.rbt cannot be opened"
  do index = 0, 1999
    x = [0.0_r, (index + 0.5_r) * 5e-5_r]
    v = gas
    omega = 0
    inertia = 0
    flight = 0
    hit = 0
    do while (x(1) >= 0 .and. x(1) < 0.5_r)
      v = v + (1 - exp(-drag * dt)) * (gas - v)
      flight = flight + dt
      wall = wall_ahead()
      if (wall == 0) then
        x = x + dt * v(:2)
        cycle
      end if
      normal = walls(3:5, wall)
      if (rbt_deposits(v, normal, resting_speed()) == 1) exit
      call slow_down_spin()
      code = rbt_rebound(table, v, normal, half_size, omega=omega, inertia=(inertia), index=index, &
          hit=hit, seed=seed, new_velocity=new_v, new_omega=new_omega, new_inertia=inertia)
      if (code < 0) error stop "a rebound has failed"
      if (iand(code, RBT_OUTSIDE) /= 0) outside = outside + 1
      v = new_v
      omega = new_omega
      hit = hit + 1
    end do
    call slow_down_spin()
    if (x(1) >= 0.5_r) passed = passed + 1
    if (x(1) < 0) back = back + 1
    hits = hits + hit
    energy = energy + sum(v**2)
    spin = spin + omega(3)
  end do
  print "(3(i0, 1x), 2(g0, 1x), i0)", passed, back, hits, energy, spin, outside

contains

  ! Number of the wall that the next step crosses; 0: none.
  function wall_ahead() result(found)
    integer(c_int) :: found, k
    real(r) :: w(6), away, along, approach

    found = 0
    do k = 1, 6
      w = walls(:, k)
      away = w(3) * (x(1) - w(1)) + w(4) * (x(2) - w(2))
      along = w(4) * (x(1) - w(1)) - w(3) * (x(2) - w(2))
      approach = -(w(3) * v(1) + w(4) * v(2))
      if (away >= 0 .and. away < dt * approach .and. along > 0 .and. along < w(6)) found = k
    end do
  end function wall_ahead

  ! Normal speed below which a grain rests: its next hop would be lower than a hundredth of its
  ! diameter, since the gas presses it to the wall.
  function resting_speed() result(speed)
    real(r) :: speed, pressure

    pressure = -dot_product(normal, gas - v) * drag  ! acceleration towards the wall
    speed = sqrt(2 * max(pressure, 0.0_r) * 0.01_r * diameter)
  end function resting_speed

  ! The torque of the gas over the whole flight from the last wall. One call is exact.
  subroutine slow_down_spin()
    real(r) :: moment

    moment = inertia * mass * half_size**2
    if (hit > 0) call rbt_spin_after((omega), flight, moment, diameter, density, viscosity, &
        new_omega=omega)  ! before the first wall it does not spin
    flight = 0
  end subroutine slow_down_spin
end program tracker
