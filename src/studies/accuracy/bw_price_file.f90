module bw_price_file
  !! The variables of DIR/<scene>.accuracy.nc.
  use bw_kinds, only: dp
  use bw_error, only: error_type
  use bw_missing, only: is_missing, missing
  use bw_price_list, only: beyond_model, by_counts, by_tolerances, ladder_words, method_words, price_digits, &
    price_list, priced_stages, rung_words, work_slope
  use bw_stopwatch, only: processor_name, stage_words
  use bw_study_file, only: study_file, study_values
  implicit none (type, external)
  private

  type, extends(study_values), public :: price_values
    type(price_list) :: list
  contains
    procedure :: put => put_prices
  end type price_values

contains

  subroutine put_prices(self, file, error)
    !! Everything that was measured.
    class(price_values), intent(in) :: self
    type(study_file), intent(in) :: file
    type(error_type), allocatable, intent(inout) :: error
    call file%put_text('machine', processor_name(), error)
    call file%put_axis('rung', size(self%list%rungs), 'number of the rung', error)
    call file%put_axis('stage', priced_stages, 'stage of the work', error, stage_words(:priced_stages))
    call put_rungs(file, self%list, error)
    call put_errors(file, self%list, error)
    call put_seconds(file, self%list, error)
    call put_converged(file, self%list, error)
  end subroutine put_prices

  subroutine put_rungs(file, list, error)
    !! What each rung is.
    type(study_file), intent(in) :: file
    type(price_list), intent(in) :: list
    type(error_type), allocatable, intent(inout) :: error
    associate (rungs => list%rungs)
      call file%put_flags('ladder', 'rung', 'what the rungs of a ladder are made by', rungs%ladder, ladder_words, error)
      call file%put_flags('rung_status', 'rung', 'how the rung ended', rungs%status, rung_words, error)
      call file%put_numbers('tolerance', 'rung', '1', 'largest error that was asked for, over the peak', rungs%tolerance, error)
      call file%put_counts('mode_count', 'rung', 'number of modes that were summed', rungs%mode_count, error)
      call file%put_counts('refined_count', 'rung', 'number of modes whose root was solved in extended precision', &
                           rungs%refined_count, error)
      call file%put_flags('method', 'rung', 'how the modes were summed', rungs%method, method_words, error)
    end associate
  end subroutine put_rungs

  subroutine put_errors(file, list, error)
    type(study_file), intent(in) :: file
    type(price_list), intent(in) :: list
    type(error_type), allocatable, intent(inout) :: error
    associate (rungs => list%rungs)
      call file%put_numbers('true_error', 'rung', '1', &
                            'largest difference of the displacement from the converged run, over the peak', rungs%error, error)
      call file%put_numbers('estimated_error', 'rung', '1', 'the run''s own estimate of that error', rungs%estimate, error)
      call file%put_numbers('error_ratio', 'rung', '1', 'estimated over true error', &
                            ratio(rungs%estimate, rungs%error), error)
    end associate
  end subroutine put_errors

  subroutine put_seconds(file, list, error)
    type(study_file), intent(in) :: file
    type(price_list), intent(in) :: list
    type(error_type), allocatable, intent(inout) :: error
    real(dp), dimension(size(list%rungs)) :: seconds, growth
    integer :: i
    call price_digits(list%rungs, seconds, growth)
    associate (rungs => list%rungs)
      call file%put_counts('repeats', 'rung', 'number of runs that were timed', rungs%repeats, error)
      call file%put_numbers('seconds', 'rung', 's', 'wall time, median of the repeats', rungs%seconds, error)
      call file%put_numbers('seconds_lower', 'rung', 's', 'wall time, a quarter of the repeats are faster', rungs%lower, error)
      call file%put_numbers('seconds_upper', 'rung', 's', 'wall time, a quarter of the repeats are slower', rungs%upper, error)
      call file%put_numbers('stage_seconds', 'rung stage', 's', 'wall time of the stage, median of the repeats', &
                            [(rungs(i)%stages, i=1, size(rungs))], error)
      call file%put_numbers('digit_seconds', 'rung', 's', 'further wall time for a tenth of the tolerance', &
                            seconds, error)
      call file%put_numbers('digit_growth', 'rung', '1', &
                            'further wall time for a tenth of the tolerance, as a part of the rung''s', growth, error)
      call file%put_numbers('work_slope', '', '1', 'd log(seconds)/d log(true error) over the tolerances', &
                            [work_slope(rungs, by_tolerances, list%converged_error)], error)
      call file%put_numbers('work_slope_of_counts', '', '1', 'd log(seconds)/d log(true error) over the fixed counts', &
                            [work_slope(rungs, by_counts, list%converged_error)], error)
    end associate
  end subroutine put_seconds

  subroutine put_converged(file, list, error)
    !! What the errors are measured against.
    type(study_file), intent(in) :: file
    type(price_list), intent(in) :: list
    type(error_type), allocatable, intent(inout) :: error
    call file%put_numbers('peak_displacement', '', 'm', 'largest displacement of the converged run', [list%peak], error)
    call file%put_numbers('converged_tolerance', '', '1', 'tolerance of the converged run', [list%converged_tolerance], error)
    call file%put_counts('converged_mode_count', '', 'number of modes of the converged run', [list%converged_count], error)
    call file%put_numbers('converged_error', '', '1', &
                          'the converged run''s estimate of its own error, over the peak: smaller errors are not resolved', &
                          [list%converged_error], error)
    call file%put_numbers('converged_difference', '', '1', &
                          'largest difference of the converged run from a direct sum in extended precision, over the peak', &
                          [list%converged_difference], error)
    call file%put_counts('converged_samples', '', 'number of samples at which that difference was taken', &
                         [list%checked_samples], error)
    call file%put_numbers('model_error', '', '1', &
                          'estimate of what the effects that are left out would change of the displacement, over the peak', &
                          [maxval(list%model_errors)], error)
    call file%put_counts('beyond_model', 'rung', '1 where the true error is smaller than that of the model', &
                         merge(1, 0, beyond_model(list%rungs, maxval(list%model_errors))), error)
    call file%put_numbers('reachable_tolerance', '', '1', 'smallest tolerance in reach, where one that was tried is not', &
                          [list%reachable], error)
  end subroutine put_converged

  elemental real(dp) function ratio(estimate, error)
    !! Missing where one is, or the error is zero.
    real(dp), intent(in) :: estimate, error
    ratio = missing
    if (is_missing(estimate) .or. is_missing(error)) return
    if (error > 0.0_dp) ratio = estimate/error
  end function ratio

end module bw_price_file
