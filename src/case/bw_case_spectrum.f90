module bw_case_spectrum
  !! Amplitude spectra of histories, and waves measured at tip and midpoint. The latter are compared with the modes that
  !! move in the samples after the last event and the last load.
  use bw_amplitude_spectrum, only: amplitude_spectrum, spectrum_plan
  use bw_segment_samples, only: samples_of_segment
  use bw_case_result, only: case_done, case_motion, case_spectrum, load_result
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_measured, only: measure_waves
  use bw_mode_check, only: known_modes, record_facts
  use bw_mode_set, only: first_numbers, mode_set
  use bw_monitor, only: monitor_type
  use bw_note, only: remark
  use bw_response, only: response_type
  use bw_result_layout, only: result_layout
  use bw_model_shapes, only: mean_wavenumber
  use bw_scene, only: changes_shapes, scene_type, varies_along_pieces
  use bw_scene_pieces, only: pieces_of, struck_beam
  use bw_text, only: append, text_of
  use bw_time_grid, only: time_grid_of
  use bw_timeline, only: carried_type, configurations_of
  implicit none (type, external)
  private
  public :: find_spectrum

  integer, parameter :: most = 4096              !! modes; their aliases fill any record

contains

  subroutine find_spectrum(scene, layout, motion, response, status, monitor, plan, spectrum, loads)
    !! Find amplitude spectra of all points, and waves from the tip and midpoint histories alone.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in) :: response    !! displacements at all points
    integer, intent(in) :: status                  !! of the histories
    class(monitor_type), intent(inout) :: monitor  !! nothing is found if it requests a stop
    type(spectrum_plan), intent(inout) :: plan     !! may come from another case
    type(case_spectrum), intent(out) :: spectrum
    type(load_result), intent(in), optional :: loads   !! that also move the beam
    integer :: p
    if (status /= case_done) call append(spectrum%notes, 'no spectrum: the histories are incomplete')
    if (layout%middle == 0 .or. layout%tip == 0) then
      call remark(spectrum%notes, 'measured waves: they need the points 0.5 and 1.0, so they are left out')
    else
      ! first, as it needs more memory than the spectra
      call find_waves(scene, layout, motion, response, status, monitor, spectrum, loads)
    end if
    if (status /= case_done) return
    associate (histories => response%displacement)
      allocate (spectrum%amplitude(size(histories, 1)/2 + 1, size(histories, 2)))
      do p = 1, size(histories, 2)
        if (monitor%stop_requested()) return
        call amplitude_spectrum(histories(:, p), scene%spectrum%window, plan, spectrum%amplitude(:, p))
      end do
    end associate
  end subroutine find_spectrum

  subroutine find_waves(scene, layout, motion, response, status, monitor, spectrum, loads)
    !! Measure waves in the free motion after the last event and the last load.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in) :: response
    integer, intent(in) :: status
    class(monitor_type), intent(inout) :: monitor
    type(case_spectrum), intent(inout) :: spectrum
    type(load_result), intent(in), optional :: loads
    type(record_facts) :: facts
    integer :: first, i, samples
    allocate (spectrum%measured)
    samples = size(response%displacement, 1)
    first = first_of_last(scene, motion)
    if (present(loads)) first = max(first, 1 + ceiling(min(1.0_dp, loads%until/scene%response%duration)*samples))
    if (first > samples) then
      call remark(spectrum%notes, 'measured: no sample comes after the last event, so there are no waves to measure')
    else if (first > 1) then
      call remark(spectrum%notes, 'measured: the waves are those of the '//text_of(samples - first + 1)// &
                               ' samples after the last event')
    end if
    facts%duration = scene%response%duration*(real(samples - first + 1, dp)/samples)
    facts%length = motion%units%length
    facts%max_peaks = scene%spectrum%max_peaks
    call know_ends(scene, motion, facts)
    facts%rotates = .false.
    if (allocated(scene%rotation)) facts%rotates = scene%rotation%plane == 'in'
    if (status == case_done .and. first <= samples) call know_modes(motion, facts%known, loads)
    call measure_waves(response%displacement(first:, layout%tip), response%displacement(first:, layout%middle), facts, &
                       spectrum%measured, monitor)
    if (monitor%stop_requested()) return
    do i = 1, size(spectrum%measured%notes)
      call append(spectrum%notes, spectrum%measured%notes(i)%text)
    end do
  end subroutine find_waves

  pure subroutine know_ends(scene, motion, facts)
    !! Set the boundary conditions at the end of the motion, and the length that makes α of a wave number. They are
    !! unknown with tension, taper, shear or a free hub, and while a mass is pressed against the beam.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(record_facts), intent(inout) :: facts
    type(struck_beam) :: pieces
    type(carried_type), allocatable :: carried(:)
    facts%ends = ''
    if (.not. motion%modes%resolved) return
    if (is_pressed(motion) .or. allocated(scene%shear) .or. varies_along_pieces(scene)) return
    facts%ends = 'tip'
    if (.not. changes_shapes(scene)) return
    facts%ends = 'model'
    carried = configurations_of(scene)
    associate (last => carried(min(size(carried), last_configuration(motion))))
      pieces = pieces_of(scene, motion%units, last%captured, last%body)
    end associate
    facts%model = pieces%beam
    facts%length = motion%units%length/mean_wavenumber(facts%model)
  end subroutine know_ends

  pure integer function first_of_last(scene, motion) result(first)
    !! Return the first sample, from 1, of the last segment, if the motion is known to its end; else 1.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer :: samples(2)
    first = 1
    if (motion%ending /= case_done .or. .not. allocated(motion%timeline%segments)) return
    if (size(motion%timeline%segments) == 0) return       ! modes were not found
    samples = samples_of_segment(motion, size(motion%timeline%segments), &
                                 time_grid_of(scene%response%duration, scene%response%samples, motion%units%time))
    first = samples(1)
  end function first_of_last

  pure logical function is_pressed(motion)
    !! Return whether a mass is pressed against the beam at the end; the modes include it then.
    type(case_motion), intent(in) :: motion
    is_pressed = .not. allocated(motion%modes%configuration(last_configuration(motion))%source)
  end function is_pressed

  pure integer function last_configuration(motion) result(configuration)
    !! Return the configuration at the end of the motion.
    type(case_motion), intent(in) :: motion
    configuration = motion%modes%moving
    if (.not. allocated(motion%timeline%segments)) return
    associate (segments => motion%timeline%segments)
      if (size(segments) > 0) configuration = segments(size(segments))%configuration
    end associate
  end function last_configuration

  subroutine know_modes(motion, known, loads)
    !! Find the frequencies of the modes that move at the end; of very many only the first.
    type(case_motion), intent(in) :: motion
    type(known_modes), allocatable, intent(out) :: known
    type(load_result), intent(in), optional :: loads
    class(mode_set), allocatable :: first
    integer :: count
    count = 0
    if (present(loads)) count = loads%count
    allocate (known)
    associate (segments => motion%timeline%segments, moving => motion%modes%configuration(last_configuration(motion)))
      if (size(segments) > 0) count = max(count, segments(size(segments))%count)
      if (count <= moving%set%count) then
        known%angular_frequency = frequencies_of(moving%set, count)*motion%units%frequency
        known%wavenumber = moving%set%alpha(:count)/motion%units%length
      else
        call moving%source%find(first_numbers(min(most, count)), first)
        known%angular_frequency = frequencies_of(first, first%count)*motion%units%frequency
        known%wavenumber = first%alpha(:first%count)/motion%units%length
        known%all = first%count == count
      end if
    end associate
  end subroutine know_modes

  pure function frequencies_of(modes, count) result(frequency)
    !! Return √(β² − c²/4) of the first modes; 0 for those that do not oscillate.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: count
    real(dp) :: frequency(count)
    type(dd) :: square(count)
    square = modes%beta_squared(:count)
    if (allocated(modes%damped_squared)) square = modes%damped_squared(:count)
    frequency = sqrt(max(0.0_dp, square%hi))
  end function frequencies_of

end module bw_case_spectrum
