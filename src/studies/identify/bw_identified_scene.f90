module bw_identified_scene
  !! The scene of an identified beam, as text that can be run: it has the fitted values and no groups of measurement
  !! (`&record`, `&spectrum`, `&identify`), so that it simulates. The text is in the result and in a file beside it.
  use bw_columns, only: to_width
  use bw_descriptors, only: close_file, flush_file, is_file, new_file, open_file, read_bytes, to_read, write_text
  use bw_error, only: error_type, fail, status_bad_file
  use bw_files, only: cannot_be_read, cannot_be_written, directory_of, flush_directory, look_at, path_state, remove_file
  use bw_identification, only: identification
  use bw_identify_par, only: identify_par
  use bw_kinds, only: dp, i1, i8
  use bw_input_values, only: position_of
  use bw_missing, only: is_missing
  use bw_random_effects, only: pooled_value
  use bw_scene, only: scene_type
  use bw_scene_resolved, only: resolved_text
  use bw_scene_unknowns, only: scene_with, with_unknowns
  use bw_scene_variant, only: without_group
  use bw_text, only: printable, shortest, text_of
  use bw_work_directory, only: give_name, work_directory
  implicit none (type, external)
  private
  public :: identified_attribute, identified_path, identified_room, identified_text, keep_identified

contains

  pure function identified_attribute(i) result(name)
    !! Return the name of the attribute that holds the text of the scene itself, i = 1, or of a further scene.
    integer, intent(in) :: i
    character(:), allocatable :: name
    name = 'identified_scene'
    if (i > 1) name = name//'_'//text_of(i)
  end function identified_attribute

  pure integer function identified_room(result, scene, unknowns) result(letters)
    !! Return an upper bound of the length of the text.
    character(*), intent(in) :: result                   !! as in `identified_text`
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: unknowns                      !! their number
    integer, parameter :: of_letter = 4, of_name = 100, of_numbers = 100, around = 400
      !! letters that one letter of a name may take; of an unknown's name; of its numbers; of the head's own words and the damping
    letters = len(resolved_text(scene)) + of_letter*(len(scene%name) + len(result)) + (of_name + of_numbers)*unknowns + around
  end function identified_room

  pure function identified_path(result, further) result(path)
    !! Return the file of that text, named after its result, since several results may name the same further scene.
    character(*), intent(in) :: result                   !! path of the result
    character(*), intent(in) :: further                  !! name of the further scene; empty: of the scene itself
    character(:), allocatable :: path
    path = result(:len(result) - len('.nc'))//'.identified.'
    if (further /= '') path = path//further//'.'
    path = path//'nml'
  end function identified_path

  function identified_text(result, scene, unknowns, found, damping) result(text)
    !! Return the text, with a comment for each unknown, and the measured damping if the scene has none.
    character(*), intent(in) :: result                   !! name of the result that it belongs to
    type(scene_type), intent(in) :: scene                !! without sweeps
    type(identify_par), intent(in) :: unknowns(:)        !! by their names in this scene; group 0 if absent from it
    type(identification), intent(in) :: found
    type(pooled_value), intent(in) :: damping            !! ratio; missing if none was measured
    character(:), allocatable :: text
    character, parameter :: nl = new_line('a')
    type(scene_type) :: varied, one
    type(error_type), allocatable :: error
    integer :: i
    call with_unknowns(scene, unknowns, varied)
    call scene_with(varied, found%values, one, error)
    text = without_group(without_group(without_group(resolved_text(one), 'record'), 'spectrum'), 'identify')
    associate (modes => scene%groups(position_of(scene%groups, 'modes')))
      if (.not. (modes%given('before') .or. modes%given('after') .or. modes%given('tolerance'))) &
        text = without_group(text, 'modes')          ! a motion added later needs its own
    end associate
    do i = size(unknowns), 1, -1
      if (unknowns(i)%group == 0) cycle
      text = '! '//unknowns(i)%parameter//' = '//text_of(found%values(i))//': '//end_text(found%low(i), found%width(i))// &
        ' to '//end_text(found%high(i), found%width(i))//nl//text
    end do
    if (.not. (is_missing(damping%value) .or. allocated(scene%damping))) text = &
      '! damping%ratio = '//shortest(damping%value, 6)//': '// &
      to_width(damping%value - damping%error, 2*damping%error)//' to '// &
      to_width(damping%value + damping%error, 2*damping%error)//', from the decay of '//text_of(damping%count)// &
      ' lines; the ratio of one mode scatters about it by '//shortest(damping%scatter, 2)//nl//text//'&damping'//nl// &
      '  ratio = '//text_of(damping%value)//nl//'/'//nl
    text = '! '//printable(scene%name, on_one_line=.true.)//'.nml as the result '//printable(result, on_one_line=.true.)// &
      '.nc identified it; intervals as said there.'//nl//text
  contains
    function end_text(value, width) result(words)
      real(dp), intent(in) :: value, width               !! end of an interval, and how wide this is
      character(:), allocatable :: words
      words = 'the end of its range'
      if (.not. is_missing(value)) words = to_width(value, width)
    end function end_text
  end function identified_text

  subroutine keep_identified(result, path, text, overwrite, error)
    !! Ensure that a file holds the text. An identical one is kept; another is replaced only on request.
    !! **Errors**: `status_bad_file` if another file is there, or it cannot be written.
    character(*), intent(in) :: result                   !! path of the result that it belongs to
    character(*), intent(in) :: path, text
    logical, intent(in) :: overwrite
    type(error_type), allocatable, intent(inout) :: error
    type(work_directory) :: work
    character(:), allocatable :: draft
    logical :: taken
    integer :: problem, ignored
    if (holds(path, text, error)) return
    if (allocated(error)) return
    call work%plan(result, overwrite)
    work%parts = 2                                       ! the lock is held briefly, as other parts may be at work
    call work%begin(error)
    if (allocated(error)) return
    draft = work%scratch()
    call write_whole(draft, text, problem)
    taken = .false.
    if (problem == 0) call give_name(draft, path, overwrite, taken, problem)
    if (problem == 0) problem = flush_directory(directory_of(path))
    if (problem /= 0) ignored = remove_file(draft)
    call work%leave()
    if (taken) then
      call fail(error, status_bad_file, path//': is there already, and is not what '//result//' identified; --overwrite '// &
                'replaces it')
    else if (problem /= 0) then
      call cannot_be_written(error, path, problem)
    end if
  end subroutine keep_identified

  logical function holds(path, text, error)
    !! Return whether a file has exactly this text. **Errors**: it cannot be read.
    character(*), intent(in) :: path, text
    type(error_type), allocatable, intent(inout) :: error
    type(path_state) :: state
    integer(i1) :: bytes(len(text))
    integer(i8) :: have
    integer :: descriptor, problem, ignored
    holds = .false.
    problem = look_at(path, state)
    if (problem == 0 .and. state%kind == is_file .and. state%bytes == len(text)) then
      problem = open_file(path, to_read, descriptor)
      if (problem == 0) problem = read_bytes(descriptor, 0_i8, bytes, have)
      ignored = close_file(descriptor)
      if (problem == 0) holds = have == size(bytes) .and. all(bytes == transfer(text, bytes))
    end if
    if (problem /= 0) call cannot_be_read(error, path, problem)
  end function holds

  subroutine write_whole(path, text, problem)
    !! Write a new file, onto the disk.
    character(*), intent(in) :: path, text
    integer, intent(out) :: problem
    integer :: descriptor, closed
    problem = open_file(path, new_file, descriptor)
    if (problem == 0) problem = write_text(descriptor, text)
    if (problem == 0) problem = flush_file(descriptor)
    closed = close_file(descriptor)
    if (problem == 0) problem = closed
  end subroutine write_whole

end module bw_identified_scene
