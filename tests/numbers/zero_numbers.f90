module zero_numbers
  !! Where nothing moves: the answer is zero to the last bit, and nothing traps on the way.
  use bw_kinds, only: dp
  use bw_measured, only: measure_waves, measured_type
  use bw_mode_check, only: record_facts
  use bw_response, only: response_type
  use number_table, only: table_type
  use paper_motion, only: catch_mass, catch_type, paper_beam
  implicit none (type, external)
  private
  public :: measure_zeros

  real(dp), parameter :: speeds(4) = [0.0_dp, 50.0_dp, 121.8335405733843921_dp, 300.0_dp]
    !! rad/s: at rest, stable, critical, growing

contains

  subroutine measure_zeros(table)
    type(table_type), intent(inout) :: table
    type(catch_type) :: catch
    integer :: i, modes, samples
    call table%begin('γ = 0, V = 0, one sample, a point at the root, with one mode and with many', 0.0_dp, &
                     'largest motion, and peaks found in it')
    do i = 1, size(speeds)
      do modes = 1, 41, 20
        do samples = 1, 101, 50
          catch = catch_type(omega=speeds(i), modes=modes, samples=samples)
          call at_points(table, catch, [0.0_dp, 0.0_dp])
          catch%velocity = 0.0_dp
          call at_points(table, catch, [0.5_dp, 1.0_dp])
          catch%velocity = 1.0_dp
          catch%gamma = 0.0_dp
          call at_points(table, catch, [0.5_dp, 1.0_dp])
        end do
        call at_points(table, catch_type(omega=speeds(i), modes=modes), [0.5_dp, 1.0_dp])
      end do
    end do
  end subroutine measure_zeros

  subroutine at_points(table, catch, points)
    type(table_type), intent(inout) :: table
    type(catch_type), intent(in) :: catch
    real(dp), intent(in) :: points(2)
    type(response_type) :: response
    type(measured_type) :: measured
    call catch_mass(paper_beam(), catch, points, .false., response)
    call table%note(maxval(abs(response%displacement)))
    call measure_waves(response%displacement(:, 2), response%displacement(:, 1), record_facts(catch%duration), measured)
    call table%note(real(measured%peak_count, dp))
  end subroutine at_points

end module zero_numbers
