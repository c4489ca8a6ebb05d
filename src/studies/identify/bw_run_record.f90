module bw_run_record
  !! Run of a record with a beam: its lines, the modes that match them, and the unknowns of the beam.
  !!
  !! Records of other states of the beam run first, each as a scene with its own result.
  use bw_beam_supplement, only: beam_supplement
  use bw_error, only: error_type, fail, status_bad_file, status_bad_input, status_stopped
  use bw_files, only: remove_file
  use bw_further_scenes, only: further_scenes
  use bw_identified_scene, only: identified_attribute, identified_path, keep_identified
  use bw_input_values, only: position_of
  use bw_kinds, only: dp, i4
  use bw_model_file, only: read_attribute
  use bw_monitor, only: progress_type
  use bw_outcome, only: outcome_type
  use bw_process_group, only: process_group
  use bw_record_checksum, only: record_checksums
  use bw_run_scene, only: run_scene
  use bw_scene, only: scene_type
  use bw_scene_resolved, only: resolved_text
  implicit none (type, external)
  private
  public :: run_record

  character, parameter :: nl = new_line('a')

contains

  subroutine run_record(scene, directory, overwrite, part, group, progress, outcome, error)
    !! Run a scene with a record; without a beam this is `run_scene`.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    integer, intent(in) :: part(2)               !! as in `run_scene`
    class(process_group), intent(inout) :: group
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(out) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(beam_supplement) :: supplement
    type(scene_type) :: whole                    ! the scene, completed by further scenes
    real(dp) :: nothing(0)
    integer :: status, i
    logical :: again
    if (position_of(scene%groups, 'beam') == 0) then
      call run_scene(scene, directory, overwrite, part, group, progress, outcome, error)
      return
    end if
    outcome%notes = ''
    outcome%report = ''
    supplement%scene = scene
    supplement%directory = directory
    call further_scenes(scene, supplement%further, error)
    if (.not. allocated(error) .and. part(2) > 1) then
      if (size(supplement%further) > 0) call fail(error, status_bad_input, scene%file// &
        ': &identify: further scenes are run first, which parts cannot share; accepted: the scene without --part')
    end if
    if (.not. allocated(error)) call find_identity(supplement, error)
    whole = scene
    if (.not. allocated(error)) whole%further_unknowns = &
      sum([(size(supplement%further(i)%unknowns), i=1, size(supplement%further))])
    call group%collect(nothing, error)
    if (.not. allocated(error)) call run_further(supplement%further, directory, overwrite, group, progress, outcome, error)
    if (allocated(error) .or. outcome%status == status_stopped) return
    if (group%leads()) call clear_outdated(supplement, overwrite, error)
    call group%collect(nothing, error)
    if (allocated(error)) return
    status = outcome%status
    call run_scene(whole, directory, overwrite, part, group, progress, outcome, error, supplement)
    call clear_bare(supplement, group, outcome, again, error)
    if (allocated(error)) return
    if (again) call run_scene(whole, directory, overwrite, part, group, progress, outcome, error, supplement)
    if (group%leads() .and. outcome%status /= status_stopped) call keep_scenes(supplement, overwrite, error)
    call group%collect(nothing, error)
    outcome%status = max(outcome%status, status)
  end subroutine run_record

  subroutine run_further(further, directory, overwrite, group, progress, outcome, error)
    !! Run the scenes of other states of the beam; the highest of their statuses is returned.
    type(scene_type), intent(in) :: further(:)
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    class(process_group), intent(inout) :: group
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(inout) :: error
    type(outcome_type) :: one
    real(dp) :: nothing(0)
    integer(i4), allocatable :: stop(:)
    integer :: i
    do i = 1, size(further)
      call run_scene(further(i), directory, overwrite, [1, 1], group, progress, one, error)
      call group%collect(nothing, error)
      stop = [merge(1_i4, 0_i4, one%status == status_stopped)]
      call group%share(stop)
      outcome%status = max(outcome%status, one%status)
      outcome%notes = one%notes
      if (allocated(error) .or. stop(1) == 1) return
    end do
  end subroutine run_further

  subroutine find_identity(supplement, error)
    !! Find the data of the comparison beside scene and record: further scenes and their records.
    !! **Errors**: a record cannot be read.
    type(beam_supplement), intent(inout) :: supplement
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: checksums
    integer :: i
    supplement%identity = 'modes beside lines'
    do i = 1, size(supplement%further)
      call record_checksums(supplement%further(i), checksums, error)
      if (allocated(error)) return
      supplement%identity = supplement%identity//nl//resolved_text(supplement%further(i))//checksums
    end do
  end subroutine find_identity

  subroutine clear_bare(supplement, group, outcome, again, error)
    !! Remove a finished result made when this was a further scene, as it lacks the comparison with its beam.
    type(beam_supplement), intent(in) :: supplement
    class(process_group), intent(inout) :: group
    type(outcome_type), intent(in) :: outcome
    logical, intent(out) :: again                !! the result must be made anew
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: path, there
    real(dp) :: nothing(0)
    integer(i4), allocatable :: bare(:)
    bare = [0_i4]
    if (group%leads() .and. .not. allocated(error) .and. outcome%status /= status_stopped) then
      path = supplement%directory//'/'//supplement%scene%name//'.nc'
      call read_attribute(path, 'model', there)
      if (there == '') bare = [merge(1_i4, 0_i4, remove_file(path) == 0)]
    end if
    call group%collect(nothing, error)
    call group%share(bare)
    again = bare(1) == 1
  end subroutine clear_bare

  subroutine keep_scenes(supplement, overwrite, error)
    !! Ensure that the identified scenes lie beside their result.
    !! **Errors**: another file is in the place of one, or it cannot be written.
    type(beam_supplement), intent(in) :: supplement
    logical, intent(in) :: overwrite
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: path, text, further
    integer :: i, ignored
    path = supplement%directory//'/'//supplement%scene%name//'.nc'
    further = ''
    do i = 1, 1 + size(supplement%further)
      if (allocated(error)) return
      if (i > 1) further = supplement%further(i - 1)%name
      call read_attribute(path, identified_attribute(i), text)
      if (text /= '') then
        call keep_identified(path, identified_path(path, further), text, overwrite, error)
      else if (overwrite .and. size(supplement%scene%unknowns) > 0) then
        ignored = remove_file(identified_path(path, further))     ! of an earlier result, if this one identified nothing
      end if
    end do
  end subroutine keep_scenes

  subroutine clear_outdated(supplement, overwrite, error)
    !! Remove a finished result whose further records have changed since.
    !! **Errors**: it may not be replaced.
    type(beam_supplement), intent(in) :: supplement
    logical, intent(in) :: overwrite
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: path, there
    integer :: ignored
    path = supplement%directory//'/'//supplement%scene%name//'.nc'
    call read_attribute(path, 'model', there)
    if (there == '' .or. there == supplement%identity) return
    if (overwrite) then
      ignored = remove_file(path)
    else
      call fail(error, status_bad_file, path//': is there already, of other records; --overwrite replaces it')
    end if
  end subroutine clear_outdated

end module bw_run_record
