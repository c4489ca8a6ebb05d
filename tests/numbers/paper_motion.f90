module paper_motion
  !! The paper's beam: what it does after it caught a mass at restitution 0.
  use bw_beam_par, only: beam_par
  use bw_beam_units, only: beam_units, units_of
  use bw_closed_form, only: closed_form_modes, closed_form_set
  use bw_constants, only: pi
  use bw_damping, only: damping_law
  use bw_double_double, only: to_dd, operator(*)
  use bw_impact, only: capture_mass, capture_type, strike
  use bw_kinds, only: dp
  use bw_monitor, only: silent_monitor
  use bw_response, only: finish_histories, response_type, sampling_type, start_histories
  use bw_set_sum, only: add_motion
  use bw_time_grid, only: time_grid, time_grid_of
  implicit none (type, external)
  private
  public :: catch_mass, paper_beam

  type, public :: catch_type
    !! What is caught, and how long it is watched.
    real(dp) :: gamma = 0.2_dp          !! mass ratio
    real(dp) :: omega = 0.0_dp          !! rad/s
    real(dp) :: velocity = 1.0_dp       !! approach velocity, m/s
    integer :: modes = 5                !! before and after
    integer :: after = 0                !! modes after; 0: as many as before
    real(dp) :: duration = 1.0_dp       !! s
    integer :: samples = 1
  end type catch_type

contains

  type(beam_par) function paper_beam() result(beam)
    !! Length 1 m, a steel rod of 37 mm.
    beam%length = 1.0_dp
    beam%density = 7870.0_dp
    beam%youngs_modulus = 2.0e11_dp
    beam%diameter = 0.037_dp
    beam%area = pi*beam%diameter**2/4
    beam%second_moment = pi*beam%diameter**4/64
    beam%round = .true.
  end function paper_beam

  subroutine catch_mass(beam, catch, points, with_velocity, response, law)
    !! Histories at points ξ, from impact and capture at t = 0 on.
    type(beam_par), intent(in) :: beam
    type(catch_type), intent(in) :: catch
    real(dp), intent(in) :: points(:)
    logical, intent(in) :: with_velocity
    type(response_type), intent(out) :: response
    type(damping_law), intent(in), optional :: law
    type(closed_form_set) :: free, loaded
    type(beam_units) :: units
    type(capture_type) :: capture
    type(time_grid) :: grid
    type(silent_monitor) :: monitor
    units = units_of(beam)
    free = closed_form_modes(catch%modes, 0.0_dp)
    loaded = closed_form_modes(merge(catch%after, catch%modes, catch%after > 0), catch%gamma, to_dd(catch%omega)*units%time, &
                               catch%duration/units%time%hi)
    call loaded%damp(law)
    capture = capture_mass(free, strike(free, catch%gamma, 0.0_dp), loaded)
    grid = time_grid_of(catch%duration, catch%samples, units%time)
    call start_histories(sampling_type(points, grid, units%time%hi, with_velocity), response)
    call add_motion(loaded, capture%modal_velocity*(catch%velocity*units%time%hi), monitor, response)
    call finish_histories(response)
  end subroutine catch_mass

end module paper_motion
