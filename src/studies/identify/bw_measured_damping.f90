module bw_measured_damping
  !! The damping ratio of a beam from lines that are its modes: the `&damping ratio` of an identified scene.
  use bw_measured_state, only: measured_state
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_quantile, only: normal_quantile
  use bw_random_effects, only: pooled_number, pooled_value
  implicit none (type, external)
  private
  public :: measured_damping

contains

  pure type(pooled_value) function measured_damping(states, taken, confidence, false_alarm) result(ratio)
    !! Pool the ratio δ/√(β² + δ²) of all lines, with their scatter beyond the errors of lines. `missing` if no line is
    !! a mode, or the interval contains 0.
    type(measured_state), intent(in) :: states(:)    !! with assignments
    logical, intent(in) :: taken(:)              !! whether a state belongs to the scene, (states)
    real(dp), intent(in) :: confidence, false_alarm   !! as in `pooled_number`
    real(dp), parameter :: unknown = 1.0_dp      ! deviation of a ratio that carries no information
    real(dp), allocatable :: value(:), deviation(:)
    integer :: i
    allocate (value(0), deviation(0))
    do i = 1, size(states)
      if (.not. taken(i)) cycle
      associate (lines => states(i)%lines, is_mode => states(i)%mode_of > 0)
        value = [value, pack(lines%decay/lines%frequency, is_mode)]
        deviation = [deviation, pack(lines%decay_deviation/lines%frequency, is_mode)]
      end associate
    end do
    where (.not. deviation < unknown) deviation = missing
    ratio = pooled_number(value, deviation, confidence, false_alarm)
    if (ratio%count == 1) then
      ratio%value = sum(value, mask=deviation < unknown)
      ratio%error = normal_quantile(0.5_dp + 0.5_dp*confidence)*sum(deviation, mask=deviation < unknown)
      ratio%scatter = 0
    end if
    if (ratio%count == 0 .or. .not. ratio%value > ratio%error) ratio = pooled_value()
  end function measured_damping

end module bw_measured_damping
