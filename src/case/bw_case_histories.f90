module bw_case_histories
  !! The histories of a case, segment by segment, by the modes that the scene counts or that its tolerance needs. The
  !! last two octaves of a segment's modes estimate the truncation error, so they are also summed apart. In a short
  !! record this covers all samples, and the history is the sum of the parts. In a long record it covers evenly spaced
  !! samples, and as many after the first, before waves disperse.
  use bw_segment_samples, only: samples_of_segment
  use bw_case_notes, only: note_failure, out_of_reach
  use bw_case_result, only: block_type, case_diverged, case_histories, case_motion, case_not_converged
  use bw_double_double, only: operator(*), operator(-)
  use bw_kinds, only: dp
  use bw_loaded_sum, only: find_loaded_motion
  use bw_missing, only: scaled
  use bw_mode_set, only: configuration_type, curvatures, deflections, first_failure, turns, values_at
  use bw_monitor, only: monitor_type, part_monitor
  use bw_nonuniform_sum, only: nonuniform_sum
  use bw_response, only: fill_unknown, finish_histories, response_type, sampling_type, start_histories
  use bw_scene, only: scene_type, unit_velocity
  use bw_segment, only: leaves_range, move, segment_type
  use bw_set_sum, only: add_motion
  use bw_streamed_modes, only: add_modes_of_source
  use bw_sum_choice, only: sum_tolerance
  use bw_text, only: append, shortest, text_of
  use bw_time_grid, only: time_grid, time_grid_of
  use bw_truncation_error, only: block_ends, fewest
  implicit none (type, external)
  private
  public :: add_hub_angle, find_loaded_segments, samples_before, sum_histories

  integer, parameter :: long = 2**14        !! tuned: samples up to which summing in parts costs hardly more
  integer, parameter :: looked_at = 1024 !! samples for the octaves of a long record: evenly spaced, and as many after the first

contains

  subroutine sum_histories(scene, motion, quantity, monitor, histories)
    !! Sum the histories. They are fill if modes are not resolved or not found, or the tolerance is out of reach, and
    !! from an overflow on.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: quantity                      !! deflections, curvatures or turns (bw_mode_set)
    class(monitor_type), intent(inout), target :: monitor   !! the histories are invalid if it requests a stop
    type(case_histories), intent(out) :: histories
    type(sampling_type) :: sampling
    logical :: known
    if (.not. motion%modes%resolved) histories%status = case_not_converged
    if (.not. allocated(scene%response)) return
    sampling = sampling_of(scene, motion, quantity)
    allocate (histories%response)
    known = motion%modes%resolved
    if (known .and. .not. motion%plan%within) then
      histories%status = case_not_converged
      call append(histories%notes, 'tolerance: '//out_of_reach(scene, motion)//'; the histories are missing')
      known = .false.
    end if
    if (known) then
      call sum_segments(scene, motion, sampling, monitor, histories)
      if (monitor%stop_requested()) return
      if (histories%response%failing_mode > 0) call note_overflow(scene, histories)
      associate (failure => first_failure(motion%modes%configuration))
        known = failure%first == 0
        if (.not. known .and. histories%status /= case_not_converged) then
          histories%status = case_not_converged
          call note_failure(failure, 'the histories are missing', histories%notes)
        end if
      end associate
    end if
    if (known) return
    call start_histories(sampling, histories%response)
    histories%response%finite_samples = 0
    call fill_unknown(histories%response)
  end subroutine sum_histories

  type(sampling_type) function sampling_of(scene, motion, quantity) result(sampling)
    !! Describe the samples of the whole record.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: quantity
    sampling%points = scene%response%points
    sampling%grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    sampling%unit_time = motion%units%time%hi
    sampling%velocity = scene%response%velocity .and. quantity == deflections
    sampling%quantity = quantity
  end function sampling_of

  subroutine add_hub_angle(scene, motion, monitor, response)
    !! Add the rotation of a free hub to the histories: the same sum over the same modes.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    class(monitor_type), intent(inout), target :: monitor   !! the turn is invalid if it requests a stop
    type(response_type), intent(inout) :: response
    type(case_histories) :: found
    if (.not. allocated(scene%hub)) return
    call sum_histories(scene, motion, turns, monitor, found)
    if (monitor%stop_requested()) return
    response%hub_angle = scaled(found%response%displacement(:, 1), 1.0_dp/motion%units%length)
  end subroutine add_hub_angle

  subroutine find_loaded_segments(scene, motion, monitor)
    !! Find the histories of all segments with a load, for all quantities. Call this before histories are summed.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    class(monitor_type), intent(inout) :: monitor         !! results are invalid if it requests a stop
    type(sampling_type) :: sampling
    integer :: i, samples(2)
    sampling = sampling_of(scene, motion, deflections)
    do i = 1, size(motion%timeline%segments)
      associate (segment => motion%timeline%segments(i))
        if (.not. allocated(segment%load)) cycle
        samples = samples_of_segment(motion, i, sampling%grid)
        samples(2) = min(samples(2), samples_before(motion%timeline%known_until, sampling%grid))
        if (samples(1) > samples(2)) cycle
        call find_loaded_motion(motion%modes%configuration(segment%configuration)%set, &
                                motion%ladder(:, segment%configuration), sampling, samples, &
                                scene%response%bending_moment, monitor, segment)
        if (monitor%stop_requested()) return
      end associate
    end do
  end subroutine find_loaded_segments

  subroutine note_overflow(scene, histories)
    type(scene_type), intent(in) :: scene
    type(case_histories), intent(inout) :: histories
    histories%status = case_diverged
    call append(histories%notes, 'overflow: mode '//text_of(histories%response%failing_mode)//' overflows at t = '// &
      shortest(histories%response%finite_samples*(scene%response%duration/scene%response%samples), 6)// &
      ' s; the histories are missing from there on')
  end subroutine note_overflow

  subroutine sum_segments(scene, motion, sampling, monitor, histories)
    !! Sum all segments in order, up to the time until which contacts are known. Returns early on a requested stop.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(sampling_type), intent(in) :: sampling          !! of the whole record
    class(monitor_type), intent(inout), target :: monitor
    type(case_histories), intent(inout) :: histories
    type(part_monitor) :: share
    type(response_type) :: part
    integer :: i, samples(2)
    call start_histories(sampling, histories%response)
    associate (response => histories%response, segments => motion%timeline%segments, grid => sampling%grid)
      allocate (histories%blocks(size(segments)))
      response%finite_samples = samples_before(motion%timeline%known_until, grid)
      do i = 1, size(segments)
        samples = samples_of_segment(motion, i, grid)
        samples(2) = min(samples(2), response%finite_samples)
        if (samples(1) > samples(2) .or. response%failing_mode > 0) cycle
        share = part_monitor(monitor, (samples(1) - 1.0_dp)/grid%samples, (samples(2) - samples(1) + 1.0_dp)/grid%samples)
        call sum_segment(scene, motion, segments(i), motion%modes%configuration(segments(i)%configuration), sampling, samples, &
                         share, part, histories%blocks(i))
        if (monitor%stop_requested()) return
        call take_samples(part, samples, response)
      end do
      call fill_unknown(response)
      if (any(segments%handed > 0)) response%sum_error = max(response%sum_error, sum_tolerance)
    end associate
  end subroutine sum_segments

  pure integer function samples_before(time, grid) result(samples)
    !! Count the samples before a time.
    real(dp), intent(in) :: time                  !! l²/h
    type(time_grid), intent(in) :: grid
    samples = grid%samples
    if (time >= samples*grid%step%hi) return
    samples = int(max(0.0_dp, time)/grid%step%hi) + 1
    if ((samples - 1)*grid%step%hi >= time) samples = samples - 1
  end function samples_before

  subroutine sum_segment(scene, motion, segment, configuration, sampling, samples, monitor, part, block)
    !! Sum the histories of a segment from its state at its first sample, and find the largest values of its last two octaves.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(segment_type), intent(in) :: segment
    type(configuration_type), intent(in) :: configuration    !! whose modes move in the segment
    type(sampling_type), intent(in) :: sampling          !! of the whole record
    integer, intent(in) :: samples(2)                    !! the first and the last of the segment
    class(monitor_type), intent(inout), target :: monitor
    type(response_type), intent(out) :: part             !! of these samples
    type(block_type), intent(out) :: block
    type(nonuniform_sum) :: workspace(3)                 ! of all samples, of those after the first, and of evenly spaced ones
    type(sampling_type) :: own
    type(segment_type) :: moved
    real(dp) :: unit                                     ! m of displacements in V l²/h
    integer :: ends(3)
    own = sampling
    own%grid = time_grid(samples(2) - samples(1) + 1, sampling%grid%step)
    call start_histories(own, part)
    unit = unit_velocity(scene)*motion%units%time%hi
    if (allocated(segment%load)) then
      select case (own%quantity)
      case (turns)
        part%displacement = spread(unit*segment%load%hub_turn, 2, size(own%points))
      case (curvatures)
        part%displacement = unit*segment%load%curvature
      case default
        part%displacement = unit*segment%load%displacement
        if (own%velocity) part%velocity = unit*segment%load%velocity
      end select
      if (allocated(segment%shape)) call add_shape(motion, segment, own, unit, part)
      call finish_histories(part)
      return
    end if
    call move_to_sample(segment, configuration, sampling%grid, samples(1), moved, part)
    if (part%failing_mode > 0) return
    moved%force = moved%force*unit
    if (allocated(moved%rate)) moved%rate = moved%rate*unit
    if (allocated(moved%rate)) moved%q = moved%q*unit
    allocate (block%value(size(own%points), 2), block%rate(size(own%points), 2), source=0.0_dp)
    ends = block_ends(segment%count)
    if (segment%count < fewest .or. (allocated(segment%rate) .and. .not. allocated(segment%lack))) ends = segment%count
    if (own%grid%samples <= long) then
      call add_modes(1, ends(1), workspace(1), part)
      call add_octaves(own%grid, workspace(1), part)
    else
      call add_modes(1, segment%count, workspace(1), part)
      call add_octaves(time_grid(looked_at, own%grid%step), workspace(2))
      call add_octaves(every_nth(own%grid), workspace(3))
    end if
    if (allocated(segment%rest)) part%displacement = part%displacement + spread(unit*matmul(segment%rest, &
      values_at(configuration%set, own%quantity, 1, segment%count, own%points)), 1, own%grid%samples)
    if (allocated(segment%shape)) call add_shape(motion, segment, own, unit, part)
    call finish_histories(part)
    block%rate = block%rate/own%unit_time
  contains
    subroutine add_octaves(grid, workspace, sums)
      !! Find the largest values of each octave on a grid that starts at the segment's first sample.
      type(time_grid), intent(in) :: grid
      type(nonuniform_sum), intent(inout) :: workspace
      type(response_type), intent(inout), optional :: sums   !! octaves are added to these
      type(sampling_type) :: seen
      type(response_type) :: octave
      integer :: b
      seen = own
      seen%grid = grid
      do b = 1, 2
        if (ends(b) == ends(b + 1)) return
        if (monitor%stop_requested()) return
        call start_histories(seen, octave)
        call add_modes(ends(b) + 1, ends(b + 1), workspace, octave)
        call find_largest(octave, merge(2, 1, samples(1) == 1), block%value(:, b), block%rate(:, b))
        if (present(sums)) call add_sums(octave, sums)
      end do
    end subroutine add_octaves

    subroutine add_modes(first, last, workspace, response)
      !! Add the modes `first` to `last`.
      integer, intent(in) :: first, last
      type(nonuniform_sum), intent(inout) :: workspace
      type(response_type), intent(inout) :: response
      type(part_monitor) :: share
      if (first > last) return
      share = part_monitor(monitor, 1.0_dp, 0.0_dp)      ! of few samples
      if (response%sampling%grid%samples == own%grid%samples) &
        share = part_monitor(monitor, (first - 1.0_dp)/segment%count, (last - first + 1.0_dp)/segment%count)
      if (allocated(moved%rate)) then
        call add_motion(configuration%set, moved%rate, share, response, displaced=moved%q, workspace=workspace, range=[first, last])
      else
        call add_modes_of_source(configuration%source, moved%force, first, last, share, response, workspace)
      end if
    end subroutine add_modes
  end subroutine sum_segment

  subroutine add_shape(motion, segment, sampling, unit, part)
    !! Add the equilibrium about which a segment moves.
    type(case_motion), intent(in) :: motion
    type(segment_type), intent(in) :: segment
    type(sampling_type), intent(in) :: sampling
    real(dp), intent(in) :: unit                         !! m of displacements without dimensions
    type(response_type), intent(inout) :: part
    real(dp) :: held(size(sampling%points))
    integer :: i
    held = 0.0_dp
    do i = 1, size(segment%shape)
      associate (term => segment%shape(i))
        held = held + matmul(term%amplitude, values_at(motion%modes%configuration(term%configuration)%set, sampling%quantity, 1, &
                                                       size(term%amplitude), sampling%points))
      end associate
    end do
    part%displacement = part%displacement + spread(unit*held, 1, size(part%displacement, 1))
  end subroutine add_shape

  pure subroutine move_to_sample(segment, configuration, grid, sample, moved, part)
    !! Move the state of a segment to a sample. The part fails if a growing mode has overflowed by then.
    type(segment_type), intent(in) :: segment
    type(configuration_type), intent(in) :: configuration
    type(time_grid), intent(in) :: grid                  !! of the whole record
    integer, intent(in) :: sample                        !! from 1
    type(segment_type), intent(out) :: moved
    type(response_type), intent(inout) :: part
    moved%force = segment%force
    if (.not. allocated(segment%rate)) return
    associate (elapsed => grid%step*real(sample - 1, dp) - segment%start)
      if (leaves_range(configuration%set, elapsed)) then
        part%failing_mode = 1
        part%finite_samples = 0
        return
      end if
      moved%rate = segment%rate
      moved%q = 0.0_dp*moved%rate
      if (allocated(segment%q)) moved%q = segment%q
      call move(configuration%set, elapsed, moved%q, moved%rate)
    end associate
  end subroutine move_to_sample

  pure type(time_grid) function every_nth(grid) result(coarse)
    !! Return a grid of at most `looked_at` samples, every 2ⁿ-th of the given one. Waves meet at simple fractions of the
    !! beam's time; such a step samples these instants again.
    type(time_grid), intent(in) :: grid
    integer :: stride
    stride = 1
    do while (grid%samples > looked_at*stride)
      stride = 2*stride
    end do
    coarse = time_grid((grid%samples - 1)/stride + 1, grid%step*real(stride, dp))
  end function every_nth

  pure subroutine find_largest(octave, first, value, rate)
    !! Raise the largest values at each point to those of an octave of modes.
    type(response_type), intent(in) :: octave
    integer, intent(in) :: first                         !! first sample considered, which is not that of the impact
    real(dp), intent(inout) :: value(:), rate(:)         !! (points)
    integer :: n
    n = octave%finite_samples
    value = max(value, maxval(abs(octave%displacement(first:n, :)), 1))
    if (allocated(octave%velocity)) rate = max(rate, maxval(abs(octave%velocity(first:n, :)), 1))
  end subroutine find_largest

  pure subroutine add_sums(octave, part)
    !! Add an octave of modes to the others.
    type(response_type), intent(in) :: octave
    type(response_type), intent(inout) :: part
    part%displacement = part%displacement + octave%displacement
    if (allocated(part%velocity)) part%velocity = part%velocity + octave%velocity
    part%sum_error = max(part%sum_error, octave%sum_error)
    part%transformed = part%transformed + octave%transformed
    part%mode_seconds = part%mode_seconds + octave%mode_seconds
    if (octave%finite_samples >= part%finite_samples) return
    part%finite_samples = octave%finite_samples
    part%failing_mode = octave%failing_mode
  end subroutine add_sums

  subroutine take_samples(part, samples, whole)
    !! Put the histories of some samples into those of all. If they are all, nothing is copied.
    type(response_type), intent(inout) :: part
    integer, intent(in) :: samples(2)
    type(response_type), intent(inout) :: whole
    if (samples(2) - samples(1) + 1 == whole%sampling%grid%samples) then
      call move_alloc(part%displacement, whole%displacement)
      call move_alloc(part%velocity, whole%velocity)
    else
      whole%displacement(samples(1):samples(2), :) = part%displacement
      if (allocated(whole%velocity)) whole%velocity(samples(1):samples(2), :) = part%velocity
    end if
    whole%sum_error = max(whole%sum_error, part%sum_error)
    whole%transformed = whole%transformed + part%transformed
    whole%mode_seconds = whole%mode_seconds + part%mode_seconds
    if (part%failing_mode == 0) return
    whole%failing_mode = part%failing_mode
    whole%finite_samples = samples(1) - 1 + part%finite_samples
  end subroutine take_samples

end module bw_case_histories
