module bw_sweep_par
  !! `&sweep`: a number that takes several values, each of them a case; the columns of a `&design` are sweeps, too.
  use bw_input_name, only: any_number, input_group, input_name, integer_input, number_range, real_input, reals_input, &
                           text_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp, qp
  use bw_scene_messages, only: message_list
  use bw_text, only: lower
  implicit none (type, external)
  private
  public :: spaced, build_sweep, check_sweep, sweep_lines

  type, public :: sweep_par
    character(:), allocatable :: parameter   !! 'group%name', in lower case
    real(dp), allocatable :: values(:)       !! values of the parameter, (n)
    character(:), allocatable :: spacing     !! 'linear' or 'log' between the ends; '' for listed values
    integer :: axis = 0                      !! index of its factor in the product of cases: sweeps of one axis vary together
    logical :: implied = .false.             !! without a `&sweep`: the values are numbers of the files of a record
    logical :: designed = .false.            !! without a `&sweep`: the values are a column of a `&design`
  end type sweep_par

  integer, parameter :: most_values = 1000000

  type(input_group), parameter, public :: sweep_group = input_group( &
    'sweep', repeatable=.true., absent='one case', &
    physics='Runs the scene once for each value of an input, or for each combination of the values of several.', &
    example='&rotation /|&sweep parameter = ''rotation%angular_velocity'', first = 0, last = 100, count = 11 /', &
    rules='Give `values`, or `first`, `last` and `count`. With several sweeps each combination of their values is a case; '// &
    'the value of the first changes slowest. The swept name''s group must be present; a value given there is replaced. One '// &
    'of several groups or numbers is named by its number, as `body(2)%mass` or `beam%length(1)`. With n = count, value i = '// &
    '0 ... n-1 is ((n-1-i) first + i last)/(n-1), or with logarithmic spacing first (last/first)^(i/(n-1)).')

  type(input_name), parameter, public :: sweep_names(*) = [ &
    input_name('sweep', 'parameter', text_input, required=.true., &
               meaning='the swept input, as ''group%name''; a number'), &
    input_name('sweep', 'values', reals_input, '', any_number, most=most_values, excludes='first last count spacing', &
               meaning='the values that it takes, one for each case'), &
    input_name('sweep', 'first', real_input, '', any_number, excludes='values', meaning='the first value'), &
    input_name('sweep', 'last', real_input, '', any_number, excludes='values', meaning='the last value'), &
    input_name('sweep', 'count', integer_input, '1', number_range(2.0_dp, real(most_values, dp)), excludes='values', &
               meaning='number of values, both ends included'), &
    input_name('sweep', 'spacing', text_input, default="'linear'", words='linear log', excludes='values', &
               meaning='equal differences, or equal ratios of values > 0')]

  character(*), parameter :: range_names(*) = [character(5) :: 'first', 'last', 'count']

contains

  pure subroutine check_sweep(sweep, messages)
    !! Check that values are listed, or given by their ends and number.
    type(group_values), intent(in) :: sweep
    type(message_list), intent(inout) :: messages
    integer :: i
    if (sweep%given('values')) return
    do i = 1, size(range_names)
      if (.not. sweep%given(range_names(i))) then
        call messages%add(sweep%line, 'sweep%'//trim(range_names(i)), &
                          'is missing in this group; accepted: values, or first, last and count')
      end if
    end do
    if (.not. sweep%known('spacing')) return
    if (sweep%text('spacing') /= 'log') return
    do i = 1, 2
      if (.not. sweep%known(range_names(i))) cycle
      if (sweep%number(range_names(i)) <= 0.0_dp) then
        call messages%add(sweep%line_of(range_names(i)), 'sweep%'//trim(range_names(i)), &
                          "is not positive; accepted with spacing = 'log': > 0")
      end if
    end do
  end subroutine check_sweep

  pure subroutine build_sweep(values, sweep)
    !! Build a sweep from checked values, listed or between two ends.
    type(group_values), intent(in) :: values   !! checked
    type(sweep_par), intent(out) :: sweep
    sweep%parameter = lower(values%text('parameter'))
    sweep%spacing = ''
    if (values%given('values')) then
      sweep%values = values%values(values%at('values'))%numbers
    else
      sweep%spacing = values%text('spacing')
      sweep%values = spaced(values%number('first'), values%number('last'), values%whole('count'), &
                            sweep%spacing == 'log')
    end if
  end subroutine build_sweep

  pure function sweep_lines(values, n) result(lines)
    !! Return the line of the scene from which each of the n values comes.
    type(group_values), intent(in) :: values
    integer, intent(in) :: n
    integer, allocatable :: lines(:)
    if (values%given('values')) then
      lines = values%values(values%at('values'))%lines
    else
      allocate (lines(n), source=values%line_of('count'))
      lines(1) = values%line_of('first')
      lines(n) = values%line_of('last')
    end if
  end function sweep_lines

  pure function spaced(first, last, n, logarithmic) result(values)
    !! Return n values from first to last, both exact. Extended precision makes those between accurate to double
    !! precision, so that whole numbers and powers of ten are exact, and nothing overflows.
    real(dp), intent(in) :: first, last
    integer, intent(in) :: n                   !! ≥ 2
    logical, intent(in) :: logarithmic         !! then both ends are > 0
    real(dp), allocatable :: values(:)
    real(qp) :: ends(2), step
    real(qp), allocatable :: coarse(:), fine(:)    ! a value is the product of one of each, which saves exponentials
    integer :: i, m
    ends = [real(first, qp), real(last, qp)]
    if (logarithmic) then
      ends = log(ends)
      step = (ends(2) - ends(1))/(n - 1)
      m = ceiling(sqrt(real(n, dp)))
      coarse = [(exp(ends(1) + i*m*step), i=0, (n - 1)/m)]
      fine = [(exp(i*step), i=0, m - 1)]
      values = [(real(coarse(i/m + 1)*fine(mod(i, m) + 1), dp), i=0, n - 1)]
    else
      values = [(real(((n - 1 - i)*ends(1) + i*ends(2))/(n - 1), dp), i=0, n - 1)]
    end if
    values(1) = first
    values(n) = last
  end function spaced

end module bw_sweep_par
