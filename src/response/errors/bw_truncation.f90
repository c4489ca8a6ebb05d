module bw_truncation
  !! How far a sum of n modes is from the answer of infinitely many, before any of the others is summed.
  !!
  !! What is missing is a sum of sines with the amplitudes A of the modes from n + 1 on, and of the differences that a
  !! finite number of modes before the capture leaves in the first n. The estimate is that of bw_coherence.
  !!
  !! Damped modes enter with the amplitude that is left of them at the start of stretches of the history; those that do not
  !! turn add up as what grows does, without a sign. At the first samples, where damping leaves a few modes to decide, these
  !! are summed as they are.
  !!
  !! Velocities are sums of cosines, whose phases all agree at t = 0; there the error is known (`with_start`).
  use bw_coherence, only: combined, deviation_type, largest, observation_type, path_to, stretch_type
  use bw_double_double, only: to_dd
  use bw_kinds, only: dp
  use bw_mode_set, only: first_numbers, mode_set, mode_source
  use bw_segment, only: move
  use bw_tail, only: add_modes, add_tail
  implicit none (type, external)
  private
  public :: truncation_error, tail_error, with_start

  integer, parameter :: summed = 256              !! modes of the tail, at the first samples of damped motions
  integer, parameter :: stretches_summed = 2      !! the first: samples 1 to 3

contains

  function truncation_error(modes, lacking, source, force, seen) result(error)
    !! Estimates of the largest error over the samples of a history, (points).
    class(mode_set), intent(in) :: modes          !! the first n, that were summed
    real(dp), intent(in) :: lacking(:)            !! modal velocities less those of the continuum, (n)
    class(mode_source), intent(in) :: source      !! of these modes and the others
    real(dp), intent(in) :: force                 !! the continuum's modal velocities are force·Φ_k(1)/M_k
    type(observation_type), intent(in) :: seen    !! of `seen_from_blow`
    real(dp) :: error(size(seen%points))
    error = worst_stretch(modes%count, source, force, seen, modes, lacking)
  end function truncation_error

  function tail_error(count, source, force, seen) result(error)
    !! `truncation_error` where the first `count` modes are those of the continuum, (points).
    integer, intent(in) :: count
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    type(observation_type), intent(in) :: seen
    real(dp) :: error(size(seen%points))
    error = worst_stretch(count, source, force, seen)
  end function tail_error

  function worst_stretch(count, source, force, seen, modes, lacking) result(error)
    !! Of all stretches of the history, what the modes from `count` + 1 on, and what these lack, add up to, (points).
    integer, intent(in) :: count
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    type(observation_type), intent(in) :: seen
    class(mode_set), intent(in), optional :: modes
    real(dp), intent(in), optional :: lacking(:)  !! (modes)
    real(dp) :: error(size(seen%points))
    type(deviation_type), dimension(size(seen%points)) :: sums, lack
    type(stretch_type), allocatable :: stretches(:)
    type(observation_type) :: now
    real(dp) :: estimate(size(seen%points))
    integer :: i
    error = 0.0_dp
    now = seen
    stretches = stretches_of(source, seen%stretch)
    do i = 1, size(stretches)
      now%stretch = stretches(i)
      sums = deviation_type()
      lack = deviation_type()
      if (present(lacking)) call add_modes(modes, lacking, now, spread(1.0_dp, 1, modes%count), lack)
      call add_tail(count, source, force, now, sums)
      estimate = largest(combined(sums, lack), path_to(seen%points, source%struck_at, source%uniform, source%gamma), &
                         now%stretch, source%quadratic)
      if (allocated(source%damping) .and. .not. present(lacking) .and. i <= stretches_summed .and. i < size(stretches)) then
        estimate = min(estimate, largest_seen(count, source, force, now))
      end if
      error = max(error, estimate)
    end do
  end function worst_stretch

  function largest_seen(count, source, force, seen) result(largest_motion)
    !! What the modes from `count` + 1 on add at the samples of a stretch: the first of them with their signs, the others
    !! without, (points).
    integer, intent(in) :: count
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    type(observation_type), intent(in) :: seen
    real(dp), parameter :: rounding = 1.01_dp     ! and what else is small
    real(dp) :: largest_motion(size(seen%points))
    class(mode_set), allocatable :: modes
    type(deviation_type) :: others(size(seen%points))
    type(observation_type) :: left
    real(dp), dimension(min(summed, source%highest - count)) :: q, rate
    integer :: j
    largest_motion = 0.0_dp
    left = seen
    if (size(q) > 0) call source%find(count + first_numbers(size(q)), modes)
    do j = nint(seen%stretch%start/seen%stretch%step), nint(seen%stretch%end/seen%stretch%step) - 1
      left%stretch%start = j*seen%stretch%step
      others = deviation_type()
      call add_tail(count + size(q), source, force, left, others)
      associate (unsigned => others%magnitude + others%growing)
        if (size(q) == 0) then
          largest_motion = max(largest_motion, unsigned)
        else
          q = 0.0_dp
          rate = force*modes%struck/modes%modal_mass
          call move(modes, to_dd(left%stretch%start), q, rate)
          if (seen%velocity) q = rate
          largest_motion = max(largest_motion, rounding*abs(matmul(q, modes%shapes(seen%points))) + unsigned)
        end if
      end associate
    end do
  end function largest_seen

  pure function stretches_of(source, record) result(stretches)
    !! One for modes that keep their amplitudes. Damped ones are looked at over stretches of 1, 2, 4, … samples from
    !! the first after t = 0: at the start of each its modes have decayed so far.
    class(mode_source), intent(in) :: source
    type(stretch_type), intent(in) :: record
    type(stretch_type), allocatable :: stretches(:)
    integer :: first, samples
    samples = nint(record%end/record%step)
    stretches = [record]
    if (.not. allocated(source%damping) .or. samples < 2) return
    deallocate (stretches)
    allocate (stretches(0))
    first = 1
    do
      associate (step => record%step)
        stretches = [stretches, stretch_type(step*first, step*(first + min(first, samples - first)), step)]
      end associate
      if (first > samples/2) exit
      first = 2*first
    end do
  end function stretches_of

  elemental real(dp) function with_start(estimate, start, struck, jump) result(error)
    !! The estimate for a velocity, and no less than what its first sample lacks: of infinitely many modes the beam is at
    !! rest but for the place that the mass strikes.
    real(dp), intent(in) :: estimate        !! of `truncation_error` or `tail_error`
    real(dp), intent(in) :: start           !! the velocity at t = 0
    logical, intent(in) :: struck           !! the point is that place
    real(dp), intent(in) :: jump            !! of the velocity there, (1+e)V, in the same unit
    real(dp), parameter :: margin = 1.25_dp ! empirical: nearby the next samples still see some of that coherence
    error = max(estimate, margin*abs(start - merge(jump, 0.0_dp, struck)))
  end function with_start

end module bw_truncation
