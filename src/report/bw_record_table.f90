module bw_record_table
  !! The printed table of the cases of a record, repeats or parts of it: of a few cases all, of many the first and the last.
  !! Cases are added in any order.
  use bw_case_fields, only: case_field, field_of, fields_of
  use bw_columns, only: right
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing, missing
  use bw_record_report, only: pair_text
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_swept_text, only: swept_text
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private

  integer, parameter :: shown = 10            !! first cases, and last ones
  real(dp), parameter :: two_pi = 2.0_dp*acos(-1.0_dp)

  type :: record_row
    integer :: lines = 0
    real(dp) :: frequency(2) = missing        !! Hz, of the strongest line, and half its interval
    real(dp) :: decay(2) = missing            !! 1/s, and half its interval
    real(dp) :: noise = missing               !! of the first sensor
  end type record_row

  type, public :: record_table
    private
    integer(i8) :: cases = 0
    type(record_row) :: first(shown), last(shown)
    type(case_field) :: peak_count, frequency, frequency_error, decay, decay_error, amplitude, noise
      !! where they stand in a case
  contains
    procedure :: add
    procedure :: text
  end type record_table

  interface record_table
    module procedure :: table_of
  end interface record_table

contains

  pure function table_of(layout) result(table)
    !! A table without rows.
    type(result_layout), intent(in) :: layout
    type(record_table) :: table
    associate (fields => fields_of(layout))
      table%peak_count = field_of(fields, 'peak_count')
      table%frequency = field_of(fields, 'measured_angular_frequency')
      table%frequency_error = field_of(fields, 'measured_angular_frequency_error')
      table%decay = field_of(fields, 'measured_decay_rate')
      table%decay_error = field_of(fields, 'measured_decay_rate_error')
      table%amplitude = field_of(fields, 'measured_amplitude')
      table%noise = field_of(fields, 'noise_deviation')
    end associate
    table%cases = layout%cases
  end function table_of

  pure subroutine add(self, index, numbers)
    !! Take account of a case.
    class(record_table), intent(inout) :: self
    integer(i8), intent(in) :: index          !! its number
    real(dp), intent(in), contiguous :: numbers(:)    !! (case_length)
    type(record_row) :: row
    integer(i8) :: k
    row%lines = nint(numbers(self%peak_count%first))
    row%noise = numbers(self%noise%first)
    if (row%lines > 0) then
      k = strongest(numbers(self%amplitude%first:self%amplitude%first + self%amplitude%length - 1), self%amplitude%lengths(1)) - 1
      row%frequency = numbers([self%frequency%first + k, self%frequency_error%first + k])/two_pi
      row%decay = numbers([self%decay%first + k, self%decay_error%first + k])
    end if
    if (index <= shown) self%first(index) = row
    if (index > self%cases - shown) self%last(index - (self%cases - shown)) = row
  end subroutine add

  pure integer function strongest(amplitude, peaks) result(k)
    !! The line whose amplitude is largest at any sensor.
    real(dp), intent(in) :: amplitude(:)      !! the lines of the first sensor, of the second, …
    integer, intent(in) :: peaks              !! room for so many
    k = modulo(maxloc(amplitude, dim=1, mask=.not. is_missing(amplitude)) - 1, peaks) + 1
  end function strongest

  function text(self, scene) result(lines)
    !! The table as it is printed.
    class(record_table), intent(in) :: self
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: lines
    type(text_builder) :: built
    integer(i8) :: i
    call built%append_line('')
    call built%append_line('    case   lines  strongest line         +/-  decay rate         +/-       noise   of')
    call built%append_line('                              Hz          Hz         1/s         1/s  1st sensor')
    do i = 1, self%cases
      if (i <= shown) then
        call built%append_line(row_text(i, self%first(i))//'   '//swept_text(scene, i))
      else if (i > self%cases - shown) then
        call built%append_line(row_text(i, self%last(i - (self%cases - shown)))//'   '//swept_text(scene, i))
      else if (i == shown + 1) then
        call built%append_line('     ...')
      end if
    end do
    lines = built%text()
  end function text

  pure function row_text(case, row) result(text)
    !! The numbers of a case.
    integer(i8), intent(in) :: case
    type(record_row), intent(in) :: row
    character(:), allocatable :: text
    text = right(text_of(case), 8)//right(text_of(row%lines), 8)//pair_text(row%frequency, 16)//pair_text(row%decay, 12)// &
      right(shortest(row%noise, 3), 12)
  end function row_text

end module bw_record_table
