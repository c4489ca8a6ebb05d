module bw_strain_cache
  !! Sources of modes by strains, shared by cases of a sweep with the same beam and effects. Cached modes equal
  !! recomputed ones to the bit.
  use bw_monitor, only: monitor_type, stops
  use bw_strain_source, only: strain_problem, strain_source, strain_source_of
  implicit none (type, external)
  private

  integer, parameter :: most_sources = 8           !! most sources in the cache
  integer, parameter :: most_modes = 300           !! most modes of a cached source: together less than 50 MB

  type :: cache_entry
    type(strain_problem), allocatable :: problem
    type(strain_source), allocatable :: source
  end type cache_entry

  type, public :: strain_cache
    !! Sources in the order of their entry. New ones replace the oldest.
    private
    type(cache_entry), allocatable :: entries(:)
    integer :: found = 0                           !! entries made so far
  contains
    procedure :: find => find_source
  end type strain_cache

contains

  subroutine find_source(self, problem, count, source, monitor)
    !! Find a source in the cache, or make it as `strain_source_of` does.
    class(strain_cache), intent(inout) :: self
    type(strain_problem), intent(in) :: problem
    integer, intent(in) :: count
    type(strain_source), intent(out) :: source
    class(monitor_type), intent(inout), optional :: monitor   !! none are found or cached if it requests a stop
    integer :: place
    if (.not. allocated(self%entries)) allocate (self%entries(most_sources))
    do place = 1, min(self%found, most_sources)
      associate (entry => self%entries(place))
        if (entry%source%highest /= count) cycle
        if (.not. entry%problem == problem) cycle
        source = entry%source
        return
      end associate
    end do
    call strain_source_of(problem, count, source, monitor)
    if (stops(monitor) .or. count > most_modes) return
    place = 1 + mod(self%found, most_sources)
    self%entries(place)%problem = problem
    self%entries(place)%source = source
    self%found = self%found + 1
  end subroutine find_source

end module bw_strain_cache
