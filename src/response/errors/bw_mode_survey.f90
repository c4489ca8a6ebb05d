module bw_mode_survey
  !! A survey of the modes of a motion in order: their energies, their largest displacements at the points of a history, and
  !! their part of the flexibility there. The contribution of omitted modes follows from these sums (bw_truncation_error).
  !!
  !! The first modes are kept individually, the others in bins, 128 to an octave of mode numbers, so millions take
  !! little memory. Without dimensions: displacements in V l²/h, velocities in V, energies in m_iV².
  use bw_double_double, only: dd
  use bw_flexibility, only: flexibility_table
  use bw_kinds, only: dp
  use bw_mode_set, only: batch, curvatures, first_numbers, mode_set, mode_source, values_at
  use bw_monitor, only: monitor_type, stops
  use bw_reach, only: amplitude_of, stretch_type
  implicit none (type, external)
  private

  integer, parameter :: single = 256               !! modes kept individually
  integer, parameter :: bins_an_octave = 128
  real(dp), parameter :: farthest = 1.0e150_dp !! largest displacement of a growing mode in the sums, whose square does not overflow

  type, public :: mode_bin
    !! A bin of consecutive modes.
    integer :: last = 0                            !! number of the last mode
    integer :: modes = 0
    real(dp) :: square = 0.0_dp                    !! β² of the last
    real(dp) :: damping = 0.0_dp                   !! c of the last
    real(dp) :: mean_square = 0.0_dp               !! mean of β²
    real(dp) :: energy = 0.0_dp                    !! ½ΣM(q̇² + β²q²)
    real(dp) :: size_of_energy = 0.0_dp            !! the same with |β²|
  end type mode_bin

  type, public :: point_sums
    !! Sums over the modes of a bin at one point.
    real(dp) :: share = 0.0_dp                     !! ΣΦ(ξ)²/M
    real(dp) :: reach = 0.0_dp                     !! Σ|A|, with A the largest displacement of the point in a mode
    real(dp) :: square = 0.0_dp                    !! ΣA²
    real(dp) :: largest = 0.0_dp                   !! the largest |A|
    real(dp) :: rate_square = 0.0_dp               !! ΣA² of velocities
  end type point_sums

  type, public :: mode_survey
    integer :: quantity = 1                        !! deflections or curvatures (bw_mode_set)
    real(dp), allocatable :: points(:)             !! ξ, (points)
    type(stretch_type) :: stretch                  !! samples since the start of the motion
    integer, allocatable :: wanted(:)              !! mode numbers that end a bin in any case
    integer :: bins = 0                            !! complete bins
    type(mode_bin), allocatable :: bin(:)          !! (bins, with room for more)
    type(point_sums), allocatable :: at(:, :)      !! (points, bins, with room for more)
    type(flexibility_table) :: flexibility         !! of the beam at the points, as far as computed
    type(flexibility_table) :: struck              !! at the struck point
    real(dp), allocatable :: bound(:)              !! contribution of all modes beyond, if known, (points)
    real(dp) :: bound_energy = 0.0_dp              !! energy of the motion for which it holds
  contains
    procedure :: start
    procedure :: add
    procedure :: add_set
    procedure :: add_source
    procedure :: count => surveyed
    procedure :: bin_of
  end type mode_survey

contains

  subroutine start(self, quantity, points, stretch, wanted)
    !! Start an empty survey.
    class(mode_survey), intent(out) :: self
    integer, intent(in) :: quantity
    real(dp), intent(in) :: points(:)
    type(stretch_type), intent(in) :: stretch
    integer, intent(in), optional :: wanted(:)
    self%quantity = quantity
    self%points = points
    self%stretch = stretch
    allocate (self%wanted(0))
    if (present(wanted)) self%wanted = wanted
    allocate (self%bin(2*single), self%at(size(points), 2*single))
  end subroutine start

  pure integer function surveyed(self) result(count)
    !! Count the modes surveyed.
    class(mode_survey), intent(in) :: self
    count = self%bin(self%bins + 1)%modes
    if (self%bins > 0) count = count + self%bin(self%bins)%last
  end function surveyed

  pure integer function bin_of(self, count) result(bin)
    !! Return the bin that ends with mode `count`; 0: none.
    class(mode_survey), intent(in) :: self
    integer, intent(in) :: count
    bin = findloc(self%bin(:self%bins)%last, count, dim=1)
  end function bin_of

  pure integer function end_of_bin(self, number) result(last)
    !! Return the last mode of the bin of a mode.
    class(mode_survey), intent(in) :: self
    integer, intent(in) :: number
    integer :: width
    last = number
    if (number > single) then
      width = 1
      do while (number > 2*bins_an_octave*width)
        width = 2*width
      end do
      last = ((number - 1)/width + 1)*width
    end if
    last = min(last, minval(self%wanted, mask=self%wanted >= number))
  end function end_of_bin

  subroutine make_room(self, more)
    !! Make room for more bins.
    class(mode_survey), intent(inout) :: self
    integer, intent(in) :: more
    type(mode_bin), allocatable :: bin(:)
    type(point_sums), allocatable :: at(:, :)
    integer :: n
    n = size(self%bin)
    if (self%bins + more <= n) return
    allocate (bin(2*(n + more)), at(size(self%points), 2*(n + more)))
    bin(:n) = self%bin
    at(:, :n) = self%at
    call move_alloc(bin, self%bin)
    call move_alloc(at, self%at)
  end subroutine make_room

  subroutine add(self, square, damping, q, rate, mass, shapes)
    !! Add the next modes with their initial state.
    class(mode_survey), intent(inout) :: self
    type(dd), intent(in) :: square(:)              !! β², (modes)
    real(dp), intent(in) :: damping(:)             !! c
    real(dp), intent(in) :: q(:), rate(:)
    real(dp), intent(in) :: mass(:)                !! M
    real(dp), intent(in) :: shapes(:, :)           !! Φ(ξ), or curvatures, (modes, points)
    real(dp), dimension(size(square)) :: moved, moved_rate
    integer :: ended, k, number, p
    if (allocated(self%bound)) deallocate (self%bound)
    moved = amplitude_of(square, damping, q, rate, self%stretch, .false.)
    moved_rate = amplitude_of(square, damping, q, rate, self%stretch, .true.)
    number = self%count()
    call make_room(self, size(square) + 1)
    ended = end_of_bin(self, number + 1)
    do k = 1, size(square)
      associate (bin => self%bin(self%bins + 1), at => self%at(:, self%bins + 1))
        bin%modes = bin%modes + 1
        bin%mean_square = bin%mean_square + square(k)%hi
        bin%energy = bin%energy + 0.5_dp*mass(k)*(rate(k)**2 + square(k)%hi*q(k)**2)
        bin%size_of_energy = bin%size_of_energy + 0.5_dp*mass(k)*(rate(k)**2 + abs(square(k)%hi)*q(k)**2)
        do p = 1, size(at)
          at(p)%share = at(p)%share + shapes(k, p)**2/mass(k)
          at(p)%reach = at(p)%reach + moved(k)*abs(shapes(k, p))
          at(p)%square = at(p)%square + min(farthest, moved(k)*abs(shapes(k, p)))**2
          at(p)%largest = max(at(p)%largest, moved(k)*abs(shapes(k, p)))
          at(p)%rate_square = at(p)%rate_square + min(farthest, moved_rate(k)*abs(shapes(k, p)))**2
        end do
        number = number + 1
        if (number < ended) cycle
        bin%last = number
        bin%mean_square = bin%mean_square/bin%modes
        bin%square = square(k)%hi
        bin%damping = damping(k)
      end associate
      self%bins = self%bins + 1
      ended = end_of_bin(self, number + 1)
    end do
  end subroutine add

  subroutine add_set(self, modes, first, last, q, rate)
    !! Add consecutive modes of a set.
    class(mode_survey), intent(inout) :: self
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: first, last             !! indices in the set
    real(dp), intent(in) :: q(:), rate(:)          !! of all modes of the set, or more
    real(dp) :: damping(batch)
    integer :: a, e
    damping = 0.0_dp
    do a = first, last, batch
      e = min(a + batch - 1, last)
      if (allocated(modes%damping)) damping(:e - a + 1) = modes%damping(a:e)
      call self%add(modes%beta_squared(a:e), damping(:e - a + 1), q(a:e), rate(a:e), modes%modal_mass(a:e), &
                    values_at(modes, self%quantity, a, e, self%points))
    end do
  end subroutine add_set

  subroutine add_source(self, source, force, last, monitor)
    !! Add all modes up to number `last`, undeflected at the start, with velocities force·Φ_k(ξ₀)/M_k.
    class(mode_survey), intent(inout) :: self
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    integer, intent(in) :: last
    class(monitor_type), intent(inout), optional :: monitor   !! the survey is invalid if it requests a stop
    class(mode_set), allocatable :: modes
    type(dd) :: beta(batch)
    real(dp), dimension(batch) :: drive, mass, nothing
    real(dp) :: shapes(batch, size(self%points))
    real(dp), parameter :: no_record = 0.0_dp      ! amplitudes do not depend on phases
    integer :: first, n
    nothing = 0.0_dp
    do first = self%count() + 1, min(last, source%highest), batch
      if (stops(monitor)) return
      n = min(batch, min(last, source%highest) - first + 1)
      if (allocated(source%damping) .or. self%quantity == curvatures) then
        call source%find(first - 1 + first_numbers(n), modes, no_record, monitor)
        call self%add_set(modes, 1, n, nothing, force*modes%struck/modes%modal_mass)
      else
        call source%terms(first - 1 + first_numbers(n), self%points, no_record, beta(:n), drive(:n), shapes(:n, :), mass(:n))
        call self%add(signed_square(beta(:n)), nothing(:n), nothing(:n), force*drive(:n), mass(:n), shapes(:n, :))
      end if
    end do
  end subroutine add_source

  elemental type(dd) function signed_square(beta) result(square)
    !! Return β² with its sign from √|β²| with that sign.
    type(dd), intent(in) :: beta
    square = dd(beta%hi*abs(beta%hi))
  end function signed_square

end module bw_mode_survey
