module bw_frequency_report
  !! What a report says of the response to a harmonic force: its resonances, with the damping that their half-power widths show, and
  !! its antiresonances.
  use bw_case_result, only: answer_type
  use bw_columns, only: fixed, note_rest, table_of, text_table
  use bw_frequency_response_par, only: frequency_response_par
  use bw_kinds, only: dp
  use bw_missing, only: missing, is_missing
  use bw_text, only: shortest, text_builder
  implicit none (type, external)
  private
  public :: extreme_at, report_answer

  integer, parameter :: shown = 20, most = 100       !! rows that are no details, and rows

  type, public :: extreme_type
    !! Where an answer is largest or smallest.
    logical :: is_resonance = .false., is_antiresonance = .false.
    real(dp) :: frequency = missing                  !! Hz
    real(dp) :: amplitude = missing                  !! of a resonance; missing where it is narrower than the step
    real(dp) :: ratio = missing                      !! of its damping, by its half-power width
    integer :: digits = 7                            !! of the frequency, that the parabola leaves: its error is of second order in the step
  end type extreme_type

contains

  subroutine report_answer(asked, damped, answer, lines)
    !! The resonances and antiresonances of all points.
    type(frequency_response_par), intent(in) :: asked
    logical, intent(in) :: damped                    !! else a resonance has no largest value
    type(answer_type), intent(in) :: answer
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    character(:), allocatable :: unit
    integer :: order, count, p, j
    select case (asked%quantity)
    case ('velocity')
      unit = 'm/s/N'
      order = 1
    case ('acceleration')
      unit = 'm/s2/N'
      order = 2
    case default
      unit = 'm/N'
      order = 0
    end select
    call lines%append_line('')
    call lines%append_line('response to a harmonic force of 1 N at xi = '//shortest(asked%position, 6)//': '//asked%quantity)
    table = table_of('xi|resonance|amplitude|damping ratio|antiresonance', '|Hz|'//unit//'||Hz', [10, 13, 13, 15, 15])
    call table%put_head(lines)
    count = 0
    do p = 1, size(asked%points)
      if (any(is_missing(answer%value(:, p)%re))) cycle
      do j = 2, size(asked%frequency) - 1
        call put(asked%points(p), extreme_at(asked%frequency(j - 1:j + 1), answer%value(j - 1:j + 1, p), order))
      end do
    end do
    call note_rest(lines, count, most)
    if (count == 0) call lines%append_line('  neither a resonance nor an antiresonance lies between these frequencies')
    if (allocated(answer%junction)) call report_junctions(asked%frequency, answer, lines)
  contains
    subroutine put(xi, extreme)
      real(dp), intent(in) :: xi
      type(extreme_type), intent(in) :: extreme
      character(:), allocatable :: at
      if (.not. (extreme%is_resonance .or. extreme%is_antiresonance)) return
      count = count + 1
      if (count > most) return
      at = shortest(extreme%frequency, extreme%digits)
      if (extreme%is_resonance .and. .not. damped) then
        call table%put_row(lines, fixed(xi)//'|'//at//'|-|-', detail=count > shown)
      else if (extreme%is_resonance) then
        call table%put_row(lines, fixed(xi)//'|'//at//'|'//fixed(extreme%amplitude)//'|'//fixed(extreme%ratio), &
                           detail=count > shown)
      else
        call table%put_row(lines, fixed(xi)//'||||'//at, detail=count > shown)
      end if
    end subroutine put
  end subroutine report_answer

  subroutine report_junctions(frequency, answer, lines)
    !! What the bodies and steps within the beam transmit, at least and at most.
    real(dp), intent(in) :: frequency(:)             !! Hz
    type(answer_type), intent(in) :: answer
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    integer :: i, least, most
    call lines%append_line('')
    call lines%append_line('share of the power of bending waves that bodies and steps transmit')
    table = table_of('xi|least|at|largest|at', '|%|Hz|%|Hz', [10, 13, 13, 13, 13])
    call table%put_head(lines)
    do i = 1, min(shown, size(answer%junction))
      associate (share => answer%transmitted(:, i))
        if (any(is_missing(share))) cycle
        least = minloc(share, dim=1)
        most = maxloc(share, dim=1)
        call table%put_row(lines, fixed(answer%junction(i))//'|'//shortest(100.0_dp*share(least), 4)//'|'// &
                           fixed(frequency(least))//'|'//shortest(100.0_dp*share(most), 4)//'|'//fixed(frequency(most)))
      end associate
    end do
    call note_rest(lines, count(.not. is_missing(answer%junction)), shown)
  end subroutine report_junctions

  pure type(extreme_type) function extreme_at(frequency, value, order) result(extreme)
    !! What three answers that follow each other show. The displacement H = value/(iΩ)ⁿ of one mode has |H|⁻² = (ω² − Ω²)² + (2ζωΩ)²
    !! times a number, a parabola in Ω², and Re H changes sign at ω, or is small beside Im H. Where |H| is least and Re H changes sign
    !! two parts of the answer cancel.
    real(dp), intent(in) :: frequency(3)             !! Hz
    complex(dp), intent(in) :: value(3)
    integer, intent(in) :: order                     !! n: the quantity's derivative of the displacement
    complex(dp) :: h(3)
    real(dp) :: square(3), power(3), at, least, bend, step
    h = value/(cmplx(0.0_dp, frequency, dp))**order
    square = frequency**2
    power = h%re**2 + h%im**2
    if (minval(power) <= 0.0_dp) return              ! a place that is held
    associate (turns => h(1)%re*h(3)%re < 0.0_dp)
      extreme%is_resonance = power(2) > max(power(1), power(3)) .and. (turns .or. abs(h(2)%im) > abs(h(2)%re))
      extreme%is_antiresonance = power(2) < min(power(1), power(3)) .and. turns
    end associate
    if (extreme%is_resonance) power = 1.0_dp/power
    if (.not. (extreme%is_resonance .or. extreme%is_antiresonance)) return
    call find_least(square, power, at, least, bend)
    extreme%frequency = sqrt(at)
    step = 0.5_dp*(square(3) - square(1))
    extreme%digits = min(7, 1 + max(0, floor(-2.0_dp*log10(0.5_dp*step/at))))
    if (extreme%is_antiresonance .or. least < bend*(0.5_dp*step)**2) return
    extreme%amplitude = extreme%frequency**order/sqrt(least)
    extreme%ratio = 0.5_dp*sqrt(least/bend)/at
  end function extreme_at

  pure subroutine find_least(x, y, at, least, bend)
    !! The least value of the parabola through three points, the middle one being the least.
    real(dp), intent(in) :: x(3), y(3)
    real(dp), intent(out) :: at, least, bend         !! of y = least + bend (x − at)²
    real(dp) :: slope(2)
    slope = (y(2:) - y(:2))/(x(2:) - x(:2))
    bend = (slope(2) - slope(1))/(x(3) - x(1))
    at = 0.5_dp*(x(1) + x(2) - slope(1)/bend)
    least = y(2) - bend*(x(2) - at)**2
  end subroutine find_least

end module bw_frequency_report
