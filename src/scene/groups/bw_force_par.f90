module bw_force_par
  !! `&force`: a force that acts at a place of the beam for some time.
  use bw_input_name, only: any_number, columns_input, input_group, input_name, number_range, positive, real_input, text_input, &
    unit_interval
  use bw_input_values, only: group_values, positions_of
  use bw_kinds, only: dp
  use bw_load_par, only: build_load, load_par, load_text, shape_words
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: build_force, forces_text

  type, extends(load_par), public :: force_par
    real(dp) :: position = 1.0_dp                 !! ξ where it acts
  end type force_par

  type(input_group), parameter, public :: force_group = input_group( &
    'force', repeatable=.true., along='force', is_event=.true., needs='response', excludes='record recontact', &
    absent='no force acts', &
    physics='A force F(t) at a point, positive as displacement is. Its power is F(t) v_t.', &
    example='&force position = 0.7, shape = ''half_sine'', amplitude = 200, duration = 4e-4 /   ! a tap of a '// &
    'hammer|&response duration = 0.5, samples = 8192, acceleration = .true. /', &
    rules='One group for each force. The beam is at rest until a force acts, unless something else moves it. A half sine, a '// &
    'haversine (1 - cos)/2 and a triangle begin and end at 0 and reach `amplitude` in the middle; a rectangle is '// &
    '`amplitude` throughout; a sine begins at 0 and has the `frequency`. With shape = ''file'' the force is read as '// &
    '`&record` reads histories; it is linear between samples, and 0 before and after them. Histories are exact in time and '// &
    'include the static response of the modes that are not summed. A sweep names a force by its number in the scene, as '// &
    '`force(2)%amplitude`.')

  type(input_name), parameter, public :: force_names(*) = [ &
    input_name('force', 'position', real_input, '1', unit_interval, '1', swept=.true., &
               meaning='place of the force: x/l'), &
    input_name('force', 'shape', text_input, default="'half_sine'", words=shape_words, &
               meaning='course in time; file: as measured'), &
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
               meaning='unit of the times in seconds; else by the file'), &
    input_name('force', 'sample_rate', real_input, 'Hz', number_range(1e-9_dp, 1e15_dp), excludes='time time_scale', swept=.true., &
               meaning='sampling rate, the first sample at time 0'), &
    input_name('force', 'column', columns_input, range=number_range(1.0_dp, 1e6_dp), &
               meaning='its column; absent: the only one but the time'), &
    input_name('force', 'scale', real_input, '1', any_number, swept=.true., meaning='factor to N; else by the file''s unit')]

contains

  pure type(force_par) function build_force(values) result(force)
    !! From checked values.
    type(group_values), intent(in) :: values
    force%load_par = build_load(values)
    force%position = values%number('position')
  end function build_force

  pure function forces_text(groups) result(text)
    !! What a report calls them: `force at xi = 1 (half sine of 100 N for 0.001 s)`, or of many how many there are.
    type(group_values), intent(in) :: groups(:)   !! of a scene with at least one
    character(:), allocatable :: text
    integer, parameter :: most = 3
    integer, allocatable :: forces(:)
    integer :: f
    forces = positions_of(groups, 'force')
    text = text_of(size(forces))//' forces'
    if (size(forces) > most) return
    text = ''
    do f = 1, size(forces)
      associate (values => groups(forces(f)))
        text = text//', force at xi = '//values%number_or_swept('position', '')//' ('//load_text(values, ' N')//')'
      end associate
    end do
    text = text(3:)
  end function forces_text

end module bw_force_par
