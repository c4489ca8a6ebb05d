module bw_found_lines
  !! The lines of a record as they were found, at sensors with information of their own, and the noise of these sensors.
  !!
  !! The lines of a record without noise, as a simulation's, are found from its transform to the last digit; their residual is
  !! rounding, which takes the place of noise.
  use bw_cost, only: penalty_of_line
  use bw_distinct_sensors, only: distinct_type, find_distinct, keep_distinct
  use bw_kinds, only: dp
  use bw_line, only: line_type
  use bw_line_drops, only: line_outcome
  use bw_model, only: find_misfit, model_type
  use bw_monitor, only: monitor_type, stops
  use bw_pure_record, only: find_lines_if_pure, safety
  use bw_record_search, only: find_lines
  use bw_renewal, only: renew
  use bw_samples, only: samples_type, validity
  use bw_tapered_line, only: taper_costs
  use bw_tapered_residual, only: residual_type
  implicit none (type, external)
  private
  public :: find_record_lines

  type, public :: found_lines
    type(model_type) :: model
    type(line_outcome) :: outcome
    type(distinct_type) :: distinct              !! the model is that of the sensors kept
    real(dp), allocatable :: deviation(:)        !! standard deviation of the residual of each sensor kept
    real(dp) :: needed = 0                       !! penalty of a line
  end type found_lines

contains

  subroutine find_record_lines(samples, false_alarm, found, monitor)
    !! Find the lines of a record.
    type(samples_type), intent(inout) :: samples   !! loses sensors that are constant or multiples of others
    real(dp), intent(in) :: false_alarm            !! probability that noise alone yields any line
    type(found_lines), intent(out) :: found
    class(monitor_type), intent(inout), optional :: monitor  !! results are undefined after a stop request
    type(line_type), allocatable :: lines(:)
    type(residual_type) :: residual
    logical :: pure
    found%distinct = find_distinct(samples)
    call keep_distinct(found%distinct, samples)
    pure = .false.
    if (.not. allocated(samples%missing)) call find_lines_if_pure(samples, lines, residual, pure, monitor)
    if (stops(monitor)) return
    if (pure) then
      call take_lines(samples, lines, found)
    else
      call find_lines(samples, false_alarm, found%model, found%outcome, monitor)
      if (.not. found%outcome%driven) found%needed = penalty_of_line(samples, false_alarm, found%model)
    end if
    found%deviation = deviations_of(samples, found%model)
  end subroutine find_record_lines

  subroutine take_lines(samples, lines, found)
    !! Fill the model with the lines of a record without noise. A steady line that does not oscillate is an offset and left out.
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
    real(dp) :: deviation(size(samples%value, 2))
    real(dp), allocatable :: residual(:, :)
    logical :: valid(samples%count)
    integer, parameter :: at_once = 4              ! sensors: a record may fill the memory
    integer :: first, s
    do first = 1, size(deviation), at_once
      allocate (residual(samples%count, min(at_once, size(deviation) - first + 1)))
      call find_misfit(samples, model, [(s, s=first, first + size(residual, 2) - 1)], residual)
      do s = first, first + size(residual, 2) - 1
        valid = validity(samples, s)
        deviation(s) = sqrt(sum(residual(:, s - first + 1)**2, mask=valid)/max(1, count(valid)))
      end do
      deallocate (residual)
    end do
  end function deviations_of

end module bw_found_lines
