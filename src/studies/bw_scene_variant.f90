module bw_scene_variant
  !! Variants of a scene, for studies that run it in several ways.
  !!
  !! Inputs are changed in the resolved text of the scene. The result is read and checked like any other scene, so that
  !! groups that cannot be combined are refused with the reader's own reason. Mode numbers are changed in the scene
  !! itself, since studies request tolerances that no scene may name.
  use bw_error, only: error_type
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_modes_par, only: modes_par, shown_modes
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene_text
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: with_tolerance, with_counts
  public :: has_group, with_group, with_value, without_group

  character(*), parameter :: nl = new_line('a')

  type, public :: scene_variants
    !! The scenes of several texts, each stored once.
    character(:), allocatable :: file              !! of the studied scene, for messages
    type(scene_type), allocatable :: scenes(:)
    type(string), allocatable, private :: texts(:) !! of the scenes
  contains
    procedure :: find
    procedure, private :: add
  end type scene_variants

contains

  pure type(scene_type) function with_tolerance(scene, tolerance) result(variant)
    !! Return the scene with another tolerance, and without spectral analysis, which does not depend on it.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: tolerance              !! may be outside the range of the input
    variant = summed(scene, modes_par(before=0, after=shown_modes, tolerance=tolerance))
  end function with_tolerance

  pure type(scene_type) function with_counts(scene, count) result(variant)
    !! Return the scene with one mode count before and after, and without spectral analysis.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: count
    variant = summed(scene, modes_par(before=count, after=count, tolerance=missing))
  end function with_counts

  pure type(scene_type) function summed(scene, modes) result(variant)
    !! Return the scene with other mode counts and without spectral analysis. Its inputs by name stay unchanged.
    type(scene_type), intent(in) :: scene
    type(modes_par), intent(in) :: modes
    variant = scene
    if (allocated(variant%spectrum)) deallocate (variant%spectrum)
    variant%modes = modes
  end function summed

  subroutine find(self, text, place, reason)
    !! Find the index of the scene with this text; a new text is read.
    class(scene_variants), intent(inout) :: self
    character(*), intent(in) :: text
    integer, intent(out) :: place                  !! 0 if the scene is refused
    character(:), allocatable, intent(inout) :: reason   !! why; unchanged if nothing is refused
    type(scene_type) :: scene
    type(error_type), allocatable :: error
    if (.not. allocated(self%scenes)) allocate (self%scenes(0), self%texts(0))
    do place = 1, size(self%scenes)
      if (self%texts(place)%text == text) return
    end do
    call read_scene_text(text, self%file, scene, error)
    if (allocated(error)) then
      place = 0
      reason = first_reason(error%message, self%file)
    else
      call self%add(text, scene)
    end if
  end subroutine find

  subroutine add(self, text, scene)
    !! Add a scene to the list. (Array constructors of such types leak in gfortran 12.)
    class(scene_variants), intent(inout) :: self
    character(*), intent(in) :: text
    type(scene_type), intent(in) :: scene
    type(scene_type), allocatable :: scenes(:)
    integer :: i, n
    n = size(self%scenes)
    allocate (scenes(n + 1))
    do i = 1, n
      scenes(i) = self%scenes(i)
    end do
    scenes(n + 1) = scene
    call move_alloc(scenes, self%scenes)
    call append(self%texts, text)
  end subroutine add

  pure function first_reason(message, file) result(reason)
    !! Return the first line of a message, without the file and the line number of an internal text.
    character(*), intent(in) :: message, file
    character(:), allocatable :: reason
    integer :: last
    last = index(message//new_line('a'), new_line('a')) - 1
    reason = message(:last)
    if (index(reason, file//':') == 1) reason = reason(len(file) + 2:)
    if (verify(reason(:index(reason, ':') - 1), ' 0123456789') == 0) reason = reason(index(reason, ':') + 1:)
    reason = trim(adjustl(reason))
  end function first_reason

  pure logical function has_group(text, group)
    !! Return whether the text has a group of that name.
    character(*), intent(in) :: text               !! as `resolved_text` writes it: each group and name on its own line
    character(*), intent(in) :: group
    has_group = start_of(text, group) > 0
  end function has_group

  pure function without_group(text, group) result(edited)
    !! Return the text without all groups of a name; unchanged if there is none.
    character(*), intent(in) :: text, group
    character(:), allocatable :: edited
    integer :: first, last
    edited = text
    do
      first = start_of(edited, group)
      if (first == 0) return
      last = end_of(edited, first)
      edited = edited(:first - 1)//edited(last + 1:)
    end do
  end function without_group

  pure function with_group(text, group, values) result(edited)
    !! Return the text with a group appended; it replaces one of that name.
    character(*), intent(in) :: text, group
    character(*), intent(in) :: values             !! `name = value`; empty: all defaults
    character(:), allocatable :: edited
    edited = without_group(text, group)//'&'//group//nl
    if (values /= '') edited = edited//'  '//values//nl
    edited = edited//'/'//nl
  end function with_group

  pure function with_value(text, group, name, value) result(edited)
    !! Return the text in which a name of an existing group has another value.
    character(*), intent(in) :: text, group, name
    character(*), intent(in) :: value              !! empty: the name is removed
    character(:), allocatable :: edited
    integer :: first, last, line, behind
    first = start_of(text, group)
    last = end_of(text, first)
    first = first + index(text(first:last), nl)    ! after the line with the group's name
    line = index(nl//text(first:last), nl//'  '//name//' = ')
    behind = first
    if (line > 0) then
      first = first + line - 1
      behind = first + index(text(first:last), nl)
    end if
    edited = text(:first - 1)
    if (value /= '') edited = edited//'  '//name//' = '//value//nl
    edited = edited//text(behind:)
  end function with_value

  pure integer function start_of(text, group) result(first)
    !! Return where the group opens; 0 if it is absent. A line inside a group begins with a blank or is '/'.
    character(*), intent(in) :: text, group
    first = index(nl//text, nl//'&'//group//nl)
  end function start_of

  pure integer function end_of(text, first) result(last)
    !! Return the last character of the line that closes the group opened at `first`.
    character(*), intent(in) :: text
    integer, intent(in) :: first
    last = first + index(text(first:), nl//'/'//nl) + 1
  end function end_of

end module bw_scene_variant
