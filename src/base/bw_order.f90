module bw_order
  !! Ordering and order statistics of values.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: ascending, local_maxima, place_ranks, quantile_of, vertex

contains

  pure function ascending(value) result(order)
    !! Return the permutation that sorts a short array.
    real(dp), intent(in) :: value(:)
    integer :: order(size(value)), i, j
    do i = 1, size(value)
      j = count(value(:i - 1) <= value(i)) + 1
      order(j + 1:i) = order(j:i - 1)
      order(j) = i
    end do
  end function ascending

  pure function local_maxima(value, threshold) result(place)
    !! Return positions, from 0, of values above a threshold that are not lower than their neighbours.
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
    !! Return the maximum of the parabola through the logarithms of three values, −½ … ½ from the middle one.
    real(dp), intent(in) :: value(-1:1)
    real(dp) :: height(-1:1)
    height = log(max(value, tiny(1.0_dp)))
    vertex = (height(1) - height(-1))/max(2*(2*height(0) - height(1) - height(-1)), 1.0e-10_dp)
    vertex = max(-0.5_dp, min(0.5_dp, vertex))
  end function vertex

  pure real(dp) function quantile_of(values, part) result(quantile)
    !! Return the value below which this fraction of the values lies.
    real(dp), intent(in) :: values(:), part
    real(dp) :: list(size(values))
    integer :: k
    list = values
    k = max(1, min(size(list), nint(part*(size(list) + 1))))
    call place_ranks(list, 1, size(list), [k])
    quantile = list(k)
  end function quantile_of

  pure recursive subroutine place_ranks(values, first, last, ranks)
    !! Put the values of some ranks in their sorted positions, by partitioning the range about a pivot and continuing in
    !! the parts that hold a rank (Hoare, Algorithm 65: Find, 1961; Chambers, Algorithm 410: Partial sorting, 1971).
    real(dp), intent(inout) :: values(:)
    integer, intent(in) :: first, last             !! of the range; outside of it nothing is moved
    integer, intent(in) :: ranks(:)                !! in any order
    real(dp), parameter :: golden = 0.618_dp       !! relative position of the pivot: no regular order has its extremes there
    real(dp) :: pivot, swap
    integer :: i, j
    if (first >= last .or. .not. any(ranks >= first .and. ranks <= last)) return
    pivot = values(first + int(golden*(last - first)))
    i = first
    j = last
    do while (i <= j)
      do while (values(i) < pivot)
        i = i + 1
      end do
      do while (pivot < values(j))
        j = j - 1
      end do
      if (i > j) exit
      swap = values(i)
      values(i) = values(j)
      values(j) = swap
      i = i + 1
      j = j - 1
    end do
    call place_ranks(values, first, j, ranks)
    call place_ranks(values, i, last, ranks)
  end subroutine place_ranks

end module bw_order
