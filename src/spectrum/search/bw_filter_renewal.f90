module bw_filter_renewal
  !! A filter that has whitened lines instead of noise: where a search has left lines in a record, the autoregression of what is
  !! left describes them, and its filter takes most of them away. The search of the filtered samples finds them all the same; but
  !! little is left of them, and their errors are large.
  use bw_damped_line, only: damped_line, subtract_lines
  use bw_found_lines, only: found_lines
  use bw_kinds, only: dp
  use bw_line_or_colour, only: without_trend
  use bw_samples, only: place_of, samples_type
  use bw_whitening, only: gain_of, no_whitening
  implicit none (type, external)
  private
  public :: deviation_left, filters_lines, take_filter_off, unfiltered_lines

  real(dp), parameter :: fewer = 0.9_dp        !! of the deviation that the filter was made for

contains

  logical function filters_lines(raw, found)
    !! Whether lines that have been found since explain what the filter was made for.
    type(samples_type), intent(in) :: raw      !! even samples as they were before they were whitened
    type(found_lines), intent(in) :: found     !! its deviation is that of what was left when the filter was made
    filters_lines = any(deviation_left(raw, unfiltered_lines(found)) < fewer*found%deviation)
  end function filters_lines

  function deviation_left(samples, lines) result(deviation)
    !! The standard deviation of what lines and a straight line leave of even samples, (S).
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp) :: deviation(size(samples%value, 2)), left(samples%count)
    integer :: n, s
    do s = 1, size(deviation)
      left = samples%value(:samples%count, s)
      call subtract_lines(lines, s, left)
      deviation(s) = norm2(without_trend(left, [(place_of(samples, n), n=1, samples%count)]))/sqrt(real(samples%count, dp))
    end do
  end function deviation_left

  subroutine take_filter_off(found)
    !! Turn the lines into those of samples that are not whitened; bands and refusals are of no use there.
    type(found_lines), intent(inout) :: found
    found%lines = unfiltered_lines(found)
    found%whitening = no_whitening(size(found%whitening))
    if (allocated(found%bands)) deallocate (found%bands)
    if (allocated(found%rejected)) deallocate (found%rejected)
    allocate (found%rejected(0))
  end subroutine take_filter_off

  pure function unfiltered_lines(found) result(lines)
    !! The lines with the amplitudes that they have in the samples as they were before they were whitened.
    type(found_lines), intent(in) :: found
    type(damped_line) :: lines(size(found%lines))
    integer :: k
    lines = found%lines
    do k = 1, size(lines)
      lines(k)%amplitude = lines(k)%amplitude/gain_of(found%whitening, lines(k))
    end do
  end function unfiltered_lines

end module bw_filter_renewal
