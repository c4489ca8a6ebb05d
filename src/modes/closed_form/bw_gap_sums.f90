module bw_gap_sums
  !! Sums Σ_k w_k/(α_i⁴ − ᾱ_k⁴) over two sets of modes, one of the beam alone and one with the mass at its tip: what Eq. 26,
  !! and the way back when the mass leaves, come down to.
  !!
  !! Few modes are summed pair by pair. For many the pairs that lie apart are summed by cells (bw_far_field), in time
  !! proportional to the number of modes, and only neighbours pair by pair.
  use bw_double_double, only: add_exactly, dd
  use bw_far_field, only: add_far_field, cells_to, first_in_cells
  use bw_frequency_equation, only: root_type
  use bw_kinds, only: dp, i8
  use bw_monitor, only: monitor_type, stops
  use bw_root_difference, only: fourth_power_difference
  use bw_root_list, only: root_values
  implicit none (type, external)
  private
  public :: gap_sums, pair_sums

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: chunk = 256                  !! tuned: sums whose arrays stay in the fastest cache
  integer(i8), parameter, public :: most_pairs = 4000000_i8
    !! tuned: so many take as long pair by pair as by cells, some ms

contains

  function gap_sums(onto, from, weight, onto_free, monitor) result(sums)
    !! Σ_k w_k/(α_i⁴ − α_k⁴) for all i.
    !! **Errors**: within 1e-14 of the sum of the terms' magnitudes.
    type(root_type), intent(in) :: onto(:)           !! i, ascending
    type(root_type), intent(in) :: from(:)           !! k, ascending
    real(dp), intent(in) :: weight(:)                !! (size(from))
    logical, intent(in) :: onto_free                 !! `onto` are without the mass, else `from` are
    class(monitor_type), intent(inout), optional :: monitor   !! the sums mean nothing where it asks to stop
    real(dp) :: sums(size(onto))
    integer :: first, last
    if (int(size(onto), i8)*size(from) > most_pairs) then
      sums = 0.0_dp
      call add_far_field(onto, from, weight, sums, monitor)
      call add_neighbours(onto, from, weight, onto_free, sums, monitor)
    else
      do first = 1, size(onto), chunk
        last = min(first + chunk - 1, size(onto))
        sums(first:last) = pair_sums(onto(first:last), from, weight, onto_free)
      end do
    end if
  end function gap_sums

  subroutine add_neighbours(onto, from, weight, onto_free, sums, monitor)
    !! What the far field leaves out: pairs in one cell, or in two that touch.
    type(root_type), intent(in) :: onto(:), from(:)
    real(dp), intent(in) :: weight(:)
    logical, intent(in) :: onto_free
    real(dp), intent(inout) :: sums(:)
    class(monitor_type), intent(inout), optional :: monitor
    integer, parameter :: between_questions = 64     ! cells, about a ms
    integer, allocatable :: here(:), there(:)
    integer :: c, cells, first, last
    cells = max(cells_to(onto), cells_to(from))
    allocate (here, source=first_in_cells(onto, cells))
    allocate (there, source=first_in_cells(from, cells))
    do c = 1, cells
      if (mod(c, between_questions) == 0) then
        if (stops(monitor)) return
        if (present(monitor)) call monitor%advance(real(c, dp)/cells)
      end if
      first = there(max(1, c - 1))
      last = there(min(cells, c + 1) + 1) - 1
      associate (i => here(c), j => here(c + 1) - 1)
        sums(i:j) = sums(i:j) + pair_sums(onto(i:j), from(first:last), weight(first:last), onto_free)
      end associate
    end do
  end subroutine add_neighbours

  pure function pair_sums(onto, from, weight, onto_free) result(sums)
    !! The same pair by pair, for all i at a time in vector registers; each sum is rounded about once (Neumaier).
    type(root_type), intent(in) :: onto(:)           !! a few hundred
    type(root_type), intent(in) :: from(:)
    real(dp), intent(in) :: weight(:)
    logical, intent(in) :: onto_free
    real(dp) :: sums(size(onto))
    real(dp), dimension(size(onto)) :: eighths, alpha, square, gap, lost
    type(dd) :: value(max(size(onto), size(from)))
    integer :: i, k
    sums = 0.0_dp
    lost = 0.0_dp
    if (size(onto) == 0) return
    value(:size(onto)) = root_values(onto)
    alpha = value(:size(onto))%hi
    value(:size(from)) = root_values(from)
    eighths = onto%eighths
    square = alpha**2
    i = 1
    do k = 1, size(from)
      associate (other => from(k), other_alpha => value(k)%hi)
        gap = (0.25_dp*pi*(eighths - other%eighths) + (onto%rest - other%rest))*(alpha + other_alpha)*(square + other_alpha**2)
        do while (i < size(onto) .and. onto(i)%k < other%k)
          i = i + 1
        end do
        if (onto(i)%k == other%k) gap(i) = own_gap(onto(i), other, onto_free)
        call add_exactly(weight(k)/gap, sums, lost)
      end associate
    end do
    sums = sums + lost
  end function pair_sums

  elemental real(dp) function own_gap(onto, from, onto_free) result(gap)
    !! α⁴ − ᾱ⁴ of two modes of the same number, which may nearly agree.
    type(root_type), intent(in) :: onto, from
    logical, intent(in) :: onto_free
    if (onto_free) then
      gap = fourth_power_difference(onto, from)
    else
      gap = -fourth_power_difference(from, onto)
    end if
  end function own_gap

end module bw_gap_sums
