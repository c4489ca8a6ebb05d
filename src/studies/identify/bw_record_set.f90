module bw_record_set
  !! The records that are fitted together: the cases of a scene and of further scenes, with their lines.
  use bw_error, only: error_type
  use bw_kinds, only: dp, i8
  use bw_measured_state, only: measured_state
  use bw_monitor, only: monitor_type
  use bw_record, only: sensor_type
  use bw_result_lines, only: read_result_lines, result_lines
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_count, case_scene
  use bw_scene_states, only: measured_scene
  implicit none (type, external)
  private
  public :: read_all

  type, public :: record_set
    !! Everything fitted together: the cases of the scene, then those of further scenes.
    type(measured_scene), allocatable :: measured(:)     !! (cases of all scenes)
    type(result_lines), allocatable :: lines(:)          !! (the same)
    type(measured_state), allocatable :: states(:)           !! (the same); unallocated unless unknowns are identified
    integer :: own = 0                                   !! cases of the scene itself
    integer :: places = 0                                !! along the beam, for shapes that are written
    type(sensor_type), allocatable :: sensors(:)         !! whose response to a hammer is modelled; unallocated: none
    real(dp), allocatable :: frequencies(:)              !! of that response, Hz
  end type record_set

contains

  subroutine read_all(scene, further, directory, draft, quantile, monitor, set, error)
    !! Read the scenes and lines of all cases.
    type(scene_type), intent(in) :: scene
    type(scene_type), intent(in) :: further(:)   !! scenes of other states of the beam, whose results exist
    character(*), intent(in) :: directory        !! of these results
    character(*), intent(in) :: draft            !! the result of the scene itself
    real(dp), intent(in) :: quantile             !! half width of an interval in standard deviations
    class(monitor_type), intent(inout), target :: monitor
    type(record_set), intent(out) :: set
    type(error_type), allocatable, intent(inout) :: error
    integer :: i, n
    n = int(case_count(scene))
    set%own = n
    do i = 1, size(further)
      n = n + int(case_count(further(i)))
    end do
    allocate (set%measured(n), set%lines(n))
    n = 0
    call read_cases(scene, draft)
    do i = 1, size(further)
      call read_cases(further(i), directory//'/'//further(i)%name//'.nc')
    end do
  contains
    subroutine read_cases(one, path)
      type(scene_type), intent(in) :: one
      character(*), intent(in) :: path           !! of its result
      type(result_lines), allocatable :: cases(:)
      integer :: c
      if (allocated(error)) return
      call read_result_lines(path, quantile, cases, error)
      do c = 1, int(case_count(one))
        if (allocated(error)) return
        n = n + 1
        set%lines(n) = cases(c)
        set%measured(n)%lines = cases(c)%lines
        set%measured(n)%monitor => monitor
        call case_scene(one, int(c, i8), set%measured(n)%scene, error)
      end do
    end subroutine read_cases
  end subroutine read_all

end module bw_record_set
