module bw_columns
  !! Numbers in the columns of a printed report.
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: fixed, right, seconds_text

contains

  pure function seconds_text(seconds) result(text)
    !! Below a second in whole ms, else three digits.
    real(dp), intent(in) :: seconds
    character(:), allocatable :: text
    if (seconds < 1.0_dp) then
      text = text_of(nint(1000.0_dp*seconds))//' ms'
    else
      text = shortest(seconds, 3)//' s'
    end if
  end function seconds_text

  pure function fixed(value) result(text)
    !! Seven digits, aligned at the point as far as they can; a dash for what does not exist.
    real(dp), intent(in) :: value
    character(:), allocatable :: text
    character(20) :: buffer
    text = '-'
    if (is_missing(value)) return
    if (value == 0.0_dp) then
      text = '0'
    else if (abs(value) >= 1.0e-3_dp .and. abs(value) < 1.0e6_dp) then
      write (buffer, '(f20.'//text_of(max(0, 6 - floor(log10(abs(value)))))//')') value
      text = trim(adjustl(buffer))
    else
      write (buffer, '(es20.4e3)') value
      text = trim(adjustl(buffer))
    end if
  end function fixed

  pure function right(text, width) result(field)
    !! Text at the right of a field that it never overflows.
    character(*), intent(in) :: text
    integer, intent(in) :: width
    character(:), allocatable :: field
    field = repeat(' ', max(1, width - len(text)))//text
  end function right

end module bw_columns
