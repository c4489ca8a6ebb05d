module bw_report
  !! The printed report of a case: the first modes with their wave velocities, the jump, the balance, the histories, and
  !! warnings.
  use bw_constants, only: two_pi
  use bw_event_report, only: report_contact, report_events, report_impact
  use bw_kinds, only: dp
  use bw_case_rows, only: all_modes, starts_of, values_of
  use bw_case_result, only: case_result
  use bw_columns, only: fixed, most_rows, note_rest, table_of, text_table, text_width, wrapped
  use bw_event, only: release_event
  use bw_frequency_report, only: report_answer
  use bw_history_report, only: report_histories, report_measured
  use bw_load_report, only: report_loads
  use bw_missing, only: is_missing, missing, scaled
  use bw_note, only: is_remark, unmarked
  use bw_record_report, only: report_record
  use bw_scene, only: scene_type
  use bw_screen, only: note_hang, note_mark
  use bw_text, only: lines_of, shortest, string, text_builder, text_of
  implicit none (type, external)
  private
  public :: case_report, notes_report

  integer, parameter :: shown_modes = 5, shown_configurations = 12   !! rows that are no details

contains

  function case_report(scene, result) result(text)
    !! Return the report of one case.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(in) :: result
    character(:), allocatable :: text
    type(text_builder) :: lines
    text = ''
    if (allocated(result%record)) call report_record(result%record, result%measured, &
                                                           scene%spectrum%confidence, lines)
    if (allocated(result%record)) text = lines%text()
    if (result%mode_count == 0) return             ! a note says why
    call report_modes(scene, result, lines)
    if (allocated(result%configurations)) call report_configurations(result, lines)
    if (allocated(result%impact)) then
      call report_impact(scene, result, lines)
    else if (allocated(result%configurations) .and. .not. allocated(result%contact)) then
      if (size(result%events) > 0) call report_events(result, lines)
    end if
    if (allocated(result%contact)) call report_contact(scene, result, lines)
    if (allocated(result%loads)) call report_loads(scene, result, lines)
    if (allocated(result%response)) call report_histories(scene, result, lines)
    if (allocated(result%answer)) then
      if (allocated(result%answer%extremes)) call report_answer(scene%frequency_response, result%answer, lines)
    end if
    if (allocated(result%measured)) call report_measured(result, lines)
    text = lines%text()
  end function case_report

  subroutine report_modes(scene, result, lines)
    !! Print the first modes, and the critical angular velocity.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    real(dp), allocatable, dimension(:) :: frequency, phase, group
    type(text_table) :: table
    integer :: n, count, few
    frequency = values_of(result, 'angular_frequency')
    count = size(frequency)
    n = min(most_rows, count)
    few = min(shown_modes, count)
    frequency = frequency(:n)
    phase = first_of('phase_velocity')
    group = first_of('group_velocity')
    call lines%append_line('')
    table = table_of('mode|alpha|wave number|frequency|frequency|phase velocity|group velocity|released', &
                     '||1/m|rad/s|Hz|m/s|m/s|rad/s', [6, 12, 13, 13, 13, 16, 16, 15], [(.true., n=1, 7), leaves_again(result)])
    call table%put_numbers(lines, shown_modes, reshape([first_of('alpha'), first_of('wavenumber'), frequency, &
                                                        scaled(frequency, 1.0_dp/two_pi), phase, group, &
                                                        released_frequency(result, n)], [n, 7]), count=count)
    call lines%append(why_not(first_of('growth_rate'), frequency(:few), phase(:few), group(:few), result%modes%rigid()))
    call report_critical(scene, result, lines)
  contains
    function first_of(name) result(values)
      !! Return a variable of the modes shown.
      character(*), intent(in) :: name
      real(dp), allocatable :: values(:)
      values = values_of(result, name)
      values = values(:n)
    end function first_of
  end subroutine report_modes

  subroutine report_configurations(result, lines)
    !! Print the first frequencies of every configuration of a beam that changes in time.
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    integer, parameter :: shown = 5
    real(dp), allocatable :: frequency(:, :), start(:)
    type(text_table) :: table
    character(:), allocatable :: cells
    integer :: c, k, n
    n = size(result%configurations)
    if (n < 2) return
    start = starts_of(result)
    frequency = all_modes(result, 'angular_frequency')
    frequency = scaled(frequency, 1.0_dp/two_pi)
    call lines%append_line('')
    table = table_of('configuration|from|mode 1|mode 2|mode 3|mode 4|mode 5', '|s|Hz|Hz|Hz|Hz|Hz', [15, 12, (13, k=1, shown)])
    call table%put_head(lines)
    do c = 1, min(n, most_rows)
      cells = text_of(c)//'|-'
      if (.not. is_missing(start(c))) cells = text_of(c)//'|'//shortest(start(c), 6)
      do k = 1, min(shown, size(frequency, 1))
        cells = cells//'|'//fixed(frequency(k, c))
      end do
      call table%put_row(lines, cells, detail=c > shown_configurations)
    end do
    call note_rest(lines, n, most_rows)
  end subroutine report_configurations

  pure logical function leaves_again(result)
    !! Return whether the captured mass is released and the modes of the beam alone are known.
    type(case_result), intent(in) :: result
    leaves_again = allocated(result%before) .and. allocated(result%events)
    if (leaves_again) leaves_again = any(result%events%kind == release_event)
  end function leaves_again

  function released_frequency(result, count) result(frequency)
    !! Return frequencies of the first modes of the beam alone, rad/s; missing beyond them, and if the mass stays.
    type(case_result), intent(in) :: result
    integer, intent(in) :: count
    real(dp) :: frequency(count)
    integer :: n
    frequency = missing
    if (.not. leaves_again(result)) return
    n = min(count, result%before%count)
    associate (all => values_of(result, 'angular_frequency_before'))
      frequency(:n) = all(:n)
    end associate
  end function released_frequency

  pure function why_not(growth, frequency, phase, group, rigid) result(text)
    !! Say why values of the modes shown do not exist; empty if all do.
    real(dp), intent(in) :: growth(:), frequency(:), phase(:), group(:)
    logical, intent(in) :: rigid(:)                !! the first modes move the beam as a rigid body
    character(:), allocatable :: text
    logical :: bends(size(frequency))
    bends = .true.
    bends(:size(rigid)) = .not. rigid(:size(rigid))
    associate (grows => growth(:size(frequency)) > 0.0_dp, none => is_missing(frequency))
      text = ''
      if (any(.not. bends)) text = text//'  -: a rigid-body mode is not a wave.'//new_line('a')
      if (any(none .and. grows)) text = text//'  -: an unstable mode has no frequency and is not a wave.'//new_line('a')
      if (any(none .and. bends .and. .not. grows)) text = text// &
        '  -: an overdamped mode has no frequency.'//new_line('a')
      if (any((is_missing(phase) .or. is_missing(group)) .and. bends .and. .not. none)) text = text// &
        '  -: at this frequency there is no wave with this velocity.'//new_line('a')
    end associate
  end function why_not

  subroutine report_critical(scene, result, lines)
    !! Print the critical speed of a rotating beam.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    real(dp) :: critical(1)
    critical = values_of(result, 'critical_angular_velocity')
    if (is_missing(critical(1)) .or. .not. allocated(scene%rotation)) return
    if (critical(1) == 0.0_dp) then
      call lines%append_line('  A mode is unstable at any angular velocity: the beam can turn about its root, and nothing '// &
                             'restores it.')
    else
      call lines%append_line('  A mode is unstable above '//shortest(critical(1), 6)//' rad/s ('// &
                             shortest(critical(1)*60.0_dp/two_pi, 4)//' rpm).')
    end if
  end subroutine report_critical

  pure function notes_report(notes) result(text)
    !! Return the notes, indented and wrapped: warnings as they are, remarks marked as notes.
    character(*), intent(in) :: notes             !! lines
    character(:), allocatable :: text
    type(string), allocatable :: lines(:)
    integer :: i
    text = ''
    lines = lines_of(notes)
    do i = 1, size(lines)
      if (is_remark(lines(i)%text)) then
        text = text//wrapped(note_mark//unmarked(trim(lines(i)%text)), text_width, len(note_hang))//new_line('a')
      else
        text = text//wrapped('  warning: '//trim(lines(i)%text), text_width, len(note_hang))//new_line('a')
      end if
    end do
  end function notes_report

end module bw_report
