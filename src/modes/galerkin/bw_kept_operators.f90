module bw_kept_operators
  !! Modes without a closed form that cases share: those whose beam and effects do not differ solve for them once. What is
  !! kept is what would be found again, to the bit.
  use bw_beam_operator, only: beam_operator
  use bw_galerkin_source, only: galerkin_source, galerkin_source_of
  use bw_monitor, only: monitor_type, stops
  implicit none (type, external)
  private

  integer, parameter :: most_operators = 16        !! kept at a time
  integer, parameter :: most_modes = 128           !! of one that is kept: all together take less than 20 MB

  type :: kept_operator
    type(beam_operator) :: operator
    type(galerkin_source) :: source
  end type kept_operator

  type, public :: kept_operators
    !! In the order in which they came; the oldest makes room for the newest.
    private
    type(kept_operator), allocatable :: list(:)
    integer :: found = 0                           !! that were ever kept
  contains
    procedure :: find => find_source
  end type kept_operators

contains

  subroutine find_source(self, operator, count, source, monitor)
    !! `galerkin_source_of`, remembered where there is room.
    class(kept_operators), intent(inout) :: self
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count
    type(galerkin_source), intent(out) :: source
    class(monitor_type), intent(inout), optional :: monitor   !! none are found, nor kept, where it asks to stop
    integer :: place
    if (.not. allocated(self%list)) allocate (self%list(most_operators))
    do place = 1, min(self%found, most_operators)
      if (self%list(place)%source%highest /= count) cycle
      if (.not. self%list(place)%operator == operator) cycle
      source = self%list(place)%source
      return
    end do
    call galerkin_source_of(operator, count, source, monitor)
    if (stops(monitor)) return
    if (count > most_modes) return
    place = 1 + mod(self%found, most_operators)
    self%list(place)%operator = operator
    self%list(place)%source = source
    self%found = self%found + 1
  end subroutine find_source

end module bw_kept_operators
