module bw_modelled_response
  !! Frequency responses of the model, to compare with those measured by a hammer.
  use bw_measured_state, only: measured_state
  use bw_beam_units, only: units_of
  use bw_case_frequency, only: find_frequency_response
  use bw_case_modes, only: case_mode_cache
  use bw_case_result, only: answer_type
  use bw_constants, only: two_pi
  use bw_error, only: error_type
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_monitor, only: monitor_type
  use bw_record, only: sensor_type
  use bw_scene, only: scene_type
  use bw_text, only: string
  implicit none (type, external)
  private
  public :: find_modelled_response

contains

  subroutine find_modelled_response(state, values, sensors, frequency, monitor, response)
    !! Find the response of each sensor to a force of 1 N at the hammer's position, with the scene's own damping.
    !! Missing at 0 Hz, for strains, and if these unknowns make no beam.
    type(measured_state), intent(inout) :: state
    real(dp), intent(in) :: values(:)            !! of the unknowns
    type(sensor_type), intent(in) :: sensors(:)  !! with places
    real(dp), intent(in) :: frequency(:)         !! Hz, rising from 0
    class(monitor_type), intent(inout) :: monitor
    complex(dp), allocatable, intent(out) :: response(:, :)   !! SI over N, (frequencies, sensors)
    type(scene_type) :: scene
    type(error_type), allocatable :: error
    type(case_mode_cache), target :: cache
    type(answer_type), allocatable :: answer
    type(string), allocatable :: notes(:)
    integer :: s, status
    allocate (response(size(frequency), size(sensors)), source=cmplx(missing, missing, dp))
    call state%scene_at(values, scene, error)
    if (allocated(error) .or. size(frequency) < 2) return
    allocate (notes(0))
    allocate (scene%frequency_response)
    associate (asked => scene%frequency_response)
      asked%position = scene%record%force_point
      asked%points = sensors%position
      asked%frequency = frequency(2:)
      asked%quantity = 'displacement'
    end associate
    call find_frequency_response(scene, units_of(scene%beam), 0, .false., monitor, cache, answer, notes, status)
    if (monitor%stop_requested()) return
    do s = 1, size(sensors)
      associate (known => abs(answer%value(:, s)) < missing, rate => cmplx(0.0_dp, two_pi*frequency(2:), dp))
        select case (sensors(s)%quantity)
        case ('displacement'); where (known) response(2:, s) = answer%value(:, s)
        case ('velocity'); where (known) response(2:, s) = rate*answer%value(:, s)
        case ('acceleration'); where (known) response(2:, s) = rate**2*answer%value(:, s)
        end select
      end associate
    end do
  end subroutine find_modelled_response

end module bw_modelled_response
