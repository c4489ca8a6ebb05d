module bw_case_counts
  !! How many modes a tolerance takes, before any history is summed: of the first segment, and of later ones. A survey of the modes
  !! tells what those beyond any number may add; a preview of a few shows the peak that the tolerance is a part of.
  use bw_case_modes, only: case_mode_cache, extend_source, first_modes
  use bw_case_notes, only: most_modes, most_of, most_released
  use bw_case_result, only: case_motion
  use bw_double_double, only: dd, operator(*), operator(-)
  use bw_kinds, only: dp
  use bw_lack_error, only: find_lack, lack_error
  use bw_mode_set, only: configuration_type, deflections, first_numbers, mode_source
  use bw_mode_survey, only: mode_survey
  use bw_monitor, only: monitor_type, part_monitor
  use bw_projection, only: project, projection_type
  use bw_reach, only: stretch_type
  use bw_release, only: energy_after
  use bw_response, only: response_type, sampling_type, start_histories, sum_tolerance
  use bw_rotation, only: speed_in_plane
  use bw_scene, only: scene_type
  use bw_segment, only: segment_type, together
  use bw_set_sum, only: add_motion
  use bw_streamed_modes, only: add_modes_of_source
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  use bw_timeline, only: change_type, changes_of, happens
  use bw_truncation_error, only: displacement_error, find_tail, part_shown, tail_type
  implicit none (type, external)
  private
  public :: choose_first, choose_later, samples_of_segment, stretch_of

  integer, parameter :: previewed = 1000         !! samples that show the peak well enough to plan with it
  integer, parameter, public :: looked_ahead = 4096   !! modes up to whose number twice as many are surveyed as are summed
  integer, parameter :: most_previewed = 2**16   !! modes that are summed to see it
  real(dp), parameter :: seen_part_of_most = 0.1_dp   !! of the modes that are found quickly, after which errors fall as they go on
  real(dp), parameter :: near_enough = 1.02_dp   !! times the least count that keeps a tolerance
  real(dp), parameter :: doubt_share = 0.3_dp    !! of what is allowed, that the modes after a change may be in doubt by
  real(dp), parameter, public :: bound_times = 100.0_dp    !! a tolerance, that is proved

contains

  subroutine choose_first(scene, motion, segment, monitor, cache)
    !! Of the segment that begins at t = 0; it ends with the first change.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    type(segment_type), intent(inout) :: segment
    class(monitor_type), intent(inout), target :: monitor    !! the count means nothing where it asks to stop
    type(case_mode_cache), intent(inout), optional :: cache
    type(time_grid) :: grid
    integer :: samples
    segment%count = first_modes
    if (.not. allocated(motion%survey)) allocate (motion%survey(1 + size(changes_of(scene, motion%units))))
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    if (grid%samples == 1 .or. segment%force == 0.0_dp .or. scene%impact%approach_velocity == 0.0_dp) return
    associate (moving => motion%modes%configuration(segment%configuration))
      samples = samples_of_first(scene, motion, moving, grid)
      if (motion%survey(1)%bins == 0) then
        call motion%survey(1)%start(deflections, scene%response%points, stretch_of(grid, 2, samples, segment%start))
        call motion%survey(1)%add_source(moving%source, segment%force, 2*first_modes, monitor)
        if (monitor%stop_requested()) return
      end if
      call find_peak(scene, motion, segment, samples, monitor)
      if (monitor%stop_requested()) return
      if (samples == 1 .or. motion%peak == 0.0_dp) return
      call find_first_count(scene, motion, segment, samples, monitor, cache)
    end associate
  end subroutine choose_first

  pure integer function samples_of_first(scene, motion, moving, grid) result(samples)
    !! Before the first change; all where none comes.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(configuration_type), intent(in) :: moving
    type(time_grid), intent(in) :: grid
    type(change_type), allocatable :: changes(:)
    integer :: i
    samples = grid%samples
    changes = changes_of(scene, motion%units)
    do i = 1, size(changes)
      if (happens(changes(i), scene, changes(i)%time, moving%set)) samples = min(samples, first_sample(changes(i)%time, grid) - 1)
    end do
  end function samples_of_first

  pure type(stretch_type) function stretch_of(grid, first, last, start) result(stretch)
    !! Samples, numbered from 1, of a motion that starts at a time.
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: first, last
    type(dd), intent(in) :: start                !! l²/h
    stretch = stretch_type(max(0.0_dp, (first - 1)*grid%step%hi - start%hi), last*grid%step%hi - start%hi, grid%step%hi)
  end function stretch_of

  pure function samples_of_segment(motion, i, grid) result(samples)
    !! The first and the last of a segment, numbered from 1: a sample at exactly the time of a change belongs to what comes after it.
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: i
    type(time_grid), intent(in) :: grid
    integer :: samples(2)
    associate (segments => motion%timeline%segments)
      samples = [first_sample(segments(i)%start, grid), grid%samples]
      if (i < size(segments)) samples(2) = first_sample(segments(i + 1)%start, grid) - 1
    end associate
  end function samples_of_segment

  subroutine find_peak(scene, motion, segment, samples, monitor)
    !! The largest displacement as a few modes show it, V l²/h, less what others may take off it.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    type(segment_type), intent(in) :: segment
    integer, intent(in) :: samples               !! of the segment
    class(monitor_type), intent(inout), target :: monitor
    type(time_grid) :: grid
    type(projection_type), allocatable :: projection
    type(segment_type) :: next
    type(configuration_type) :: few
    type(change_type), allocatable :: changes(:)
    real(dp) :: missing, peak
    integer :: count, i
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    associate (survey => motion%survey(1), moving => motion%modes%configuration(segment%configuration))
      if (motion%seen_peak > 0.0_dp) motion%peak = motion%seen_peak
      if (motion%peak > 0.0_dp) return
      count = first_modes
      do while (samples > 1)
        peak = previewed_peak(scene, moving, segment, count, time_grid(samples, grid%step), motion%units%time%hi, monitor)
        if (monitor%stop_requested()) return
        missing = predicted(motion, segment, count, samples - 1)
        motion%peak = max(0.5_dp*peak, peak - missing)
        if (missing <= 0.5_dp*peak .or. 8*count > moving%source%highest .or. 4*count > most_previewed) exit
        count = 4*count                          ! what is missing is all that is seen: nothing has moved far yet
        call survey%add_source(moving%source, segment%force, 2*count, monitor)
      end do
      changes = changes_of(scene, motion%units)
      do i = 1, size(changes)
        if (samples == grid%samples) exit
        associate (after => motion%modes%configuration(changes(i)%configuration)%source)
          call after%find(first_numbers(min(first_modes, after%highest)), few%set, grid%samples*grid%step%hi)
        end associate
        if (allocated(projection)) deallocate (projection)
        allocate (projection)
        call project(segment, moving, changes(i)%time, grid%samples*grid%step%hi, 0, few%set, projection, monitor)
        if (monitor%stop_requested()) return
        next = segment_type(changes(i)%configuration, changes(i)%time, q=projection%q_after, rate=projection%rate_after)
        peak = previewed_peak(scene, few, next, few%set%count, time_grid(grid%samples - samples, grid%step), &
                              motion%units%time%hi, monitor)
        motion%peak = max(motion%peak, 0.5_dp*peak)
      end do
    end associate
  end subroutine find_peak

  real(dp) function previewed_peak(scene, configuration, segment, count, grid, unit_time, monitor) result(peak)
    !! The largest displacement of the first modes at some of the samples, V l²/h; at all of them where a mode grows, whose peak is at
    !! the end.
    type(scene_type), intent(in) :: scene
    type(configuration_type), intent(in) :: configuration
    type(segment_type), intent(in) :: segment
    integer, intent(in) :: count                 !! of the modes
    type(time_grid), intent(in) :: grid          !! of the segment
    real(dp), intent(in) :: unit_time            !! s
    class(monitor_type), intent(inout), target :: monitor
    type(response_type) :: response
    type(part_monitor) :: part
    integer :: stride
    stride = (grid%samples - 1)/previewed + 1
    if (any(configuration%set%beta_squared%hi <= 0.0_dp)) stride = 1
    part = part_monitor(monitor, share=0.0_dp)
    call start_histories(sampling_type(scene%response%points, time_grid((grid%samples - 1)/stride + 1, &
                                       grid%step*real(stride, dp)), unit_time), response)
    if (allocated(segment%rate)) then
      call add_motion(configuration%set, segment%rate, part, response, displaced=segment%q)
    else
      call add_modes_of_source(configuration%source, segment%force, 1, count, sum_tolerance, part, response)
    end if
    peak = maxval(abs(response%displacement(:response%finite_samples, :)))
  end function previewed_peak

  real(dp) function predicted(motion, segment, count, samples, bound) result(error)
    !! The largest error that is expected of the first modes of the first segment, were phases random.
    type(case_motion), intent(inout) :: motion   !! its survey gets what is asked for
    type(segment_type), intent(in) :: segment
    integer, intent(in) :: count                 !! of the modes, the last of a bin
    integer, intent(in) :: samples               !! at which the motion is seen
    real(dp), intent(out), optional :: bound     !! that is proved
    type(tail_type) :: tail
    associate (survey => motion%survey(1), source => motion%modes%configuration(segment%configuration)%source)
      call find_tail(survey, source%pieces%beam, source%damping, segment%energy, count, tail, segment%force, &
                     source%struck_at)
      error = maxval(displacement_error(tail, part_planned(motion, 1, count, samples)))
      if (present(bound)) bound = maxval(tail%bound)
    end associate
  end function predicted

  pure function part_planned(motion, i, count, samples) result(part)
    !! Of the sum of its amplitudes, that a block of a segment's modes comes to: what it would with random phases, or what a sum of
    !! fewer showed.
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: i, count, samples
    real(dp) :: part(size(motion%survey(i)%points))
    part = part_shown(motion%survey(i), count, samples)
    if (allocated(motion%seen_part)) part = max(part, motion%seen_part(:, i))
  end function part_planned

  pure real(dp) function agreement(survey, source, samples) result(times)
    !! How many times what random phases do the last modes of a survey may come to. Beyond the lowest cutoff of a beam with shear waves
    !! hardly disperse, and phases agree: a block there comes to as large a part of its amplitudes as one at the cutoff.
    type(mode_survey), intent(in) :: survey
    class(mode_source), intent(in) :: source
    integer, intent(in) :: samples
    real(dp) :: cutoff                             ! 1/β² there
    integer :: b
    cutoff = maxval(source%pieces%beam%piece%compliance%hi*source%pieces%beam%piece%rotary%hi)
    times = 1.0_dp
    if (cutoff*survey%bin(survey%bins)%square <= 1.0_dp) return
    b = findloc(cutoff*survey%bin(:survey%bins)%square > 1.0_dp, .true., dim=1)
    times = maxval(part_shown(survey, survey%bin(b)%last, samples)/part_shown(survey, survey%bin(survey%bins)%last, samples))
  end function agreement

  subroutine find_first_count(scene, motion, segment, samples, monitor, cache)
    !! The least count within the tolerance, of as many modes as it takes.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    type(segment_type), intent(inout) :: segment
    integer, intent(in) :: samples
    class(monitor_type), intent(inout) :: monitor
    type(case_mode_cache), intent(inout), optional :: cache
    real(dp) :: allowed
    real(dp), dimension(2) :: errors, before, power       ! the estimate, and the bound's part: each falls in its own way
    real(dp) :: agree, fall(2)
    integer :: count, last, last_before, most
    logical :: extended
    allowed = motion%aim*scene%modes%tolerance*motion%peak
    last_before = 0
    before = 0.0_dp
    associate (survey => motion%survey(1), source => motion%modes%configuration(segment%configuration)%source)
      most = most_of(scene, source)
      power = steepest(source)
      do
        last = survey%bin(survey%bins)%last
        errors = errors_with(last)
        if (all(errors <= allowed)) exit
        if (last_before > 0 .and. last > last_before) power = max(0.1_dp, log(before/errors)/log(real(last, dp)/last_before))
        if (survey%count() >= min(most, source%highest)) then
          call extend_source(scene, motion%units, segment%configuration == together, monitor, source, extended, cache)
          if (.not. extended) exit
        else if (last >= seen_part_of_most*min(most, source%quickly)) then
          agree = agreement(survey, source, samples - 1)
          fall = max(power, steepest(source))
          if (agree > 1.0_dp) fall = steepest(source, agreeing=.true.)
          if (any(expected(fall) > allowed)) then  ! no need to find millions of modes that are not enough
            segment%count = last
            call motion%reach(scene%modes%tolerance, maxval(expected(min(power, fall)))/motion%peak)
            return
          end if
        end if
        last_before = last
        before = errors
        call survey%add_source(source, segment%force, next_count(last, times(), min(most, source%highest)), monitor)
        if (monitor%stop_requested()) return
      end do
      count = least_count()
      if (count <= looked_ahead) call survey%add_source(source, segment%force, 2*count, monitor)
      if (monitor%stop_requested()) return
      segment%count = least_count()
      call motion%reach(scene%modes%tolerance, maxval(errors_with(segment%count))/motion%peak)
    end associate
  contains
    function errors_with(count) result(errors)
      !! That are expected of the first modes: estimate, and bound over what it may be of a tolerance.
      integer, intent(in) :: count
      real(dp) :: errors(2), bound
      errors(1) = predicted(motion, segment, count, samples - 1, bound)
      errors(2) = bound/bound_times
      errors = max(errors, 1.0e-100_dp)          ! powers are taken of them
    end function errors_with
    pure function expected(power) result(least)
      !! Errors of as many modes as there may be, where they fall as that power of their number.
      real(dp), intent(in) :: power(2)
      real(dp) :: least(2)
      least = errors*[agree, 1.0_dp]*(real(last, dp)/most)**power
    end function expected
    real(dp) function times()
      !! As many modes as there are, that are enough.
      times = maxval((errors/allowed)**(1.0_dp/power))
    end function times
    integer function least_count() result(count)
      !! By powers that go through what is not enough and what is; the most that there are where none is enough.
      integer :: few, enough, try
      real(dp) :: now, over(2), power              ! errors over what is allowed
      associate (survey => motion%survey(1))
        few = survey%bin_of(first_modes)
        enough = survey%bins
        over = [over_allowed(few), over_allowed(enough)]
        if (over(1) <= 1.0_dp) enough = few
        do while (enough - few > 1 .and. over(2) <= 1.0_dp)
          associate (ends => real(survey%bin([few, enough])%last, dp))
            if (ends(2) <= near_enough*ends(1)) exit
            power = log(over(1)/over(2))/log(ends(2)/ends(1))
            try = int(ends(1)*min(over(1)**(1.0_dp/power), ends(2)/ends(1)))
          end associate
          try = max(few + 1, min(enough - 1, findloc(survey%bin(:enough)%last >= try, .true., dim=1)))
          now = over_allowed(try)
          if (now <= 1.0_dp) then
            enough = try
            over(2) = now
          else
            few = try
            over(1) = now
          end if
        end do
        count = survey%bin(enough)%last
      end associate
    end function least_count
    real(dp) function over_allowed(bin) result(over)
      integer, intent(in) :: bin                   !! the modes to whose end are summed
      over = maxval(errors_with(motion%survey(1)%bin(bin)%last))/allowed
    end function over_allowed
  end subroutine find_first_count

  pure function steepest(source, agreeing) result(power)
    !! Powers of the number of modes by which the estimate and the bound fall in the end: amplitudes fall as k⁻³, with shear as k⁻²;
    !! they add up in the bound, and in the estimate where phases agree; else at random.
    class(mode_source), intent(in) :: source
    logical, intent(in), optional :: agreeing      !! phases do
    real(dp) :: power(2)
    power = 2.0_dp
    if (any(source%pieces%beam%piece%compliance%hi > 0.0_dp)) power = 1.0_dp
    if (.not. present(agreeing)) power(1) = power(1) + 0.5_dp
  end function steepest

  pure integer function next_count(last, times, most) result(count)
    !! So many modes as an error takes that falls as a power of their number, in steps that learn the power.
    integer, intent(in) :: last
    real(dp), intent(in) :: times                !! as many as are surveyed
    integer, intent(in) :: most
    real(dp), parameter :: least = 1.1_dp, largest = 16.0_dp
    count = int(min(real(most, dp), last*max(least, min(largest, times)) + 1.0_dp))
  end function next_count

  subroutine choose_later(scene, motion, last, next, projection, monitor, cache)
    !! Of a segment after a change: as many modes before it are handed on, and so many move after it, as keep the tolerance.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    type(segment_type), intent(in) :: last       !! a copy of the segment before it
    type(segment_type), intent(inout) :: next    !! whose start and configuration are known
    type(projection_type), intent(inout) :: projection   !! new
    class(monitor_type), intent(inout), target :: monitor
    type(case_mode_cache), intent(inout), optional :: cache
    type(time_grid) :: grid
    type(stretch_type) :: stretch
    real(dp) :: allowed, doubt, error, last_doubt
    integer :: first, handed, last_handed, most, most_handed, n, samples
    logical :: extended, grows
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    first = first_sample(next%start, grid)
    samples = grid%samples - first + 1
    stretch = stretch_of(grid, first, grid%samples, next%start)
    next%count = first_modes
    allowed = motion%aim*scene%modes%tolerance*motion%peak
    associate (before => motion%modes%configuration(last%configuration), after => motion%modes%configuration(next%configuration))
      most_handed = min(most_modes, before%source%highest, max(before%source%quickly, last%count))
      most = min(most_released, after%source%highest)
      handed = 0
      last_doubt = 0.0_dp
      last_handed = 0
      n = min(most, max(first_modes, 2*last%count))    ! a beam without its mass takes nearly twice as many
      if (first > grid%samples .or. allowed == 0.0_dp) n = min(most, first_modes)
      do
        call after%source%find(first_numbers(n), after%set, grid%samples*grid%step%hi, monitor)
        call project(last, before, next%start - last%start, grid%samples*grid%step%hi, handed, after%set, projection, monitor)
        if (monitor%stop_requested()) return
        call survey_next()
        grows = .false.
        if (doubt > 1.0_dp .and. projection%place%count == before%source%highest) then
          call extend_source(scene, motion%units, last%configuration == together, monitor, before%source, extended, cache)
          if (extended) most_handed = min(most_modes, before%source%highest)
        end if
        if (doubt > 1.0_dp .and. projection%place%count < most_handed) then
          grows = .true.
          handed = more_handed()
        end if
        if (error > 1.0_dp) then
          if (n == most) then
            call extend_source(scene, motion%units, next%configuration == together, monitor, after%source, extended, cache)
            if (extended) most = min(most_released, after%source%highest)
          end if
          if (n < most) then
            grows = .true.
            n = min(most, next_count(n, 1.05_dp*error**0.4_dp, 2*n))
          end if
        end if
        if (.not. grows) exit
      end do
      if (first <= grid%samples .and. allowed > 0.0_dp) call cut_to_least()
    end associate
  contains
    integer function more_handed() result(count)
      !! So many modes before that the doubt is allowed, were it to fall on as a power of their number as it last did.
      real(dp) :: power
      power = 1.5_dp
      associate (known => projection%place%count)
        if (last_handed > 0 .and. known > last_handed) &
          power = max(0.5_dp, min(power, log(last_doubt/doubt)/log(real(known, dp)/last_handed)))
        count = int(min(real(most_handed, dp), known*max(1.25_dp, min(64.0_dp, 1.05_dp*doubt**(1.0_dp/power)))))
        last_handed = known
        last_doubt = doubt
      end associate
    end function more_handed
    subroutine survey_next()
      !! What the modes there are may be off by, and what they are handed, over what is allowed of either.
      type(lack_error) :: lacking
      real(dp) :: part(size(scene%response%points)), times(size(scene%response%points))
      associate (survey => motion%survey(2), after => motion%modes%configuration(next%configuration))
        next%energy = energy_after(projection, after%set, speed_in_plane(scene%rotation, motion%units))
        call survey%start(deflections, scene%response%points, stretch, [n])
        call survey%add_set(after%set, 1, n, projection%q_after, projection%rate_after)
        error = 0.0_dp
        doubt = projection%place%part*sqrt(2.0_dp*projection%place%missing_energy*projection%place%mobility)/scene%modes%tolerance
        if (first > grid%samples .or. allowed == 0.0_dp) return
        part = part_planned(motion, 2, n, samples)
        times = 0.0_dp
        call find_lack(projection%lack, after%set, n, survey, samples, part, times, lacking)
        doubt = max(maxval(lacking%displacement)/(doubt_share*allowed), maxval(lacking%bound)/(0.5_dp*bound_times*allowed))
        error = error_with(n)
      end associate
    end subroutine survey_next
    real(dp) function error_with(count)
      !! Of the first of them, over what is left of the tolerance.
      integer, intent(in) :: count
      type(tail_type) :: tail
      associate (survey => motion%survey(2), source => motion%modes%configuration(next%configuration)%source)
        call find_tail(survey, source%pieces%beam, source%damping, next%energy, count, tail)
        error_with = maxval(displacement_error(tail, part_planned(motion, 2, count, samples)))/(1.0_dp - doubt_share)
        error_with = max(error_with, maxval(tail%bound)/(0.5_dp*bound_times))/allowed
      end associate
    end function error_with
    subroutine cut_to_least()
      !! Drop the modes that the tolerance does not take.
      integer :: few, enough, try
      few = min(first_modes, n)
      enough = n
      if (error_with(few) <= 1.0_dp) enough = few
      do while (enough - few > max(1, few/32))
        try = (few + enough)/2
        if (motion%survey(2)%bin_of(try) == 0) exit
        if (error_with(try) <= 1.0_dp) then
          enough = try
        else
          few = try
        end if
      end do
      next%count = enough
      call motion%reach(scene%modes%tolerance, motion%aim*scene%modes%tolerance*max(error_with(enough), doubt))
    end subroutine cut_to_least
  end subroutine choose_later

end module bw_case_counts
