module bw_spectrum_par
  !! `&spectrum`: amplitude spectra, and the waves that they show.
  use bw_input_name, only: input_group, input_name, integer_input, number_range, real_input, text_input
  use bw_input_values, only: group_values, position_of
  use bw_kinds, only: dp
  use bw_scene_messages, only: message_list
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: build_spectrum, check_spectrum, complete_spectrum

  type, public :: spectrum_par
    character(:), allocatable :: window   !! one of the words below
    integer :: max_peaks = 20             !! ≥ 1
    real(dp) :: confidence = 0.95_dp      !! confidence level of intervals, 0.5 ≤ … < 1
    real(dp) :: false_alarm = 0.01_dp     !! probability that noise alone gives a line, > 0
    character(:), allocatable :: ends     !! boundary conditions of the beam: one of the words below
  end type spectrum_par

  integer, parameter, public :: least_samples = 16     !! of a history with a spectrum, simulated or measured
    !! below it, no two peaks are resolved: the main lobe of the widest window covers eight lines of the spectrum

  type(input_group), parameter, public :: spectrum_group = input_group( &
    'spectrum', needs='response|record', absent='no spectral analysis', &
    physics='Finds the amplitude spectrum of a simulated response, and the frequencies, wave numbers and wave velocities '// &
    'that two sensors would measure. For a `&record` it finds the spectral lines, each with frequency, decay rate and '// &
    'amplitude and their confidence intervals.', &
    example='&impact mass_ratio = 0.2 /|&capture /|&response duration = 1, samples = 65536 /|&spectrum window = '// &
    '''blackman_harris'' /', &
    rules='At least 16 samples are needed. Frequencies, wave numbers and wave velocities of the spectral peaks are '// &
    'measured where 0.5 and 1.0 are among the points of `&response`; with `&stiffening` or `&shear` only the frequencies. '// &
    '`confidence`, `false_alarm` and `ends` concern a `&record`. `ends` says which shapes are fitted to its amplitudes:|'// &
    '`model`: those of the scene''s own beam; the default where it has supports, bodies, a hub or pieces|'// &
    '`tip`: those of a clamped beam that may have a mass at its tip; the default elsewhere|'// &
    '`clamped`: those of a beam of which only the clamped root is known|'// &
    '`any`: a beam with any ends')

  type(input_name), parameter, public :: spectrum_names(*) = [ &
    input_name('spectrum', 'window', text_input, default="'hann'", &
               words='hann rectangular hamming blackman blackman_harris flat_top', &
               meaning='window of the amplitude spectrum'), &
    input_name('spectrum', 'max_peaks', integer_input, '1', number_range(1.0_dp, 1e4_dp), '20', &
               meaning='largest number of peaks to measure'), &
    input_name('spectrum', 'confidence', real_input, '1', number_range(0.5_dp, 0.999999_dp), '0.95', swept=.true., &
               meaning='confidence level of the intervals of a record''s lines'), &
    input_name('spectrum', 'false_alarm', real_input, '1', number_range(1e-12_dp, 0.5_dp), '0.01', swept=.true., &
               meaning='probability of a line in a record of noise alone'), &
    input_name('spectrum', 'ends', text_input, default="'tip'", words='model tip clamped any', &
               meaning='boundary conditions assumed when waves are fitted')]

contains

  pure subroutine check_spectrum(groups, messages)
    !! Check that there are enough samples for a spectrum.
    type(group_values), intent(in) :: groups(:)
    type(message_list), intent(inout) :: messages
    integer :: i
    i = position_of(groups, 'response')
    if (i == 0 .or. position_of(groups, 'spectrum') == 0) return
    if (.not. groups(i)%known('samples')) return
    if (groups(i)%whole('samples') < least_samples) then
      call messages%add(groups(i)%line_of('samples'), 'response%samples', text_of(groups(i)%whole('samples'))// &
                        ' samples are too few for &spectrum; accepted: '//text_of(least_samples)//' or more')
    end if
  end subroutine check_spectrum

  pure subroutine complete_spectrum(spectrum, has_parts)
    !! Use the boundary conditions of the scene's own beam if it differs from the paper's.
    type(group_values), intent(inout) :: spectrum
    logical, intent(in) :: has_parts              !! the scene gives supports, attached bodies or several pieces
    integer :: i
    i = spectrum%at('ends')            ! gfortran 12 miscompiles `values(at(...))%text = ...`
    if (has_parts .and. .not. spectrum%values(i)%given) spectrum%values(i)%text = 'model'
  end subroutine complete_spectrum

  pure type(spectrum_par) function build_spectrum(values) result(spectrum)
    !! Build the spectrum from checked values.
    type(group_values), intent(in) :: values
    spectrum%window = values%text('window')
    spectrum%max_peaks = values%whole('max_peaks')
    spectrum%confidence = values%number('confidence')
    spectrum%false_alarm = values%number('false_alarm')
    spectrum%ends = values%text('ends')
  end function build_spectrum

end module bw_spectrum_par
