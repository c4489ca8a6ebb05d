module bw_tail
  !! Sums over the modes of a struck beam that are not summed: how far they move, without their phases.
  !!
  !! Were the phases random, the largest value of N samples would hardly ever be above √(½ΣA²)·√(2 ln 2N). But they are nearly
  !! quadratic in k: near times τ of which πτ/2 is a fraction of small numbers many of them agree again, as in theta sums,
  !! whose values above x times the mean square's root are as rare as x⁻⁴ (J. Marklof, 1999), so that N samples find one of
  !! about N^(1/4). The estimate is the smaller of Σ|A| and the larger of these two with their factors. The sums run over
  !! windows of mode numbers that double in length, each sampled by runs of neighbouring modes, since the shapes at a point
  !! repeat every few modes.
  !!
  !! **Empirical**: `safety`, `revival`, and the sampling; test_bw_truncation shows what they are worth.
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_modal_flow, only: slow_exponent
  use bw_mode_set, only: mode_set, mode_source
  use bw_reach, only: damped_reach, stretch_type, turns, undamped_reaches
  implicit none (type, external)
  private
  public :: add_modes, add_tail, largest, sampled

  real(dp), parameter :: safety = 2.5_dp          !! empirical: of the phases as if they were random
  real(dp), parameter :: revival = 2.0_dp         !! empirical: of N^(1/4); from 500 samples on it is the larger one
  integer, parameter :: runs = 4, run_length = 16 !! sampled modes of a window
  integer, parameter :: part = 1024               !! modes whose shapes are held at a time
  real(dp), parameter, public :: negligible = 1.0e-3_dp   !! a window that adds less than this ends the sum
  real(dp), parameter :: unseen = 0.1_dp
    !! of what damped modes add: runs see 0.07 too little of a window in which amplitudes fall as k⁻⁶, and modes that creep back
    !! all have one sign, so that nothing of their sum is to spare

  type, public :: deviation_type
    !! Of one point: the sums from which the estimates are made.
    real(dp) :: magnitude = 0.0_dp                !! Σ|A|
    real(dp) :: square = 0.0_dp                   !! ΣA²
    real(dp) :: growing = 0.0_dp                  !! the largest value of what grows, or creeps back
  end type deviation_type

contains

  elemental real(dp) function largest(sums, samples, coherence) result(error)
    !! The estimate that follows from the sums of one point.
    type(deviation_type), intent(in) :: sums
    integer, intent(in) :: samples
    real(dp), intent(in), optional :: coherence     !! at least so many times the mean square's root
    real(dp) :: times                               ! of the mean square's root
    times = max(safety*sqrt(2.0_dp*log(2.0_dp*max(2, samples))), revival*sqrt(sqrt(real(samples, dp))))
    if (present(coherence)) times = max(times, coherence)
    error = sums%growing + min(sums%magnitude, times*sqrt(0.5_dp*sums%square))
  end function largest

  subroutine add_tail(count, source, force, points, stretch, velocity, sums, shown)
    !! The continuum's modes from `count` + 1 on.
    integer, intent(in) :: count
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    real(dp), intent(in) :: points(:)
    type(stretch_type), intent(in) :: stretch
    logical, intent(in) :: velocity
    type(deviation_type), intent(inout) :: sums(:)
    class(mode_source), intent(in), optional :: shown   !! modes that they have turned into, number by number
    type(deviation_type) :: before(size(points))
    integer :: first, last
    if (source%gamma == 0.0_dp .or. force == 0.0_dp) return
    first = count + 1
    do while (first <= source%highest)
      last = window_end(first, source, stretch%start)
      before = sums
      call add_window(source, force, sampled(first, last), last - first + 1, points, stretch, velocity, sums, shown)
      if (allocated(source%damping)) call add_unseen(before, sums)
      if (source%gamma*first > 1.0_dp .and. all(sums%square - before%square <= negligible*sums%square) .and. &
          all(sums%growing - before%growing <= negligible*sums%growing) .and. &
          (velocity .or. all(sums%magnitude - before%magnitude <= negligible*sums%magnitude))) exit
      first = last + 1
    end do
    if (source%decay > 0.0_dp .and. first > source%highest) then
      call extrapolate(source, force, points, stretch, velocity, sums, shown)
    end if
  end subroutine add_tail

  elemental subroutine add_unseen(before, sums)
    !! What the runs of a window may not have seen, unless signs make up for it.
    type(deviation_type), intent(in) :: before    !! the sums without this window
    type(deviation_type), intent(inout) :: sums
    sums%magnitude = sums%magnitude + unseen*(sums%magnitude - before%magnitude)
    sums%growing = sums%growing + unseen*(sums%growing - before%growing)
  end subroutine add_unseen

  integer function window_end(first, source, elapsed) result(last)
    !! Twice the first mode, or where damping has left much less of the last mode than of the first, no further than all modes
    !! are looked at: a few runs of them would not see where the others end.
    integer, intent(in) :: first
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: elapsed               !! since all modes began
    real(dp), parameter :: steepest = 0.5_dp      ! nepers
    real(dp), parameter :: nothing = 60.0_dp      ! nepers, of which nothing is left: windows may be as wide as they like
    class(mode_set), allocatable :: ends
    type(dd) :: exponent(2)
    last = min(2*max(first, run_length), source%highest)
    if (.not. allocated(source%damping)) return
    do while (last - first >= 2*runs*run_length)
      call source%find([first, last], ends)
      exponent = slow_exponent(ends%beta_squared, ends%damping)
      if (abs(exponent(1)%hi - exponent(2)%hi)*elapsed <= steepest .or. -exponent(1)%hi*elapsed > nothing) exit
      last = first + (last - first)/2
    end do
  end function window_end

  subroutine add_window(source, force, number, window, points, stretch, velocity, sums, shown)
    !! Modes that stand for a window of so many: of undamped ones no more is found than is needed.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    integer, intent(in) :: number(:), window
    real(dp), intent(in) :: points(:)
    type(stretch_type), intent(in) :: stretch
    logical, intent(in) :: velocity
    type(deviation_type), intent(inout) :: sums(:)
    class(mode_source), intent(in), optional :: shown
    class(mode_set), allocatable :: modes, others
    type(dd) :: beta(size(number))
    real(dp) :: drive(size(number)), shapes(size(number), size(points)), weight
    weight = real(window, dp)/size(number)
    if (present(shown)) then
      call source%find(number, modes)
      call shown%find(number, others)
      call add_modes(others, force*modes%tip/modes%modal_mass, points, stretch, velocity, weight, sums)
    else if (allocated(source%damping)) then
      call source%find(number, modes)
      call add_modes(modes, force*modes%tip/modes%modal_mass, points, stretch, velocity, weight, sums)
    else
      call source%terms(number, points, beta=beta, drive=drive, shapes=shapes)
      call add_amplitudes(force*drive, shapes, beta%hi > 0.0_dp, undamped_reaches(beta%hi, stretch%end, velocity), weight, &
                          sums)
    end if
  end subroutine add_window

  subroutine extrapolate(source, force, points, stretch, velocity, sums, shown)
    !! The modes beyond the highest that can be found, as the last octave of those tells. Velocities fall as 1/k, whose
    !! sum has no bound: their magnitudes then say nothing.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    real(dp), intent(in) :: points(:)
    type(stretch_type), intent(in) :: stretch
    logical, intent(in) :: velocity
    type(deviation_type), intent(inout) :: sums(:)
    class(mode_source), intent(in), optional :: shown
    real(dp), parameter :: no_bound = 1.0e3_dp
    type(deviation_type) :: octave(size(points))
    real(dp) :: decay
    integer :: k, first
    first = source%highest/2 + 1
    call add_window(source, force, [(k, k=first, source%highest)], source%highest - first + 1, points, stretch, velocity, &
                    octave, shown)
    decay = merge(1.0_dp, source%decay, velocity)
    sums%square = sums%square + octave%square/(2.0_dp**(2.0_dp*decay - 1.0_dp) - 1.0_dp)
    if (velocity) then
      sums%magnitude = sums%magnitude + no_bound*octave%magnitude
    else
      sums%magnitude = sums%magnitude + octave%magnitude/(2.0_dp**(decay - 1.0_dp) - 1.0_dp)
    end if
  end subroutine extrapolate

  pure function sampled(first, last) result(number)
    !! All mode numbers of a short window, runs of neighbours of a long one.
    integer, intent(in) :: first, last
    integer, allocatable :: number(:)
    integer :: i, k, gap
    if (last - first + 1 <= 2*runs*run_length) then
      number = [(k, k=first, last)]
    else
      gap = (last - first + 1)/runs
      number = [((first + i*gap + (gap - run_length)/2 + k, k=0, run_length - 1), i=0, runs - 1)]
    end if
  end function sampled

  pure subroutine add_modes(modes, rate, points, stretch, velocity, weight, sums)
    !! Amplitudes of modes that start with velocity `rate`; each stands for `weight` modes.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: rate(:)               !! (modes)
    real(dp), intent(in) :: points(:)
    type(stretch_type), intent(in) :: stretch
    logical, intent(in) :: velocity
    real(dp), intent(in) :: weight
    type(deviation_type), intent(inout) :: sums(:)
    real(dp) :: reach(part)
    logical :: stable(part)
    integer :: first, last, n
    do first = 1, modes%count, part
      last = min(first + part - 1, modes%count)
      n = last - first + 1
      associate (square => modes%beta_squared(first:last))
        if (allocated(modes%damping)) then
          stable(:n) = turns(square, modes%damping(first:last))
          reach(:n) = damped_reach(square, modes%damping(first:last), stretch, velocity)
        else
          stable(:n) = square%hi > 0.0_dp
          reach(:n) = undamped_reaches(sign(sqrt(abs(square%hi)), square%hi), stretch%end, velocity)
        end if
      end associate
      call add_amplitudes(rate(first:last), modes%some_shapes(first, last, points), stable(:n), reach(:n), weight, sums)
    end do
  end subroutine add_modes

  pure subroutine add_amplitudes(rate, shapes, stable, reach, weight, sums)
    real(dp), intent(in) :: rate(:), shapes(:, :)
    logical, intent(in) :: stable(:)
    real(dp), intent(in) :: reach(:)              !! how far the mode goes that starts with velocity 1
    real(dp), intent(in) :: weight
    type(deviation_type), intent(inout) :: sums(:)
    real(dp) :: amplitude, total(3)
    integer :: k, p
    do p = 1, size(sums)
      total = 0.0_dp
      do k = 1, size(rate)
        amplitude = abs(rate(k)*shapes(k, p))*reach(k)
        if (stable(k)) then
          total(1) = total(1) + amplitude
          total(2) = total(2) + amplitude**2
        else
          total(3) = total(3) + amplitude
        end if
      end do
      sums(p)%magnitude = sums(p)%magnitude + weight*total(1)
      sums(p)%square = sums(p)%square + weight*total(2)
      sums(p)%growing = sums(p)%growing + weight*total(3)
    end do
  end subroutine add_amplitudes

end module bw_tail
