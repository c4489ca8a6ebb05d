module bw_strain_cache
  !! Sources of modes by strains, shared by cases of a sweep with the same beam and effects. Cached modes equal
  !! recomputed ones to the bit.
  use bw_monitor, only: monitor_type, stops
  use bw_strain_source, only: strain_problem, strain_source, strain_source_of
  implicit none (type, external)
  private

  integer, parameter :: most_sources = 16          !! most sources in the cache
  integer, parameter :: most_squares = 600000
    !! most for the sum of squared mode counts, proportional to memory: together less than 50 MB

  type :: cache_entry
    type(strain_problem), allocatable :: problem   !! unallocated: empty entry
    type(strain_source), allocatable :: source
  end type cache_entry

  type, public :: strain_cache
    !! Sources in the order of their entry. New ones replace the oldest.
    private
    type(cache_entry), allocatable :: entries(:)
    integer :: found = 0                           !! entries made so far
  contains
    procedure :: find => find_source
    procedure, private :: keep
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
    do place = 1, most_sources
      if (count_of(self%entries(place)) /= count) cycle
      if (.not. self%entries(place)%problem == problem) cycle
      source = self%entries(place)%source
      return
    end do
    call strain_source_of(problem, count, source, monitor)
    if (.not. stops(monitor) .and. count <= int(sqrt(real(most_squares)))) call self%keep(problem, source)
  end subroutine find_source

  subroutine keep(self, problem, source)
    !! Store a source, dropping the oldest as needed.
    class(strain_cache), intent(inout) :: self
    type(strain_problem), intent(in) :: problem
    type(strain_source), intent(in) :: source
    integer :: i, place
    place = place_of(self%found + 1)
    do i = self%found + 1 - most_sources, self%found
      if (i == self%found + 1 - most_sources .or. &
          sum(count_of(self%entries)**2) + source%highest**2 > most_squares) self%entries(place_of(i)) = cache_entry()
    end do
    self%entries(place)%problem = problem
    self%entries(place)%source = source
    self%found = self%found + 1
  end subroutine keep

  elemental integer function place_of(number) result(place)
    !! Return the index of the n-th entry.
    integer, intent(in) :: number
    place = 1 + modulo(number, most_sources)
  end function place_of

  elemental integer function count_of(entry) result(count)
    !! Return the number of modes of an entry; 0 if it is empty.
    type(cache_entry), intent(in) :: entry
    count = 0
    if (allocated(entry%source)) count = entry%source%highest
  end function count_of

end module bw_strain_cache
