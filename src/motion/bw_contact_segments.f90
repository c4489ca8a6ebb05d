module bw_contact_segments
  !! Segments of the motion of beam and mass: free flight to the next contact, and contact that lasts, in
  !! which both move together in the modes of bw_contact_modes until the force between them falls to zero. Units of bw_segment.
  use bw_contact_modes, only: contact_set
  use bw_contact_motion, only: contact_motion
  use bw_double_double, only: to_dd
  use bw_kinds, only: dp, qp
  use bw_monitor, only: monitor_type
  use bw_next_zero, only: certain, find_zero
  use bw_oscillators, only: moving_state, oscillators
  use bw_perturbations, only: error_from, perturbations
  use bw_segment, only: alone, segment_type, together
  implicit none (type, external)
  private
  public :: follow_flight, follow_contact, judge_rebound

  real(dp), parameter :: unseen = 1.0e-12_dp      !! of V times the record: rebounds that stay below it are left out
  real(dp), parameter, public :: slow = 1.0e-9_dp !! of V: a separation below it is none

  integer, parameter, public :: leaves = 0, stays = 1, undecided = 2

contains

  subroutine follow_flight(motion, opening, longest, outcome, segment, sway, monitor)
    !! To the next contact, to where one is in doubt, or to the end.
    type(contact_motion), intent(inout) :: motion
    integer, intent(in) :: opening                !! the first derivative of the gap that is not zero now
    real(dp), intent(in) :: longest               !! time from now to the end
    integer, intent(out) :: outcome               !! never, certain or in_doubt (bw_next_zero)
    type(segment_type), intent(out) :: segment      !! the motion until then
    real(dp), intent(out) :: sway                 !! what the tip's displacement may be in it
    class(monitor_type), intent(inout), optional :: monitor   !! the outcome means nothing where it asks to stop
    type(moving_state) :: from
    from = motion%state
    call find_zero(motion%parts, motion%gap, motion%near, opening, longest, motion%state, outcome, monitor)
    call finish(motion, from, segment, sway)
    if (outcome == certain) call motion%near%meet(motion%parts, motion%gap, motion%state)
  end subroutine follow_flight

  subroutine finish(motion, from, segment, sway)
    !! What there is to say of a flight whose end the state has reached.
    type(contact_motion), intent(inout) :: motion
    type(moving_state), intent(in) :: from
    type(segment_type), intent(out) :: segment
    real(dp), intent(out) :: sway
    real(dp) :: error(size(from%u), 2), start_error
    start_error = error_from(motion%near%lag)
    call motion%near%move(motion%parts, from, motion%state, error)
    associate (n => motion%modes)
      sway = motion%parts%sway(motion%gap%a(:n), from, motion%state)
      segment = segment_type(alone, to_dd(from%time), count=n, q=real(from%u(:n), dp), rate=real(from%v(:n), dp), &
                             start_error=start_error, error=error(:n, :))
    end associate
  end subroutine finish

  integer function judge_rebound(motion, longest) result(verdict)
    !! Whether the mass is pressed against the tip, and all further rebounds would stay below what can be seen: with the
    !! relative acceleration a they take R = 2s/a/(1−e) in all, s the velocity of separation, and reach no further than
    !! s²/2a; a must not change in that time.
    type(contact_motion), intent(in) :: motion
    real(dp), intent(in) :: longest               !! the whole record
    real(qp) :: separation, pull, settling
    separation = motion%separation()
    pull = motion%pull()
    verdict = leaves
    if (motion%restitution == 0.0_qp .or. separation <= slow) then
      if (pull > 0.0_qp .or. (pull == 0.0_qp .and. motion%jerk() < 0.0_qp)) verdict = stays
      if (abs(pull) < error_of_pull(motion)) verdict = undecided
    else if (motion%restitution < 1.0_qp .and. pull > 0.0_qp) then
      settling = 2.0_qp*separation/pull/(1.0_qp - motion%restitution)
      if (separation*settling <= unseen*longest .and. abs(motion%jerk())*settling <= 0.5_qp*pull) verdict = stays
    end if
  end function judge_rebound

  pure real(dp) function error_of_pull(motion) result(error)
    !! By how much the acceleration that presses the mass against the tip may be off, from the neighbours of the motion.
    type(contact_motion), intent(in) :: motion
    real(dp), dimension(size(motion%near%lag)) :: deviation
    integer :: p
    do p = 1, size(deviation)
      associate (u => motion%near%u(:, p), v => motion%near%v(:, p))
        deviation(p) = sum(real(motion%gap%a, dp)*(real(motion%parts%c, dp)*v + motion%parts%beta_squared%hi*u))
      end associate
    end do
    error = error_from(deviation)
  end function error_of_pull

  subroutine follow_contact(motion, modes, longest, outcome, impulse, segment, sway, monitor)
    !! Beam and mass together, from now until the force between them falls to zero, or is in doubt, or to the end.
    type(contact_motion), intent(inout) :: motion
    type(contact_set), intent(in) :: modes
    real(dp), intent(in) :: longest               !! time from now to the end
    integer, intent(out) :: outcome               !! never, certain or in_doubt
    real(qp), intent(out) :: impulse              !! on the tip in that time, and as the mass comes to rest on it
    type(segment_type), intent(out) :: segment      !! the motion until then
    real(dp), intent(out) :: sway                 !! what the tip's displacement may be in it
    class(monitor_type), intent(inout), optional :: monitor   !! the outcome means nothing where it asks to stop
    type(moving_state) :: from, z
    type(perturbations) :: near
    real(dp) :: error(modes%count, 2), start_error
    integer :: order
    impulse = -motion%separation()
    motion%lost = motion%lost + 0.5_qp*motion%separation()**2/motion%mobility
    start_error = error_from(motion%near%lag)
    if (.not. allocated(modes%damping)) call omit_rebounds(motion)
    call project(modes, motion, z, near)
    from = z
    order = merge(0, 1, modes%parts%derivative(modes%force, z, 0) > 0.0_qp)
    call find_zero(modes%parts, modes%force, near, order, longest, z, outcome, monitor)
    call near%move(modes%parts, from, z, error)
    if (outcome == certain) call near%meet(modes%parts, modes%force, z)
    impulse = (impulse + sum(modes%force%a*integral(modes%parts, from, z) + modes%force%b*(z%u - from%u)))/motion%mobility
    call expand(modes, z, near, motion)
    sway = modes%parts%sway(modes%tip_in_full, from, z)
    segment = segment_type(together, to_dd(from%time), count=modes%count, q=real(from%u, dp), rate=real(from%v, dp), &
                           start_error=start_error, error=error)
  end subroutine follow_contact

  pure subroutine omit_rebounds(motion)
    !! What that may change. The rebounds' impulses and those of a contact that lasts from now on have the same sum and the
    !! same first moment about the time at which the gap stays closed, which both end with; their second moments differ by
    !! sR²(1−e)/3(1+e+e²) over the mobility. (Damped, the contact modes are a model from the first rebound on that is left out.)
    type(contact_motion), intent(inout) :: motion
    real(dp), dimension(size(motion%share)) :: change, share
    real(dp) :: separation, pull, e
    integer :: p
    separation = real(motion%separation(), dp)
    pull = real(motion%pull(), dp)
    e = real(motion%restitution, dp)
    if (separation <= 0.0_dp) return
    share = real(motion%share, dp)
    change = share*separation
    if (pull > 0.0_dp .and. e < 1.0_dp) then
      associate (square => motion%parts%beta_squared%hi, settling => 2.0_dp*separation/pull/(1.0_dp - e))
        change = 0.5_dp*share*(sum(real(motion%gap%a, dp)*share*square) - square) &
          *(separation*settling**2*(1.0_dp - e)/(3.0_dp*(1.0_dp + e + e**2)))
      end associate
    end if
    do p = 1, size(motion%near%lag)
      motion%near%v(:, p) = motion%near%v(:, p) + motion%near%sign(1, p)*change
    end do
  end subroutine omit_rebounds

  pure subroutine project(modes, motion, z, near)
    !! The state of beam and mass in the contact modes: its projection with the weight of both, as a blow without rebound
    !! leaves it; and the neighbours'.
    type(contact_set), intent(in) :: modes
    type(contact_motion), intent(in) :: motion
    type(moving_state), intent(out) :: z
    type(perturbations), intent(out) :: near
    z%u = matmul(motion%state%u, modes%onto)
    z%v = matmul(motion%state%v, modes%onto)
    z%time = motion%state%time
    near = motion%near
    near%u = matmul(transpose(real(modes%onto, dp)), motion%near%u)
    near%v = matmul(transpose(real(modes%onto, dp)), motion%near%v)
    near%sign = motion%near%sign(:modes%count, :)
  end subroutine project

  pure subroutine expand(modes, z, near, motion)
    !! The same in the modes of the beam alone; the mass is at the tip.
    type(contact_set), intent(in) :: modes
    type(moving_state), intent(in) :: z
    type(perturbations), intent(in) :: near
    type(contact_motion), intent(inout) :: motion
    real(dp) :: mixing(modes%count, modes%count), sign(modes%count + 1, size(near%lag))
    integer :: n
    n = modes%count
    motion%state%u = [matmul(modes%mixing, z%u), dot_product(modes%tip_in_full, z%u)]
    motion%state%v = [matmul(modes%mixing, z%v), dot_product(modes%tip_in_full, z%v)]
    motion%state%time = z%time
    mixing = real(modes%mixing, dp)
    sign = motion%near%sign
    motion%near = near
    motion%near%sign = sign
    deallocate (motion%near%u, motion%near%v)
    allocate (motion%near%u(n + 1, size(near%lag)), motion%near%v(n + 1, size(near%lag)))
    motion%near%u(:n, :) = matmul(mixing, near%u)
    motion%near%v(:n, :) = matmul(mixing, near%v)
    motion%near%u(n + 1, :) = matmul(modes%struck, near%u)
    motion%near%v(n + 1, :) = matmul(modes%struck, near%v)
  end subroutine expand

  pure function integral(parts, from, to) result(sums)
    !! ∫u dt = −(Δv + cΔu)/β².
    type(oscillators), intent(in) :: parts
    type(moving_state), intent(in) :: from, to
    real(qp) :: sums(size(from%u)), time
    time = to%time - from%time
    where (abs(parts%square)*time**2 > 1.0e-6_qp)
      sums = -((to%v - from%v) + parts%c*(to%u - from%u))/parts%square
    elsewhere
      sums = time*(0.5_qp*(from%u + to%u) + time*(from%v - to%v)/12)    ! Hermite's rule
    end where
  end function integral

end module bw_contact_segments
