module bw_kept_operators
  !! Modes without a closed form that cases share: those whose beam and effects do not differ solve for them once. What is
  !! kept is what would be found again, to the bit.
  use bw_beam_operator, only: beam_operator
  use bw_double_double, only: dd
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
      if (.not. same_operator(self%list(place)%operator, operator)) cycle
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

  pure logical function same_operator(one, other) result(same)
    !! To the bit.
    type(beam_operator), intent(in) :: one, other
    same = (one%gamma == other%gamma) .and. (one%hub_radius == other%hub_radius) .and. (one%in_plane .eqv. other%in_plane) &
      .and. (allocated(one%omega) .eqv. allocated(other%omega)) &
      .and. (allocated(one%tension) .eqv. allocated(other%tension)) &
      .and. (allocated(one%shear) .eqv. allocated(other%shear)) &
      .and. (allocated(one%tip_inertia) .eqv. allocated(other%tip_inertia))
    if (.not. same) return
    if (allocated(one%omega)) same = same_number(one%omega, other%omega)
    if (allocated(one%tension)) same = same .and. all(one%tension == other%tension)
    if (allocated(one%shear)) same = same .and. one%shear%compliance == other%shear%compliance &
      .and. one%shear%rotary == other%shear%rotary
    if (allocated(one%tip_inertia)) same = same .and. one%tip_inertia == other%tip_inertia
  end function same_operator

  elemental logical function same_number(a, b) result(same)
    type(dd), intent(in) :: a, b
    same = a%hi == b%hi .and. a%lo == b%lo
  end function same_number

end module bw_kept_operators
