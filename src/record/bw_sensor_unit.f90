module bw_sensor_unit
  !! Units that laboratories write, what they measure, and what they are in SI.
  use bw_kinds, only: dp
  use bw_text, only: lower
  implicit none (type, external)
  private
  public :: factor_of, is_unit, quantity_of, si_unit

  type :: unit_type
    character(12) :: word                    !! as it is written
    character(12) :: quantity                !! what it measures; '' for what is none of a record
    real(dp) :: factor                       !! SI over this unit; 0 where it says nothing of a quantity
  end type unit_type

  real(dp), parameter :: gravity = 9.80665_dp      !! standard acceleration

  type(unit_type), parameter :: units(*) = [ &
    unit_type('s', 'time', 1.0_dp), unit_type('sec', 'time', 1.0_dp), unit_type('second', 'time', 1.0_dp), &
    unit_type('seconds', 'time', 1.0_dp), unit_type('ms', 'time', 1e-3_dp), unit_type('msec', 'time', 1e-3_dp), &
    unit_type('us', 'time', 1e-6_dp), unit_type('µs', 'time', 1e-6_dp), unit_type('min', 'time', 60.0_dp), &
    unit_type('m', 'displacement', 1.0_dp), unit_type('cm', 'displacement', 1e-2_dp), &
    unit_type('mm', 'displacement', 1e-3_dp), unit_type('um', 'displacement', 1e-6_dp), &
    unit_type('µm', 'displacement', 1e-6_dp), unit_type('in', 'displacement', 0.0254_dp), &
    unit_type('m/s', 'velocity', 1.0_dp), unit_type('m s-1', 'velocity', 1.0_dp), unit_type('mm/s', 'velocity', 1e-3_dp), &
    unit_type('m/s2', 'acceleration', 1.0_dp), unit_type('m/s^2', 'acceleration', 1.0_dp), &
    unit_type('m/s**2', 'acceleration', 1.0_dp), unit_type('m/s²', 'acceleration', 1.0_dp), &
    unit_type('m/s'//char(178), 'acceleration', 1.0_dp), &  ! the same in Latin 1
    unit_type('m s-2', 'acceleration', 1.0_dp), unit_type('mm/s2', 'acceleration', 1e-3_dp), &
    unit_type('mm/s^2', 'acceleration', 1e-3_dp), unit_type('g', 'acceleration', gravity), &
    unit_type('m/m', 'strain', 1.0_dp), unit_type('strain', 'strain', 1.0_dp), unit_type('um/m', 'strain', 1e-6_dp), &
    unit_type('µm/m', 'strain', 1e-6_dp), unit_type('ustrain', 'strain', 1e-6_dp), &
    unit_type('microstrain', 'strain', 1e-6_dp), unit_type('V', '', 0.0_dp), unit_type('mV', '', 0.0_dp), &
    unit_type('Volt', '', 0.0_dp), unit_type('N', '', 0.0_dp), unit_type('Hz', '', 0.0_dp), unit_type('counts', '', 0.0_dp), &
    unit_type('1', '', 0.0_dp)]

contains

  pure integer function place_of(unit) result(place)
    !! Place of a unit above; 0 where it is not known. Capitals matter only where another unit is written so.
    character(*), intent(in) :: unit
    do place = size(units), 1, -1
      if (units(place)%word == unit) return
    end do
    do place = size(units), 1, -1
      if (lower(units(place)%word) == lower(unit) .and. unit /= '' .and. len_trim(unit) <= len(units%word)) return
    end do
  end function place_of

  pure logical function is_unit(text)
    !! The text is a unit.
    character(*), intent(in) :: text
    is_unit = place_of(text) > 0 .and. text /= ''
  end function is_unit

  pure function quantity_of(unit) result(quantity)
    !! What a unit measures, as `&record` names it; '' where it is not known, or no quantity of a sensor.
    character(*), intent(in) :: unit
    character(:), allocatable :: quantity
    integer :: place
    quantity = ''
    place = place_of(unit)
    if (place == 0) return
    if (units(place)%quantity /= 'time') quantity = trim(units(place)%quantity)
  end function quantity_of

  pure real(dp) function factor_of(unit, quantity) result(factor)
    !! SI over a unit of a quantity, or of `time`; 0 where the unit is not known, or of something else.
    character(*), intent(in) :: unit, quantity
    integer :: place
    factor = 0.0_dp
    place = place_of(unit)
    if (place == 0) return
    if (units(place)%quantity == quantity) factor = units(place)%factor
  end function factor_of

  pure function si_unit(quantity) result(unit)
    !! The SI unit of a quantity of a sensor, as UDUNITS writes it.
    character(*), intent(in) :: quantity
    character(:), allocatable :: unit
    select case (quantity)
    case ('displacement'); unit = 'm'
    case ('velocity'); unit = 'm s-1'
    case ('acceleration'); unit = 'm s-2'
    case default; unit = '1'
    end select
  end function si_unit

end module bw_sensor_unit
