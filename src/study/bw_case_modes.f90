module bw_case_modes
  !! The modes of a case: the one place that knows how they are found.
  use bw_kinds, only: dp
  use bw_case_result, only: case_result, add_note
  use bw_closed_form, only: source_in_closed_form
  use bw_damping, only: law_of
  use bw_double_double, only: dd
  use bw_mode_set, only: mode_set, mode_source
  use bw_modes_par, only: by_tolerance
  use bw_record_stretch, only: record_stretch
  use bw_rotation, only: acts_in_plane, dimensionless_speed
  use bw_scene, only: scene_type
  implicit none (type, external)
  private
  public :: find_modes

contains

  subroutine find_modes(scene, result, free, loaded, source, alone)
    !! Modes of the beam alone, and of beam and mass if the mass is captured; the last of them are in force. Where a
    !! tolerance says how many are summed, there are none before the capture, and the first few stand for those after it.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    class(mode_set), allocatable, intent(out) :: free, loaded
    class(mode_source), allocatable, intent(out) :: source   !! of beam and mass; absent: the mass is not captured
    class(mode_source), allocatable, intent(out) :: alone    !! of the beam alone
    type(dd), allocatable :: omega                 ! absent: the beam does not rotate in the plane of its motion
    real(dp), allocatable :: longest               ! absent: no history is asked for
    call find_rotation(scene, result, omega)
    if (allocated(scene%response)) longest = record_stretch(scene)*(scene%response%duration/result%units%time%hi)
    alone = source_in_closed_form(0.0_dp, omega)
    if (allocated(scene%damping)) alone%damping = law_of(scene%damping, result%units)
    if (allocated(scene%capture)) then
      source = source_in_closed_form(scene%impact%mass_ratio, omega)
      source%stretch = record_stretch(scene)
      if (allocated(alone%damping)) source%damping = alone%damping
      call source%find(first_numbers(scene%modes%after), loaded, longest)
      result%modes = loaded
      if (by_tolerance(scene%modes)) return
      call alone%find(first_numbers(scene%modes%before), free)
      result%before = free
    else
      call alone%find(first_numbers(scene%modes%before), free, longest)
      result%modes = free
    end if
  end subroutine find_modes

  subroutine find_rotation(scene, result, omega)
    !! Rotation as far as it acts on modes in closed form.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    type(dd), allocatable, intent(out) :: omega
    result%can_grow = .true.
    if (.not. allocated(scene%rotation)) return
    result%can_grow = acts_in_plane(scene%rotation)
    if (result%can_grow) then
      omega = dimensionless_speed(scene%rotation, result%units)
    else
      call add_note(result, &
        'no effect: rotation out of plane changes nothing in this model, which has neither tension nor shear')
    end if
  end subroutine find_rotation

  pure function first_numbers(count) result(number)
    integer, intent(in) :: count
    integer :: number(count)
    integer :: k
    number = [(k, k=1, count)]
  end function first_numbers

end module bw_case_modes
