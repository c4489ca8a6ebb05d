module bw_effect_file
  !! The variables of DIR/<scene>.effects.nc.
  use bw_kinds, only: dp
  use bw_effect_list, only: effect_list, effect_row, effect_words, state_words
  use bw_error, only: error_type
  use bw_hint, only: compared_modes
  use bw_missing, only: is_missing, missing
  use bw_stopwatch, only: processor_name
  use bw_study_file, only: study_file, study_values
  implicit none (type, external)
  private

  type, extends(study_values), public :: effect_values
    type(effect_list) :: list
  contains
    procedure :: put => put_effects
  end type effect_values

  character(*), parameter :: by_mode = 'effect mode'

contains

  subroutine put_effects(self, file, error)
    !! All rows into the file of the study.
    class(effect_values), intent(in) :: self
    type(study_file), intent(in) :: file
    type(error_type), allocatable, intent(inout) :: error
    call file%put_text('machine', processor_name(), error)
    call file%put_text('remarks', remarks_of(self%list%rows), error)
    call file%put_axis('effect', size(self%list%rows), 'effect', error, effect_words)
    call file%put_axis('mode', compared_modes, 'mode number k', error)
    call file%put_flags('effect_state', 'effect', 'whether the scene has the effect', self%list%rows%state, state_words, error)
    call file%put_counts('matters_from_mode', 'effect', &
                         'first mode whose frequency the effect changes by more than the tolerance; 0 where none', &
                         self%list%rows%matters_from, error)
    call file%put_numbers('frequency_tolerance', '', '1', 'change of a frequency above which an effect matters', &
                          [self%list%tolerance], error)
    call put_modes(file, self%list%rows, error)
    call put_costs(file, self%list%rows, error)
  end subroutine put_effects

  subroutine put_modes(file, rows, error)
    !! Frequencies with and without, and what that changes.
    type(study_file), intent(in) :: file
    type(effect_row), intent(in) :: rows(:)
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    call file%put_numbers('angular_frequency_with', by_mode, 'rad s-1', 'angular frequency with the effect', &
                          [(rows(i)%with%angular_frequency, i=1, size(rows))], error)
    call file%put_numbers('angular_frequency_without', by_mode, 'rad s-1', 'angular frequency without the effect', &
                          [(rows(i)%without%angular_frequency, i=1, size(rows))], error)
    call file%put_numbers('frequency_change', by_mode, '1', 'relative change of the angular frequency by the effect', &
                          [(rows(i)%frequency_change, i=1, size(rows))], error)
    call file%put_numbers('phase_velocity_change', by_mode, '1', 'relative change of the phase velocity by the effect', &
                          [(rows(i)%phase_velocity_change, i=1, size(rows))], error)
    call file%put_numbers('group_velocity_change', by_mode, '1', 'relative change of the group velocity by the effect', &
                          [(rows(i)%group_velocity_change, i=1, size(rows))], error)
  end subroutine put_modes

  subroutine put_costs(file, rows, error)
    !! What the effect changes in the response, and what it costs.
    type(study_file), intent(in) :: file
    type(effect_row), intent(in) :: rows(:)
    type(error_type), allocatable, intent(inout) :: error
    call file%put_numbers('response_change', 'effect', '1', &
                          'largest change of the displacement by the effect over the peak of the scene''s own', &
                          rows%response_change, error)
    call file%put_numbers('seconds_with', 'effect', 's', 'wall time of a case with the effect, median of the repeats', &
                          rows%seconds_with, error)
    call file%put_numbers('seconds_without', 'effect', 's', 'wall time of a case without the effect, median of the repeats', &
                          rows%seconds_without, error)
    call file%put_numbers('cost', 'effect', '1', 'wall time with the effect over that without it', &
                          ratio(rows%seconds_with, rows%seconds_without), error)
  end subroutine put_costs

  elemental real(dp) function ratio(above, below)
    real(dp), intent(in) :: above, below
    ratio = missing
    if (is_missing(above) .or. is_missing(below)) return
    if (below > 0.0_dp) ratio = above/below
  end function ratio

  pure function remarks_of(rows) result(text)
    !! One line for each effect that has a remark.
    type(effect_row), intent(in) :: rows(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(rows)
      if (rows(i)%remark == '') cycle
      if (text /= '') text = text//new_line('a')
      text = text//trim(effect_words(rows(i)%effect))//': '//rows(i)%remark
    end do
  end function remarks_of

end module bw_effect_file
