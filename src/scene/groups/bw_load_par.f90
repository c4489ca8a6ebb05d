module bw_load_par
  !! `&force`: a force on a place of the beam, for a limited time. `&base`: a transverse acceleration of the frame that holds the
  !! beam. Both vary in time as a pulse, a tone or as given in a file.
  use bw_input_name, only: any_number, columns_input, input_group, input_name, number_range, positive, real_input, text_input, &
    unit_interval
  use bw_input_values, only: group_values, position_of, positions_of
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_record_par, only: column_choice, one_choice
  use bw_scene_messages, only: message_list
  use bw_text, only: replaced, text_of
  implicit none (type, external)
  private
  public :: begins_or_ends_at_once, build_load, check_load, complete_loads, loads_text

  type, public :: load_par
    character(:), allocatable :: shape            !! half_sine, haversine, triangle, rectangle, sine or file
    real(dp) :: amplitude = 0.0_dp                !! its peak, N or m/s²
    real(dp) :: start = 0.0_dp                    !! s; for a file, an offset of its times
    real(dp) :: duration = missing                !! s, > 0; `missing`: to the end of the record
    real(dp) :: frequency = 0.0_dp                !! of a sine, Hz
    character(:), allocatable :: file             !! as the user gave it, relative to the scene; unallocated: none
    type(column_choice), allocatable :: time      !! column of the times; unallocated: not given
    type(column_choice), allocatable :: column    !! of the load; unallocated: the only one besides the time
    real(dp) :: sample_rate = missing             !! Hz; `missing` if times are read
    real(dp) :: scale = missing                   !! SI over the unit of the column; `missing`: from that unit
    real(dp) :: time_scale = missing              !! s over the file's unit of time; `missing` likewise
    integer :: line = 0                           !! where the group opens
  end type load_par

  type, extends(load_par), public :: force_par
    real(dp) :: position = 1.0_dp                 !! ξ where it acts
  end type force_par

  character(*), parameter :: shape_words = 'half_sine haversine triangle rectangle sine file'
  character(*), parameter :: of_file(*) = [character(11) :: 'file', 'time', 'time_scale', 'sample_rate', 'column', 'scale']

  type(input_group), parameter, public :: force_group = input_group( &
    'force', repeatable=.true., along='force', is_event=.true., needs='response', excludes='record recontact', &
    absent='no force acts', &
    physics='A force F(t) at a point, positive in the direction of positive displacement. Its power is F(t) v_t.', &
    example='&force position = 0.7, shape = ''half_sine'', amplitude = 200, duration = 4e-4 /   ! a tap of a '// &
    'hammer|&response duration = 0.5, samples = 8192, acceleration = .true. /', &
    rules='Write one group for each force. The beam is at rest until a force acts, unless something else moves it. A half '// &
    'sine, a haversine (1 - cos)/2 and a triangle begin and end at 0 and reach `amplitude` in the middle; a rectangle is '// &
    '`amplitude` throughout; a sine begins at 0 and has the `frequency`. With shape = ''file'' the force is read like the '// &
    'histories of a `&record`; it is linear between samples, and 0 before and after them. Histories are exact in time and '// &
    'include the static response of the modes that are not summed. A sweep names a force by its number in the scene, as '// &
    '`force(2)%amplitude`.')

  type(input_name), parameter, public :: force_names(*) = [ &
    input_name('force', 'position', real_input, '1', unit_interval, '1', swept=.true., &
               meaning='place of the force: x/l'), &
    input_name('force', 'shape', text_input, default="'half_sine'", words=shape_words, &
               meaning='variation in time; file: as measured'), &
    input_name('force', 'amplitude', real_input, 'N', any_number, swept=.true., &
               meaning='largest value, positive as displacement'), &
    input_name('force', 'start', real_input, 's', any_number, '0', swept=.true., &
               meaning='beginning; added to the times of a file'), &
    input_name('force', 'duration', real_input, 's', positive, swept=.true., &
               meaning='duration of pulse or tone; absent: to the end'), &
    input_name('force', 'frequency', real_input, 'Hz', positive, swept=.true., meaning='frequency of a sine'), &
    input_name('force', 'file', text_input, '', meaning='file of the measured force'), &
    input_name('force', 'time', columns_input, range=number_range(1.0_dp, 1e6_dp), excludes='sample_rate', &
               meaning='column of the times'), &
    input_name('force', 'time_scale', real_input, '1', positive, excludes='sample_rate', swept=.true., &
               meaning='unit of the times in seconds; absent: by the file'), &
    input_name('force', 'sample_rate', real_input, 'Hz', number_range(1e-9_dp, 1e15_dp), excludes='time time_scale', swept=.true., &
               meaning='sampling rate, the first sample at time 0'), &
    input_name('force', 'column', columns_input, range=number_range(1.0_dp, 1e6_dp), &
               meaning='its column; absent: the only one besides the time'), &
    input_name('force', 'scale', real_input, '1', any_number, swept=.true., meaning='factor to N; absent: by the file''s unit')]

  type(input_group), parameter, public :: base_group = input_group( &
    'base', repeatable=.true., along='base', is_event=.true., needs='response', excludes='record recontact', &
    absent='the frame does not accelerate', &
    physics='The frame that holds the beam has the transverse acceleration a(t), as on a shaker table or in a ground shock. In '// &
    'the moving frame beam and bodies are loaded by -a times their mass.', &
    example='&base shape = ''haversine'', amplitude = 50, duration = 0.011 /   ! m/s2|&response duration = 0.2, samples = '// &
    '4096, points = 0.0, 1.0, bending_moment = .true. /', &
    rules='Write one group for each acceleration of root, supports and springs. Displacements, velocities and accelerations '// &
    'are relative to the moving frame: an accelerometer on the beam measures a(t) in addition. The axis of a `&hub` moves with '// &
    'the frame; only the inertia of the beam turns the hub, whose own centre of mass lies on the axis. A uniform load of q N/m '// &
    'along a uniform beam without bodies is equivalent to the acceleration -q divided by its mass per length. Shapes and files '// &
    'are those of `&force`.')

  type(input_name), parameter, public :: base_names(*) = [ &
    input_name('base', 'shape', text_input, default="'half_sine'", words=shape_words, &
               meaning='variation in time; file: as measured'), &
    input_name('base', 'amplitude', real_input, 'm s-2', any_number, swept=.true., &
               meaning='largest value of the acceleration'), &
    input_name('base', 'start', real_input, 's', any_number, '0', swept=.true., &
               meaning='beginning; added to the times of a file'), &
    input_name('base', 'duration', real_input, 's', positive, swept=.true., &
               meaning='duration of pulse or tone; absent: to the end'), &
    input_name('base', 'frequency', real_input, 'Hz', positive, swept=.true., meaning='frequency of a sine'), &
    input_name('base', 'file', text_input, '', meaning='file of the measured acceleration'), &
    input_name('base', 'time', columns_input, range=number_range(1.0_dp, 1e6_dp), excludes='sample_rate', &
               meaning='column of the times'), &
    input_name('base', 'time_scale', real_input, '1', positive, excludes='sample_rate', swept=.true., &
               meaning='unit of the times in seconds; absent: by the file'), &
    input_name('base', 'sample_rate', real_input, 'Hz', number_range(1e-9_dp, 1e15_dp), excludes='time time_scale', swept=.true., &
               meaning='sampling rate, the first sample at time 0'), &
    input_name('base', 'column', columns_input, range=number_range(1.0_dp, 1e6_dp), &
               meaning='its column; absent: the only one besides the time'), &
    input_name('base', 'scale', real_input, '1', any_number, swept=.true., meaning='factor to m/s2; absent: by the file''s unit')]

contains

  pure subroutine check_load(load, messages)
    !! Check that a shape has the values that it needs, and none that have no meaning for it.
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
      character(:), allocatable :: instead
      instead = 'a group without it'
      if (name == 'file') instead = instead//', or shape = ''file'''
      if (load%given(name)) call messages%add(load%line_of(name), place//name, 'has no meaning with shape = '''//shape// &
                                              '''; accepted: '//instead)
    end subroutine refuse
  end subroutine check_load

  pure subroutine complete_loads(groups, messages)
    !! Check that a load begins before the histories end.
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
                        text_of(groups(g)%number('start'))//' s, after the end of the histories; accepted: below the duration '// &
                        'of &response, '//text_of(groups(r)%number('duration'))//' s')
    end do
  end subroutine complete_loads

  pure type(load_par) function build_load(values) result(load)
    !! Build a load from checked values.
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
    !! Return whether the load jumps, so that accelerations do not converge. A load from a file is checked when it is read.
    type(group_values), intent(in) :: load
    real(dp) :: half_turns
    jumps = .false.
    if (.not. load%known('shape')) return
    jumps = load%text('shape') == 'rectangle'
    if (load%text('shape') /= 'sine' .or. .not. (load%known('duration') .and. load%known('frequency'))) return
    half_turns = 2.0_dp*load%number('frequency')*load%number('duration')
    jumps = abs(half_turns - anint(half_turns)) > 16.0_dp*spacing(half_turns)
  end function begins_or_ends_at_once

  pure function loads_text(groups, group) result(text)
    !! Return the text of a report on all forces, or all motions of the base: `force at xi = 1 (half sine of 100 N for 0.001 s)`,
    !! or their number if they are many.
    type(group_values), intent(in) :: groups(:)
    character(*), intent(in) :: group              !! `force` or `base`; there is at least one
    character(:), allocatable :: text
    integer, parameter :: most = 3
    integer, allocatable :: loads(:)
    integer :: i
    loads = positions_of(groups, group)
    if (group == 'base') then
      text = 'base ('//load_text(groups(loads(1)), ' m/s2')//')'
      if (size(loads) > 1) text = text_of(size(loads))//' motions of the base'
    else
      text = ''
      do i = 1, size(loads)
        text = text//', force at xi = '//groups(loads(i))%number_or_swept('position', '')//' ('// &
          load_text(groups(loads(i)), ' N')//')'
      end do
      text = text(3:)
      if (size(loads) > most) text = text_of(size(loads))//' forces'
    end if
  end function loads_text

  pure function load_text(values, unit) result(text)
    !! Return the text of one load: `half sine of 100 N for 0.001 s`.
    type(group_values), intent(in) :: values
    character(*), intent(in) :: unit               !! of the load, with a leading blank
    character(:), allocatable :: text
    text = replaced(values%text('shape'), '_', ' ')
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
