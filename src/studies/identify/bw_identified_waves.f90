module bw_identified_waves
  !! Waves of a record along the identified beam, from its lines in the result and the shapes of the identified scene.
  use bw_case_result, only: case_result
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing
  use bw_monitor, only: monitor_type
  use bw_notes, only: notes_type
  use bw_number_file, only: real_width
  use bw_record_report, only: report_waves
  use bw_record_waves, only: find_beam_waves
  use bw_result_table, only: result_table
  use bw_scene, only: scene_type
  use bw_text, only: text_builder
  implicit none (type, external)
  private
  public :: put_identified_waves

contains

  subroutine put_identified_waves(draft, scenes, quantile, monitor, notes, lines)
    !! Put the waves of all cases into the result, and print those of a single case.
    class(result_table), intent(inout) :: draft
    type(scene_type), intent(in) :: scenes(:)          !! identified scenes, (cases)
    real(dp), intent(in) :: quantile                   !! how many standard deviations half an interval is
    class(monitor_type), intent(inout) :: monitor      !! nothing is put if it asks to stop
    character(:), allocatable, intent(inout) :: notes
    type(text_builder), intent(inout) :: lines
    type(case_result) :: one
    type(notes_type) :: of_cases
    integer(i8) :: c
    do c = 1, size(scenes)
      call take_lines(draft, c, quantile, one)
      call find_beam_waves(scenes(c), one, monitor)
      if (monitor%stop_requested()) return
      call put('wavenumber', one%measured%wavenumber, one%measured%wavenumber_error)
      call put('phase_velocity', one%measured%phase_velocity, one%measured%phase_velocity_error)
      call put('group_velocity', one%measured%group_velocity, one%measured%group_velocity_error)
      call put('stiffness_root', one%record%stiffness_root(1:1), one%record%stiffness_root(2:2))
      call put('angular_velocity', one%record%angular_velocity(1:1), one%record%angular_velocity(2:2))
      call of_cases%add(c, one%notes)
      if (size(scenes) == 1) call report_waves(one%record, one%measured, lines)
    end do
    notes = notes//of_cases%lines(draft%layout%cases)
  contains
    subroutine put(name, values, errors)
      !! Put values; fill follows the last line.
      character(*), intent(in) :: name
      real(dp), intent(in) :: values(:), errors(:)
      associate (value => draft%variable('measured_'//name), error => draft%variable('measured_'//name//'_error'))
        call draft%file%put_numbers(draft%place_of(value, c), real_width, values)
        call draft%file%put_numbers(draft%place_of(error, c), real_width, errors)
      end associate
    end subroutine put
  end subroutine put_identified_waves

  subroutine take_lines(draft, case, quantile, one)
    !! Read the data that waves are measured from: lines, sensors, and the noise of amplitudes.
    class(result_table), intent(inout) :: draft
    integer(i8), intent(in) :: case
    real(dp), intent(in) :: quantile
    type(case_result), intent(out) :: one
    real(dp), allocatable :: phase(:, :)               ! (sensors, lines)
    real(dp), allocatable :: re(:, :, :), im(:, :, :)  ! (lines, sensors, sensors)
    integer :: n, sensors
    allocate (one%notes(0), one%measured, one%record)
    one%record%extent%sensors = draft%layout%record%sensors
    n = count(.not. is_missing(draft%get('measured_angular_frequency', case)))
    sensors = draft%layout%points
    phase = of_sensors('measured_phase')
    associate (lines => one%record%lines)
      lines%quantile = quantile
      lines%angular_frequency = of_lines('measured_angular_frequency')
      lines%angular_frequency_error = of_lines('measured_angular_frequency_error')
      lines%decay_rate = of_lines('measured_decay_rate')
      lines%amplitude = of_sensors('measured_amplitude')*exp(cmplx(0.0_dp, phase, dp))
      lines%amplitude_noise = of_sensors('measured_amplitude_noise')
      lines%own = .not. any(is_missing(lines%amplitude_noise), dim=2)
      re = of_pairs('measured_noise_correlation_real')
      im = of_pairs('measured_noise_correlation_imag')
      if (n > 0 .and. .not. all(is_missing(re))) lines%noise_correlation = reshape(cmplx(re, im, dp), [sensors, sensors, n], &
                                                                                   order=[3, 2, 1])
    end associate
  contains
    function of_lines(name) result(values)
      character(*), intent(in) :: name
      real(dp) :: values(n)
      associate (all => draft%get(name, case))
        values = all(:n)
      end associate
    end function of_lines
    function of_sensors(name) result(values)
      !! (sensors, lines)
      character(*), intent(in) :: name
      real(dp) :: values(sensors, n), columns(draft%layout%peaks, sensors)
      columns = reshape(draft%get(name, case), shape(columns))
      values = transpose(columns(:n, :))
    end function of_sensors
    function of_pairs(name) result(values)
      !! (lines, sensors, sensors), the last index being the first of the pair.
      character(*), intent(in) :: name
      real(dp) :: values(n, sensors, sensors), columns(draft%layout%peaks, sensors, sensors)
      columns = reshape(draft%get(name, case), shape(columns))
      values = columns(:n, :, :)
    end function of_pairs
  end subroutine take_lines

end module bw_identified_waves
