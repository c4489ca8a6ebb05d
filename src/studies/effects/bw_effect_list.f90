module bw_effect_list
  !! The influence of the effects that a scene has and of those that it lacks: one row for each.
  use bw_hint, only: compared_modes
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  implicit none (type, external)
  private
  public :: compare_frequencies, largest_change

  integer, parameter, public :: effect_off = 1, effect_on = 2, effect_not_combined = 3
  character(*), parameter, public :: state_words(*) = [character(12) :: 'off', 'on', 'not_combined']   !! by number

  type, public :: compared_case
    !! The compared quantities of a case, SI; missing if they do not exist.
    real(dp), dimension(compared_modes) :: angular_frequency = missing, phase_velocity = missing, group_velocity = missing
  end type compared_case

  type, public :: effect_row
    !! One effect: the scene with it and without it, all else equal.
    character(21) :: effect = ''                   !! its name
    integer :: state = effect_not_combined
    character(:), allocatable :: remark            !! values used; if it is not combined, the reason
    integer :: place_with = 0, place_without = 0   !! of the two scenes in the list of variants; 0: not combined
    type(compared_case) :: with, without
    real(dp), dimension(compared_modes) :: frequency_change = missing, phase_velocity_change = missing, &
      group_velocity_change = missing              !! with over without, less 1
    integer :: matters_from = 0                    !! first mode whose frequency changes by more than the tolerance; 0: none
    real(dp) :: response_change = missing          !! largest difference of the displacement over the scene's peak
    real(dp) :: response_error = missing            !! estimated error of both displacements over that peak; missing: none
    logical :: is_whole = .true.                   !! false: numbers of a run cannot be trusted, and are omitted
    real(dp) :: seconds_with = missing, seconds_without = missing
  end type effect_row

  type, public :: effect_list
    real(dp) :: tolerance = 0.0_dp                 !! threshold for a change of a frequency or of the response
    character(:), allocatable :: tolerance_source  !! its source
    integer :: mode_count = 0                      !! of the scene's modes that are compared
    type(effect_row), allocatable :: rows(:)
  end type effect_list

contains

  pure subroutine compare_frequencies(row, tolerance)
    !! Find the changes of a row whose two runs are done. If a run has no frequencies, the significance is unknown.
    type(effect_row), intent(inout) :: row
    real(dp), intent(in) :: tolerance
    row%frequency_change = change(row%with%angular_frequency, row%without%angular_frequency)
    row%phase_velocity_change = change(row%with%phase_velocity, row%without%phase_velocity)
    row%group_velocity_change = change(row%with%group_velocity, row%without%group_velocity)
    row%matters_from = 0
    if (all(is_missing(row%with%angular_frequency)) .or. all(is_missing(row%without%angular_frequency))) return
    row%matters_from = findloc(matters(row%with%angular_frequency, row%without%angular_frequency, tolerance), .true., dim=1)
  end subroutine compare_frequencies

  elemental real(dp) function change(with, without)
    !! Return the relative change; missing if either value does not exist or the second is 0.
    real(dp), intent(in) :: with, without
    change = missing
    if (is_missing(with) .or. is_missing(without)) return
    if (without /= 0.0_dp) change = (with - without)/without
  end function change

  elemental logical function matters(with, without, tolerance)
    !! Return whether a frequency changes by more than the tolerance, or exists on one side only.
    real(dp), intent(in) :: with, without, tolerance
    matters = is_missing(with) .neqv. is_missing(without)
    if (is_missing(with) .or. is_missing(without)) return
    matters = abs(with - without) > tolerance*abs(without)
  end function matters

  pure real(dp) function largest_change(changes) result(largest)
    !! Return the largest existing change, with its sign; missing if there is none.
    real(dp), intent(in) :: changes(:)
    integer :: k
    largest = missing
    k = maxloc(abs(changes), dim=1, mask=.not. is_missing(changes))
    if (k > 0) largest = changes(k)
  end function largest_change

end module bw_effect_list
