module bw_further_scenes
  !! The scenes that `&identify` groups name beside their own: each has a record of the same beam in another state.
  use bw_error, only: error_type, fail, status_bad_input
  use bw_files, only: directory_of
  use bw_identify_par, only: most_unknowns
  use bw_input_values, only: group_values, position_of, positions_of
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene
  use bw_text, only: append, string, text_of
  implicit none (type, external)
  private
  public :: further_scenes

contains

  subroutine further_scenes(scene, further, error)
    !! Read the further scenes, each once, in their order.
    !! **Errors**: one cannot be read, or has no record or no beam.
    type(scene_type), intent(in) :: scene
    type(scene_type), allocatable, intent(out) :: further(:)
    type(error_type), allocatable, intent(out) :: error
    type(string), allocatable :: paths(:)
    integer, allocatable :: places(:)
    integer :: i
    call list_paths(scene, paths, places)
    allocate (further(size(paths)))
    do i = 1, size(paths)
      call read_scene(paths(i)%text, further(i), error)
      if (allocated(error)) return
      call check_further(scene, scene%groups(places(i)), further, i, error)
      if (allocated(error)) return
    end do
    i = sum([(size(further(i)%unknowns), i=1, size(further))])
    if (size(scene%unknowns) + i > most_unknowns) call fail(error, status_bad_input, scene%file//': identify: is one of '// &
      text_of(size(scene%unknowns) + i)//' with those of further scenes; accepted: at most '//text_of(most_unknowns))
  end subroutine further_scenes

  subroutine list_paths(scene, paths, places)
    !! List the files, and the group that names each.
    type(scene_type), intent(in) :: scene
    type(string), allocatable, intent(out) :: paths(:)
    integer, allocatable, intent(out) :: places(:)
    integer, allocatable :: groups(:)
    character(:), allocatable :: path
    integer :: g, i, j
    allocate (paths(0), places(0))
    groups = positions_of(scene%groups, 'identify')
    do g = 1, size(groups)
      associate (group => scene%groups(groups(g)))
        if (.not. group%known('with')) cycle
        associate (names => group%values(group%at('with'))%texts)
          do i = 1, size(names)
            path = names(i)%text
            if (index(path, '/') /= 1) path = directory_of(scene%file)//'/'//path
            if (any([(paths(j)%text == path, j=1, size(paths))])) cycle
            call append(paths, path)
            places = [places, groups(g)]
          end do
        end associate
      end associate
    end do
  end subroutine list_paths

  subroutine check_further(scene, group, further, i, error)
    !! Check that a further scene has a record and a beam, names no further ones, and has a result of its own.
    type(scene_type), intent(in) :: scene
    type(group_values), intent(in) :: group              !! that names it
    type(scene_type), intent(in) :: further(:)
    integer, intent(in) :: i                             !! its index
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: problem
    integer, allocatable :: places(:)
    integer :: j
    problem = ''
    if (.not. allocated(further(i)%record)) problem = 'has no &record'
    if (position_of(further(i)%groups, 'beam') == 0) problem = 'has no &beam'
    places = positions_of(further(i)%groups, 'identify')
    do j = 1, size(places)
      if (further(i)%groups(places(j))%known('with')) problem = 'names further scenes itself'
    end do
    if (.not. all(further(i)%sweeps%implied)) problem = 'has sweeps'
    if (further(i)%name == scene%name) problem = 'would have the same result as this scene'
    do j = 1, i - 1
      if (further(j)%name == further(i)%name) problem = 'would have the same result as '//further(j)%file
    end do
    if (problem == '') return
    call fail(error, status_bad_input, scene%file//':'//text_of(group%line_of('with'))//': identify%with: '//further(i)%file// &
              ' '//problem//'; accepted: scenes with &record and &beam, without &sweep and identify%with, and of other names')
  end subroutine check_further

end module bw_further_scenes
