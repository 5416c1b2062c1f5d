! Grains of corundum in a channel with two plates: each keeps its number, its hits and its spin.
program tracker
  use, intrinsic :: iso_c_binding, only: r => c_double, c_int, c_int64_t
  use rebound_sampler
  implicit none
  ! SI units: time step, gas, diameter and mass of a grain
  real(r), parameter :: dt = 2e-5_r, gas(3) = [100, 0, 0], rho = 1.2_r, mu = 1.8e-5_r, &
      d = 60e-6_r, m = 4.5e-10_r, a = 0.63_r * d, still(3) = 0, s = 0.8660254_r, o = 0
  ! floor, roof, two sides of each plate: x, y of an end, the normal into the gas, the length
  real(r), parameter :: walls(6, 6) = reshape([-9._r, o, o, 1._r, o, 18._r, 9._r, 0.1_r, o, -1._r, &
      o, 18._r, 0.1_r, o, -s, 0.5_r, o, 0.07_r, 0.135_r, 0.06062178_r, s, -0.5_r, o, 0.07_r, &
      0.235_r, 0.03937822_r, -s, -0.5_r, o, 0.07_r, 0.2_r, 0.1_r, s, 0.5_r, o, 0.07_r], [6, 6])
  real(r) :: x(2), v(3), omega(3), inertia, n(3), w(6), into, away, along, speed, share, time, ends(6)
  integer(c_int) :: code, hit, k
  integer(c_int64_t) :: index, seed = 7
  type(rbt_table) :: table

  code = rbt_open("corundum-steel.rbt", table); share = 1 - exp(-9.42477796_r * mu * d * dt / m); ends = 0
  do index = 0, 1999
    x = [o, (index + 0.5_r) * 5e-5_r]; v = gas; omega = 0; hit = 0; into = 0; time = 0
    inertia = 0.4_r  ! inertia about omega: that of a grain at rest has no effect
    do while (code >= RBT_OK .and. x(1) >= 0 .and. x(1) < 0.5_r .and. (into <= 0 .or. into > 1))
      v = v + share * (gas - v)
      time = time + dt  ! since the last wall
      into = 0  ! m/s into a wall that the next step crosses; up to 1, the grain rests
      do k = 1, 6
        w = walls(:, k); speed = -dot_product(w(3:4), v(:2))
        away = dot_product(w(3:4), x - w(:2)); along = w(4) * (x(1) - w(1)) - w(3) * (x(2) - w(2))
        if (away < 0 .or. away >= dt * speed .or. along <= 0 .or. along >= w(6)) cycle
        n = w(3:5); into = speed
      end do
      if (into <= 0) x = x + dt * v(:2)
      if (into <= 1) cycle
      call rbt_spin_after((omega), time, inertia * m * a**2, d, rho, mu, still, omega)  ! the gas
      code = rbt_rebound(table, (v), n, a, omega=(omega), inertia=(inertia), index=index, hit=hit, &
          seed=seed, new_velocity=v, new_omega=omega, new_inertia=inertia)
      time = 0; hit = hit + 1; if (code > RBT_OK) ends(6) = ends(6) + 1  ! outside what the table covers
    end do
    ends(:5) = ends(:5) + [merge(1, 0, [x(1) >= 0.5_r, x(1) < 0]) + o, hit + o, sum(v**2), omega(3)]
  end do
  print "(6(g0, 1x), a)", ends, rbt_strerror(min(code, RBT_OK))
end program tracker
