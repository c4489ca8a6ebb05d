module bw_tapered_search
  !! All lines of a record of lines and rounding without noise, as that of a simulation: peaks are examined in the order of their
  !! strength, lines that share bins of the tapered transform are fitted together, and the residual is searched again until no
  !! peak is significant.
  use bw_kinds, only: dp
  use bw_line, only: line_type
  use bw_line_group, only: group_type, refit_group
  use bw_monitor, only: monitor_type, stops
  use bw_order, only: ascending
  use bw_tapered_line, only: position_of
  use bw_tapered_residual, only: find_residual, residual_type, strength, visible_peaks
  implicit none (type, external)
  private
  public :: find_pure_lines, line_groups

  integer, parameter :: max_rounds = 16
  integer, parameter :: most_lines = 200
  real(dp), parameter :: separation = 10            !! bins, at which sidelobes are below 1e-6
  integer, parameter :: beside = 3             !! bins; within the main lobe
  real(dp), parameter :: line_work = 0.045_dp  !! of subtracting a line, relative to two tapered transforms; measured

  type :: closed_type
    !! A peak where a further line did not help.
    integer :: bin = 0
    integer :: neighbours = 0                  !! lines near it at that time: a new one removes its leakage
  end type closed_type

contains

  subroutine find_pure_lines(record, lines, residual, monitor)
    !! Find the lines of a record, by ascending position, and their residual; both are undefined after a stop request.
    real(dp), intent(in) :: record(0:, :)      !! (N, S), not zero everywhere
    type(line_type), allocatable, intent(out) :: lines(:)
    type(residual_type), intent(out) :: residual
    class(monitor_type), intent(inout), optional :: monitor
    integer, allocatable :: peak(:)
    type(closed_type), allocatable :: closed(:)
    real(dp) :: size_now, size_before, work
    integer :: round
    allocate (lines(0), peak(0), closed(0))
    call find_residual(record, lines, residual, monitor)
    size_before = huge(1.0_dp)
    work = residual_work(0)
    do round = 1, max_rounds
      if (stops(monitor)) return
      peak = open_peaks(visible_peaks(residual), position_of(lines, residual%count), closed)
      if (round == 1 .and. size(peak) == 0) peak = [maxloc(strength(residual), dim=1) - 1]  ! lines in every bin
      size_now = maxval(abs(residual%tapered))
      if (size(peak) == 0 .and. size_now > 0.5_dp*size_before) exit
      if (size(lines) + size(peak) > most_lines) exit
      size_before = size_now
      if (present(monitor)) call monitor%advance(work/(work + 2*residual_work(size(lines) + size(peak))))
      call fit_groups(residual, peak, lines, closed, monitor)
      if (stops(monitor)) return
      call find_residual(record, lines, residual, monitor)
      work = work + residual_work(size(lines))
    end do
  end subroutine find_pure_lines

  pure real(dp) function residual_work(lines) result(work)
    !! The work of finding a residual, relative to that without lines.
    integer, intent(in) :: lines
    work = 1.0_dp + lines*line_work
  end function residual_work

  pure function open_peaks(peak, position, closed) result(open)
    !! The peaks without those where a further line has already failed to help among the same neighbours.
    integer, intent(in) :: peak(:)
    real(dp), intent(in) :: position(:)        !! of the lines
    type(closed_type), intent(in) :: closed(:)
    integer, allocatable :: open(:)
    logical :: holds(size(closed))
    integer :: i
    holds = [(closed(i)%neighbours == near(closed(i)%bin, position), i=1, size(closed))]
    allocate (open, source=pack(peak, [(all(abs(closed%bin - peak(i)) > beside .or. .not. holds), i=1, size(peak))]))
  end function open_peaks

  pure integer function near(bin, position)
    !! The number of positions that share bins with a group at this bin.
    integer, intent(in) :: bin
    real(dp), intent(in) :: position(:)
    near = count(abs(position - bin) < 2*separation)
  end function near

  subroutine fit_groups(residual, peak, lines, closed, monitor)
    !! Fit each group of lines and new peaks; peaks that gave no line are closed.
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: peak(:)
    type(line_type), allocatable, intent(inout) :: lines(:)
    type(closed_type), allocatable, intent(inout) :: closed(:)
    class(monitor_type), intent(inout), optional :: monitor
    type(line_type), allocatable :: fitted(:)
    type(group_type), allocatable :: group(:)
    integer :: i, j, lines_before
    allocate (group, source=line_groups(lines, peak, residual%count))
    allocate (fitted(0))
    do i = 1, size(group)
      if (stops(monitor)) return
      lines_before = size(group(i)%lines)
      call refit_group(residual, group(i))
      fitted = [fitted, group(i)%lines]
      if (size(group(i)%lines) > lines_before) cycle
      do j = 1, size(group(i)%peaks)
        closed = [closed, closed_type(group(i)%peaks(j), near(group(i)%peaks(j), position_of(lines, residual%count)))]
      end do
    end do
    lines = fitted
  end subroutine fit_groups

  pure function line_groups(lines, peak, count) result(group)
    !! The groups of lines and peaks by ascending position, divided at gaps of more than `separation` bins.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: peak(:)
    integer, intent(in) :: count               !! samples
    type(group_type), allocatable :: group(:)
    real(dp) :: position(size(lines) + size(peak)), before
    integer :: order(size(position)), i, j
    position = [position_of(lines, count), real(peak, dp)]
    order = ascending(position)
    allocate (group(0))
    before = -2*separation
    do i = 1, size(order)
      j = order(i)
      if (position(j) - before > separation) group = [group, group_type()]
      before = position(j)
      associate (last => group(size(group)))
        if (.not. allocated(last%lines)) allocate (last%lines(0), last%peaks(0))
        if (j <= size(lines)) then
          last%lines = [last%lines, lines(j)]
        else
          last%peaks = [last%peaks, peak(j - size(lines))]
        end if
      end associate
    end do
  end function line_groups

end module bw_tapered_search
