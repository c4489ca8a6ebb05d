module bw_galerkin_source
  !! Modes without a closed form by their numbers: as many as were solved for, and how amplitudes fall beyond them. Cases whose
  !! beam and effects do not differ may share a cache, and then solve for their modes once: what is in it is what would be found
  !! again, to the bit.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  use bw_galerkin, only: galerkin_modes
  use bw_galerkin_set, only: galerkin_set
  use bw_mode_set, only: mode_set, mode_source
  use bw_monitor, only: monitor_type, stops
  implicit none (type, external)
  private
  public :: galerkin_source_of

  integer, parameter :: most_sources = 16          !! cached at a time
  integer, parameter :: most_modes = 128           !! of one that is cached: all together take less than 20 MB

  type, extends(mode_source), public :: galerkin_source
    type(galerkin_set) :: solved                   !! the first modes, from which others are taken
  contains
    procedure :: find => find_among_solved
  end type galerkin_source

  type :: cache_entry
    type(beam_operator) :: operator
    type(galerkin_source) :: source
  end type cache_entry

  type, public :: galerkin_cache
    !! Sources in the order in which they came; the newest replaces the oldest.
    private
    type(cache_entry), allocatable :: entries(:)
    integer :: found = 0                           !! that were ever cached
  contains
    procedure :: find => find_source
  end type galerkin_cache

contains

  subroutine galerkin_source_of(operator, count, source, monitor)
    !! Make a source of the first `count` modes, and none beyond them.
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count
    type(galerkin_source), intent(out) :: source
    class(monitor_type), intent(inout), optional :: monitor   !! none are found where it asks to stop
    call galerkin_modes(operator, count, source%solved, monitor)
    source%gamma = operator%gamma
    source%highest = count
    source%decay = decay_of(operator, count)
  end subroutine galerkin_source_of

  pure real(dp) function decay_of(operator, count) result(decay)
    !! The n of |Φ_k(1)Φ_k(ξ)|/(M_kβ_k) ∝ k⁻ⁿ beyond mode `count`: 3 where the tip mass holds the beam, α being above 1/γ; 2 where
    !! the mass is light, or waves are those of shear or of a string.
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count
    real(dp) :: alpha
    alpha = count*acos(-1.0_dp)
    decay = 3.0_dp
    if (alpha*operator%gamma < 1.0_dp .or. allocated(operator%shear)) decay = 2.0_dp
    if (.not. allocated(operator%tension)) return
    if (alpha**2 < operator%tension(1)) decay = 2.0_dp
  end function decay_of

  subroutine find_among_solved(self, number, modes, longest, monitor)
    !! Find the modes of these numbers among those that were solved for. `longest` has no use here: β² has the digits that it
    !! has. Nor has the monitor: all is found already.
    class(galerkin_source), intent(in) :: self
    integer, intent(in) :: number(:)
    class(mode_set), allocatable, intent(out) :: modes
    real(dp), intent(in), optional :: longest
    class(monitor_type), intent(inout), optional :: monitor
    type(galerkin_set), allocatable :: found
    allocate (found)
    associate (all => self%solved)
      call found%take_numbers(all, number)
      found%body = all%body
      found%deflection = all%deflection(:, number)
      found%strain = all%strain(:, number)
      if (allocated(all%turning)) found%turning = all%turning(:, number)
    end associate
    call found%damp(self%damping)
    if (present(longest) .or. present(monitor)) continue
    call move_alloc(found, modes)
  end subroutine find_among_solved

  ! The cache

  subroutine find_source(self, operator, count, source, monitor)
    !! Make the source as `galerkin_source_of` does, or find it in the cache.
    class(galerkin_cache), intent(inout) :: self
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count
    type(galerkin_source), intent(out) :: source
    class(monitor_type), intent(inout), optional :: monitor   !! none are found, nor cached, where it asks to stop
    integer :: place
    if (.not. allocated(self%entries)) allocate (self%entries(most_sources))
    do place = 1, min(self%found, most_sources)
      if (self%entries(place)%source%highest /= count) cycle
      if (.not. self%entries(place)%operator == operator) cycle
      source = self%entries(place)%source
      return
    end do
    call galerkin_source_of(operator, count, source, monitor)
    if (stops(monitor)) return
    if (count > most_modes) return
    place = 1 + mod(self%found, most_sources)
    self%entries(place)%operator = operator
    self%entries(place)%source = source
    self%found = self%found + 1
  end subroutine find_source

end module bw_galerkin_source
