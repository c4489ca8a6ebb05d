module bw_band_fit
  !! Least-squares fit of the lines in a band to all sensors and stretches at once. Stretches share only the exponents, so that the
  !! slopes of their projections are stacked.
  use bw_band, only: enough_for, holds
  use bw_band_columns, only: band_type, line_columns, trend_columns
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_line, only: has_trend, highest, line_type, pole_at, psi
  use bw_line_projection, only: find_step, project, projected_type
  implicit none (type, external)
  private
  public :: amplitudes_of, fit_band, free_of, reduce, slope_place, slopes_of, squares_left, unknown_place

  real(dp), parameter, public :: converged = 1.0e-3_dp   !! tuned: predicted decrease of the squares, in variances of the noise
  real(dp), parameter, public :: most_growth = 0.5_dp  !! e-folds of a line over the longest stretch: free decays do not grow
  integer, parameter :: most_halvings = 4
  real(dp), parameter :: longest = 0.7_dp        !! tuned: largest step of a pole, relative to its width

  type, extends(projected_type), public :: reduced_type
    !! The fit of one part.
    integer :: stretch = 0
    integer :: sensors(2) = 1                    !! first and last
  end type reduced_type

contains

  subroutine fit_band(band, with_trend, most_steps, lines, reduced, slowest, least)
    !! Refit poles and courses of the lines by Gauss–Newton steps, which are shortened until the squares fall.
    type(band_type), intent(in) :: band          !! with rows that contain these lines
    logical, intent(in) :: with_trend            !! fit an offset and a slope, too
    integer, intent(in) :: most_steps
    type(line_type), intent(inout) :: lines(:)   !! amplitudes are not used
    type(reduced_type), allocatable, intent(out) :: reduced(:)   !! (parts)
    real(dp), intent(in), optional :: slowest    !! fraction of the squares; the fit ends with a step that leaves more
    real(dp), intent(in), optional :: least      !! the fit ends at once if its first step predicts a smaller decrease
    type(reduced_type), allocatable :: trial(:)
    type(line_type) :: moved(size(lines))
    real(dp) :: step(unknown_place(lines, size(lines) + 1) - 1), gain, factor, left, before
    integer :: i, j
    reduced = reduce(band, lines, with_trend)
    left = squares_left(reduced)
    do i = 1, most_steps
      call step_of(reduced, lines, step, gain)
      if (.not. gain > converged) exit
      if (i == 1 .and. present(least)) then
        if (gain < least) exit
      end if
      factor = min(1.0_dp, 1/farthest(band, lines, step))
      do j = 0, most_halvings
        moved = moved_lines(band, lines, factor*step)
        if (all(is_held(band, moved))) then
          trial = reduce(band, moved, with_trend)
          if (squares_left(trial) < left) exit
        end if
        factor = factor/4
      end do
      if (j > most_halvings) exit
      lines = moved
      call move_alloc(trial, reduced)
      before = left
      left = squares_left(reduced)
      if (.not. present(slowest)) cycle
      if (left > slowest*before) exit
    end do
  end subroutine fit_band

  elemental logical function is_held(band, line)
    !! Whether a line stays within the band as long as it lives, and grows neither at first nor at the end.
    type(band_type), intent(in) :: band
    type(line_type), intent(in) :: line
    real(dp) :: span
    span = min(band%longest, real(maxval(band%part%used), dp))
    is_held = holds(band, line, 0.0_dp) .and. holds(band, line, span)
    if (size(line%courses) > 0) is_held = is_held .and. &
      & max(line%pole%re, real(pole_at(line, band%longest), dp))*band%longest < most_growth
  end function is_held

  pure real(dp) function squares_left(reduced)
    !! Sum of squared residuals over all stretches and sensors.
    type(reduced_type), intent(in) :: reduced(:)
    integer :: i
    squares_left = sum([(sum(reduced(i)%left), i=1, size(reduced))])
  end function squares_left

  pure integer function unknown_place(lines, k) result(place)
    !! Index of the first unknown of line k: real and imaginary part of its pole, then those of κ and the rate of each course. For k
    !! beyond the last line it is one more than the number of unknowns.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: k
    integer :: i
    place = 2*k - 1 + 3*sum([(size(lines(i)%courses), i=1, k - 1)])
  end function unknown_place

  pure integer function slope_place(lines, k) result(place)
    !! Index of the first slope column of line k: two for its pole, two for κ and two for the rate of each course.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: k
    integer :: i
    place = 2*k - 1 + 4*sum([(size(lines(i)%courses), i=1, k - 1)])
  end function slope_place

  pure function free_of(lines) result(free)
    !! The unknowns that are free: the decay of a steady line is 0, and some rates are fixed.
    type(line_type), intent(in) :: lines(:)
    logical, allocatable :: free(:)
    integer :: k, c
    allocate (free(unknown_place(lines, size(lines) + 1) - 1), source=.true.)
    do k = 1, size(lines)
      free(unknown_place(lines, k)) = .not. lines(k)%steady
      do c = 1, size(lines(k)%courses)
        free(unknown_place(lines, k) + 1 + 3*c) = .not. lines(k)%courses(c)%held
      end do
    end do
  end function free_of

  function reduce(band, lines, with_trend) result(reduced)
    !! The triangle of the lines' columns in each part of a band, and the record rotated by it.
    type(band_type), intent(in) :: band
    type(line_type), intent(in) :: lines(:)
    logical, intent(in) :: with_trend
    type(reduced_type), allocatable :: reduced(:)
    real(dp), allocatable :: matrix(:, :), columns(:, :, :)
    integer :: p, k, m, n, c, slopes
    n = 2*size(lines) + merge(2, 0, with_trend)
    allocate (reduced(size(band%part)))
    do p = 1, size(band%part)
      associate (part => band%part(p), own => reduced(p))
        own%stretch = part%stretch
        own%sensors = part%sensors
        allocate (matrix(size(part%root), n + slope_place(lines, size(lines) + 1) - 1))
        do k = 1, size(lines)
          slopes = 1 + 2*size(lines(k)%courses)
          allocate (columns(size(part%root), 2, 0:slopes))
          columns(:, :, :) = line_columns(band, part, lines(k), slopes)
          matrix(:, 2*k - 1:2*k) = columns(:, :, 0)
          do m = 1, slopes
            c = n + slope_place(lines, k) + 2*(m - 1)
            matrix(:, c:c + 1) = columns(:, :, m)
          end do
          deallocate (columns)
        end do
        if (with_trend) then
          matrix(:, n - 1:n) = 0
          if (has_trend(lines, nint(band%longest), part%length)) matrix(:, n - 1:n) = trend_columns(band, part)
        end if
        call project(matrix, part%rows, n, own)
        deallocate (matrix)
      end associate
    end do
  end function reduce

  pure function slopes_of(reduced, lines) result(matrix)
    !! The derivatives of all rows by the free unknowns, with amplitudes, offset and slope eliminated, (rows, unknowns).
    type(reduced_type), intent(in) :: reduced(:)
    type(line_type), intent(in) :: lines(:)
    real(dp), allocatable :: matrix(:, :)
    logical, allocatable :: free(:)
    complex(dp) :: amplitude
    integer :: p, s, k, i, j, c, row, n
    free = free_of(lines)
    n = 0
    do p = 1, size(reduced)
      n = n + max(0, size(reduced(p)%triangle, 1) - reduced(p)%linear)*size(reduced(p)%rotated, 2)
    end do
    allocate (matrix(n, size(free)), source=0.0_dp)
    row = 0
    do p = 1, size(reduced)
      associate (own => reduced(p))
        n = size(own%triangle, 1) - own%linear
        if (n <= 0) cycle
        do s = 1, size(own%rotated, 2)
          do k = 1, size(lines)
            amplitude = cmplx(own%linear_part(2*k - 1, s), own%linear_part(2*k, s), dp)
            i = unknown_place(lines, k)
            c = own%linear + slope_place(lines, k)
            matrix(row + 1:row + n, i) = slope_of(own, c, amplitude, n)
            matrix(row + 1:row + n, i + 1) = slope_of(own, c, (0, 1)*amplitude, n)
            do j = 1, size(lines(k)%courses)
              matrix(row + 1:row + n, i + 3*j - 1) = slope_of(own, c + 4*j - 2, amplitude, n)
              matrix(row + 1:row + n, i + 3*j) = slope_of(own, c + 4*j - 2, (0, 1)*amplitude, n)
              matrix(row + 1:row + n, i + 3*j + 1) = slope_of(own, c + 4*j, lines(k)%courses(j)%bend*amplitude, n)
            end do
          end do
          row = row + n
        end do
      end associate
    end do
    if (.not. all(free)) matrix = matrix(:, pack([(c, c=1, size(free))], free))
  end function slopes_of

  pure function slope_of(own, c, amplitude, rows) result(slope)
    !! The rows below those of the amplitudes of two slope columns, times an amplitude. Elements below the diagonal of R hold other
    !! data.
    type(reduced_type), intent(in) :: own
    integer, intent(in) :: c                     !! the first column
    complex(dp), intent(in) :: amplitude
    integer, intent(in) :: rows
    real(dp) :: slope(rows)
    integer :: held
    slope = 0
    held = min(rows, c - own%linear)
    slope(:held) = amplitude%re*own%length(c)*own%triangle(own%linear + 1:own%linear + held, c)
    held = min(rows, c - own%linear + 1)
    slope(:held) = slope(:held) + amplitude%im*own%length(c + 1)*own%triangle(own%linear + 1:own%linear + held, c + 1)
  end function slope_of

  subroutine step_of(reduced, lines, step, gain)
    !! The Gauss–Newton step of the unknowns, and the decrease of the squares that it predicts.
    type(reduced_type), intent(in) :: reduced(:)
    type(line_type), intent(in) :: lines(:)
    real(dp), intent(out) :: step(:), gain
    real(dp), allocatable :: matrix(:, :), right(:)
    logical, allocatable :: free(:)
    integer :: p, s
    matrix = slopes_of(reduced, lines)
    free = free_of(lines)
    right = [((reduced(p)%rotated(reduced(p)%linear + 1:, s), s=1, size(reduced(p)%rotated, 2)), p=1, size(reduced))]
    call find_step(matrix, right, step(:count(free)), gain)
    step = unpack(step(:count(free)), free, 0.0_dp)
  end subroutine step_of

  pure real(dp) function farthest(band, lines, step)
    !! The longest step of a pole over the largest allowed: a fraction of its width, and a fraction of a period by its courses.
    type(band_type), intent(in) :: band
    type(line_type), intent(in) :: lines(:)
    real(dp), intent(in) :: step(:)
    real(dp) :: span, width
    integer :: k, c, i
    span = maxval(band%part%used)
    farthest = tiny(1.0_dp)
    do k = 1, size(lines)
      i = unknown_place(lines, k)
      width = max(abs(lines(k)%pole%re), 2/span)
      farthest = max(farthest, hypot(step(i), step(i + 1))/(longest*width))
      do c = 1, size(lines(k)%courses)
        associate (g => lines(k)%courses(c)%rate)
          farthest = max(farthest, hypot(step(i + 3*c - 1), step(i + 3*c))*psi(g, min(span, 1/width)), &
            & abs(step(i + 3*c + 1))/(longest*max(g, 0.5_dp/span)))
        end associate
      end do
    end do
  end function farthest

  pure function moved_lines(band, lines, step) result(moved)
    !! The lines after a step. Frequencies stay between 0 and half the sampling rate, and growth is limited.
    type(band_type), intent(in) :: band
    type(line_type), intent(in) :: lines(:)
    real(dp), intent(in) :: step(:)
    type(line_type) :: moved(size(lines))
    real(dp) :: span
    integer :: k, c, i
    span = maxval(band%part%used)
    moved = lines
    do k = 1, size(lines)
      i = unknown_place(lines, k)
      associate (z => moved(k)%pole)
        z = z + cmplx(step(i), step(i + 1), dp)
        if (band%tapered) then                   ! its lines may grow, and meet their mirror images
          z = cmplx(max(-highest/span, min(highest/span, z%re)), min(abs(z%im), 2*pi - abs(z%im)), dp)
          cycle
        end if
        z = cmplx(min(z%re, most_growth/max(band%longest, 1.0_dp*enough_for(1))), max(1/span, min(pi - 1/span, z%im)), dp)
      end associate
      do c = 1, size(lines(k)%courses)
        associate (course => moved(k)%courses(c))
          course%bend = course%bend + cmplx(step(i + 3*c - 1), step(i + 3*c), dp)
          course%rate = max(0.0_dp, course%rate + step(i + 3*c + 1))
        end associate
      end do
    end do
  end function moved_lines

  pure function amplitudes_of(reduced, k, stretches, sensors) result(amplitude)
    !! The amplitudes of line k in each stretch, (S, stretches from the one before any blow on); 0 in stretches without rows.
    type(reduced_type), intent(in) :: reduced(:)
    integer, intent(in) :: k, stretches, sensors
    complex(dp) :: amplitude(sensors, stretches)
    integer :: p
    amplitude = 0
    do p = 1, size(reduced)
      associate (x => reduced(p)%linear_part)
        amplitude(reduced(p)%sensors(1):reduced(p)%sensors(2), reduced(p)%stretch + 1) = cmplx(x(2*k - 1, :), x(2*k, :), dp)
      end associate
    end do
  end function amplitudes_of

end module bw_band_fit
