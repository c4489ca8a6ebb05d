module bw_result_layout
  !! Which arrays a scene's result holds, and how long they are: known before anything is computed.
  use bw_kinds, only: dp, i8
  use bw_error, only: error_type
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_count, case_scene
  implicit none (type, external)
  private
  public :: layout_of, has_dimension, dimension_length

  type, public :: result_layout
    !! A length of 0 means that nothing has this dimension.
    integer :: cases = 0              !! 0: no sweep, so no dimension `case`
    integer :: modes = 0              !! the largest number of any case
    integer :: modes_before = 0
    integer :: profile = 0
    integer :: events = 0
    integer :: points = 0
    integer :: samples = 0
    integer :: frequencies = 0
    integer :: peaks = 0
    logical :: velocity = .false.     !! velocity histories are asked for
    logical :: continuum = .false.    !! histories have the answer of infinitely many modes as their limit
    integer :: middle = 0             !! which point is ξ = 0.5, 0 if none
    integer :: tip = 0                !! which point is ξ = 1, 0 if none
  end type result_layout

contains

  subroutine layout_of(scene, layout, error)
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(out) :: layout
    type(error_type), allocatable, intent(out) :: error
    if (size(scene%sweeps) > 0) layout%cases = int(case_count(scene))
    call count_modes(scene, layout, error)
    if (allocated(error)) return
    if (allocated(scene%impact)) then
      layout%profile = scene%impact%profile_points
      layout%events = 1
      if (allocated(scene%capture)) layout%events = 2
    end if
    if (.not. allocated(scene%response)) return
    layout%points = size(scene%response%points)
    layout%samples = scene%response%samples
    layout%velocity = scene%response%velocity
    layout%continuum = allocated(scene%capture)
    layout%middle = findloc(scene%response%points, 0.5_dp, dim=1)
    layout%tip = findloc(scene%response%points, 1.0_dp, dim=1)
    if (.not. allocated(scene%spectrum)) return
    layout%frequencies = layout%samples/2 + 1
    if (layout%middle > 0 .and. layout%tip > 0) layout%peaks = scene%spectrum%max_peaks
  end subroutine layout_of

  subroutine count_modes(scene, layout, error)
    !! The largest counts of any case; cases differ only if a count is swept.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(inout) :: layout
    type(error_type), allocatable, intent(out) :: error
    type(scene_type) :: one
    integer(i8) :: i, last
    logical :: swept
    integer :: s
    swept = .false.
    do s = 1, size(scene%sweeps)
      swept = swept .or. index(scene%sweeps(s)%parameter, 'modes%') == 1
    end do
    last = 1
    if (swept) last = case_count(scene)
    do i = 1, last
      call case_scene(scene, i, one, error)
      if (allocated(error)) return
      if (allocated(scene%capture)) then
        layout%modes = max(layout%modes, one%modes%after)
        layout%modes_before = max(layout%modes_before, one%modes%before)
      else
        layout%modes = max(layout%modes, one%modes%before)
      end if
    end do
  end subroutine count_modes

  pure integer function dimension_length(layout, name) result(length)
    !! Length of a dimension by its name in the file; 0 where nothing has it.
    type(result_layout), intent(in) :: layout
    character(*), intent(in) :: name
    select case (name)
    case ('case'); length = layout%cases
    case ('mode'); length = layout%modes
    case ('mode_before'); length = layout%modes_before
    case ('profile'); length = layout%profile
    case ('event'); length = layout%events
    case ('point'); length = layout%points
    case ('time'); length = layout%samples
    case ('frequency'); length = layout%frequencies
    case ('peak'); length = layout%peaks
    case default; length = 0
    end select
  end function dimension_length

  pure logical function has_dimension(layout, name)
    type(result_layout), intent(in) :: layout
    character(*), intent(in) :: name
    has_dimension = dimension_length(layout, name) > 0
  end function has_dimension

end module bw_result_layout
