module bw_frequency_response_par
  !! `&frequency_response`: the response of the beam to a harmonic force.
  use bw_input_name, only: input_group, input_name, integer_input, number_range, positive, real_input, reals_input, text_input, &
    unit_interval
  use bw_input_values, only: group_values, position_of
  use bw_kinds, only: dp
  use bw_scene_messages, only: message_list
  use bw_sweep_par, only: spaced
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: build_frequency_response, check_frequency_response, complete_frequency_response

  type, public :: frequency_response_par
    real(dp) :: position = 1.0_dp            !! ξ of the force
    real(dp), allocatable :: points(:)       !! ξ of the response in [0, 1], all different, (points)
    real(dp), allocatable :: frequency(:)    !! Hz, ascending, (frequencies)
    character(:), allocatable :: quantity    !! displacement, velocity or acceleration
  end type frequency_response_par

  type(input_group), parameter, public :: frequency_response_group = input_group( &
    'frequency_response', excludes='record', absent='no frequency response', &
    physics='Finds the steady response to a harmonic force of unit amplitude as a complex ratio: receptance (displacement), '// &
    'mobility (velocity) or accelerance (acceleration).', &
    example='&damping ratio = 0.005 /|&frequency_response first = 5, last = 2000, quantity = ''acceleration'', points = '// &
    '0.5, 1.0 /', &
    rules='The result holds the real and the imaginary part of the response at `points` to a harmonic force of 1 N at '// &
    '`position`. A captured mass is part of the beam. If the scene has a `&response`, the `points` are those of that group.')

  type(input_name), parameter, public :: frequency_response_names(*) = [ &
    input_name('frequency_response', 'position', real_input, '1', unit_interval, '1', swept=.true., &
               meaning='place of the force: x/l'), &
    input_name('frequency_response', 'points', reals_input, '1', unit_interval, '1.0', most=1000, &
               meaning='places of the response: x/l'), &
    input_name('frequency_response', 'first', real_input, 'Hz', positive, required=.true., meaning='lowest frequency'), &
    input_name('frequency_response', 'last', real_input, 'Hz', positive, required=.true., meaning='highest frequency'), &
    input_name('frequency_response', 'count', integer_input, '1', number_range(2.0_dp, 1e6_dp), '1000', &
               meaning='number of frequencies'), &
    input_name('frequency_response', 'spacing', text_input, default="'log'", words='log linear', &
               meaning='spacing of the frequencies'), &
    input_name('frequency_response', 'quantity', text_input, default="'displacement'", words='displacement velocity acceleration', &
               meaning='response in m/N, m/(s N) or m/(s2 N)')]

contains

  pure subroutine check_frequency_response(groups, messages)
    !! Check that frequencies increase, that no point is given twice, and that points are those of `&response`.
    type(group_values), intent(in) :: groups(:)
    type(message_list), intent(inout) :: messages
    integer :: g, r, i
    g = position_of(groups, 'frequency_response')
    if (g == 0) return
    associate (group => groups(g))
      if (group%known('first') .and. group%known('last')) then
        if (group%number('last') <= group%number('first')) call messages%add(group%line_of('last'), 'frequency_response%last', &
          'is not above first = '//text_of(group%number('first'))//' Hz; accepted: a higher frequency')
      end if
      associate (points => group%values(group%at('points')))
        if (.not. (points%known .and. points%given)) return
        do i = 2, size(points%numbers)
          if (any(points%numbers(:i - 1) == points%numbers(i))) call messages%add(points%lines(i), 'frequency_response%points', &
            text_of(points%numbers(i))//' is given twice; accepted: each point once')
        end do
        r = position_of(groups, 'response')
        if (r == 0) return
        if (.not. groups(r)%known('points')) return
        associate (others => groups(r)%values(groups(r)%at('points')))
          if (size(others%numbers) == size(points%numbers)) then
            if (all(others%numbers == points%numbers)) return
          end if
          call messages%add(points%lines(1), 'frequency_response%points', 'are not those of &response, and a result has one '// &
                            'coordinate of points; accepted: the same, or none here')
        end associate
      end associate
    end associate
  end subroutine check_frequency_response

  pure subroutine complete_frequency_response(groups, g)
    !! Set points that are not given to those of `&response`, if there is one.
    type(group_values), intent(inout) :: groups(:)
    integer, intent(in) :: g                 !! place of this group
    integer :: r
    r = position_of(groups, 'response')
    if (r == 0 .or. groups(g)%given('points')) return
    if (.not. groups(r)%known('points')) return
    associate (points => groups(g)%values(groups(g)%at('points')))
      call points%set_numbers(groups(r)%values(groups(r)%at('points'))%numbers, 0)
    end associate
  end subroutine complete_frequency_response

  pure type(frequency_response_par) function build_frequency_response(values) result(response)
    !! Build a frequency response from checked values.
    type(group_values), intent(in) :: values
    response%position = values%number('position')
    response%points = values%values(values%at('points'))%numbers
    response%frequency = spaced(values%number('first'), values%number('last'), values%whole('count'), &
                                values%text('spacing') == 'log')
    response%quantity = values%text('quantity')
  end function build_frequency_response

end module bw_frequency_response_par
