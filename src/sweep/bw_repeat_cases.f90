module bw_repeat_cases
  !! The lines of all cases of a result whose cases are repeats of one record, kept until they are pooled. Cases are added in any
  !! order.
  use bw_case_fields, only: case_field, field_of, fields_of
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing, missing
  use bw_quantile, only: normal, student_quantile
  use bw_record_lines, only: status_words
  use bw_repeats, only: pool_repeats, pooled_lines, repeated_lines
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  implicit none (type, external)
  private

  integer, parameter :: drifting = findloc(status_words == 'drifting', .true., dim=1) - 1      !! bit
  real(dp), parameter :: two_pi = 2.0_dp*acos(-1.0_dp)

  type, public :: repeat_cases
    private
    type(repeated_lines) :: lines
    real(dp) :: quantile = 1          !! standard deviations of half an interval
    real(dp) :: resolution = 0        !! rad/s, of the longest record
    type(case_field) :: frequency, frequency_error, frequency_bound, decay, decay_error, decay_bound, status
      !! where they stand in a case
  contains
    procedure :: add
    procedure :: pooled
  end type repeat_cases

  interface repeat_cases
    module procedure :: cases_of
  end interface repeat_cases

contains

  pure type(repeat_cases) function cases_of(scene, layout) result(cases)
    !! All cases, without lines.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    cases%quantile = student_quantile(scene%spectrum%confidence, normal)
    cases%resolution = two_pi/layout%record%duration
    associate (fields => fields_of(layout), lines => cases%lines)
      cases%frequency = field_of(fields, 'measured_angular_frequency')
      cases%frequency_error = field_of(fields, 'measured_angular_frequency_error')
      cases%frequency_bound = field_of(fields, 'measured_angular_frequency_bound')
      cases%decay = field_of(fields, 'measured_decay_rate')
      cases%decay_error = field_of(fields, 'measured_decay_rate_error')
      cases%decay_bound = field_of(fields, 'measured_decay_rate_bound')
      cases%status = field_of(fields, 'peak_status')
      allocate (lines%frequency(layout%peaks, layout%cases), source=missing)
      lines%frequency_deviation = lines%frequency
      lines%decay = lines%frequency
      lines%decay_deviation = lines%frequency
      allocate (lines%frequency_drift(layout%peaks, layout%cases), source=0.0_dp)
      lines%decay_drift = lines%frequency_drift
    end associate
  end function cases_of

  pure subroutine add(self, index, numbers)
    !! Keep the lines of a case.
    class(repeat_cases), intent(inout) :: self
    integer(i8), intent(in) :: index                  !! its number
    real(dp), intent(in), contiguous :: numbers(:)    !! (case_length)
    real(dp), dimension(size(self%lines%frequency, 1)) :: least
    logical :: drifts(size(least))
    associate (lines => self%lines)
      lines%frequency(:, index) = numbers_of(self%frequency, numbers)
      lines%decay(:, index) = numbers_of(self%decay, numbers)
      drifts = btest(nint(numbers_of(self%status, numbers)), drifting)
      least = epsilon(least)*max(lines%frequency(:, index), self%resolution)       ! of a record without noise
      call part_error(numbers_of(self%frequency_error, numbers), numbers_of(self%frequency_bound, numbers), self%quantile, &
                      drifts, least, lines%frequency_deviation(:, index), lines%frequency_drift(:, index))
      call part_error(numbers_of(self%decay_error, numbers), numbers_of(self%decay_bound, numbers), self%quantile, &
                      drifts, least, lines%decay_deviation(:, index), lines%decay_drift(:, index))
    end associate
  end subroutine add

  pure function numbers_of(field, numbers) result(values)
    !! The numbers of one field of a case.
    type(case_field), intent(in) :: field
    real(dp), intent(in), contiguous :: numbers(:)
    real(dp) :: values(field%length)
    values = numbers(field%first:field%first + field%length - 1)
  end function numbers_of

  elemental subroutine part_error(error, bound, quantile, drifts, least, deviation, drift)
    !! Part half an interval into what differs from repeat to repeat, as a standard deviation, and what a drift along the record
    !! adds to it, which is the same in each.
    real(dp), intent(in) :: error, bound, quantile
    logical, intent(in) :: drifts
    real(dp), intent(in) :: least             !! deviation
    real(dp), intent(out) :: deviation, drift
    deviation = missing
    drift = 0
    if (is_missing(error)) return
    deviation = max(error/quantile, least)
    if (.not. drifts .or. is_missing(bound)) return
    deviation = max(min(bound, deviation), least)
    drift = max(0.0_dp, error - quantile*deviation)
  end subroutine part_error

  pure type(pooled_lines) function pooled(self, scene)
    !! What all cases say together, in SI.
    class(repeat_cases), intent(in) :: self
    type(scene_type), intent(in) :: scene
    pooled = pool_repeats(self%lines, self%resolution, scene%spectrum%confidence, scene%spectrum%false_alarm, &
                          size(self%lines%frequency, 1))
  end function pooled

end module bw_repeat_cases
