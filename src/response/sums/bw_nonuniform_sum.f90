module bw_nonuniform_sum
  !! Histories of many stable modes by a non-uniform fast Fourier transform, in modes + samples·log(samples) steps.
  !!
  !! Every mode, at its frequency modulo the sampling rate, is spread onto a uniform grid of frequencies with the kernel of
  !! bw_spreading_kernel; a fast transform of the grid gives samples, which are divided by the kernel's transform. Sines and
  !! cosines have separate real grids from 0 to the Nyquist frequency: a motion from zero displacement needs sines for
  !! displacements and cosines for velocities. Frequencies, grid positions and weights are common to all grids. Positions are
  !! relative to the nearest grid point, computed before rounding, so no accuracy is lost in long records.
  !!
  !! **Errors**: `transform_error`, over the peak, for modes with at least one cycle in the record. The amplitude q̇/β
  !! of slower ones exceeds their motion, and the error is relative to the amplitude.
  !!
  !! **Source**: Dutt and Rokhlin (1993), doi:10.1137/0914081; Barnett, Magland and af Klinteberg (2019),
  !! doi:10.1137/18M120885X.
  use bw_kinds, only: dp, i8
  use bw_double_double, only: dd, dd_pi, rounder, operator(*), operator(/)
  use bw_mode_set, only: batch
  use bw_monitor, only: monitor_type, stops
  use bw_samples_of_grid, only: add_samples, fold_ends
  use bw_sine_sum, only: sine_sum_plan
  use bw_spread, only: rows_of, spread_modes
  use bw_spreading_kernel, only: kernel_of, spreading_kernel
  use bw_time_grid, only: time_grid
  use bw_turn, only: turn_fractions
  implicit none (type, external)
  private
  public :: points_at_once

  integer, parameter :: most_points = 16           !! tuned: points whose coefficients of a batch stay in the cache
  integer, parameter :: most_kept = 2**20          !! numbers of grids kept for the next sum, 8 MB
  integer, parameter :: most_numbers = 2**23       !! of grids in memory at a time, 64 MB; a single grid may be larger

  ! Kinds of grids, in this order, each for all points; a sum has those that are not zero.
  integer, parameter :: sines = 1, rate_cosines = 2, cosines = 3, rate_sines = 4
  logical, parameter :: of_cosines(4) = [.false., .true., .true., .false.]

  type, public :: nonuniform_sum
    !! A sum in progress: modes are added in any number of parts and transformed once. Reopened, it reuses kernel, plan
    !! and memory of the last sum if they fit.
    private
    integer :: half = 0                            !! half the points of a grid
    integer :: points = 0                          !! of the beam
    logical :: with(4) = .false.                   !! kinds of grids
    type(time_grid) :: grid
    type(spreading_kernel) :: kernel
    type(sine_sum_plan) :: plan
    real(dp), allocatable :: spectra(:, :)
      !! (2·half grid points, with room for the kernel, points·kinds); half the kernel's width lies before the first
    real(dp), allocatable :: start(:), start_dot(:)   !! the sum at t = 0, (points)
  contains
    procedure :: open => open_sum
    procedure :: add => add_modes
    procedure :: close => close_sum
    procedure :: shrink
  end type nonuniform_sum

contains

  pure integer function points_at_once(half, samples, points, kinds) result(group)
    !! Return how many points may have grids in memory together: no more numbers than the histories, or 64 MB.
    integer, intent(in) :: half, samples, points
    integer, intent(in) :: kinds                    !! of grids
    integer(i8) :: numbers
    numbers = max(int(most_numbers, i8), int(samples, i8)*points*kinds)
    group = int(max(1_i8, min(int(min(points, most_points), i8), numbers/(2_i8*half*kinds))))
  end function points_at_once

  subroutine open_sum(self, grid, width, half, points, with_velocity, moved)
    !! Prepare a sum, and the kernel and grids that do not remain from the last.
    class(nonuniform_sum), intent(inout) :: self
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: width                    !! of the kernel
    integer, intent(in) :: half                     !! half the points of a grid of frequencies
    integer, intent(in) :: points                   !! of the beam
    logical, intent(in) :: with_velocity
    logical, intent(in) :: moved                    !! modes have initial displacements
    integer :: columns, rows
    logical :: known
    known = self%kernel%width == width .and. self%half == half .and. self%grid%samples == grid%samples
    if (.not. known) self%kernel = kernel_of(width, 2.0_dp*half/grid%samples)
    self%with = [.true., with_velocity, moved, moved .and. with_velocity]
    columns = points*count(self%with)
    rows = 2*half + rows_of(width)
    if (allocated(self%spectra)) then
      if (any(shape(self%spectra) /= [rows, columns])) deallocate (self%spectra)
    end if
    if (.not. allocated(self%spectra)) allocate (self%spectra(rows, columns))
    self%spectra = 0.0_dp
    self%half = half
    self%points = points
    self%grid = grid
    self%start = spread(0.0_dp, 1, points)
    self%start_dot = self%start
  end subroutine open_sum

  subroutine close_sum(self, displacement, velocity, monitor)
    !! Transform the sum and add its samples to histories.
    class(nonuniform_sum), intent(inout) :: self
    real(dp), intent(inout), contiguous :: displacement(:, :)   !! (samples, points)
    real(dp), intent(inout), optional, contiguous :: velocity(:, :)
    class(monitor_type), intent(inout), optional :: monitor     !! the histories are invalid if it requests a stop
    logical :: cosine(size(self%spectra, 2))
    integer :: kind, skip
    cosine = [(spread(of_cosines(kind), 1, merge(self%points, 0, self%with(kind))), kind=1, 4)]
    call fold_ends(self%half, self%kernel%width, cosine, self%spectra)
    skip = self%kernel%width/2
    call self%plan%transform(self%half, cosine, skip, self%spectra, monitor)
    if (stops(monitor)) return
    do kind = 1, 4
      if (.not. self%with(kind)) cycle
      associate (grids => self%spectra(:, first_of(self, kind):first_of(self, kind) + self%points - 1))
        if (kind == sines .or. kind == cosines) then
          call add_samples(self%kernel, self%half, of_cosines(kind), skip, grids, displacement)
        else
          call add_samples(self%kernel, self%half, of_cosines(kind), skip, grids, velocity)
        end if
      end associate
    end do
    displacement(1, :) = displacement(1, :) + self%start
    if (present(velocity)) velocity(1, :) = velocity(1, :) + self%start_dot
  end subroutine close_sum

  subroutine shrink(self)
    !! Release the memory of large grids.
    class(nonuniform_sum), intent(inout) :: self
    if (.not. allocated(self%spectra)) return
    if (size(self%spectra) > most_kept) deallocate (self%spectra)
  end subroutine shrink

  pure integer function first_of(self, kind) result(column)
    !! Return the first column of a kind of grids.
    class(nonuniform_sum), intent(in) :: self
    integer, intent(in) :: kind
    column = 1 + self%points*count(self%with(:kind - 1))
  end function first_of

  subroutine add_modes(self, beta, q_dot, shapes, q)
    !! Add modes to all grids.
    class(nonuniform_sum), intent(inout) :: self
    type(dd), intent(in), contiguous :: beta(:)     !! β > 0, (modes)
    real(dp), intent(in), contiguous :: q_dot(:)    !! modal velocities at t = 0, (modes)
    real(dp), intent(in) :: shapes(:, :)            !! Φ_k(ξ_p), (modes, points)
    real(dp), intent(in), optional, contiguous :: q(:)   !! modal displacements at t = 0, (modes); if opened with `moved`
    real(dp) :: offset(batch), side(batch), amplitude(batch)
    real(dp), allocatable :: coefficients(:, :)     ! too large for the stack with thousands of points
    type(dd) :: turns
    integer :: place(batch), first, kind, last, n, p
    turns = self%grid%step/(dd_pi*2.0_dp)
    allocate (coefficients(batch, size(self%spectra, 2)))
    do first = 1, size(beta), batch
      last = min(first + batch - 1, size(beta))
      n = last - first + 1
      call find_places(turn_fractions(beta(first:last)*turns), 4*self%half, place(:n), offset(:n), side(:n))
      do kind = 1, 4
        if (.not. self%with(kind)) cycle
        select case (kind)
        case (sines)
          amplitude(:n) = side(:n)*(q_dot(first:last)/beta(first:last)%hi)
        case (rate_cosines)
          amplitude(:n) = q_dot(first:last)
        case (cosines)
          amplitude(:n) = q(first:last)
        case (rate_sines)
          amplitude(:n) = -side(:n)*(q(first:last)*beta(first:last)%hi)
        end select
        do p = 1, self%points
          call multiply(n, amplitude, shapes(first:last, p), coefficients(:, first_of(self, kind) + p - 1))
        end do
      end do
      call spread_modes(self%kernel, place(:n) + 2, offset(:n), coefficients(:n, :), self%spectra)
    end do
    do p = 1, self%points
      if (self%with(cosines)) self%start(p) = self%start(p) + dot_product(q, shapes(:, p))
      if (self%with(rate_cosines)) self%start_dot(p) = self%start_dot(p) + dot_product(q_dot, shapes(:, p))
    end do
  end subroutine add_modes

  pure subroutine multiply(n, a, b, product)
    !! Return the elementwise product of two lists, of a length known to the compiler.
    integer, intent(in) :: n
    real(dp), intent(in) :: a(n), b(n)
    real(dp), intent(inout) :: product(n)
    product = a*b
  end subroutine multiply

  pure subroutine find_places(fraction, points, place, offset, side)
    !! Find the positions of modes among grid points m + ½, `points` to a cycle. Frequencies above Nyquist have the
    !! mirrored phase. The fraction is split so that the product with its larger part is exact.
    type(dd), intent(in) :: fraction(:)       !! cycles per sample, −½ … ½
    integer, intent(in) :: points             !! ≤ 2²⁹
    integer, intent(out) :: place(:)          !! m of the grid point to the left of the mode, from −1
    real(dp), intent(out) :: offset(:)        !! distance from there, 0 … 1 spacings
    real(dp), intent(out) :: side(:)          !! −1 for a mirrored phase, else 1
    real(dp), parameter :: coarse = 1.5_dp*2.0_dp**29        ! its last bit is 2⁻²³
    real(dp) :: large, left, position, sign_of, size_of, whole
    integer :: i
    do i = 1, size(fraction)
      sign_of = sign(1.0_dp, fraction(i)%hi)
      size_of = abs(fraction(i)%hi)
      large = (size_of + coarse) - coarse
      position = large*points
      whole = (position + rounder) - rounder
      position = (position - whole) + ((size_of - large) + sign_of*fraction(i)%lo)*points - 0.5_dp
      left = ((position - 0.5_dp) + rounder) - rounder
      offset(i) = position - left
      place(i) = int(whole + left)
      side(i) = sign_of
    end do
  end subroutine find_places

end module bw_nonuniform_sum
