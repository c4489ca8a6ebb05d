module bw_found_lines
  !! The lines of a record as they were found: at sensors that tell something of their own, with the noise in which they are.
  !!
  !! A record without noise, as a simulation's, has its lines from its transform to the last digit; what is left is rounding, and
  !! stands for the noise.
  use bw_distinct_sensors, only: distinct_type, find_distinct, keep_distinct
  use bw_kinds, only: dp
  use bw_line, only: line_type
  use bw_line_search, only: find_lines, line_outcome
  use bw_model, only: find_misfit, model_type, renew
  use bw_monitor, only: monitor_type, stops
  use bw_pure_record, only: find_lines_if_pure, safety
  use bw_samples, only: samples_type
  use bw_tapered_line, only: taper_costs
  use bw_tapered_residual, only: residual_type
  implicit none (type, external)
  private
  public :: find_record_lines

  type, public :: found_lines
    type(model_type) :: model
    type(line_outcome) :: outcome
    type(distinct_type) :: distinct              !! the model is that of the sensors that are kept
    real(dp), allocatable :: deviation(:)        !! standard deviation of the residual of each of these
  end type found_lines

contains

  subroutine find_record_lines(samples, false_alarm, found, monitor)
    !! Find the lines of a record.
    type(samples_type), intent(inout) :: samples   !! loses sensors that are constant, or copies of others
    real(dp), intent(in) :: false_alarm            !! that noise alone makes any line
    type(found_lines), intent(out) :: found
    class(monitor_type), intent(inout), optional :: monitor  !! nothing is of use where it asks to stop
    type(line_type), allocatable :: lines(:)
    type(residual_type) :: left
    logical :: pure
    found%distinct = find_distinct(samples)
    call keep_distinct(found%distinct, samples)
    pure = .false.
    if (.not. allocated(samples%valid)) call find_lines_if_pure(samples, lines, left, pure, monitor)
    if (stops(monitor)) return
    if (pure) then
      call take_lines(samples, lines, found)
    else
      call find_lines(samples, false_alarm, found%model, found%outcome, monitor)
    end if
    found%deviation = deviations_of(samples, found%model)
  end subroutine find_record_lines

  subroutine take_lines(samples, lines, found)
    !! Take the lines of a record without noise. One that does not oscillate and is steady is an offset.
    type(samples_type), intent(in) :: samples
    type(line_type), intent(in) :: lines(:)
    type(found_lines), intent(inout) :: found
    associate (model => found%model, sensors => size(samples%value, 2))
      allocate (model%stretches(2, 0:1), model%trend(2, sensors, 0:1))
      model%stretches = reshape([1, 0, 1, samples%count], [2, 2])
      model%trend = 0
      model%lines = pack(lines, .not. (lines%steady .and. .not. lines%pole%im > 0))
      model%lines%steady = .false.
      call renew(samples, 0.0_dp, .false., model, 0)
      model%noise%filter = model%noise%filter/(safety*taper_costs)
      model%white = model%white/(safety*taper_costs)
    end associate
    allocate (found%outcome%poles(0), found%outcome%gains(0))
  end subroutine take_lines

  pure function deviations_of(samples, model) result(deviation)
    !! The standard deviation of each sensor's residual.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    real(dp) :: deviation(size(samples%value, 2)), left(samples%count, 1)
    logical :: valid(samples%count)
    integer :: s
    valid = .true.
    if (allocated(samples%valid)) valid = samples%valid
    do s = 1, size(deviation)                      ! one sensor at a time: a record may fill the memory
      call find_misfit(samples, model, [s], left)
      deviation(s) = sqrt(sum(left(:, 1)**2, mask=valid)/max(1, count(valid)))
    end do
  end function deviations_of

end module bw_found_lines
