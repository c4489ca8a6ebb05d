module bw_effect_scenes
  !! The scenes that a study of effects runs, each once, and which two of them each effect's row compares.
  use bw_effect_list, only: effect_not_combined, effect_off, effect_on, effect_row, effect_words
  use bw_error, only: error_type
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene_text
  use bw_text, only: string
  implicit none (type, external)
  private
  public :: add_pair, leave_out, start_scenes

  type, public :: effect_pair
    integer :: with = 0, without = 0               !! places in the list of scenes; 0: not combined
  end type effect_pair

  type, public :: effect_scenes
    !! All rows, and every scene that they take, each once; the first is the one that is studied.
    character(:), allocatable :: file              !! of the scene, for messages
    type(effect_row), allocatable :: rows(:)       !! by the effects' numbers
    type(effect_pair), allocatable :: pairs(:)     !! of the rows
    type(scene_type), allocatable :: scenes(:)
    type(string), allocatable, private :: texts(:) !! of the scenes
  end type effect_scenes

contains

  subroutine start_scenes(text, file, list)
    !! No pair yet, and the scene that is studied, which has been read before and is not refused now.
    character(*), intent(in) :: text               !! resolved
    character(*), intent(in) :: file
    type(effect_scenes), intent(out) :: list
    character(:), allocatable :: never
    integer :: e, place
    list%file = file
    allocate (list%scenes(0), list%texts(0), list%rows(size(effect_words)), list%pairs(size(effect_words)))
    do e = 1, size(list%rows)
      call leave_out(list, e, '')
    end do
    place = place_of(list, text, never)
  end subroutine start_scenes

  subroutine leave_out(list, effect, reason)
    !! An effect that cannot be tried beside this scene, and why.
    type(effect_scenes), intent(inout) :: list
    integer, intent(in) :: effect
    character(*), intent(in) :: reason
    list%rows(effect)%effect = effect
    list%rows(effect)%state = effect_not_combined
    list%rows(effect)%remark = reason
    list%pairs(effect) = effect_pair()
  end subroutine leave_out

  subroutine add_pair(list, effect, is_on, with, without, remark)
    !! Read both texts. Where one is refused the row is left out, with the first of the reader's reasons.
    type(effect_scenes), intent(inout) :: list
    integer, intent(in) :: effect
    logical, intent(in) :: is_on                   !! in the scene that is studied
    character(*), intent(in) :: with, without, remark
    character(:), allocatable :: reason
    list%pairs(effect)%with = place_of(list, with, reason)
    list%pairs(effect)%without = place_of(list, without, reason)
    list%rows(effect)%state = merge(effect_on, effect_off, is_on)
    list%rows(effect)%remark = remark
    if (allocated(reason)) call leave_out(list, effect, reason)
  end subroutine add_pair

  integer function place_of(list, text, reason) result(place)
    !! Of the scene with this text in the list, which takes it in if it is new; 0, with a reason, where it is refused.
    type(effect_scenes), intent(inout) :: list
    character(*), intent(in) :: text
    character(:), allocatable, intent(inout) :: reason
    type(scene_type) :: scene
    type(error_type), allocatable :: error
    do place = 1, size(list%scenes)
      if (list%texts(place)%text == text) return
    end do
    call read_scene_text(text, list%file, scene, error)
    if (allocated(error)) then
      place = 0
      reason = first_reason(error%message, list%file)
      return
    end if
    call take_in(list, text, scene)
    place = size(list%scenes)
  end function place_of

  subroutine take_in(list, text, scene)
    !! One more scene. (Array constructors of such types leak in gfortran 12.)
    type(effect_scenes), intent(inout) :: list
    character(*), intent(in) :: text
    type(scene_type), intent(in) :: scene
    type(scene_type), allocatable :: scenes(:)
    type(string), allocatable :: texts(:)
    integer :: i, n
    n = size(list%scenes)
    allocate (scenes(n + 1), texts(n + 1))
    do i = 1, n
      scenes(i) = list%scenes(i)
      texts(i) = list%texts(i)
    end do
    scenes(n + 1) = scene
    texts(n + 1)%text = text
    call move_alloc(scenes, list%scenes)
    call move_alloc(texts, list%texts)
  end subroutine take_in

  pure function first_reason(message, file) result(reason)
    !! The first line of a message, without the file and the line in a text that nobody sees.
    character(*), intent(in) :: message, file
    character(:), allocatable :: reason
    integer :: last
    last = index(message//new_line('a'), new_line('a')) - 1
    reason = message(:last)
    if (index(reason, file//':') == 1) reason = reason(len(file) + 2:)
    if (verify(reason(:index(reason, ':') - 1), ' 0123456789') == 0) reason = reason(index(reason, ':') + 1:)
    reason = trim(adjustl(reason))
  end function first_reason

end module bw_effect_scenes
