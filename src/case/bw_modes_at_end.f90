module bw_modes_at_end
  !! The modes that move in the samples after the last event: what is measured there is checked with them.
  use bw_case_result, only: case_done, case_result
  use bw_course, only: free_modes, held_modes, loaded_modes
  use bw_double_double, only: dd, to_dd, operator(*), operator(-)
  use bw_kinds, only: dp
  use bw_mode_check, only: known_modes
  use bw_mode_set, only: first_numbers, mode_set, mode_source
  use bw_modes_par, only: by_tolerance
  use bw_scene, only: scene_type
  implicit none (type, external)
  private
  public :: modes_at_end, kind_at_end

  integer, parameter :: most = 4096              !! modes; their images fill any record

contains

  pure integer function kind_at_end(scene, result) result(kind)
    !! Which set moves after the last event, a number of bw_course.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(in) :: result
    if (allocated(result%courses)) then
      kind = result%courses(size(result%courses))%modes
    else
      kind = merge(loaded_modes, free_modes, allocated(scene%capture))
    end if
  end function kind_at_end

  subroutine modes_at_end(scene, free, loaded, source, alone, result, known)
    !! Their frequencies; the first ones of very many. Nothing where no waves are asked for, or the histories end early.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in), optional :: free, loaded    !! modes of the beam alone, and of beam and mass
    class(mode_source), intent(in), optional :: source       !! modes of beam and mass
    class(mode_source), intent(in) :: alone                  !! modes of the beam alone
    type(case_result), intent(in) :: result
    type(known_modes), allocatable, intent(out) :: known
    class(mode_set), allocatable :: first
    integer :: summed
    if (.not. allocated(scene%spectrum) .or. result%status /= case_done) return
    allocate (known)
    select case (kind_at_end(scene, result))
    case (held_modes)
      call know(result%held, result, known)
    case (loaded_modes)
      if (by_tolerance(scene%modes)) then
        summed = result%mode_count
        call source%find(first_numbers(min(most, summed)), first)
      else
        call know(loaded, result, known)
      end if
    case default
      if (by_tolerance(scene%modes)) then
        summed = result%released_count
        call alone%find(first_numbers(min(most, summed)), first)
      else
        call know(free, result, known)
      end if
    end select
    if (.not. allocated(first)) return
    call know(first, result, known)
    known%all = first%count == summed
  end subroutine modes_at_end

  pure subroutine know(modes, result, known)
    !! √(β² − c²/4) of oscillating modes, in rad/s.
    class(mode_set), intent(in) :: modes
    type(case_result), intent(in) :: result
    type(known_modes), intent(inout) :: known
    type(dd) :: square(modes%count), rate(modes%count)
    square = modes%beta_squared
    if (allocated(modes%damping)) then
      rate = to_dd(0.5_dp*modes%damping)
      square = square - rate*rate
    end if
    known%angular_frequency = sqrt(max(0.0_dp, square%hi))*result%units%frequency
  end subroutine know

end module bw_modes_at_end
