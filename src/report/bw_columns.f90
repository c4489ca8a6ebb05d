module bw_columns
  !! Numbers in the columns of a printed report.
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: fixed, numbered_rows, right, seconds_text

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
    !! Seven digits, aligned at the point as far as they can, five of numbers that are very large or small; a dash for what does
    !! not exist.
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
      text = shortest(value, 5)
    end if
  end function fixed

  pure function right(text, width) result(field)
    !! Text at the right of a field that it never overflows.
    character(*), intent(in) :: text
    integer, intent(in) :: width
    character(:), allocatable :: field
    field = repeat(' ', max(1, width - len(text)))//text
  end function right

  subroutine numbered_rows(lines, most, widths, columns, rounded)
    !! Rows of numbers, each behind its own from 1 on, at most `most` of them.
    type(text_builder), intent(inout) :: lines
    integer, intent(in) :: most
    integer, intent(in) :: widths(:)              !! (columns)
    real(dp), intent(in) :: columns(:, :)         !! (rows, columns)
    integer, intent(in), optional :: rounded      !! a column of errors, of which two digits are enough
    integer :: k, c
    do k = 1, min(most, size(columns, 1))
      call lines%append(right(text_of(k), 6))
      do c = 1, size(columns, 2)
        if (c == rounded_column(rounded)) then
          call lines%append(right(shortest(columns(k, c), 2), widths(c)))
        else
          call lines%append(right(fixed(columns(k, c)), widths(c)))
        end if
      end do
      call lines%append_line('')
    end do
    if (size(columns, 1) > most) call lines%append_line('   ...  '//text_of(size(columns, 1))//' in the file')
  end subroutine numbered_rows

  pure integer function rounded_column(rounded) result(column)
    !! 0 where there is none.
    integer, intent(in), optional :: rounded
    column = 0
    if (present(rounded)) column = rounded
  end function rounded_column

end module bw_columns
