module bw_result_table
  !! The table of result variables: every variable of type double that depends on the case, histories apart.
  use bw_result_layout, only: result_layout, has_dimension
  implicit none (type, external)
  private
  public :: variable_table, is_held

  type, public :: variable_row
    character(32) :: name = ''
    character(16) :: dimensions = ''     !! names in the file's order, by spaces; a scalar has none
    character(16) :: units = '1'         !! UDUNITS
    character(120) :: long_name = ''
    character(40) :: references = ''     !! the paper's equation; empty where it is not one of the paper's
  end type variable_row

contains

  pure function variable_table() result(rows)
    !! Every variable of type double that depends on the case, histories apart.
    type(variable_row), allocatable :: rows(:)
    type(variable_row), allocatable :: modal(:), before(:)
    modal = modal_rows()
    before = modal
    before%name = suffixed(modal%name)
    before%dimensions = 'mode_before'
    before%long_name = before_name(modal%long_name)
    before%references = before_source(modal%name)
    rows = [modal, before, impact_rows(), event_rows(), error_rows(), measured_rows()]
  end function variable_table

  pure function modal_rows() result(rows)
    type(variable_row), allocatable :: rows(:)
    rows = [ &
      variable_row('alpha', 'mode', '1', 'wave number times length', 'Eq. 19'), &
      variable_row('wavenumber', 'mode', 'm-1', 'wave number P', 'Eq. 19'), &
      variable_row('angular_frequency', 'mode', 'rad s-1', 'angular frequency', 'Eq. 30'), &
      variable_row('growth_rate', 'mode', 's-1', 'growth rate, the real part of the eigenvalue', 'Eq. 27'), &
      variable_row('modal_mass', 'mode', 'kg', 'modal mass', 'Eq. 21'), &
      variable_row('modal_velocity', 'mode', 'm s-1', 'modal velocity just after the last event at t = 0', 'Eq. 26'), &
      variable_row('phase_velocity', 'mode', 'm s-1', 'phase velocity', 'Eq. 32'), &
      variable_row('group_velocity', 'mode', 'm s-1', 'group velocity', 'Eq. 33')]
  end function modal_rows

  elemental character(32) function suffixed(name)
    character(*), intent(in) :: name
    suffixed = trim(name)//'_before'
  end function suffixed

  elemental character(120) function before_name(long_name) result(name)
    character(*), intent(in) :: long_name
    name = long_name(:min(100, len_trim(long_name)))//', before the capture'
    if (index(long_name, 'modal velocity') == 1) name = 'jump of the modal velocity at the impact'
  end function before_name

  elemental character(40) function before_source(name) result(source)
    !! The equation of the beam alone.
    character(*), intent(in) :: name
    select case (name)
    case ('alpha', 'wavenumber'); source = 'Eq. 8'
    case ('angular_frequency', 'growth_rate'); source = 'Eqs 2 and 10'
    case ('modal_mass'); source = 'Eq. 10'
    case ('modal_velocity'); source = 'Eq. 12'
    case ('phase_velocity'); source = 'Eq. 32'
    case default; source = 'Eq. 33'
    end select
  end function before_source

  pure function impact_rows() result(rows)
    type(variable_row), allocatable :: rows(:)
    rows = [ &
      variable_row('velocity_jump', 'profile', 'm s-1', 'jump of the velocity along the beam at the impact', 'Fig. 3'), &
      variable_row('impulse', '', 'N s', 'impulse of the impact on the beam''s tip', 'Eq. 12, reference [8]'), &
      variable_row('mass_velocity', '', 'm s-1', 'velocity of the mass just after the impact', 'Eq. 12, reference [8]'), &
      variable_row('tip_velocity', '', 'm s-1', 'velocity of the beam''s tip just after the impact', 'Eq. 12, reference [8]'), &
      variable_row('critical_angular_velocity', '', 'rad s-1', 'lowest angular velocity at which a mode is unstable', &
                   'Eq. 31'), &
      variable_row('critical_angular_velocity_before', '', 'rad s-1', &
                   'lowest angular velocity at which a mode is unstable, before the capture', 'Eq. 31')]
  end function impact_rows

  pure function event_rows() result(rows)
    type(variable_row), allocatable :: rows(:)
    rows = [ &
      variable_row('event_time', 'event', 's', 'time of the event', ''), &
      variable_row('event_end', 'event', 's', 'end of the event', ''), &
      variable_row('event_time_error', 'event', 's', 'estimate of the error of the time of the event', ''), &
      variable_row('event_end_error', 'event', 's', 'estimate of the error of the end of the event', ''), &
      variable_row('event_impulse', 'event', 'N s', 'impulse of the event on the beam''s tip', ''), &
      variable_row('energy_before', 'event', 'J', 'energy of beam and mass before the event', ''), &
      variable_row('energy_after', 'event', 'J', 'energy of beam and mass after the event', ''), &
      variable_row('momentum_before', 'event', 'kg m s-1', &
                   'generalised momentum of the first mode per unit of tip displacement, before the event', ''), &
      variable_row('momentum_after', 'event', 'kg m s-1', &
                   'generalised momentum of the first mode per unit of tip displacement, after the event', '')]
  end function event_rows

  pure function error_rows() result(rows)
    type(variable_row), allocatable :: rows(:)
    rows = [ &
      variable_row('displacement_error', 'point', 'm', &
                   'estimate of the largest error of the displacement; with a capture against infinitely many modes', ''), &
      variable_row('velocity_error', 'point', 'm s-1', &
                   'estimate of the largest error of the velocity; with a capture against infinitely many modes', '')]
  end function error_rows

  pure function measured_rows() result(rows)
    type(variable_row), allocatable :: rows(:)
    type(variable_row), allocatable :: values(:), bounds(:)
    integer :: i
    values = [ &
      variable_row('measured_angular_frequency', 'peak', 'rad s-1', 'angular frequency measured in the histories', ''), &
      variable_row('measured_wavenumber', 'peak', 'm-1', 'wave number measured in the histories', 'Eqs 18 and 20'), &
      variable_row('measured_phase_velocity', 'peak', 'm s-1', 'phase velocity measured in the histories', ''), &
      variable_row('measured_group_velocity', 'peak', 'm s-1', 'group velocity measured in the histories', '')]
    bounds = values
    do i = 1, size(bounds)
      bounds(i)%name = trim(values(i)%name)//'_error'
      bounds(i)%long_name = 'bound of the error of the '//values(i)%long_name(:64)
      bounds(i)%references = ''
    end do
    rows = [values, bounds]
  end function measured_rows

  pure logical function is_held(layout, row) result(held)
    !! Whether the scene's result has this variable at all.
    type(result_layout), intent(in) :: layout
    type(variable_row), intent(in) :: row
    select case (row%name)
    case ('critical_angular_velocity'); held = .true.
    case ('critical_angular_velocity_before'); held = has_dimension(layout, 'mode_before')
    case ('displacement_error'); held = layout%continuum .or. layout%contacts
    case ('velocity_error'); held = (layout%continuum .or. layout%contacts) .and. layout%velocity
    case ('event_time_error', 'event_end_error'); held = layout%contacts
    case ('modal_velocity', 'impulse', 'mass_velocity', 'tip_velocity'); held = has_dimension(layout, 'event')
    case default; held = has_dimension(layout, trim(row%dimensions))
    end select
  end function is_held

end module bw_result_table
