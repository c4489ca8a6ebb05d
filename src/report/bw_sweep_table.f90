module bw_sweep_table
  !! The printed table of a sweep: all of a few cases, or the first, the last and the extreme ones of many, each with
  !! its swept values.
  use bw_case_result, only: case_done
  use bw_columns, only: fixed, short, table_of, text_table
  use bw_constants, only: two_pi
  use bw_kinds, only: dp, i1, i8
  use bw_missing, only: is_missing, missing, scaled
  use bw_record_table, only: record_table
  use bw_result_draft, only: result_draft
  use bw_swept_text, only: swept_text
  use bw_text, only: text_builder, text_of
  implicit none (type, external)
  private
  public :: sweep_table

  integer, parameter :: most_rows = 20      !! of a sweep whose cases are all shown
  integer, parameter :: at_once = 4096      !! cases read together
  character(*), parameter :: reasons(*) = [character(24) :: 'first', 'last', 'lowest frequency', 'highest frequency', &
    'smallest displacement', 'largest displacement', 'largest stress', 'largest force', 'first without frequency', &
    'first not trusted']                    !! why cases of a large sweep are shown
  integer, parameter :: contrary(*) = [1, 2, 4, 3, 6, 5, 7, 8, 9, 10]   !! of two such reasons neither is given for one case
  character(*), parameter :: outcomes(*) = [character(24) :: 'largest_displacement', 'largest_stress', 'largest_contact_force', &
    'restitution', 'final_mass_velocity']   !! of motions and contacts, as far as a result has them
  integer, parameter :: displacement = 1, stress = 2, force = 3
  integer, parameter :: ordered(*) = [-1, -1, 0, 0, displacement, displacement, stress, force, -1, -1]
    !! what each reason orders the cases by: 0: their frequencies; below: nothing
  integer, parameter :: direction(*) = [0, 0, -1, 1, -1, 1, 1, 1, 0, 0]      !! 1: the largest is shown, −1: the smallest

  type :: case_row
    !! The properties of a case that may be shown.
    integer(i8) :: case = 0                 !! its number; 0: none yet
    integer :: status = case_done
    real(dp) :: frequency = missing         !! of the lowest bending mode, rad/s
    real(dp) :: outcome(size(outcomes)) = missing   !! the largest over all points
  end type case_row

contains

  function sweep_table(draft, statuses) result(lines)
    !! Return the table of all cases of a draft.
    type(result_draft), intent(inout) :: draft
    integer(i1), intent(in) :: statuses(:)    !! of all cases, (cases)
    character(:), allocatable :: lines
    type(case_row), allocatable :: rows(:)    ! by case, or by reason
    type(text_builder) :: built
    type(text_table) :: table
    character(:), allocatable :: reasons_shown, mode
    integer(i8) :: printed                    ! the last case
    logical :: without, varies, wave, has(size(outcomes))
    integer :: r, k
    if (draft%layout%of_record) then
      lines = record_table(draft)
      return
    end if
    mode = 'mode '//text_of(lowest_mode(draft))
    allocate (rows(merge(size(statuses), size(reasons), size(statuses) <= most_rows)))
    call choose_rows(draft, statuses, rows)
    without = .false.
    printed = 0
    call built%append_line('')
    has = [(draft%variable(trim(outcomes(k))) > 0, k=1, size(has))]
    varies = any(is_missing(rows%frequency) .and. rows%case > 0) .or. &
             fixed(maxval(rows%frequency, rows%case > 0)) /= fixed(minval(rows%frequency, rows%case > 0))
    if (varies) then
      call built%append_line('  Lowest mode of each case: modes are numbered by frequency in each case, even if frequencies '// &
                             'cross')
    else
      call built%append_line('  Each case; '//mode//' has '//fixed(rows(1)%frequency/two_pi)//' Hz in all')
    end if
    wave = varies .and. .not. any(has(stress:))       ! there is room for all columns of a mode
    table = table_of('case|modes|'//mode//': frequency|'//trim(merge('frequency        ', mode//': frequency', wave))// &
                     '|phase velocity|group velocity|displacement|stress|contact force|restitution|mass leaves at|swept', &
                     '||rad/s|Hz|m/s|m/s|m, largest sample|Pa|N||m/s|', &
                     [8, 8, 19, merge(12, 19, wave), 16, 16, 19, 14, 15, 13, 16, 0], &
                     [.true., .true., wave, varies, wave, wave, has, .true.])
    call table%put_head(built)
    do
      r = next_row(rows, printed)
      if (r == 0) exit
      reasons_shown = ''
      if (size(statuses) > most_rows) reasons_shown = why(rows, r)
      call table%put_row(built, row_cells(draft, rows(r)), '   '//swept_text(draft%scene, rows(r)%case)//reasons_shown)
      without = without .or. is_missing(rows(r)%frequency)
      printed = rows(r)%case
    end do
    if (without) call built%append_line('  -: '//mode//' is unstable or overdamped, or could not be found: it has no frequency.')
    if (size(statuses) > most_rows) call built%append_line('    '//text_of(size(statuses))//' cases in the file')
    lines = built%text()
  end function sweep_table

  pure integer function lowest_mode(draft) result(mode)
    !! Return the number of the lowest bending mode: after the rigid rotation on a free hub.
    type(result_draft), intent(in) :: draft
    mode = merge(2, 1, allocated(draft%scene%hub) .and. draft%length_of('mode') > 1)
  end function lowest_mode

  subroutine choose_rows(draft, statuses, rows)
    !! Select the cases that are shown.
    type(result_draft), intent(inout) :: draft
    integer(i1), intent(in) :: statuses(:)
    type(case_row), intent(inout) :: rows(:)
    real(dp) :: frequency(at_once), at_point(at_once)
    real(dp), allocatable :: outcome(:, :)    ! (cases, outcomes)
    type(case_row) :: row
    integer :: first, n, i, k, p, r, variable
    allocate (outcome(at_once, size(outcomes)))
    do first = 1, size(statuses), at_once
      n = min(at_once, size(statuses) - first + 1)
      call draft%get_column(draft%variable('angular_frequency'), lowest_mode(draft), int(first, i8), frequency(:n))
      outcome(:n, :) = missing
      do k = 1, size(outcomes)
        variable = draft%variable(trim(outcomes(k)))
        if (variable == 0) cycle
        do p = 1, merge(draft%layout%points, 1, k < force)
          call draft%get_column(variable, p, int(first, i8), at_point(:n))
          where (is_missing(outcome(:n, k)) .or. (at_point(:n) > outcome(:n, k) .and. .not. is_missing(at_point(:n)))) &
            outcome(:n, k) = at_point(:n)
        end do
      end do
      do i = 1, n
        row = case_row(first + i - 1, int(statuses(first + i - 1)), frequency(i), outcome(i, :))
        if (size(statuses) <= most_rows) rows(row%case) = row
        do r = 1, merge(0, size(reasons), size(statuses) <= most_rows)
          if (is_better(row, rows(r), r, size(statuses, kind=i8))) rows(r) = row
        end do
      end do
    end do
  end subroutine choose_rows

  pure logical function is_better(row, than, reason, cases)
    !! Return whether a case is to replace another for a reason; of equal ones the first stays.
    type(case_row), intent(in) :: row
    type(case_row), intent(in) :: than        !! selected so far; case 0: none
    integer, intent(in) :: reason             !! its number in `reasons`
    integer(i8), intent(in) :: cases          !! in all
    real(dp), parameter :: same = 1.0e-9_dp
    real(dp) :: value, other, alike           ! the last: difference between two methods for the same modes
    logical :: is_first
    is_first = than%case == 0 .or. row%case < than%case
    if (ordered(reason) >= 0) then
      value = direction(reason)*merge(row%frequency, row%outcome(max(1, ordered(reason))), ordered(reason) == 0)
      other = direction(reason)*merge(than%frequency, than%outcome(max(1, ordered(reason))), ordered(reason) == 0)
      alike = same*abs(other)
      is_better = than%case == 0 .or. value > other + alike .or. (.not. value < other - alike .and. is_first)
      is_better = is_better .and. .not. is_missing(abs(value))
    else
      select case (reason)                    ! first, last, first without frequency, first not trusted
      case (1); is_better = row%case == 1
      case (2); is_better = row%case == cases
      case (9); is_better = is_missing(row%frequency) .and. row%status == case_done .and. is_first
      case default; is_better = row%status /= case_done .and. is_first
      end select
    end if
  end function is_better

  pure integer function next_row(rows, printed) result(next)
    !! Return the row of the lowest case after the last printed; 0 if there is none.
    type(case_row), intent(in) :: rows(:)
    integer(i8), intent(in) :: printed
    integer :: k
    next = 0
    do k = 1, size(rows)
      if (rows(k)%case <= printed) cycle
      if (next == 0) then
        next = k
      else if (rows(k)%case < rows(next)%case) then
        next = k
      end if
    end do
  end function next_row

  pure function why(rows, r) result(words)
    !! Give the reasons for which a case of a large sweep is shown.
    type(case_row), intent(in) :: rows(:)
    integer, intent(in) :: r
    character(:), allocatable :: words
    integer :: k
    words = ''
    do k = 1, size(reasons)
      if (rows(k)%case /= rows(r)%case) cycle
      if (contrary(k) /= k .and. rows(contrary(k))%case == rows(k)%case) cycle
      words = words//', '//trim(reasons(k))
    end do
    if (words /= '') words = ' ('//words(3:)//')'
  end function why

  function row_cells(draft, row) result(cells)
    !! Return the cells of a case.
    type(result_draft), intent(inout) :: draft
    type(case_row), intent(in) :: row
    character(:), allocatable :: cells
    real(dp), allocatable :: modes(:), phase_velocity(:), group_velocity(:)
    integer :: mode
    mode = lowest_mode(draft)
    modes = draft%get('mode_count', row%case)
    phase_velocity = draft%get('phase_velocity', row%case)
    group_velocity = draft%get('group_velocity', row%case)
    cells = text_of(row%case)//'|'//text_of(nint(modes(1)))//'|'//fixed(row%frequency)//'|'// &
      fixed(scaled(row%frequency, 1.0_dp/two_pi))//'|'//fixed(phase_velocity(mode))//'|'//fixed(group_velocity(mode))//'|'// &
      fixed(row%outcome(1))//'|'//fixed(row%outcome(2))//'|'//fixed(row%outcome(3))//'|'//short(row%outcome(4), 5)//'|'// &
      short(row%outcome(5), 5)
  end function row_cells

end module bw_sweep_table
