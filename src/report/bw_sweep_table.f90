module bw_sweep_table
  !! The printed table of a sweep: of a few cases all, of many the first, the last, and those that are extreme, each with the
  !! values that it was given. Cases are added in any order.
  use bw_case_fields, only: case_field, field_of, fields_of
  use bw_case_result, only: case_done
  use bw_columns, only: fixed, right
  use bw_kinds, only: dp, i8
  use bw_magnitude, only: largest_magnitude
  use bw_missing, only: is_missing, missing, scaled
  use bw_record_table, only: record_table
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_swept_text, only: swept_text
  use bw_text, only: text_builder, text_of
  implicit none (type, external)
  private

  integer, parameter :: most_rows = 20      !! of a sweep whose cases are all shown
  character(*), parameter :: reasons(*) = [character(24) :: 'first', 'last', 'lowest frequency', 'highest frequency', &
    'smallest displacement', 'largest displacement', 'first without frequency', 'first not trusted']
    !! why cases of a large sweep are shown

  type :: case_row
    !! A case that is shown.
    integer(i8) :: case = 0                 !! its number; 0: none yet
    integer :: modes = 0                    !! how many were summed
    integer :: status = case_done
    real(dp) :: frequency = missing         !! of mode 1, rad/s
    real(dp) :: phase_velocity = missing
    real(dp) :: group_velocity = missing
    real(dp) :: displacement = missing      !! the largest, m
  end type case_row

  type, public :: sweep_table
    private
    integer(i8) :: cases = 0
    type(case_row) :: rows(max(most_rows, size(reasons)))     !! by case, or by reason
    type(case_field) :: mode_count, status, frequency, phase_velocity, group_velocity, displacement
      !! where they stand in a case
    type(record_table), allocatable :: of_records      !! instead of all that, of repeats of a record
  contains
    procedure :: add
    procedure :: text
  end type sweep_table

  interface sweep_table
    module procedure :: table_of
  end interface sweep_table

contains

  pure function table_of(layout) result(table)
    !! A table without rows.
    type(result_layout), intent(in) :: layout
    type(sweep_table) :: table
    if (layout%of_record) then
      table%of_records = record_table(layout)
      return
    end if
    associate (fields => fields_of(layout))
      table%mode_count = field_of(fields, 'mode_count')
      table%status = field_of(fields, 'case_status')
      table%frequency = field_of(fields, 'angular_frequency')
      table%phase_velocity = field_of(fields, 'phase_velocity')
      table%group_velocity = field_of(fields, 'group_velocity')
      table%displacement = field_of(fields, 'displacement')
    end associate
    table%cases = layout%cases
  end function table_of

  pure subroutine add(self, index, numbers)
    !! Take account of a case.
    class(sweep_table), intent(inout) :: self
    integer(i8), intent(in) :: index          !! its number
    real(dp), intent(in), contiguous :: numbers(:)    !! (case_length)
    type(case_row) :: row
    integer :: r
    if (allocated(self%of_records)) then
      call self%of_records%add(index, numbers)
      return
    end if
    row = case_row(index, nint(numbers(self%mode_count%first)), nint(numbers(self%status%first)), &
                   numbers(self%frequency%first), numbers(self%phase_velocity%first), numbers(self%group_velocity%first))
    if (self%displacement%name /= '') then
      associate (first => self%displacement%first, length => self%displacement%length)
        row%displacement = largest_of(numbers(first:first + length - 1))
      end associate
    end if
    if (self%cases <= most_rows) then
      self%rows(index) = row
      return
    end if
    do r = 1, size(reasons)
      if (is_better(row, self%rows(r), trim(reasons(r)), self%cases)) self%rows(r) = row
    end do
  end subroutine add

  pure real(dp) function largest_of(history) result(largest)
    !! The largest displacement that is known; missing where none is.
    real(dp), intent(in), contiguous :: history(:)
    largest = largest_magnitude(history)
    if (largest < missing) return
    largest = missing
    if (any(.not. is_missing(history))) largest = maxval(abs(history), mask=.not. is_missing(history))
  end function largest_of

  pure logical function is_better(row, than, reason, cases)
    !! A case is to be shown for a reason instead of another: of equal ones the first.
    type(case_row), intent(in) :: row
    type(case_row), intent(in) :: than        !! shown so far; case 0: none is
    character(*), intent(in) :: reason
    integer(i8), intent(in) :: cases          !! in all
    logical :: is_first
    is_first = than%case == 0 .or. row%case < than%case
    select case (reason)
    case ('first'); is_better = row%case == 1
    case ('last'); is_better = row%case == cases
    case ('lowest frequency'); is_better = leads(-row%frequency, -than%frequency, is_missing(row%frequency))
    case ('highest frequency'); is_better = leads(row%frequency, than%frequency, is_missing(row%frequency))
    case ('smallest displacement'); is_better = leads(-row%displacement, -than%displacement, is_missing(row%displacement))
    case ('largest displacement'); is_better = leads(row%displacement, than%displacement, is_missing(row%displacement))
    case ('first without frequency'); is_better = is_missing(row%frequency) .and. row%status == case_done .and. is_first
    case default; is_better = row%status /= case_done .and. is_first
    end select
  contains
    pure logical function leads(value, other, none)
      real(dp), intent(in) :: value, other
      logical, intent(in) :: none             !! the value does not exist
      leads = .not. none .and. (than%case == 0 .or. value > other .or. (.not. value < other .and. is_first))
    end function leads
  end function is_better

  function text(self, scene) result(lines)
    !! The table as it is printed.
    class(sweep_table), intent(in) :: self
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: lines
    type(text_builder) :: built
    integer(i8) :: printed                    ! the last case
    logical :: without
    integer :: r
    if (allocated(self%of_records)) then
      lines = self%of_records%text(scene)
      return
    end if
    without = .false.
    printed = 0
    call built%append_line('')
    call built%append_line('    case   modes  mode 1: frequency   frequency  phase velocity  group velocity  displacement   swept')
    call built%append_line('                              rad/s          Hz             m/s             m/s    m, largest')
    do
      r = next_row(self, printed)
      if (r == 0) exit
      call built%append_line(row_text(self%rows(r))//'   '//swept_text(scene, self%rows(r)%case)//why(self, r))
      without = without .or. is_missing(self%rows(r)%frequency)
      printed = self%rows(r)%case
    end do
    if (without) call built%append_line('  -: mode 1 grows, or creeps back, or could not be found: it has no frequency.')
    if (self%cases > most_rows) call built%append_line('    '//text_of(self%cases)//' cases in the file')
    lines = built%text()
  end function text

  pure integer function next_row(self, printed) result(next)
    !! The row of the lowest case behind the last that is printed; 0 where there is none.
    class(sweep_table), intent(in) :: self
    integer(i8), intent(in) :: printed
    integer :: k
    next = 0
    do k = 1, size(self%rows)
      if (self%rows(k)%case <= printed) cycle
      if (next == 0) then
        next = k
      else if (self%rows(k)%case < self%rows(next)%case) then
        next = k
      end if
    end do
  end function next_row

  pure function why(self, r) result(words)
    !! The reasons for which a case of a large sweep is shown.
    class(sweep_table), intent(in) :: self
    integer, intent(in) :: r
    character(:), allocatable :: words
    integer :: k
    words = ''
    if (self%cases <= most_rows) return
    do k = 1, size(reasons)
      if (self%rows(k)%case == self%rows(r)%case) words = words//', '//trim(reasons(k))
    end do
    words = ' ('//words(3:)//')'
  end function why

  pure function row_text(row) result(text)
    !! The numbers of a case.
    type(case_row), intent(in) :: row
    character(:), allocatable :: text
    real(dp), parameter :: two_pi = 2.0_dp*acos(-1.0_dp)
    text = right(text_of(row%case), 8)//right(text_of(row%modes), 8)//right(fixed(row%frequency), 19)// &
      right(fixed(scaled(row%frequency, 1.0_dp/two_pi)), 12)//right(fixed(row%phase_velocity), 16)// &
      right(fixed(row%group_velocity), 16)//right(fixed(row%displacement), 14)
  end function row_text

end module bw_sweep_table
