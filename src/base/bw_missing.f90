module bw_missing
  !! The number for 'does not exist' in arrays of results, and `_FillValue` in files. It is finite, so that it passes
  !! floating-point traps.
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: is_missing, no_number, scaled

  real(dp), parameter, public :: missing = 9.9692099683868690e+36_dp  !! NetCDF's own fill value for doubles

contains

  elemental logical function is_missing(value)
    !! Return whether a number is the missing value.
    real(dp), intent(in) :: value
    is_missing = value == missing
  end function is_missing

  elemental real(dp) function scaled(value, unit)
    !! Convert to another unit; a missing number stays missing, and overflow becomes missing.
    real(dp), intent(in) :: value, unit
    scaled = missing
    if (is_missing(value)) return
    if (abs(value) <= huge(value)/max(1.0_dp, abs(unit))) scaled = value*unit
  end function scaled

  elemental real(dp) function no_number()
    !! Return NaN, for impossible cases, which the last check before the file reports as a fault of the program.
    no_number = ieee_value(no_number, ieee_quiet_nan)
  end function no_number

end module bw_missing
