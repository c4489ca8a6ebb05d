module bw_price_list
  !! The cost of accuracy for a scene: the rungs of two ladders, tolerances and fixed mode counts, each with its error
  !! and run time; what follows from them; and the variables of DIR/<scene>.accuracy.nc.
  use bw_kinds, only: dp
  use bw_absent_effects, only: absent_words
  use bw_missing, only: is_missing, missing
  use bw_stopwatch, only: processor_name, stage_words
  use bw_study_file, only: study_file, study_values
  implicit none (type, external)
  private
  public :: beyond_model, digit_noise, is_above_estimate, is_resolved, price_digits, what_is_bounded, work_slope

  integer, parameter, public :: by_tolerances = 1, by_counts = 2
  character(*), parameter, public :: ladder_words(2) = [character(9) :: 'tolerance', 'counts']   !! by number

  integer, parameter, public :: rung_measured = 1, rung_out_of_reach = 2, rung_too_long = 3, rung_diverged = 4
  character(*), parameter, public :: rung_words(4) = &
    [character(12) :: 'measured', 'out_of_reach', 'too_long', 'diverged']   !! by number

  integer, parameter, public :: by_products = 1, by_transform = 2, not_summed = 3
  character(*), parameter, public :: method_words(3) = [character(9) :: 'products', 'transform', 'none']   !! by number

  integer, parameter, public :: priced_stages = 3      !! modes, events, response

  type, public :: rung_type
    integer :: ladder = by_tolerances
    integer :: status = rung_measured
    real(dp) :: tolerance = missing       !! requested; missing on the ladder of counts
    integer :: mode_count = 0             !! modes summed; 0 if none were
    integer :: method = not_summed
    real(dp) :: error = missing           !! largest difference from the converged run at the samples, over the peak
    real(dp) :: estimate = missing        !! the run's own estimate of that error
    integer :: repeats = 0
    real(dp) :: seconds = missing         !! median
    real(dp) :: lower = missing, upper = missing        !! quartiles, s
    real(dp) :: stages(priced_stages) = missing         !! medians, s
  end type rung_type

  type, extends(study_values), public :: price_list
    type(rung_type), allocatable :: rungs(:)   !! ladder by ladder, from coarse to fine
    logical :: bounds_all = .false.            !! errors cover all histories, each relative to its own peak; else the displacement
    real(dp) :: peak = 0.0_dp                  !! largest displacement of the converged run, m
    real(dp) :: converged_tolerance = missing  !! that the converged run meets
    integer :: converged_count = 0             !! modes of the converged run
    real(dp) :: converged_error = missing      !! its own estimate, over the peak: smaller errors cannot be measured
    real(dp) :: model_errors(size(absent_words)) = missing
      !! estimated change by each effect that the scene leaves out, over the peak; missing if `bounds_all`
    real(dp) :: reachable = missing            !! the smallest attainable tolerance; missing: all that were tried
  contains
    procedure :: put => put_prices
  end type price_list

contains

  elemental logical function is_resolved(rung, converged_error)
    !! Return whether the measured error is the rung's own, and not that of the converged run.
    type(rung_type), intent(in) :: rung
    real(dp), intent(in) :: converged_error
    is_resolved = .false.
    if (is_missing(rung%error) .or. rung%error == 0.0_dp) return
    is_resolved = rung%error > converged_error
  end function is_resolved

  elemental logical function is_above_estimate(rung, reference_error)
    !! Return whether the true error exceeds the rung's estimate by more than the error of the reference run.
    type(rung_type), intent(in) :: rung
    real(dp), intent(in) :: reference_error   !! of the converged run, over the peak
    is_above_estimate = .false.
    if (rung%status /= rung_measured .or. is_missing(rung%error) .or. is_missing(rung%estimate)) return
    is_above_estimate = rung%error > rung%estimate + reference_error
  end function is_above_estimate

  elemental logical function beyond_model(rung, model_error)
    !! Return whether the rung's numerical error is below the modelling error.
    type(rung_type), intent(in) :: rung
    real(dp), intent(in) :: model_error       !! the largest in the list
    beyond_model = .false.
    if (.not. (is_missing(rung%error) .or. is_missing(model_error))) beyond_model = rung%error < model_error
  end function beyond_model

  pure integer function next_rung(rungs, i)
    !! Return the next timed rung of the same ladder; 0 if there is none.
    type(rung_type), intent(in) :: rungs(:)
    integer, intent(in) :: i
    next_rung = 0
    if (i == size(rungs) .or. is_missing(rungs(i)%seconds)) return
    if (rungs(i + 1)%ladder /= rungs(i)%ladder .or. is_missing(rungs(i + 1)%seconds)) return
    next_rung = i + 1
  end function next_rung

  pure subroutine price_digits(rungs, seconds, growth)
    !! Find the cost of the next digit, from one tolerance to the next: additional seconds per factor of ten, and the
    !! same relative to the present seconds (0.25: a quarter more). Missing on the last rung and on the ladder of
    !! counts.
    type(rung_type), intent(in) :: rungs(:)
    real(dp), intent(out) :: seconds(:), growth(:)      !! (rungs)
    real(dp) :: digits
    integer :: i, next
    seconds = missing
    growth = missing
    do i = 1, size(rungs)
      next = next_rung(rungs, i)
      if (next == 0 .or. is_missing(rungs(i)%tolerance)) cycle
      digits = log10(rungs(i)%tolerance/rungs(next)%tolerance)
      seconds(i) = (rungs(next)%seconds - rungs(i)%seconds)/digits
      growth(i) = (rungs(next)%seconds/rungs(i)%seconds)**(1.0_dp/digits) - 1.0_dp
    end do
  end subroutine price_digits

  pure function digit_noise(rungs) result(noise)
    !! Return the uncertainty of the cost of the next digit by the scatter of repeats, s: half the interquartile ranges
    !! of both rungs, per factor of ten; missing if there is no cost.
    type(rung_type), intent(in) :: rungs(:)
    real(dp) :: noise(size(rungs))
    integer :: i, next
    noise = missing
    do i = 1, size(rungs)
      next = next_rung(rungs, i)
      if (next == 0 .or. is_missing(rungs(i)%tolerance)) cycle
      noise(i) = 0.5_dp*(rungs(i)%upper - rungs(i)%lower + rungs(next)%upper - rungs(next)%lower) &
                 /log10(rungs(i)%tolerance/rungs(next)%tolerance)
    end do
  end function digit_noise

  pure real(dp) function work_slope(rungs, ladder, converged_error) result(slope)
    !! Return d log(seconds)/d log(error), least squares over the rungs of a ladder whose error is resolved: −0.05 means
    !! that a tenth of the error takes 10^0.05 times as long. Missing if the errors span less than a factor of ten, as
    !! this would extrapolate.
    type(rung_type), intent(in) :: rungs(:)
    integer, intent(in) :: ladder
    real(dp), intent(in) :: converged_error
    real(dp), allocatable :: x(:), y(:)
    logical :: used(size(rungs))
    used = rungs%ladder == ladder .and. .not. is_missing(rungs%seconds) .and. is_resolved(rungs, converged_error)
    x = log(pack(rungs%error, used))
    y = log(pack(rungs%seconds, used))
    slope = missing
    if (size(x) < 2) return
    x = x - sum(x)/size(x)
    if (maxval(x) - minval(x) < log(10.0_dp)) return
    slope = sum(x*y)/sum(x**2)
  end function work_slope

  subroutine put_prices(self, file)
    !! Put all measured values into the file.
    class(price_list), intent(in) :: self
    type(study_file), intent(inout) :: file
    call file%put_text('machine', processor_name())
    call file%put_axis('rung', size(self%rungs), 'number of the rung')
    call file%put_axis('stage', priced_stages, 'stage of the work', stage_words(:priced_stages))
    call put_rungs(file, self)
    call put_errors(file, self)
    call put_seconds(file, self)
    call put_converged(file, self)
  end subroutine put_prices

  subroutine put_rungs(file, list)
    !! Put the definition of each rung.
    type(study_file), intent(inout) :: file
    class(price_list), intent(in) :: list
    associate (rungs => list%rungs)
      call file%put_counts('ladder', 'rung', 'what the rungs of a ladder are made by', rungs%ladder, ladder_words)
      call file%put_counts('rung_status', 'rung', 'how the rung ended', rungs%status, rung_words)
      call file%put_numbers('tolerance', 'rung', '1', 'requested largest error, over the peak', rungs%tolerance)
      call file%put_counts('mode_count', 'rung', 'number of modes that were summed', rungs%mode_count)
      call file%put_counts('method', 'rung', 'how the modes were summed', rungs%method, method_words)
    end associate
  end subroutine put_rungs

  subroutine put_errors(file, list)
    !! Put true errors, estimated errors, and their ratios.
    type(study_file), intent(inout) :: file
    class(price_list), intent(in) :: list
    associate (rungs => list%rungs)
      call file%put_numbers('true_error', 'rung', '1', &
                            'largest difference from the converged run of '//what_is_bounded(list)//', over its peak', rungs%error)
      call file%put_numbers('estimated_error', 'rung', '1', 'the run''s own estimate of that error', rungs%estimate)
      call file%put_numbers('error_ratio', 'rung', '1', 'estimated over true error', &
                            ratio(rungs%estimate, rungs%error))
    end associate
  end subroutine put_errors

  subroutine put_seconds(file, list)
    !! Put run times and quantities derived from them.
    type(study_file), intent(inout) :: file
    class(price_list), intent(in) :: list
    real(dp), dimension(size(list%rungs)) :: seconds, growth
    integer :: i
    call price_digits(list%rungs, seconds, growth)
    associate (rungs => list%rungs)
      call file%put_counts('repeats', 'rung', 'number of runs that were timed', rungs%repeats)
      call file%put_numbers('seconds', 'rung', 's', 'wall time, median of the repeats', rungs%seconds)
      call file%put_numbers('seconds_lower', 'rung', 's', 'wall time, a quarter of the repeats are faster', rungs%lower)
      call file%put_numbers('seconds_upper', 'rung', 's', 'wall time, a quarter of the repeats are slower', rungs%upper)
      call file%put_numbers('stage_seconds', 'rung stage', 's', 'wall time of the stage, median of the repeats', &
                            [(rungs(i)%stages, i=1, size(rungs))])
      call file%put_numbers('digit_seconds', 'rung', 's', 'further wall time for a tenth of the tolerance', &
                            seconds)
      call file%put_numbers('digit_noise', 'rung', 's', &
                            'uncertainty of the additional wall time from the scatter of the repeats', digit_noise(rungs))
      call file%put_numbers('digit_growth', 'rung', '1', &
                            'additional wall time for a tenth of the tolerance, as a fraction of the rung''s', growth)
      call file%put_numbers('work_slope', '', '1', 'd log(seconds)/d log(true error) over the tolerances', &
                            [work_slope(rungs, by_tolerances, list%converged_error)])
      call file%put_numbers('work_slope_of_counts', '', '1', 'd log(seconds)/d log(true error) over the fixed counts', &
                            [work_slope(rungs, by_counts, list%converged_error)])
    end associate
  end subroutine put_seconds

  subroutine put_converged(file, list)
    !! Put the reference of the errors.
    type(study_file), intent(inout) :: file
    class(price_list), intent(in) :: list
    call file%put_numbers('peak_displacement', '', 'm', 'largest displacement of the converged run', [list%peak])
    call file%put_numbers('converged_tolerance', '', '1', 'tolerance of the converged run', [list%converged_tolerance])
    call file%put_counts('converged_mode_count', '', 'number of modes of the converged run', [list%converged_count])
    call file%put_numbers('converged_error', '', '1', &
                          'the converged run''s estimate of its own error, over the peak: smaller errors are not resolved', &
                          [list%converged_error])
    call file%put_numbers('model_error', '', '1', &
                          'estimated change of the displacement by effects that are left out, over the peak', &
                          [maxval(list%model_errors)])
    call file%put_counts('beyond_model', 'rung', '1 where the true error is smaller than that of the model', &
                         merge(1, 0, beyond_model(list%rungs, maxval(list%model_errors))))
    call file%put_numbers('reachable_tolerance', '', '1', 'smallest tolerance in reach, where one that was tried is not', &
                          [list%reachable])
  end subroutine put_converged

  pure function what_is_bounded(list) result(words)
    !! Name what a tolerance bounds and the study measures.
    class(price_list), intent(in) :: list
    character(:), allocatable :: words
    words = 'the displacement'
    if (list%bounds_all) words = 'each history'
  end function what_is_bounded

  elemental real(dp) function ratio(estimate, error)
    !! Return the estimated error over the true one; missing if either is missing or the true one is zero.
    real(dp), intent(in) :: estimate, error
    ratio = missing
    if (is_missing(estimate) .or. is_missing(error)) return
    if (error > 0.0_dp) ratio = estimate/error
  end function ratio

end module bw_price_list
