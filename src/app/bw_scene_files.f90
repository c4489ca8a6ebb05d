module bw_scene_files
  !! The scenes that a command line names: files, and directories that stand for their *.nml.
  use bw_console, only: print_warning
  use bw_error, only: error_type, status_bad_file, status_bad_input, status_done
  use bw_files, only: directory_is_there, files_in, reason
  use bw_process, only: settle_libraries
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene, stem
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: read_and_list

contains

  subroutine read_and_list(words, aloud, scenes, count, status)
    !! Read all scenes and print what is wrong with the bad ones; none is good where the system lets nothing be run.
    type(string), intent(in) :: words(:)           !! paths, as the user wrote them
    logical, intent(in) :: aloud                   !! print it
    type(scene_type), allocatable, intent(out) :: scenes(:)
    integer, intent(out) :: count                  !! how many of `scenes` are good
    integer, intent(out) :: status                 !! the highest of the errors'
    type(string), allocatable :: messages(:)
    type(error_type), allocatable :: error
    integer :: i
    call read_scenes(words, scenes, count, messages, status)
    if (count > 0) call settle_libraries(scenes(1)%file, error)
    if (allocated(error)) then
      call append(messages, error%message)
      status = max(status, error%status)
      count = 0
    end if
    do i = 1, size(messages)
      if (aloud) call print_warning(messages(i)%text)
    end do
  end subroutine read_and_list

  subroutine read_scenes(words, scenes, count, messages, status)
    !! Read all scenes before any is run. Two scenes of one name leave no scene at all.
    type(string), intent(in) :: words(:)                        !! as the user wrote them
    type(scene_type), allocatable, intent(out) :: scenes(:)     !! the first `count` of them are read
    integer, intent(out) :: count
    type(string), allocatable, intent(out) :: messages(:)       !! one for each bad scene or path
    integer, intent(out) :: status                              !! the highest of the bad ones', or `status_done`
    type(string), allocatable :: paths(:)
    type(error_type), allocatable :: error
    logical :: clash
    integer :: i
    allocate (messages(0))
    count = 0
    status = status_done
    call expand(words, paths, messages)
    if (size(messages) > 0) status = status_bad_file
    allocate (scenes(size(paths)))
    call find_clashes(paths, messages, clash)
    if (clash) then
      status = max(status, status_bad_input)
      return
    end if
    do i = 1, size(paths)
      call read_scene(paths(i)%text, scenes(count + 1), error)
      if (allocated(error)) then
        call append(messages, error%message)
        status = max(status, error%status)
      else
        count = count + 1
      end if
    end do
  end subroutine read_scenes

  subroutine expand(words, paths, messages)
    !! Paths of files from words, of which each may be a directory that stands for its *.nml.
    type(string), intent(in) :: words(:)
    type(string), allocatable, intent(out) :: paths(:)
    type(string), allocatable, intent(inout) :: messages(:)
    type(string), allocatable :: found(:)
    integer :: i, j, problem
    allocate (paths(0))
    do i = 1, size(words)
      if (directory_is_there(words(i)%text)) then
        problem = files_in(words(i)%text, '.nml', found)
        if (problem /= 0) then
          call append(messages, words(i)%text//': this directory cannot be listed: '//reason(problem))
        else if (size(found) == 0) then
          call append(messages, words(i)%text//': no scenes in this directory; accepted: files *.nml')
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
    !! A directory's path without a slash at its end.
    character(*), intent(in) :: path
    character(:), allocatable :: text
    text = path
    if (len(path) > 1 .and. path(len(path):) == '/') text = path(:len(path) - 1)
  end function without_slash

  subroutine find_clashes(paths, messages, clash)
    !! Find scenes of one stem, which would write the same result.
    type(string), intent(in) :: paths(:)
    type(string), allocatable, intent(inout) :: messages(:)
    logical, intent(out) :: clash
    type(string) :: stems(size(paths))
    integer :: i, j
    clash = .false.
    do i = 1, size(paths)
      stems(i)%text = stem(paths(i)%text)
      do j = 1, i - 1
        if (stems(i)%text /= stems(j)%text) cycle
        call append(messages, paths(i)%text//': has the same name as '//paths(j)%text// &
          ', and both would write '//stems(i)%text//'.nc; accepted: different names, or separate runs')
        clash = .true.
        exit
      end do
    end do
  end subroutine find_clashes

end module bw_scene_files
