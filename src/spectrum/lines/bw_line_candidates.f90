module bw_line_candidates
  !! Where lines may be: at peaks of what is left, and at poles of a group's bins.
  use bw_kinds, only: dp
  use bw_line, only: line_type, points
  use bw_line_image, only: add_lines
  use bw_line_poles, only: find_poles, pencil_of, pencil_type, rank_of
  use bw_line_residual, only: plain_bins, residual_type
  implicit none (type, external)
  private
  public :: ample_pencil, peak_lines, pole_lines

  integer, parameter :: least_beside = 5       !! bins beside a group that help to find its poles
  integer, parameter :: most_beside = 40
  real(dp), parameter :: at_edge = 1.0e-3_dp   !! bins; a pole that near 0 from below is no mirror image
  real(dp), parameter :: grows = 1.0e-3_dp     !! over the record; slower motion at 0 is a drift, which is a line's too
  real(dp), parameter :: most_growth = 300     !! over the record

contains

  pure function peak_lines(residual, peaks) result(lines)
    !! A line at each peak, its offset by a parabola through the logarithms of three bins.
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: peaks(:)
    type(line_type) :: lines(size(peaks))
    real(dp) :: value(-1:1)
    integer :: i, m
    lines%bin = peaks
    do i = 1, size(peaks)
      if (peaks(i) == 0 .or. peaks(i) == ubound(residual%windowed, 1)) cycle
      value = [(norm2(abs(residual%windowed(peaks(i) + m, :))), m=-1, 1)]
      if (any(value <= 0)) cycle
      value = log(value)
      lines(i)%offset = (value(1) - value(-1))/max(2*(2*value(0) - value(1) - value(-1)), 1.0_dp)
      lines(i)%offset = max(-0.5_dp, min(0.5_dp, lines(i)%offset))
    end do
  end function peak_lines

  subroutine ample_pencil(residual, own, bins, noise, pencil, rank)
    !! A pencil over so many bins that its rank, which counts the lines, is well below its size.
    type(residual_type), intent(in) :: residual
    type(line_type), intent(in) :: own(:)
    integer, intent(in) :: bins(2)
    real(dp), intent(in) :: noise
    type(pencil_type), intent(out) :: pencil
    integer, intent(out) :: rank
    integer :: beside
    beside = least_beside
    do
      pencil = group_pencil(residual, own, bins, beside)
      rank = rank_of(pencil, noise)
      if (4*rank < 3*size(pencil%singular) .or. beside > most_beside .or. 2*beside > residual%count) exit
      beside = 2*beside
    end do
  end subroutine ample_pencil

  function group_pencil(residual, own, bins, beside) result(pencil)
    !! Pencil of the group's bins and some beside them; on both sides of 0 where the group is near it.
    type(residual_type), intent(in) :: residual
    type(line_type), intent(in) :: own(:)      !! lines of the group so far, which `residual` is without
    integer, intent(in) :: bins(2), beside
    type(pencil_type) :: pencil
    complex(dp), allocatable :: image(:, :)
    integer :: first, last
    first = bins(1) - beside
    last = bins(2) + beside
    if (bins(1) == 0) first = -last
    if (bins(2) == residual%count/2) last = residual%count - first
    if (last - first >= residual%count) then
      first = -((residual%count - 1)/2)
      last = residual%count/2
    end if
    allocate (image(first:last, points), source=plain_bins(residual, first, last))
    call add_lines(own, residual%count, first, image, 1.0_dp, .false.)
    pencil = pencil_of(image, first, residual%count)
  end function group_pencil

  function pole_lines(pencil, rank, bins) result(lines)
    !! Lines at the poles that lie among the group's bins; mirror images at negative frequency are left out. A pole at
    !! 0 that grows is a real exponential: put there exactly, it stays, having no phase and no slope by its offset.
    type(pencil_type), intent(in) :: pencil
    integer, intent(in) :: rank, bins(2)
    type(line_type), allocatable :: lines(:)
    real(dp), allocatable :: position(:), growth(:)
    integer :: i
    allocate (lines(0))
    call find_poles(pencil, rank, position, growth)
    where (abs(position) < at_edge .and. abs(growth) > grows) position = 0
    do i = 1, size(position)
      if (position(i) < max(bins(1) - 1.0_dp, -at_edge) .or. position(i) > bins(2) + 1) cycle
      if (2*position(i) > pencil%count + at_edge .or. abs(growth(i)) > most_growth) cycle
      lines = [lines, line_type(bin=nint(position(i)), offset=position(i) - nint(position(i)), growth=growth(i))]
    end do
  end function pole_lines

end module bw_line_candidates
