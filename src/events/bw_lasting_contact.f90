module bw_lasting_contact
  !! A contact that lasts: beam and mass move together in the modes of bw_held_modes until the force between them falls to
  !! zero. Units of bw_course.
  use bw_body_state, only: body_state, momentum_of
  use bw_course, only: append_course, course_type, held_at_tip => held_modes, leaves_range, move
  use bw_double_double, only: accurate_sum, dd, to_dd, operator(+)
  use bw_energy, only: carry, energy_type, known_energy, sharper, state_energy
  use bw_event, only: event_type
  use bw_free_flight, only: finest, gap_of, grazing
  use bw_held_modes, only: held_modes, held_set
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, stops
  use bw_signal, only: signal_type
  implicit none (type, external)
  private
  public :: hold, stays

  real(dp), parameter :: unseen = 1.0e-12_dp      !! of V times the record: rebounds that stay below it are left out

contains

  logical function stays(free, restitution, omega, longest, state)
    !! The mass is pressed against the tip, and all further rebounds would stay below what can be seen: with the
    !! relative acceleration a they take 2s/a/(1−e) in all, s the velocity of separation, and reach no further than
    !! s²/2a; a must not change in that time.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: restitution, omega, longest
    type(body_state), intent(in) :: state
    type(signal_type) :: gap
    real(dp) :: separation, pull, rest
    gap = gap_of(free, omega, state)
    separation = max(0.0_dp, gap%derivative(1))
    pull = -gap%derivative(2)
    stays = .false.
    if (restitution == 0.0_dp .or. separation <= grazing) then
      stays = pull > 0.0_dp
      if (pull == 0.0_dp) stays = gap%derivative(3) < 0.0_dp
    else if (restitution < 1.0_dp .and. pull > 0.0_dp) then
      rest = 2.0_dp*separation/pull/(1.0_dp - restitution)
      stays = separation*rest <= unseen*longest .and. abs(gap%derivative(3))*rest <= 0.5_dp*pull
    end if
  end function stays

  subroutine hold(free, gamma, omega, longest, held, state, event, energy, courses, ends, out_of_range, monitor)
    !! A contact that lasts: beam and mass together until the force between them falls to zero, or to the end. A course more.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: gamma, omega, longest
    type(held_set), intent(inout) :: held         !! found when it is first asked for
    type(body_state), intent(inout) :: state
    type(event_type), intent(inout) :: event
    type(energy_type), intent(inout) :: energy    !! of the state
    type(course_type), allocatable, intent(inout) :: courses(:)  !! to which that of beam and mass together is added
    logical, intent(out) :: ends                  !! before the record does
    logical, intent(inout) :: out_of_range        !! set where the motion grows so much that the search ended
    class(monitor_type), intent(inout), optional :: monitor   !! what is found means nothing where it asks to stop
    type(signal_type) :: force
    real(dp), dimension(free%count) :: z, z_rate
    real(dp) :: left, time, before, swept
    if (held%count == 0) call held_modes(free, gamma, omega, held, monitor)
    if (stops(monitor)) return
    before = state%speed + event%impulse/gamma             ! of the mass, when it arrived
    call held%take(state%q, state%rate, state%place, state%speed, z, z_rate)
    call append_course(courses, held_at_tip, state%time, z, z_rate)
    left = longest - state%time%hi
    ends = .false.
    time = left
    if (.not. leaves_range(held, to_dd(left))) then
      force = force_of(held, omega, z, z_rate)
      if (force%start > 0.0_dp) then
        call force%first_zero(0.0_dp, left, finest*longest, ends, time, monitor=monitor)
      else
        call force%first_zero(0.0_dp, left, finest*longest, ends, time, opening=1, monitor=monitor)
      end if
      swept = dot_product(held%tip, integral(held, z, z_rate, to_dd(time)))
      energy = sharper(energy, state_energy(held, z, z_rate))
      call carry(held, to_dd(time), z, z_rate, energy)
      event%impulse = gamma*(before - dot_product(held%tip, z_rate) + omega**2*swept)
    else
      out_of_range = .true.
      time = 0.0_dp
    end if
    call held%give(z, z_rate, state%q, state%rate)
    state%place = dot_product(held%tip, z)
    state%speed = dot_product(held%tip, z_rate)
    state%time = state%time + to_dd(time)
    event%end_time = merge(state%time%hi, longest, ends)
    event%energy_after = known_energy(energy)
    event%momentum_after = momentum_of(free, gamma, state)
  end subroutine hold

  pure type(signal_type) function force_of(held, omega, z, z_rate) result(force)
    !! What presses the mass against the tip, positive while it does: the acceleration with which the gap would close,
    !! −φᵀ(q̈ of the beam alone) + ω²y. Undamped, that is the force m_jΣΦ_k(1)(β_k² + ω²)z_k times 1/m_j + Σφ_i(1)²/M_i;
    !! damped, the held modes are taken as uncoupled, and only this tells when the gap really opens.
    type(held_set), intent(in) :: held
    real(dp), intent(in) :: omega, z(:), z_rate(:)
    real(dp), dimension(size(z)) :: square, by_place, by_rate
    square = held%beta_squared%hi
    by_rate = 0.0_dp*z
    by_place = held%tip*(square + omega**2)
    if (allocated(held%damping)) then
      by_place = matmul(held%free%tip*held%free%beta_squared%hi, held%mixing) + omega**2*held%tip
      by_rate = matmul(held%free%tip*held%free%damping, held%mixing)
    end if
    force%beta_squared = held%beta_squared
    force%c = 0.0_dp*z
    if (allocated(held%damping)) force%c = held%damping
    force%u = by_place*z + by_rate*z_rate
    force%u_dot = by_place*z_rate - by_rate*(force%c*z_rate + square*z)
    force%start = max(0.0_dp, accurate_sum(force%u))
  end function force_of

  pure function integral(held, z, z_rate, time) result(sums)
    !! ∫z dt = −(Δż + cΔz)/β².
    type(held_set), intent(in) :: held
    real(dp), intent(in) :: z(:), z_rate(:)
    type(dd), intent(in) :: time
    real(dp), dimension(size(z)) :: sums, later, later_rate, c
    c = 0.0_dp
    if (allocated(held%damping)) c = held%damping
    later = z
    later_rate = z_rate
    call move(held, time, later, later_rate)
    where (abs(held%beta_squared%hi)*time%hi**2 > 1.0e-6_dp)
      sums = -((later_rate - z_rate) + c*(later - z))/held%beta_squared%hi
    elsewhere
      sums = time%hi*(0.5_dp*(z + later) + time%hi*(z_rate - later_rate)/12.0_dp)    ! Hermite's rule
    end where
  end function integral

end module bw_lasting_contact
