module bw_order
  !! Places of values in a row by size.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: ascending, local_maxima, vertex

contains

  pure function ascending(value) result(order)
    !! The permutation that sorts a short array.
    real(dp), intent(in) :: value(:)
    integer :: order(size(value)), i, j
    do i = 1, size(value)
      j = count(value(:i - 1) <= value(i)) + 1
      order(j + 1:i) = order(j:i - 1)
      order(j) = i
    end do
  end function ascending

  pure function local_maxima(value, threshold) result(place)
    !! The places, from 0, of values above a threshold that are not lower than their neighbours.
    real(dp), intent(in) :: value(0:), threshold
    integer, allocatable :: place(:)
    logical :: high(0:size(value) - 1)
    integer :: last, i
    last = size(value) - 1
    high = value > threshold
    high(1:) = high(1:) .and. value(1:) >= value(:last - 1)
    high(:last - 1) = high(:last - 1) .and. value(:last - 1) > value(1:)
    allocate (place, source=pack([(i, i=0, last)], high))
  end function local_maxima

  pure real(dp) function vertex(value)
    !! Where the parabola through the logarithms of three values is highest, −½ … ½ from the middle one.
    real(dp), intent(in) :: value(-1:1)
    real(dp) :: height(-1:1)
    height = log(max(value, tiny(1.0_dp)))
    vertex = (height(1) - height(-1))/max(2*(2*height(0) - height(1) - height(-1)), 1.0e-10_dp)
    vertex = max(-0.5_dp, min(0.5_dp, vertex))
  end function vertex

end module bw_order
