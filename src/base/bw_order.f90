module bw_order
  !! Places of values in a row by size.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: ascending, local_maxima, quantile_of, sort, vertex

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

  pure subroutine sort(values)
    !! Sort many numbers, ascending, by merging runs of them that are sorted.
    real(dp), intent(inout) :: values(:)
    real(dp), allocatable :: merged(:)
    integer :: run, first, middle, last, i, j, k
    allocate (merged(size(values)))
    run = 1
    do while (run < size(values))
      do first = 1, size(values), 2*run
        middle = min(first + run - 1, size(values))
        last = min(middle + run, size(values))
        i = first
        j = middle + 1
        do k = first, last
          if (j > last) then
            merged(k) = values(i)
            i = i + 1
          else if (i > middle) then
            merged(k) = values(j)
            j = j + 1
          else if (values(j) < values(i)) then
            merged(k) = values(j)
            j = j + 1
          else
            merged(k) = values(i)
            i = i + 1
          end if
        end do
      end do
      values = merged
      run = 2*run
    end do
  end subroutine sort

  pure real(dp) function quantile_of(values, part) result(quantile)
    !! The value that so large a part of them is below, by halving the range until only one is left in it.
    real(dp), intent(in) :: values(:), part
    real(dp) :: list(size(values)), pivot, swap
    integer :: low, high, i, j, k
    list = values
    low = 1
    high = size(list)
    k = max(1, min(size(list), nint(part*(size(list) + 1))))
    do while (low < high)
      pivot = list((low + high)/2)
      i = low
      j = high
      do while (i <= j)
        do while (list(i) < pivot)
          i = i + 1
        end do
        do while (pivot < list(j))
          j = j - 1
        end do
        if (i > j) exit
        swap = list(i)
        list(i) = list(j)
        list(j) = swap
        i = i + 1
        j = j - 1
      end do
      if (k <= j) then
        high = j
      else if (k >= i) then
        low = i
      else
        exit
      end if
    end do
    quantile = list(k)
  end function quantile_of

end module bw_order
