module bw_record_waves
  !! Waves of a record's lines, from their amplitudes at sensors with known positions.
  use bw_beam_units, only: beam_units, units_of
  use bw_case_result, only: case_result, record_result
  use bw_input_values, only: position_of
  use bw_monitor, only: monitor_type
  use bw_note, only: is_remark, remark, unmarked
  use bw_result_layout, only: has, result_layout
  use bw_model_shapes, only: mean_wavenumber
  use bw_scene, only: scene_type
  use bw_scene_pieces, only: pieces_of, struck_beam
  use bw_sensor_lines, only: measured_lines, sensor_facts, sensor_waves
  use bw_sensor_waves, only: measure_sensor_waves
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: find_beam_waves, find_record_waves

  character(*), parameter :: kind = 'measured waves: '

contains

  subroutine find_record_waves(scene, layout, result, monitor)
    !! Set the measured frequencies, and find waves if sensors have positions. If the beam has unknowns, waves follow
    !! after their identification.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(case_result), intent(inout) :: result         !! with lines
    class(monitor_type), intent(inout) :: monitor      !! the waves are invalid if it requests a stop
    associate (lines => result%record%lines)
      allocate (result%measured)
      result%measured%peak_count = size(lines%angular_frequency)
      result%measured%angular_frequency = lines%angular_frequency
      result%measured%angular_frequency_error = lines%angular_frequency_error
    end associate
    if (has(layout, 'places') .and. .not. has(layout, 'waves')) call say_why_not(scene, result)
    if (has(layout, 'waves') .and. .not. has(layout, 'unknown')) call find_beam_waves(scene, result, monitor)
  end subroutine find_record_waves

  subroutine find_beam_waves(scene, result, monitor)
    !! Find the waves of the lines along a beam, and their notes.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result         !! with positions of sensors, lines and `measured`
    class(monitor_type), intent(inout) :: monitor      !! the waves are invalid if it requests a stop
    type(sensor_waves) :: waves
    call measure_sensor_waves(facts_of(scene, result%record), lines_of(result%record), waves, monitor)
    call join_notes(waves%notes, result)
    result%measured%wavenumber = waves%wavenumber
    result%measured%wavenumber_error = waves%wavenumber_error
    result%measured%phase_velocity = waves%phase_velocity
    result%measured%phase_velocity_error = waves%phase_velocity_error
    result%measured%group_velocity = waves%group_velocity
    result%measured%group_velocity_error = waves%group_velocity_error
    result%record%stiffness_root = [waves%stiffness_root, waves%stiffness_root_error]
    result%record%angular_velocity = [waves%angular_velocity, waves%angular_velocity_error]
  end subroutine find_beam_waves

  pure function facts_of(scene, record) result(facts)
    !! Collect what is known besides the lines.
    type(scene_type), intent(in) :: scene
    type(record_result), intent(in) :: record
    type(sensor_facts) :: facts
    type(beam_units) :: units
    type(struck_beam) :: pieces
    integer, allocatable :: own(:)
    integer :: s
    own = own_sensors(record)
    units = units_of(scene%beam)
    facts%length = units%length
    facts%position = record%extent%sensors(own)%position
    allocate (facts%quantity(size(own)))
    do s = 1, size(own)
      facts%quantity(s)%text = record%extent%sensors(own(s))%quantity
    end do
    facts%ends = scene%spectrum%ends
    if (facts%ends == 'model') then
      pieces = pieces_of(scene, units, .false.)
      facts%model = pieces%beam
      facts%length = units%length/mean_wavenumber(facts%model)
    end if
    facts%stiffness_root = units%h%hi*(facts%length/units%length)**2
    facts%confidence = scene%spectrum%confidence
    if (.not. allocated(scene%rotation)) return
    facts%rotates = scene%rotation%plane == 'in'
    if (facts%rotates) facts%angular_velocity = scene%rotation%angular_velocity
  end function facts_of

  pure function lines_of(record) result(lines)
    !! Return the lines with standard deviations instead of intervals.
    type(record_result), intent(in) :: record
    type(measured_lines) :: lines
    integer, allocatable :: own(:)
    own = own_sensors(record)
    lines%angular_frequency = record%lines%angular_frequency
    lines%frequency_deviation = record%lines%angular_frequency_error/record%lines%quantile
    lines%decay_rate = record%lines%decay_rate
    lines%amplitude = record%lines%amplitude(own, :)
    lines%deviation = record%lines%amplitude_noise(own, :)
    if (allocated(record%lines%noise_correlation)) lines%correlation = record%lines%noise_correlation(own, own, :)
  end function lines_of

  pure function own_sensors(record) result(own)
    !! Return the sensors that are neither constant nor multiples of others; only these inform on shapes.
    type(record_result), intent(in) :: record
    integer, allocatable :: own(:)
    integer :: s
    own = pack([(s, s=1, size(record%lines%own))], record%lines%own)
  end function own_sensors

  pure subroutine join_notes(notes, result)
    !! Join the notes on waves to one warning, for shapes and wave numbers that fit no uniform beam, and one remark, as
    !! a sweep shows only the first note of a kind.
    type(string), intent(in) :: notes(:)
    type(case_result), intent(inout) :: result
    character(:), allocatable :: warnings, remarks
    integer :: i
    warnings = ''
    remarks = ''
    do i = 1, size(notes)
      if (is_remark(notes(i)%text)) then
        remarks = remarks//'; '//unmarked(notes(i)%text)
      else
        warnings = warnings//'; '//notes(i)%text
      end if
    end do
    if (warnings /= '') call append(result%notes, kind//warnings(3:))
    if (remarks /= '') call remark(result%notes, 'missing waves: '//remarks(3:))
  end subroutine join_notes

  pure subroutine say_why_not(scene, result)
    !! Note why sensors with positions give no waves.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    if (position_of(scene%groups, 'beam') == 0) then
      call remark(result%notes, kind//'they need the length of the beam in &beam, and are left out')
    else
      call remark(result%notes, kind//'they are left out, since they are not available with tension or shear, and with pieces '// &
        'need ends = ''model''')
    end if
  end subroutine say_why_not

end module bw_record_waves
