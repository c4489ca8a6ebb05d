module bw_load_par
  !! What `&force` and `&base` have in common: how a load varies in time, as a pulse, a tone or what a file holds.
  use bw_input_values, only: group_values, position_of
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_record_par, only: column_choice, one_choice
  use bw_scene_messages, only: message_list
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: begins_or_ends_at_once, build_load, check_load, complete_loads, load_text

  type, public :: load_par
    character(:), allocatable :: shape            !! half_sine, haversine, triangle, rectangle, sine or file
    real(dp) :: amplitude = 0.0_dp                !! its largest value, N or m/s²
    real(dp) :: start = 0.0_dp                    !! s; of a file what is added to its times
    real(dp) :: duration = missing                !! s, > 0; `missing`: to the end of the record
    real(dp) :: frequency = 0.0_dp                !! of a sine, Hz
    character(:), allocatable :: file             !! as the user wrote it, beside the scene; unallocated: none
    type(column_choice), allocatable :: time      !! column of the times; unallocated: not said
    type(column_choice), allocatable :: column    !! of the load; unallocated: the only one beside the time
    real(dp) :: sample_rate = missing             !! Hz; `missing` where times are read
    real(dp) :: scale = missing                   !! SI over the unit of the column; `missing`: that unit tells
    real(dp) :: time_scale = missing              !! s over the file's unit of time; `missing` likewise
    integer :: line = 0                           !! where the group opens
  end type load_par

  character(*), parameter, public :: shape_words = 'half_sine haversine triangle rectangle sine file'
  character(*), parameter :: of_file(*) = [character(11) :: 'file', 'time', 'time_scale', 'sample_rate', 'column', 'scale']

contains

  pure subroutine check_load(load, messages)
    !! A shape has what it takes, and nothing that has no meaning for it.
    type(group_values), intent(in) :: load
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: shape, place
    integer :: i
    if (.not. load%known('shape')) return
    shape = load%text('shape')
    place = trim(load%group)//'%'
    if (shape == 'file') then
      call need('file', 'the name of a file', messages)
      call refuse('amplitude', messages)
      call refuse('duration', messages)
    else
      call need('amplitude', 'the largest value of the load', messages)
      do i = 1, size(of_file)
        call refuse(trim(of_file(i)), messages)
      end do
    end if
    if (shape == 'sine') then
      call need('frequency', 'a frequency in Hz', messages)
    else
      call refuse('frequency', messages)
    end if
  contains
    pure subroutine need(name, what, messages)
      character(*), intent(in) :: name, what
      type(message_list), intent(inout) :: messages
      if (.not. load%given(name)) call messages%add(load%line, place//name, 'is missing: shape = '''//shape// &
                                                    ''' needs it; accepted: '//what)
    end subroutine need

    pure subroutine refuse(name, messages)
      character(*), intent(in) :: name
      type(message_list), intent(inout) :: messages
      if (load%given(name)) call messages%add(load%line_of(name), place//name, 'has no meaning with shape = '''//shape// &
                                              '''; accepted: a group without it')
    end subroutine refuse
  end subroutine check_load

  pure subroutine complete_loads(groups, messages)
    !! A load begins before the histories end.
    type(group_values), intent(in) :: groups(:)
    type(message_list), intent(inout) :: messages
    integer :: g, r
    r = position_of(groups, 'response')
    if (r == 0) return
    if (.not. groups(r)%known('duration')) return
    do g = 1, size(groups)
      if (groups(g)%group /= 'force' .and. groups(g)%group /= 'base') cycle
      if (.not. groups(g)%known('start') .or. groups(g)%text('shape') == 'file') cycle
      if (groups(g)%number('start') < groups(r)%number('duration')) cycle
      call messages%add(groups(g)%line_of('start'), trim(groups(g)%group)//'%start', 'is '// &
                        text_of(groups(g)%number('start'))//' s, when the histories have ended; accepted: below the duration '// &
                        'of &response, '//text_of(groups(r)%number('duration'))//' s')
    end do
  end subroutine complete_loads

  pure type(load_par) function build_load(values) result(load)
    !! From checked values.
    type(group_values), intent(in) :: values
    load%line = values%line
    load%shape = values%text('shape')
    load%start = values%number('start')
    if (values%known('amplitude')) load%amplitude = values%number('amplitude')
    if (values%known('duration')) load%duration = values%number('duration')
    if (values%known('frequency')) load%frequency = values%number('frequency')
    if (values%known('sample_rate')) load%sample_rate = values%number('sample_rate')
    if (values%known('scale')) load%scale = values%number('scale')
    if (values%known('time_scale')) load%time_scale = values%number('time_scale')
    if (values%known('file')) load%file = values%text('file')
    if (values%known('time')) load%time = one_choice(values%values(values%at('time')))
    if (values%known('column')) load%column = one_choice(values%values(values%at('column')))
  end function build_load

  pure logical function begins_or_ends_at_once(load) result(jumps)
    !! The load itself jumps, after which accelerations have no limit. What a file holds is seen when it is read.
    type(group_values), intent(in) :: load
    real(dp) :: half_turns
    jumps = .false.
    if (.not. load%known('shape')) return
    jumps = load%text('shape') == 'rectangle'
    if (load%text('shape') /= 'sine' .or. .not. (load%known('duration') .and. load%known('frequency'))) return
    half_turns = 2.0_dp*load%number('frequency')*load%number('duration')
    jumps = abs(half_turns - anint(half_turns)) > 16.0_dp*spacing(half_turns)
  end function begins_or_ends_at_once

  pure function load_text(values, unit) result(text)
    !! What a report calls it: `half sine of 100 N for 0.001 s`.
    type(group_values), intent(in) :: values
    character(*), intent(in) :: unit               !! of the load, behind a blank
    character(:), allocatable :: text
    integer :: i
    text = values%text('shape')
    do i = 1, len(text)
      if (text(i:i) == '_') text(i:i) = ' '
    end do
    if (text == 'file') then
      text = 'measured in '//values%text('file')
      return
    end if
    text = text//' of '//values%number_or_swept('amplitude', unit)
    if (values%known('frequency')) text = text//' at '//values%number_or_swept('frequency', ' Hz')
    if (values%known('duration')) text = text//' for '//values%number_or_swept('duration', ' s')
    if (values%number('start') > 0.0_dp .or. values%is_swept('start')) text = text//' from '// &
      values%number_or_swept('start', ' s')//' on'
  end function load_text

end module bw_load_par
