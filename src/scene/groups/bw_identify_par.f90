module bw_identify_par
  !! `&identify`: an unknown number of the beam, estimated from the lines of a record.
  use bw_input_name, only: any_number, input_group, input_name, real_input, text_input, texts_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp
  use bw_scene_messages, only: message_list
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: check_identify

  integer, parameter, public :: most_unknowns = 12       !! all corners of their ranges are checked, 2 to this power
  integer, parameter :: most_scenes = 100
  real(dp), parameter, public :: logarithmic_from = 10.0_dp
    !! ratio last/first, both above 0, from which an unknown is searched by its logarithm

  type, public :: identify_par
    !! An unknown number of a scene, with its range.
    character(:), allocatable :: parameter               !! 'group%name', in lower case, as a sweep names it
    character(:), allocatable :: unit                    !! as UDUNITS writes it
    integer :: group = 0                                 !! place of its group in the scene; 0: not found
    integer :: value = 0                                 !! place of its name in the group
    integer :: element = 1                               !! index among the numbers of the name
    real(dp) :: first = 0.0_dp, last = 0.0_dp            !! its range, first < last
    real(dp) :: start = 0.0_dp                           !! value of the scene if in range, else the middle
    logical :: logarithmic = .false.                     !! searched by its logarithm
  end type identify_par

  type(input_group), parameter, public :: identify_group = input_group( &
    'identify', needs='record spectrum beam', repeatable=.true., along='unknown', absent='nothing is fitted', &
    physics='Fits unknown inputs of the beam to the lines of a record by least squares, with confidence intervals and '// &
    'correlations.', &
    example='&beam length = 0.6, density = 2700, width = 0.03, height = 0.006 /|&record file = '// &
    '''input/records/ring_down_1.csv'', quantity = ''acceleration'', points = 0.5, 1.0 /|&spectrum /|&identify parameter = '// &
    '''beam%youngs_modulus'', first = 50e9, last = 90e9 /', &
    rules='One group for each unknown. Its group must be present; a value given there that lies in the range is one of the '// &
    'starting points of the search. One of several bodies or pieces is named by its number, as `body(2)%mass`. An unknown '// &
    'whose range is above 0 and spans a factor of 10 or more is searched on a logarithmic scale. `&identify` excludes `&sweep` '// &
    'and `&design`; several files of the record are fitted together. `with` names further scenes, each with a `&record` of its '// &
    'own and the same beam in another state (with a mass, or of another length). An unknown has one value in all scenes that '// &
    'give a value to its name. `&identify` in a further scene declares unknowns of that scene alone.')

  type(input_name), parameter, public :: identify_names(*) = [ &
    input_name('identify', 'parameter', text_input, required=.true., &
               meaning='the unknown input, as ''group%name''; a real number of the beam'), &
    input_name('identify', 'first', real_input, '', any_number, required=.true., meaning='lower end of its range'), &
    input_name('identify', 'last', real_input, '', any_number, required=.true., meaning='upper end of its range'), &
    input_name('identify', 'with', texts_input, most=most_scenes, meaning='further scenes whose records are fitted together')]

contains

  pure subroutine check_identify(group, messages)
    !! Check that first < last.
    type(group_values), intent(in) :: group
    type(message_list), intent(inout) :: messages
    if (.not. (group%known('first') .and. group%known('last'))) return
    if (group%number('first') < group%number('last')) return
    call messages%add(group%line_of('last'), 'identify%last', text_of(group%number('last'))//' is not above first = '// &
                      text_of(group%number('first'))//'; accepted: a range, first < last')
  end subroutine check_identify

end module bw_identify_par
