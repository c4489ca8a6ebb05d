module bw_scene_files
  !! The scenes named on a command line: files, and directories that stand for their *.nml.
  use bw_console, only: print_warning
  use bw_error, only: error_type, status_bad_file, status_bad_input, status_done
  use bw_existing_result, only: check_result_path
  use bw_files, only: directory_is_there, files_in, look_at, path_state, reason, same_file
  use bw_process, only: prepare_libraries
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene, stem
  use bw_scene_tally, only: scene_tally
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: read_and_list

  type, public :: refused_type
    !! A scene that is not run.
    character(:), allocatable :: file              !! its path, as the user wrote it
    integer :: status = status_done                !! the reason
    character(:), allocatable :: message           !! lines
  end type refused_type

contains

  subroutine read_and_list(words, aloud, scenes, count, status, tally, refused)
    !! Read all scenes and print the errors of the bad ones. None is run if two files would write the same result, or
    !! the system does not allow it.
    type(string), intent(in) :: words(:)           !! paths, as the user wrote them
    logical, intent(in) :: aloud                   !! print it
    type(scene_type), allocatable, intent(out) :: scenes(:)
    integer, intent(out) :: count                  !! number of `scenes` to run
    integer, intent(out) :: status                 !! the highest of all errors
    type(scene_tally), intent(inout), optional :: tally      !! receives the numbers of scenes and of wrong ones
    type(refused_type), allocatable, intent(out), optional :: refused(:)
    type(refused_type), allocatable :: bad(:)
    type(error_type), allocatable :: error
    logical :: clash
    integer :: i
    call read_scenes(words, scenes, count, bad, status, clash)
    if (present(tally)) tally%scenes = count
    if (clash) count = 0
    if (count > 0) call prepare_libraries(scenes(1)%file, error)
    if (allocated(error)) then
      call refuse(bad, scenes(1)%file, error%status, error%message)
      status = max(status, error%status)
      count = 0
    end if
    do i = 1, size(bad)
      if (aloud) call print_warning(bad(i)%message)
    end do
    if (present(tally)) then
      tally%wrong = size(bad)
      tally%scenes = tally%scenes + tally%wrong
    end if
    if (present(refused)) call move_alloc(bad, refused)
  end subroutine read_and_list

  subroutine refuse(refused, file, status, message)
    !! Add a scene that is not run.
    type(refused_type), allocatable, intent(inout) :: refused(:)
    character(*), intent(in) :: file, message
    integer, intent(in) :: status
    type(refused_type), allocatable :: more(:)
    integer :: i
    allocate (more(size(refused) + 1))
    do i = 1, size(refused)
      more(i) = refused(i)
    end do
    more(size(more))%file = file
    more(size(more))%status = status
    more(size(more))%message = message
    call move_alloc(more, refused)
  end subroutine refuse

  subroutine read_scenes(words, scenes, count, refused, status, clash)
    !! Read all scenes before any is run.
    type(string), intent(in) :: words(:)                        !! as the user wrote them
    type(scene_type), allocatable, intent(out) :: scenes(:)     !! the first `count` of them are read
    integer, intent(out) :: count
    type(refused_type), allocatable, intent(out) :: refused(:)  !! one for each bad scene or path
    integer, intent(out) :: status                              !! the highest of all errors, or `status_done`
    logical, intent(out) :: clash                               !! two files would write the same result
    integer, allocatable :: clashes(:)
    type(string), allocatable :: paths(:)
    type(error_type), allocatable :: error
    integer :: i
    allocate (refused(0))
    count = 0
    status = status_done
    call expand(words, paths, refused)
    if (size(refused) > 0) status = status_bad_file
    call drop_repeated(paths)
    allocate (scenes(size(paths)))
    clashes = clashes_of(paths)
    clash = any(clashes > 0)
    if (clash) status = max(status, status_bad_input)
    do i = 1, size(paths)
      if (clashes(i) > 0) then
        call refuse(refused, paths(i)%text, status_bad_input, paths(i)%text//': has the same name as '// &
                    paths(clashes(i))%text//', and both would write '//stem(paths(i)%text)// &
                    '.nc; accepted: different names, or separate runs')
        cycle
      end if
      call check_result_path(stem(paths(i)%text)//'.nc', error)
      if (.not. allocated(error)) call read_scene(paths(i)%text, scenes(count + 1), error)
      if (allocated(error)) then
        call refuse(refused, paths(i)%text, error%status, error%message)
        status = max(status, error%status)
      else
        count = count + 1
      end if
    end do
  end subroutine read_scenes

  subroutine expand(words, paths, refused)
    !! Replace each directory by its *.nml files.
    type(string), intent(in) :: words(:)
    type(string), allocatable, intent(out) :: paths(:)
    type(refused_type), allocatable, intent(inout) :: refused(:)
    type(string), allocatable :: found(:)
    integer :: i, j, problem
    allocate (paths(0))
    do i = 1, size(words)
      if (directory_is_there(words(i)%text)) then
        problem = files_in(words(i)%text, '.nml', found)
        if (problem /= 0) then
          call refuse(refused, words(i)%text, status_bad_file, &
                      words(i)%text//': this directory cannot be listed: '//reason(problem))
        else if (size(found) == 0) then
          call refuse(refused, words(i)%text, status_bad_file, &
                      words(i)%text//': no scenes in this directory; accepted: files *.nml')
        end if
        do j = 1, size(found)
          call append(paths, without_slash(words(i)%text)//'/'//found(j)%text)
        end do
      else
        call append(paths, words(i)%text)
      end if
    end do
  end subroutine expand

  pure function without_slash(path) result(text)
    !! Return a directory's path without a trailing slash.
    character(*), intent(in) :: path
    character(:), allocatable :: text
    text = path
    if (len(path) > 1 .and. path(len(path):) == '/') text = path(:len(path) - 1)
  end function without_slash

  subroutine drop_repeated(paths)
    !! Keep the first path of each file: a scene named twice is run once.
    type(string), allocatable, intent(inout) :: paths(:)
    type(string), allocatable :: kept(:)
    type(string) :: stems(size(paths))
    type(path_state) :: states(size(paths))
    integer :: i, j, problem
    allocate (kept(0))
    do i = 1, size(paths)
      stems(i)%text = stem(paths(i)%text)
      problem = look_at(paths(i)%text, states(i))    ! if this fails, reading the file will report why
      do j = 1, i - 1
        if (stems(j)%text /= stems(i)%text) cycle
        if (same_file(states(i), states(j)) .or. paths(i)%text == paths(j)%text) exit
      end do
      if (j == i) call append(kept, paths(i)%text)
    end do
    call move_alloc(kept, paths)
  end subroutine drop_repeated

  function clashes_of(paths) result(clashes)
    !! Return for each path the first earlier one with the same stem, which would write the same result; 0 if there is none.
    type(string), intent(in) :: paths(:)             !! of different files
    integer :: clashes(size(paths))
    type(string) :: stems(size(paths))
    integer :: i, j
    clashes = 0
    do i = 1, size(paths)
      stems(i)%text = stem(paths(i)%text)
      do j = 1, i - 1
        if (stems(i)%text /= stems(j)%text) cycle
        clashes(i) = j
        exit
      end do
    end do
  end function clashes_of

end module bw_scene_files
