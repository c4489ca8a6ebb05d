module bw_over_cases
  !! Statistics over all cases of a result.
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing, missing
  use bw_order, only: place_ranks
  use bw_repeats, only: pooled_lines
  use bw_result_layout, only: quantile_levels
  use bw_result_table, only: result_table
  implicit none (type, external)
  private
  public :: quantiles_of_cases

  integer, parameter :: most_numbers = 2**22      !! in memory at a time
  integer, parameter :: block = 4096              !! cases read together

  type, public :: case_quantiles
    !! Quantiles of one variable, separately for each of its numbers.
    real(dp), allocatable :: values(:, :)         !! missing if no case has the number, (numbers, quantiles)
    integer, allocatable :: cases(:)              !! cases with the number, (numbers)
  end type case_quantiles

  type, public :: over_cases
    type(pooled_lines), allocatable :: pooled             !! unallocated: the cases are no repeats
    type(case_quantiles), allocatable :: quantiles(:)     !! in the order of the table's summaries; unallocated: no design
  end type over_cases

contains

  subroutine quantiles_of_cases(table, quantiles)
    !! Find quantiles of all summaries of a design over the cases of an open draft.
    class(result_table), intent(inout) :: table
    type(case_quantiles), allocatable, intent(out) :: quantiles(:)
    real(dp), allocatable :: columns(:, :), rows(:)
    integer :: s, v, n, together, first, last, k, cases, p
    cases = table%layout%cases
    allocate (quantiles(size(table%summaries)))
    do s = 1, size(quantiles)
      v = table%variable(table%summaries(s)%name)
      n = int(table%head%variables(v)%room)
      allocate (quantiles(s)%values(n, size(quantile_levels)), quantiles(s)%cases(n))
      together = max(1, min(n, most_numbers/cases))
      do first = 1, n, together
        last = min(n, first + together - 1)
        allocate (columns(cases, first:last))
        do k = 1, cases, block
          allocate (rows(n*min(block, cases - k + 1)))
          call table%file%get_numbers(table%place_of(v, int(k, i8)), table%head%variables(v)%width, rows)
          do p = first, last
            columns(k:k + size(rows)/n - 1, p) = rows(p::n)
          end do
          deallocate (rows)
        end do
        do p = first, last
          call find_quantiles(columns(:, p), quantiles(s)%values(p, :), quantiles(s)%cases(p))
        end do
        deallocate (columns)
      end do
    end do
  end subroutine quantiles_of_cases

  pure subroutine find_quantiles(values, quantiles, cases)
    !! Interpolate linearly between the sorted numbers, of which the first is quantile 0 and the last 1.
    real(dp), intent(in) :: values(:)             !! missing ones are ignored
    real(dp), intent(out) :: quantiles(:)
    integer, intent(out) :: cases                 !! those not missing
    real(dp), allocatable :: order(:)
    real(dp) :: places(size(quantiles))
    integer :: below(size(quantiles)), above(size(quantiles))
    quantiles = missing
    order = pack(values, .not. is_missing(values))
    cases = size(order)
    if (cases == 0) return
    places = 1 + quantile_levels*(cases - 1)
    below = min(int(places), cases)
    above = min(below + 1, cases)
    call place_ranks(order, 1, cases, [below, above])
    quantiles = order(below) + (places - below)*(order(above) - order(below))
  end subroutine find_quantiles

end module bw_over_cases
