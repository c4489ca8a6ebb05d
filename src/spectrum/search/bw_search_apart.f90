module bw_search_apart
  !! The search of a large record whose sensors share noise: at mixtures of the sensors that share little of it.
  !!
  !! At the sensors themselves a search would take much of such noise for lines, which takes long, before all of it is known. Its
  !! directions are seen in the middle of the record, with the lines in it, well enough for a search; it is told anew from what
  !! lines leave (`bw_damped_search`).
  use bw_common_noise, only: find_mixture, join, mixture_type, separate
  use bw_damped_line, only: damped_line
  use bw_fourier, only: real_fourier
  use bw_found_lines, only: find_nothing, found_lines
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type, stops
  use bw_noise_level, only: mean_deviation
  use bw_ordinates, only: find_ordinates, ordinates_type
  use bw_samples, only: samples_type
  use bw_search_rounds, only: search, settle
  implicit none (type, external)
  private
  public :: search_apart, sum_amplitudes

  integer, parameter :: many = 2**17           !! samples of each sensor; the search of fewer takes no longer than a second or two
  integer, parameter :: enough = 2**14         !! that tell the directions of shared noise

contains

  subroutine search_apart(samples, false_alarm, plan, found, rough, monitor)
    !! Search the samples, from the lines that are there already, at mixtures if there are many samples and sensors share noise. The
    !! lines, and what they leave, are those of the sensors. Where the monitor stops nothing is of use.
    type(samples_type), intent(inout) :: samples   !! after a search at mixtures they are the same but for rounding
    real(dp), intent(in) :: false_alarm
    type(real_fourier), intent(inout) :: plan
    type(found_lines), intent(inout) :: found
    type(mixture_type), intent(out) :: rough       !! not allocated: the sensors were searched as they are
    class(monitor_type), intent(inout), optional :: monitor
    type(ordinates_type) :: tapered
    if (samples%count >= many) call look_at_middle(samples, plan, rough)
    if (.not. allocated(rough%mixed)) then
      call settle(samples, found)
      call search(samples, false_alarm, plan, found, monitor)
      return
    end if
    call separate(rough, samples)
    call sum_amplitudes(rough%separating, found%lines)
    call settle(samples, found)
    call search(samples, false_alarm, plan, found, monitor)
    if (stops(monitor)) return
    call join(rough, samples)
    deallocate (found%bands)                   ! they hold what the samples were
    call sum_amplitudes(rough%mixed, found%lines)
    found%still = matmul(found%still, transpose(rough%mixed))
    call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)  ! the noise that lines are weighed by
    call settle(samples, found, monitor)
    call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)
  end subroutine search_apart

  subroutine look_at_middle(samples, plan, rough)
    !! Find as many mixtures as there are sensors, in the middle of the record.
    type(samples_type), intent(in) :: samples
    type(real_fourier), intent(inout) :: plan
    type(mixture_type), intent(out) :: rough
    type(samples_type) :: middle
    type(found_lines) :: found
    type(ordinates_type) :: tapered
    integer :: first
    first = (samples%count - enough)/2
    middle%count = enough
    middle%value = samples%value(first + 1:first + enough, :)
    if (allocated(samples%place)) middle%place = samples%place(first + 1:first + enough) - samples%place(first + 1)
    call find_nothing(size(middle%value, 2), found)
    call settle(middle, found)
    call find_ordinates(middle, found%lines, found%still, plan, found%ordinates, tapered)
    call find_mixture(middle, found%ordinates%seen, mean_deviation(found%ordinates%noise), rough)
    if (.not. allocated(rough%mixed)) return
    if (size(rough%mixed, 2) < size(rough%mixed, 1)) deallocate (rough%mixed)
  end subroutine look_at_middle

  pure subroutine sum_amplitudes(factor, lines)
    !! Give lines the amplitudes that they have at sums of sensors.
    real(dp), intent(in) :: factor(:, :)       !! (sums, S)
    type(damped_line), intent(inout) :: lines(:)
    integer :: k
    do k = 1, size(lines)
      lines(k)%amplitude = matmul(factor, lines(k)%amplitude)
    end do
  end subroutine sum_amplitudes

end module bw_search_apart
