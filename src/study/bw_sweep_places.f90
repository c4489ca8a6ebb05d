module bw_sweep_places
  !! The leader's first step of a sweep with long histories: the head of its result and the places of its cases, of an earlier
  !! run where they are there.
  use bw_descriptor, only: put_on_disk
  use bw_error, only: error_type, fail_to_write
  use bw_posix, only: rename_file
  use bw_result_body, only: result_body
  use bw_result_file, only: create_result, result_file
  use bw_result_header, only: holds_scene
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_unfinished, only: unfinished_work
  implicit none (type, external)
  private
  public :: settle_places

contains

  subroutine settle_places(scene, layout, unfinished, body, error)
    !! Find the places, or make them. Where nothing is long, or they cannot be had, all numbers go by way of the journals.
    !! **Errors**: the result under way cannot be written.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(unfinished_work), intent(in) :: unfinished
    type(result_body), intent(inout) :: body
    type(error_type), allocatable, intent(inout) :: error
    logical :: wanted
    call body%plan(layout)
    wanted = unfinished%straight .and. body%has_long()
    if (wanted) then
      if (holds_scene(unfinished%head_path(), scene)) call body%find(unfinished%head_path())
    end if
    if (.not. body%known()) call unfinished%remove_result()
    if (wanted .and. .not. body%known()) then
      call make_head(scene, layout, unfinished, error)
      if (.not. allocated(error)) call body%find(unfinished%head_path())
      if (.not. body%known()) call unfinished%remove_result()
    end if
    if (body%known()) call body%open(unfinished%result_path(), error)
  end subroutine settle_places

  subroutine make_head(scene, layout, unfinished, error)
    !! All of the result but its cases, which gets its name when it is whole, and on the disk: no checksum tells later what
    !! a crash of the machine has taken from it.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(unfinished_work), intent(in) :: unfinished
    type(error_type), allocatable, intent(inout) :: error
    type(result_file) :: file
    logical :: kept
    call create_result(unfinished%new_head_path(), scene, layout, file, error)
    if (allocated(error)) return
    call file%put_marks(error)
    call file%close(error)
    if (allocated(error)) return
    kept = put_on_disk(unfinished%new_head_path())
    if (kept) kept = rename_file(unfinished%new_head_path(), unfinished%head_path())
    if (.not. kept) call fail_to_write(error, unfinished%head_path())
  end subroutine make_head

end module bw_sweep_places
