module bw_tip_remainder
  !! What a sum of n modes lacks of the tip's velocity at one instant: the sum over as many further modes as it takes.
  !!
  !! When a mass leaves, the modes of the beam alone start from what the beam does then, and what converges slowest in that
  !! is the tip's velocity: of a loaded mode k far above a free mode i the overlap ∫Φ̄_kφ_i dξ goes to −γΦ̄_k(1)φ_i(1), so
  !! that all of them together give every free mode the same blow, −γφ_i(1) times the velocity that is missing at the tip.
  !! It is a sum of A_k cos β_kt, A_k = force·Φ̄_k(1)²/M̄_k falling as k⁻²: n modes lack n^(−3/2) of it. But it is one number,
  !! and a million modes for it cost little.
  !!
  !! What N modes lack is judged by ΣA = (1+e)V, the velocity at t = 0: less the terms that were summed it bounds the others,
  !! and with the last term also ΣA². How far their phases can agree at that one instant is that of bw_coherence.
  use bw_coherence, only: deviation_type, from_tip, largest, stretch_type
  use bw_double_double, only: accurate_sum, dd, dd_pi, operator(*), operator(/)
  use bw_kinds, only: dp
  use bw_modal_flow, only: slow_exponent
  use bw_mode_set, only: mode_set, mode_source
  use bw_monitor, only: monitor_type, stops
  use bw_release, only: tip_remainder
  use bw_segment, only: energy_type, move_with_energy, state_energy
  use bw_turn, only: phase_angles
  implicit none (type, external)
  private
  public :: find_tip_remainder

  integer, parameter :: chunk = 256               !! modes held at a time
  integer, parameter :: most_terms = 10000000
  integer, parameter :: neighbours = 16           !! among which A is not even: waves of shear take turns with those of bending
  real(dp), parameter :: pi = acos(-1.0_dp)

  type :: running_sum
    real(dp) :: started = 0.0_dp                  !! ΣA
    real(dp) :: last = 0.0_dp                     !! A of the last modes
    real(dp) :: kept = 1.0_dp                     !! what damping has left of the last mode's amplitude
    type(tip_remainder) :: remainder
  end type running_sum

contains

  subroutine find_tip_remainder(source, force, first, time, bound, remainder, highest, monitor)
    !! Find the remainder by summing more and more modes, until its uncertainty is within a bound, or all modes there are, or
    !! 10⁷, or those that are found quickly, or `highest`, have been summed. Roots are solved in extended precision where
    !! phases call for it, but not because a scene asks for that in every root: the terms fall as k⁻².
    class(mode_source), intent(in) :: source      !! of beam and mass, γ > 0
    real(dp), intent(in) :: force                 !! (1+e)γ: modal velocities at t = 0 are this times Φ_k(1)/M_k
    integer, intent(in) :: first                  !! n; every growing mode is among the first n
    type(dd), intent(in) :: time                  !! of the instant, l²/h
    real(dp), intent(in) :: bound                 !! of the velocity, V
    type(tip_remainder), intent(out) :: remainder
    integer, intent(in), optional :: highest      !! > n; no mode beyond it is looked at
    class(monitor_type), intent(inout), optional :: monitor   !! what is found means nothing where it asks to stop
    type(running_sum) :: sum
    integer :: last, most, next
    most = min(most_terms, source%highest, max(source%quickly, first))
    if (present(highest)) most = min(most, highest)
    last = min(first, most)
    call add_modes(source, force, 1, last, time, .false., sum, monitor)
    do
      if (stops(monitor)) exit
      sum%remainder%uncertainty = uncertainty_of(sum, force/source%gamma, last, time, source%quadratic)
      if (last == most .or. (last > first .and. sum%remainder%uncertainty <= bound)) exit
      next = next_count(last, most, sum%remainder%uncertainty, bound)
      call add_modes(source, force, last + 1, next, time, .true., sum, monitor)
      last = next
    end do
    remainder = sum%remainder
    remainder%count = last
    remainder%energy = remainder%energy + 0.5_dp*force*max(0.0_dp, force/source%gamma - sum%started)*sum%kept**2
  end subroutine find_tip_remainder

  pure integer function next_count(last, most, uncertainty, bound) result(next)
    !! Twice the modes, or as many as a sum of random phases then takes.
    integer, intent(in) :: last, most             !! modes that were summed, and all
    real(dp), intent(in) :: uncertainty, bound    !! reached, and wanted
    real(dp) :: times
    times = 2.0_dp
    if (bound > 0.0_dp) times = min(times, 1.05_dp*max(1.0_dp, uncertainty/bound)**(2.0_dp/3.0_dp))
    next = int(min(real(most, dp), last*times + chunk))
  end function next_count

  pure real(dp) function uncertainty_of(sum, total, last, time, quadratic) result(most)
    !! How far the velocity by the modes that are left out may go at that instant (bw_coherence). With ΣA² as of terms that
    !! fall as k⁻²; it is at most three times as large, of those of a light mass up to twice.
    type(running_sum), intent(in) :: sum
    real(dp), intent(in) :: total                 !! ΣA of all modes
    integer, intent(in) :: last                   !! mode that was summed
    type(dd), intent(in) :: time
    logical, intent(in) :: quadratic              !! phases are quadratic in the mode's number
    type(deviation_type) :: sums
    real(dp) :: left
    left = max(0.0_dp, total - sum%started)
    sums = deviation_type(magnitude=left*sum%kept, largest=min(sum%last, left)*sum%kept, passing=huge(1.0_dp), alpha=pi*last)
    sums%square = sums%magnitude*sums%largest/merge(3.0_dp, 1.0_dp, quadratic)
    most = largest(sums, from_tip(1.0_dp), stretch_type(time%hi, 2.0_dp*time%hi, time%hi), quadratic)
  end function uncertainty_of

  subroutine add_modes(source, force, first, last, time, beyond, sum, monitor)
    !! Add modes `first` … `last` to the sum, a chunk at a time.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    integer, intent(in) :: first, last
    type(dd), intent(in) :: time
    logical, intent(in) :: beyond                 !! they are not among the first n
    type(running_sum), intent(inout) :: sum
    class(monitor_type), intent(inout), optional :: monitor
    integer :: i, k
    do k = first, last, chunk
      if (stops(monitor)) return
      if (allocated(source%damping)) then
        call add_damped(source, force, [(i, i=k, min(k + chunk - 1, last))], time, beyond, sum)
      else
        call add_undamped(source, force, [(i, i=k, min(k + chunk - 1, last))], time, beyond, sum)
      end if
    end do
  end subroutine add_modes

  subroutine add_undamped(source, force, number, time, beyond, sum)
    !! They keep their energy, ½M(force Φ(1)/M)² = ½ force A.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    integer, intent(in) :: number(:)
    type(dd), intent(in) :: time
    logical, intent(in) :: beyond
    type(running_sum), intent(inout) :: sum
    type(dd) :: beta(size(number))
    real(dp), dimension(size(number)) :: angle, drive, term
    real(dp) :: tip(size(number), 1)
    call source%terms(number, [source%struck_at], min(1.0_dp, source%stretch)*time%hi, beta, drive, tip)
    term = force*drive*tip(:, 1)
    call take_terms(term, sum)
    sum%remainder%energy = sum%remainder%energy + 0.5_dp*force*accurate_sum(term)
    if (.not. beyond) return
    angle = phase_angles(beta*(time/(dd_pi*2.0_dp)), 1)
    call take_motion(sin(angle)*(term/beta%hi), cos(angle)*term, sum)
  end subroutine add_undamped

  subroutine add_damped(source, force, number, time, beyond, sum)
    !! Modes that lose energy: what is left of each at that time.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    integer, intent(in) :: number(:)
    type(dd), intent(in) :: time
    logical, intent(in) :: beyond
    type(running_sum), intent(inout) :: sum
    class(mode_set), allocatable :: modes
    real(dp), dimension(size(number)) :: q, rate
    type(energy_type) :: energy
    type(dd) :: slow
    integer :: n
    n = size(number)
    call source%find(number, modes, min(1.0_dp, source%stretch)*time%hi)
    q = 0.0_dp
    rate = force*modes%struck/modes%modal_mass
    call take_terms(modes%struck*rate, sum)
    energy = state_energy(modes, q, rate)
    call move_with_energy(modes, time, q, rate, energy)
    if (beyond) call take_motion(modes%struck*q, modes%struck*rate, sum)
    sum%remainder%energy = sum%remainder%energy + energy%value
    slow = slow_exponent(modes%beta_squared(n), modes%damping(n))
    sum%kept = exp(slow%hi*time%hi)
  end subroutine add_damped

  pure subroutine take_terms(term, sum)
    !! Add the terms A, and remember the last of them.
    real(dp), intent(in) :: term(:)               !! A, (modes)
    type(running_sum), intent(inout) :: sum
    sum%started = sum%started + accurate_sum(term)
    sum%last = maxval(term(max(1, size(term) - neighbours):))
  end subroutine take_terms

  pure subroutine take_motion(displacement, velocity, sum)
    !! Add what modes that are not among the first n move at the tip.
    real(dp), intent(in) :: displacement(:), velocity(:)   !! of the tip, (modes)
    type(running_sum), intent(inout) :: sum
    sum%remainder%displacement = sum%remainder%displacement + accurate_sum(displacement)
    sum%remainder%velocity = sum%remainder%velocity + accurate_sum(velocity)
  end subroutine take_motion

end module bw_tip_remainder
