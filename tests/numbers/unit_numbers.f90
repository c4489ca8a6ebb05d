module unit_numbers
  !! Units of length, time and mass changed by powers of two.
  use bw_kinds, only: dp
  use bw_beam_par, only: beam_par
  use bw_measured, only: measure_waves, measured_type
  use bw_mode_check, only: record_facts
  use bw_missing, only: is_missing
  use bw_response, only: response_type
  use number_table, only: table_type
  use paper_motion, only: catch_mass, catch_type, paper_beam
  implicit none (type, external)
  private
  public :: measure_units

  integer, parameter :: power = 200
  real(dp), parameter :: points(3) = [0.0_dp, 0.5_dp, 1.0_dp]
  real(dp), parameter :: speeds(3) = [0.0_dp, 50.0_dp, 130.0_dp]   !! rad/s; a mode grows at the last

contains

  subroutine measure_units(table)
    type(table_type), intent(inout) :: table
    logical, parameter :: round(2) = [.true., .false.]
    integer :: section, speed, length, time, mass
    call table%begin('histories and measured waves, units of length, time and mass times 2^±200', 0.0_dp, &
                     'numbers whose bits differ')
    do section = 1, size(round)
      do speed = 1, size(speeds)
        do length = -power, power, power
          do time = -power, power, power
            do mass = -power, power, power
              call table%note(real(differences(round(section), speeds(speed), length, time, mass), dp))
            end do
          end do
        end do
      end do
    end do
  end subroutine measure_units

  integer function differences(round, omega, length, time, mass)
    !! How many numbers are not those of the plain units, exactly scaled.
    logical, intent(in) :: round                  !! the section is given by its diameter
    real(dp), intent(in) :: omega
    integer, intent(in) :: length, time, mass     !! powers of two
    type(response_type) :: plain, scaled
    type(measured_type) :: measured, measured_scaled
    call observe(round, omega, 0, 0, 0, plain, measured)
    call observe(round, omega, length, time, mass, scaled, measured_scaled)
    differences = count(scale(plain%displacement, length) /= scaled%displacement) &
      + count(scale(plain%velocity, length - time) /= scaled%velocity) &
      + abs(measured%peak_count - measured_scaled%peak_count)
    if (measured%peak_count /= measured_scaled%peak_count) return
    differences = differences + unlike(measured%angular_frequency, measured_scaled%angular_frequency, -time) &
      + unlike(measured%angular_frequency_error, measured_scaled%angular_frequency_error, -time) &
      + unlike(measured%wavenumber, measured_scaled%wavenumber, -length) &
      + unlike(measured%phase_velocity, measured_scaled%phase_velocity, length - time) &
      + unlike(measured%group_velocity, measured_scaled%group_velocity, length - time)
  end function differences

  pure integer function unlike(plain, scaled, exponent)
    !! Numbers that do not exist have no unit.
    real(dp), intent(in) :: plain(:), scaled(:)
    integer, intent(in) :: exponent
    unlike = count(merge(plain, scale(plain, exponent), is_missing(plain)) /= scaled)
  end function unlike

  subroutine observe(round, omega, length, time, mass, response, measured)
    !! The paper's beam in units that make lengths 2^length, times 2^time and masses 2^mass as large.
    logical, intent(in) :: round
    real(dp), intent(in) :: omega
    integer, intent(in) :: length, time, mass
    type(response_type), intent(out) :: response
    type(measured_type), intent(out) :: measured
    type(beam_par) :: beam
    type(catch_type) :: catch
    beam = paper_beam()
    beam%round = round
    beam%length = scale(beam%length, length)
    beam%diameter = scale(beam%diameter, length)
    beam%area = scale(beam%area, 2*length)
    beam%second_moment = scale(beam%second_moment, 4*length)
    beam%density = scale(beam%density, mass - 3*length)
    beam%youngs_modulus = scale(beam%youngs_modulus, mass - length - 2*time)
    catch = catch_type(omega=scale(omega, -time), velocity=scale(1.0_dp, length - time), duration=scale(0.5_dp, time), &
                       samples=128)
    call catch_mass(beam, catch, points, .true., response)
    call measure_waves(response%displacement(:, 3), response%displacement(:, 2), &
                       record_facts(catch%duration, beam%length), measured)
  end subroutine observe

end module unit_numbers
