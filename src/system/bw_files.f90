module bw_files
  !! Files and directories by name. Failures return a `problem`, the system's error number, which `reason` describes; 0
  !! is success. That a name does not exist is distinguished from not knowing.
  use, intrinsic :: iso_c_binding, only: c_char, c_f_pointer, c_int64_t, c_null_char, c_ptr
  use bw_error, only: error_type, fail, status_bad_file
  use bw_kinds, only: i8
  use bw_system_calls, only: bw_do, bw_error_text, bw_kind_of_error, bw_list, bw_look_at, bw_release, error_not_there, &
    is_directory, may_be_written, to_flush_names, to_link, to_make_directory, to_remove, to_remove_directory, to_rename
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: look_at, directory_is_there, same_file, files_in, make_directory, may_write, remove_file, remove_directory, rename_file
  public :: link_file, flush_directory, directory_of, path_beside, reason, cannot_be_read, cannot_be_written

  integer, parameter :: longest_reason = 200

  type, public :: path_state
    !! The object that a path names.
    integer :: kind = 0               !! is_file, is_directory, or above: something else; 0: nothing
    integer(i8) :: device = 0, inode = 0     !! identify a file, whatever its name
    integer(i8) :: links = 0          !! number of its names
    integer(i8) :: bytes = 0
  end type path_state

contains

  integer function look_at(path, state, itself) result(problem)
    !! Find out what a path names; that nothing exists is no problem.
    character(*), intent(in) :: path
    type(path_state), intent(out) :: state
    logical, intent(in), optional :: itself      !! present: a link itself, not its target
    integer(c_int64_t) :: found(5)
    problem = bw_look_at(-1, path//c_null_char, merge(1, 0, present(itself)), found)
    if (problem == 0) state = path_state(int(found(1)), found(2), found(3), found(4), found(5))
    if (bw_kind_of_error(problem) == error_not_there) problem = 0
  end function look_at

  logical function directory_is_there(path)
    !! Return whether a directory of that name exists, as far as is known.
    character(*), intent(in) :: path
    type(path_state) :: state
    integer :: problem
    problem = look_at(path, state)
    directory_is_there = problem == 0 .and. state%kind == is_directory
  end function directory_is_there

  pure logical function same_file(one, other)
    !! Return whether two names, or a name and an open file, refer to the same file.
    type(path_state), intent(in) :: one, other
    same_file = one%kind > 0 .and. one%device == other%device .and. one%inode == other%inode
  end function same_file

  integer function files_in(directory, suffix, names) result(problem)
    !! List the names in a directory with a suffix, sorted, without hidden ones.
    character(*), intent(in) :: directory, suffix
    type(string), allocatable, intent(out) :: names(:)
    type(c_ptr) :: address
    integer(c_int64_t) :: length
    character(c_char), pointer :: letters(:)
    character(:), allocatable :: name
    integer(i8) :: i, first
    allocate (names(0))
    problem = bw_list(directory//c_null_char, suffix//c_null_char, address, length)
    if (problem /= 0) return
    call c_f_pointer(address, letters, [length])
    first = 1
    do i = 1, length
      if (letters(i) /= c_null_char) cycle
      name = repeat(' ', int(i - first))
      name = transfer(letters(first:i - 1), name)
      call append(names, name)
      first = i + 1
    end do
    call bw_release(address)
  end function files_in

  integer function on_path(what, path) result(problem)
    !! Perform an operation of `bw_do` on a path.
    integer, intent(in) :: what
    character(*), intent(in) :: path
    problem = bw_do(what, path//c_null_char, c_null_char)
  end function on_path

  integer function make_directory(path) result(problem)
    !! Make a directory and its missing parents, durably.
    character(*), intent(in) :: path
    integer :: last
    problem = 0
    do last = 1, len(path)
      if (last < len(path)) then
        if (path(last + 1:last + 1) /= '/' .or. path(last:last) == '/') cycle
      end if
      problem = on_path(to_make_directory, path(:last))
      if (problem == 0) problem = flush_directory(directory_of(path(:last)))
      if (directory_is_there(path(:last))) problem = 0
      if (problem /= 0) return
    end do
  end function make_directory

  integer function may_write(directory) result(problem)
    !! Check whether names can be created in a directory.
    character(*), intent(in) :: directory
    problem = on_path(may_be_written, directory)
  end function may_write

  pure function directory_of(path) result(directory)
    !! Return the directory of a path; trailing slashes are ignored.
    character(*), intent(in) :: path
    character(:), allocatable :: directory
    integer :: last
    last = verify(path, '/', back=.true.)
    last = index(path(:last), '/', back=.true.)
    if (last == 0) directory = '.'
    if (last > 0) directory = path(:last)
  end function directory_of

  pure function path_beside(scene, file) result(path)
    !! Return the path of a file that a scene names, relative to the scene's directory.
    character(*), intent(in) :: scene              !! path of the scene
    character(*), intent(in) :: file               !! as written by the user
    character(:), allocatable :: path
    path = file
    if (path(1:1) == '/' .or. index(scene, '/') == 0) return
    if (index(scene, '/dev/fd/') == 1) return      ! the scene came through a pipe, which has no directory
    path = directory_of(scene)//path
  end function path_beside

  integer function remove_file(path) result(problem)
    !! Remove a file; that none exists is no problem.
    character(*), intent(in) :: path
    problem = on_path(to_remove, path)
    if (bw_kind_of_error(problem) == error_not_there) problem = 0
  end function remove_file

  integer function remove_directory(path) result(problem)
    !! Remove a directory if it is empty.
    character(*), intent(in) :: path
    problem = on_path(to_remove_directory, path)
  end function remove_directory

  integer function rename_file(from, to) result(problem)
    !! Rename a file atomically, within one file system; an existing file of that name is replaced.
    character(*), intent(in) :: from, to
    problem = bw_do(to_rename, from//c_null_char, to//c_null_char)
  end function rename_file

  integer function link_file(from, to) result(problem)
    !! Give a file one more name, which must not exist.
    character(*), intent(in) :: from, to
    problem = bw_do(to_link, from//c_null_char, to//c_null_char)
  end function link_file

  integer function flush_directory(path) result(problem)
    !! Flush the names in a directory to the disk.
    character(*), intent(in) :: path
    problem = on_path(to_flush_names, path)
  end function flush_directory

  function reason(problem) result(text)
    !! Return the system's description of an error.
    integer, intent(in) :: problem
    character(:), allocatable :: text
    character(longest_reason) :: buffer
    call bw_error_text(problem, buffer, len(buffer))
    text = buffer(:index(buffer, c_null_char) - 1)
  end function reason

  subroutine cannot_be_read(error, path, problem)
    !! Set `error` to the system's reason why a path cannot be read, unless it is set.
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in) :: path
    integer, intent(in) :: problem
    if (.not. allocated(error)) call fail(error, status_bad_file, path//': cannot be read: '//reason(problem))
  end subroutine cannot_be_read

  subroutine cannot_be_written(error, path, problem)
    !! Set `error` to the system's reason why a path cannot be written, unless it is set.
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in) :: path
    integer, intent(in) :: problem
    if (.not. allocated(error)) call fail(error, status_bad_file, path//': cannot be written: '//reason(problem))
  end subroutine cannot_be_written

end module bw_files
