module bw_base_par
  !! `&base`: the frame that holds the beam is accelerated across it.
  use bw_input_name, only: any_number, columns_input, input_group, input_name, number_range, positive, real_input, text_input
  use bw_input_values, only: group_values, positions_of
  use bw_kinds, only: dp
  use bw_load_par, only: build_load, load_par, load_text, shape_words
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: bases_text, build_base

  type(input_group), parameter, public :: base_group = input_group( &
    'base', repeatable=.true., along='base', is_event=.true., needs='response', excludes='record recontact', &
    absent='the frame does not accelerate', &
    physics='What holds the beam moves transversely with the acceleration a(t), as a shaker table or a ground shock does. '// &
    'Seen from the moving frame the beam and its bodies are loaded by -a times their mass.', &
    example='&base shape = ''haversine'', amplitude = 50, duration = 0.011 /   ! m/s2|&response duration = 0.2, samples = '// &
    '4096, points = 0.0, 1.0, bending_moment = .true. /', &
    rules='One group for each acceleration of root, supports and springs; displacements, velocities and accelerations '// &
    'are those seen from the moving frame: an accelerometer on the beam shows a(t) more. The axis of a `&hub` moves with '// &
    'the frame: the inertia of the beam turns the hub, and its own does not, as its centre of mass lies on the axis. A '// &
    'uniform load of q N/m along a uniform beam without bodies is equivalent to the acceleration -q over its mass per '// &
    'length. Shapes and files are those of `&force`.')

  type(input_name), parameter, public :: base_names(*) = [ &
    input_name('base', 'shape', text_input, default="'half_sine'", words=shape_words, &
               meaning='course in time; file: as measured'), &
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
               meaning='unit of the times in seconds; else by the file'), &
    input_name('base', 'sample_rate', real_input, 'Hz', number_range(1e-9_dp, 1e15_dp), excludes='time time_scale', swept=.true., &
               meaning='sampling rate, the first sample at time 0'), &
    input_name('base', 'column', columns_input, range=number_range(1.0_dp, 1e6_dp), &
               meaning='its column; absent: the only one but the time'), &
    input_name('base', 'scale', real_input, '1', any_number, swept=.true., meaning='factor to m/s2; else by the file''s unit')]

contains

  pure type(load_par) function build_base(values) result(base)
    !! From checked values.
    type(group_values), intent(in) :: values
    base = build_load(values)
  end function build_base

  pure function bases_text(groups) result(text)
    !! What a report calls them: `base (sine of 1 m/s2 at 20 Hz)`.
    type(group_values), intent(in) :: groups(:)   !! of a scene with at least one
    character(:), allocatable :: text
    integer, allocatable :: bases(:)
    bases = positions_of(groups, 'base')
    text = text_of(size(bases))//' motions of the base'
    if (size(bases) > 1) return
    text = 'base ('//load_text(groups(bases(1)), ' m/s2')//')'
  end function bases_text

end module bw_base_par
