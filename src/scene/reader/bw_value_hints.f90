module bw_value_hints
  !! Suggestions for a value that is not a valid number: a decimal comma, a unit after the number, a power of ten.
  use bw_constants, only: pi, two_pi
  use bw_kinds, only: dp
  use bw_scene_scalars, only: parse_real
  use bw_text, only: lower, shortest
  implicit none (type, external)
  private
  public :: value_hint

  type :: hinted_unit
    !! A unit in common use, and its value in SI.
    character(8) :: word                    !! as users write it
    real(dp) :: factor
    character(8) :: si                      !! as in the table of inputs
  end type hinted_unit

  type(hinted_unit), parameter :: units(*) = [ &
    hinted_unit('GPa', 1.0e9_dp, 'Pa'), hinted_unit('MPa', 1.0e6_dp, 'Pa'), hinted_unit('kPa', 1.0e3_dp, 'Pa'), &
    hinted_unit('Pa', 1.0_dp, 'Pa'), hinted_unit('km', 1.0e3_dp, 'm'), hinted_unit('m', 1.0_dp, 'm'), &
    hinted_unit('cm', 1.0e-2_dp, 'm'), hinted_unit('mm', 1.0e-3_dp, 'm'), hinted_unit('s', 1.0_dp, 's'), &
    hinted_unit('ms', 1.0e-3_dp, 's'), hinted_unit('us', 1.0e-6_dp, 's'), hinted_unit('kg', 1.0_dp, 'kg'), &
    hinted_unit('g', 1.0e-3_dp, 'kg'), hinted_unit('t', 1.0e3_dp, 'kg'), hinted_unit('rpm', pi/30.0_dp, 'rad s-1'), &
    hinted_unit('Hz', two_pi, 'rad s-1')]

  character(*), parameter :: digits = '0123456789'

contains

  pure function value_hint(written, unit) result(hint)
    !! Return '; …', or nothing if nothing is recognised.
    character(*), intent(in) :: written     !! the value as in the scene
    character(*), intent(in) :: unit        !! SI unit of the input; empty if it has none
    character(:), allocatable :: hint
    hint = comma_hint(written)
    if (hint == '') hint = power_hint(written)
    if (hint == '') hint = unit_hint(written, unit)
  end function value_hint

  pure function comma_hint(written) result(hint)
    !! Recognise `0,037`: a comma between digits.
    character(*), intent(in) :: written
    character(:), allocatable :: hint
    integer :: comma, behind
    hint = ''
    comma = index(written, ',')
    if (comma < 2 .or. comma == len(written)) return
    if (verify(written(:comma - 1), digits//'+-') > 0) return
    behind = verify(written(comma + 1:), digits)
    if (behind == 1) return
    if (behind > 1) then
      if (scan(written(comma + behind:comma + behind), 'eEdD') == 0) return
    end if
    hint = '; a comma separates values, and the decimal mark is a point: '//written(:comma - 1)//'.'//written(comma + 1:)
    if (len(written) - comma == 3 .and. written(:comma - 1) /= '0') hint = hint//', or '//written(:comma - 1)// &
      written(comma + 1:)
  end function comma_hint

  pure function power_hint(written) result(hint)
    !! Recognise a power of ten in another notation: `2*10^11`, `2x10**11`, `10^11`.
    character(*), intent(in) :: written
    character(:), allocatable :: hint, mantissa, power
    integer :: ten, mark
    hint = ''
    mark = index(written, '^') + index(written, '**')
    ten = mark - 2
    if (ten < 1) return
    if (written(ten:mark - 1) /= '10') return
    mantissa = '1'
    if (ten > 1) mantissa = trim(written(:ten - 1))
    if (ten > 1) mantissa = trim(mantissa(:scan(mantissa, digits//'.', back=.true.)))
    power = adjustl(written(mark + merge(1, 2, index(written, '^') > 0):))
    if (mantissa == '' .or. power == '' .or. verify(trim(power), digits//'+-') > 0) return
    hint = '; a power of ten is written with e: '//mantissa//'e'//trim(power)
  end function power_hint

  pure function unit_hint(written, unit) result(hint)
    !! Recognise a number with its unit: `200 GPa`, `1000mm`.
    character(*), intent(in) :: written, unit
    character(:), allocatable :: hint, word, problem
    real(dp) :: number
    integer :: last, i
    hint = ''
    last = scan(written, digits//'.', back=.true.)
    if (last == 0 .or. last == len(written)) return
    word = trim(adjustl(written(last + 1:)))
    call parse_real(written(:last), number, problem)
    if (problem /= '' .or. word == '' .or. scan(word, ' ,=') > 0) return
    if (lower(word(1:1)) < 'a' .or. lower(word(1:1)) > 'z') return
    hint = '; values are written without units'
    if (unit /= '' .and. unit /= '1') hint = hint//', in '//trim(unit)
    do i = 1, size(units)
      if (lower(trim(units(i)%word)) /= lower(word) .or. units(i)%si /= unit) cycle
      if (units(i)%word /= word .and. any(units%word == word .and. units%si == unit)) cycle
      hint = hint//': '//shortest(number*units(i)%factor, 12)
      return
    end do
  end function unit_hint

end module bw_value_hints
