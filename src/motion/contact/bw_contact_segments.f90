module bw_contact_segments
  !! Segments of the motion of beam and mass: flight to the next contact, and lasting contact, in which both move in the
  !! modes of bw_contact_modes until the force between them vanishes. Units of bw_segment.
  use bw_contact_modes, only: contact_set
  use bw_contact_motion, only: contact_motion
  use bw_double_double, only: dd, operator(-)
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type
  use bw_oscillators, only: moving_state, oscillators, weighted_sum
  use bw_segment, only: alone, together
  use bw_signal, only: signal_of, signal_type
  implicit none (type, external)
  private
  public :: elapsed, follow_contact, follow_flight, rebound_error, mass_stays

  real(dp), parameter :: unseen = 1.0e-12_dp      !! of V times the record: smaller rebounds are neglected
  real(dp), parameter :: slow = 1.0e-9_dp         !! of V: smaller separation speeds count as 0
  real(dp), parameter :: never = 1.0e200_dp

contains

  subroutine follow_flight(motion, released, last, found, monitor)
    !! Move in flight to the next contact, or to the end.
    type(contact_motion), intent(inout) :: motion
    logical, intent(in) :: released               !! after a lasting contact, whose force has vanished
    real(dp), intent(in) :: last                  !! end of the search
    logical, intent(out) :: found                 !! a contact comes before it
    class(monitor_type), intent(inout), optional :: monitor   !! results are invalid if it requests a stop
    type(moving_state) :: from
    integer :: opening
    from = motion%state
    opening = merge(1, 2, motion%separation() > slow)
    if (released) opening = 3
    call find_zero(motion%parts(alone), motion%gap, opening, last, motion%state, found, monitor)
    call motion%damp(alone, motion%inertia, from, elapsed(from, motion%state))
  end subroutine follow_flight

  subroutine find_zero(parts, sum_of, order, last, state, found, monitor)
    !! Move to the first zero of a sum that is positive from now on.
    type(oscillators), intent(in) :: parts
    type(weighted_sum), intent(in) :: sum_of
    integer, intent(in) :: order                  !! of its first nonzero derivative now
    real(dp), intent(in) :: last
    type(moving_state), intent(inout) :: state    !! at the zero, or at the end
    logical, intent(out) :: found
    class(monitor_type), intent(inout), optional :: monitor
    type(signal_type) :: signal
    real(dp) :: time
    signal = signal_of(parts, sum_of, state, order)
    call signal%first_zero((last - state%time%hi) - state%time%lo, found, time, monitor)
    call parts%move(time, state)
  end subroutine find_zero

  pure real(dp) function elapsed(from, to) result(time)
    !! Return the time between two states.
    type(moving_state), intent(in) :: from, to
    type(dd) :: later
    later = to%time - from%time
    time = later%hi
  end function elapsed

  pure logical function mass_stays(motion, longest) result(stays)
    !! Return whether, after an impact, the mass stays pressed against the tip: at once, or as all further rebounds are negligible.
    type(contact_motion), intent(in) :: motion
    real(dp), intent(in) :: longest               !! the whole record
    real(dp) :: separation
    separation = motion%separation()
    stays = motion%restitution == 0.0_dp .or. separation <= slow
    if (.not. stays) stays = separation*rebound_time(motion) <= unseen*longest
    if (stays) stays = motion%is_pressed()
  end function mass_stays

  pure real(dp) function rebound_time(motion) result(time)
    !! Return the time in which all further rebounds end. With the relative acceleration a it is R = 2s/a/(1−e), where s
    !! is the speed of separation; their height is at most s²/2a. `never` unless a is nearly constant in that time.
    type(contact_motion), intent(in) :: motion
    real(dp) :: jerk, pull
    time = never
    pull = motion%pull()
    if (pull <= 0.0_dp .or. motion%restitution == 1.0_dp) return
    jerk = motion%parts(alone)%derivative(motion%gap, motion%state, 3)
    time = 2.0_dp*motion%separation()/pull/(1.0_dp - motion%restitution)
    if (abs(jerk)*time > 0.5_dp*pull) time = never
  end function rebound_time

  subroutine follow_contact(motion, modes, last, from, to, impulse, found, monitor)
    !! Move beam and mass together until the force between them vanishes, or to the end.
    type(contact_motion), intent(inout) :: motion
    type(contact_set), intent(in) :: modes
    real(dp), intent(in) :: last                  !! end of the search
    type(moving_state), intent(out) :: from, to   !! first and last state of the contact modes
    real(dp), intent(out) :: impulse              !! on the tip, including that by which the mass stops relative to it
    logical, intent(out) :: found                 !! the contact ends before it
    class(monitor_type), intent(inout), optional :: monitor   !! results are invalid if it requests a stop
    integer :: order
    associate (parts => motion%parts(together), force => modes%force, blow => motion%separation())
      call motion%lose(0.5_dp*blow**2*motion%yield())
      from = moving_state(matmul(motion%state%u, modes%onto), matmul(motion%state%v, modes%onto), motion%state%time)
      to = from
      order = merge(0, 1, parts%derivative(force, from, 0) > 0.0_dp)
      call find_zero(parts, force, order, last, to, found, monitor)
      impulse = (sum(force%a*integral(parts, from, to) + force%b*(to%u - from%u)) - blow)*motion%yield()
    end associate
    call motion%damp(together, modes%modal_mass, from, elapsed(from, to))
    motion%state = moving_state([matmul(modes%mixing, to%u), dot_product(modes%struck, to%u)], &
                                [matmul(modes%mixing, to%v), dot_product(modes%struck, to%v)], to%time)
  end subroutine follow_contact

  pure function rebound_error(motion) result(change)
    !! Bound the velocity errors due to neglected rebounds. Their impulses and those of a lasting contact have the same sum and
    !! the same first moment about the time of final closure; their second moments differ by sR²(1−e)/3(1+e+e²) over the
    !! mobility. With damping the contact modes define the motion from the first neglected rebound on, and the error is 0.
    type(contact_motion), intent(in) :: motion
    real(dp), dimension(motion%modes + 1) :: change
    real(dp) :: separation, time
    separation = max(0.0_dp, motion%separation())
    change = motion%share()*separation
    if (any(motion%parts(alone)%c > 0.0_dp)) change = 0.0_dp
    time = rebound_time(motion)
    if (time == never) return
    associate (square => motion%parts(alone)%beta_squared%hi, e => motion%restitution)
      change = 0.5_dp*(change*sum(motion%gap%a*motion%share()*square) - change*square) &
        *time**2*(1.0_dp - e)/(3.0_dp*(1.0_dp + e + e**2))
    end associate
  end function rebound_error

  pure function integral(parts, from, to) result(sums)
    !! Return ∫u dt = −(Δv + cΔu)/β².
    type(oscillators), intent(in) :: parts
    type(moving_state), intent(in) :: from, to
    real(dp) :: sums(size(from%u)), time
    time = elapsed(from, to)
    where (abs(parts%beta_squared%hi)*time**2 > 1.0e-4_dp)
      sums = -((to%v - from%v) + parts%c*(to%u - from%u))/parts%beta_squared%hi
    elsewhere
      sums = time*(0.5_dp*(from%u + to%u) + time*(from%v - to%v)/12)    ! Hermite quadrature
    end where
  end function integral

end module bw_contact_segments
