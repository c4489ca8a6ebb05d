module bw_event_report
  !! The printed report of events: the state just after an impact, the forces of contacts, and the balance of every event.
  use bw_case_result, only: case_result
  use bw_case_rows, only: values_of
  use bw_columns, only: fixed, most_rows, note_rest, table_of, text_table
  use bw_event, only: capture_event, contact_event, event_words
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_scene, only: bodies_change, scene_type
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: report_contact, report_events, report_impact

  integer, parameter :: shown_events = 8     !! rows that are no details

contains

  subroutine report_impact(scene, result, lines)
    !! Print the jump, and the balance of every event.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    character(:), allocatable :: struck, spot
    real(dp) :: state(3)
    struck = 'tip'
    spot = 'tip'
    if (scene%impact%position < 1.0_dp) struck = 'beam there'
    if (scene%impact%position < 1.0_dp) spot = 'place of the blow'
    state = [values_of(result, 'impulse'), values_of(result, 'mass_velocity'), values_of(result, 'tip_velocity')]
    call lines%append_line('')
    if (result%impact%gamma == 0.0_dp) then
      call lines%append_line('  Nothing strikes the beam: the mass is 0.')
    else
      call lines%append_line('  Just after the impact: impulse '//shortest(state(1), 6)//' N s; velocity of the mass '// &
                             shortest(state(2), 6)//' m/s, of the '//struck//' '//shortest(state(3), 6)//' m/s')
    end if
    if (result%impact%impulse == 0.0_dp .and. result%impact%gamma > 0.0_dp) call lines%append_line( &
      '  With infinitely many modes the velocity jumps only at the '//spot//' itself, which takes no impulse.')
    call report_events(result, lines)
  end subroutine report_impact

  subroutine report_contact(scene, result, lines)
    !! Print duration and peak force of the first contact, the rebound of the mass, and the result of an instantaneous blow.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    character(:), allocatable :: text
    logical, allocatable :: matters(:)
    integer :: i, hardest
    call lines%append_line('')
    if (all(result%events%kind /= contact_event)) then
      if (scene%impact%mass_ratio > 0.0_dp .and. (allocated(scene%initial) .or. bodies_change(scene))) then
        call lines%append_line('  The mass does not meet the beam within the record.')
      else
        call lines%append_line('  Nothing strikes the beam: the mass or its velocity is 0.')
      end if
      if (size(result%events) > 0) call report_events(result, lines)
      return
    end if
    matters = forces_that_matter(result)
    hardest = maxloc(abs(result%contact%largest), dim=1, mask=matters)
    i = findloc(result%events%kind, contact_event, dim=1)
    if (.not. matters(i)) i = hardest
    associate (event => result%events(i), contact => result%contact, impulse => values_of(result, 'event_impulse'), &
               presses => result%events(:size(matters))%kind == contact_event, &
               blow => (1.0_dp + result%contact%restitution)*scene%impact%mass*result%contact%approach)
      text = '  The first contact '
      if (i == hardest .and. count(presses(:i)) > 1) text = '  Contact '//text_of(count(presses(:i)))//', the one with the '// &
        'largest force, '
      text = text//'lasts '//shortest(1.0e6_dp*(event%end_time - event%time), 5)//' us'// &
        give_or_take(1.0e6_dp*event%end_error, 'us')//' with a force of up to '//shortest(abs(contact%largest(i)), 6)//' N'// &
        give_or_take(contact%force_error(i), 'N')//', '//shortest(1.0e6_dp*(contact%largest_time(i) - event%time), 4)// &
        ' us after it begins; impulse '//shortest(impulse(i), 6)//' N s'
      if (any(result%events%kind == capture_event)) then
        call lines%append_line(text//'; the mass is captured at the largest indentation.')
      else if (is_missing(contact%restitution) .or. count(presses(:i)) > 1) then
        call lines%append_line(text//'.')
        if (contact%lasting .and. count(result%events%kind == contact_event) == 1) &
          call lines%append_line('  It has not ended at the end of the record, so that there is no restitution yet.')
      else
        call lines%append_line(text//', effective restitution '//shortest(contact%restitution, 5)//'.')
        call lines%append_line('  An instantaneous blow with that restitution has the impulse '//shortest(blow, 4)// &
          ' N s on a rigid wall and '//shortest(blow/(1.0_dp + scene%impact%mass_ratio*sum(result%modes%struck**2/ &
          result%modes%modal_mass)), 4)//' N s on '//text_of(result%modes%count)// &
          ' modes of the beam, where it tends to 0 as modes are added.')
      end if
      if (count(presses) > 1) call lines%append_line('  '//text_of(count(presses))//' contacts with a total impulse of '// &
        shortest(sum(impulse, mask=result%events%kind == contact_event), 6)//' N s. The largest force, '// &
        shortest(abs(contact%largest(hardest)), 6)//' N, occurs in contact '//text_of(count(presses(:hardest)))//', at '// &
        shortest(contact%largest_time(hardest), 6)//' s.')
      if (count(matters) < count(presses)) call lines%append_line('  '//text_of(count(presses) - count(matters))// &
        ' of them stay below a millionth of that: waves run ahead, and the mass chatters before the main contact.')
      if (.not. is_missing(contact%leaving)) call lines%append_line('  After the last contact the mass moves at '// &
        shortest(contact%leaving, 5)//' m/s'//part_of_approach(scene, contact%leaving)//'.')
    end associate
    call report_events(result, lines, matters)
  end subroutine report_contact

  pure function give_or_take(error, unit) result(text)
    !! Format an error after its number; empty if unknown.
    real(dp), intent(in) :: error
    character(*), intent(in) :: unit
    character(:), allocatable :: text
    text = ''
    if (.not. is_missing(error)) text = ' (+/- '//shortest(error, 2)//' '//unit//')'
  end function give_or_take

  pure function forces_that_matter(result) result(matters)
    !! Select contacts with more than a small fraction of the largest force, (events up to the last contact). Waves that
    !! precede the motion of a released beam make a nearby mass chatter before the beam reaches it.
    type(case_result), intent(in) :: result
    logical, allocatable :: matters(:)
    real(dp), parameter :: part = 1.0e-6_dp
    associate (force => abs(result%contact%largest))
      matters = result%events(:size(force))%kind == contact_event
      matters = matters .and. force >= part*maxval(force, mask=matters)
    end associate
  end function forces_that_matter

  pure function part_of_approach(scene, leaving) result(text)
    !! Return the final velocity of a mass relative to its approach velocity, if it has one.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: leaving
    character(:), allocatable :: text
    text = ''
    if (scene%impact%approach_velocity /= 0.0_dp) &
      text = ', '//shortest(leaving/scene%impact%approach_velocity, 3)//' of its approach velocity'
  end function part_of_approach

  subroutine report_events(result, lines, matters)
    !! Print the balance of every event; times unless all are at t = 0, with errors if contacts amplify them, and ends
    !! if one lasts.
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    logical, intent(in), optional :: matters(:)   !! contacts that matter; absent: all events do
    real(dp), allocatable, dimension(:) :: energy_before, energy_after, momentum_before, momentum_after, time, end_time, &
      impulse, hub
    type(text_table) :: table
    character(:), allocatable :: until
    logical :: timed, lasting, doubtful, pressed  ! columns
    logical, allocatable :: shown(:)
    integer, allocatable :: rows(:)
    integer :: i, j
    time = values_of(result, 'event_time')
    end_time = values_of(result, 'event_end')
    timed = any(end_time > 0.0_dp)
    lasting = any(end_time > time)
    doubtful = timed .and. any(result%events%time_error > 0.0_dp)
    hub = values_of(result, 'hub_rate_change')
    call lines%append_line('')
    pressed = allocated(result%contact)
    table = table_of('  event|time|+/-|until|impulse|largest force|energy before|energy after|momentum before|momentum after|'// &
                     'hub faster by', '|s|s|s|N s|N|J|J|kg m/s|kg m/s|rad/s', [-10, 14, 10, 14, 12, 15, 15, 15, 17, 16, 15], &
                     [.true., timed, doubtful, lasting, .true., pressed, .true., .true., .not. pressed, .not. pressed, &
                      any(abs(hub) > 0.0_dp)])
    call table%put_head(lines)
    shown = result%events%kind /= contact_event .or. .not. pressed
    if (present(matters)) shown(:size(matters)) = shown(:size(matters)) .or. matters
    impulse = values_of(result, 'event_impulse')
    energy_before = values_of(result, 'energy_before')
    energy_after = values_of(result, 'energy_after')
    momentum_before = values_of(result, 'momentum_before')
    momentum_after = values_of(result, 'momentum_after')
    if (size(shown) <= most_rows) then
      rows = [(i, i=1, size(shown))]
    else
      rows = pack([(i, i=1, size(shown))], shown)
      rows = rows(:min(most_rows, size(rows)))
    end if
    do j = 1, size(rows)
      i = rows(j)
      until = ''
      if (end_time(i) > time(i)) until = shortest(end_time(i), 7)
      call table%put_row(lines, '  '//event_words(result%events(i)%kind)//'|'//shortest(time(i), 7)//'|'// &
                         shortest(result%events(i)%time_error, 2)//'|'//until//'|'//fixed(impulse(i))//'|'//force_cell(i)//'|'// &
                         fixed(energy_before(i))//'|'//fixed(energy_after(i))//'|'//fixed(momentum_before(i))//'|'// &
                         fixed(momentum_after(i))//hub_cell(i), detail=.not. shown(i) .or. count(shown(:i)) > shown_events)
    end do
    call note_rest(lines, size(result%events), most_rows)
    if (any(is_missing([energy_before, energy_after]))) call lines%append_line('  -: a small difference of large numbers, with '// &
      'fewer than three reliable digits.')
  contains
    function force_cell(i) result(cell)
      integer, intent(in) :: i                    !! the event
      character(:), allocatable :: cell
      cell = ''
      if (.not. pressed) return
      if (result%events(i)%kind == contact_event) cell = fixed(abs(result%contact%largest(i)))
    end function force_cell

    function hub_cell(i) result(cell)
      integer, intent(in) :: i                    !! the event
      character(:), allocatable :: cell
      cell = ''
      if (any(abs(hub) > 0.0_dp)) cell = '|'//fixed(hub(i))
    end function hub_cell
  end subroutine report_events

end module bw_event_report
