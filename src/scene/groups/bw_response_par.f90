module bw_response_par
  !! `&response`: time histories at points of the beam.
  use bw_input_name, only: input_group, input_name, integer_input, logical_input, number_range, positive, real_input, &
                           reals_input, unit_interval
  use bw_input_values, only: group_values, position_of
  use bw_kinds, only: dp
  use bw_load_par, only: begins_or_ends_at_once
  use bw_scene_messages, only: message_list
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: build_response, check_limits, check_response

  type, public :: response_par
    real(dp) :: duration = 0.0_dp        !! T [s], > 0
    integer :: samples = 0               !! N ≥ 1; the times are the exact j·T/N, j = 0 … N−1
    real(dp), allocatable :: points(:)   !! ξ in [0, 1], in the user's order, all different, (n_points)
    logical :: velocity = .false.        !! velocities are requested, too
    logical :: bending_moment = .false.  !! and bending moments
    logical :: acceleration = .false.    !! and accelerations
    logical :: shear_force = .false.     !! and shear forces
  end type response_par

  type(input_group), parameter, public :: response_group = input_group( &
    'response', needs='impact|force|base|initial|body', absent='no time history', &
    physics='Histories at points of the beam. Every sample is exact for the modes that are summed, however few samples there '// &
    'are. But a peak may lie between samples, and a spectrum shows only frequencies below the Nyquist frequency samples/(2 '// &
    'duration). Reports and results give the largest sample; the report estimates how much larger the peak may be, and warns '// &
    'if that matters.', &
    example='&impact mass_ratio = 0.2 /|&capture /|&response duration = 0.5, samples = 8192, points = 0.25, 0.5, 1, '// &
    'velocity = .true. /', &
    rules='Samples are taken at the exact times j duration/samples, j = 0 ... samples-1. Accelerations and shear forces '// &
    'converge under forces, motions of the base and contacts. They do not converge, and are refused, after an instantaneous '// &
    'blow or a capture, with `&initial`, and if bodies come or leave; accelerations also if a force begins or ends abruptly.')

  type(input_name), parameter, public :: response_names(*) = [ &
    input_name('response', 'duration', real_input, 's', positive, required=.true., &
               meaning='length of the histories, from t = 0 on'), &
    input_name('response', 'samples', integer_input, '1', number_range(1.0_dp, 1e9_dp), required=.true., &
               meaning='samples of each history'), &
    input_name('response', 'points', reals_input, '1', unit_interval, '0.5, 1.0', most=1000, &
               meaning='places of the histories: x/l, 0 at the root, 1 at the tip'), &
    input_name('response', 'velocity', logical_input, default='.false.', meaning='histories of the velocity'), &
    input_name('response', 'acceleration', logical_input, default='.false.', meaning='histories of the acceleration'), &
    input_name('response', 'bending_moment', logical_input, default='.false.', meaning='histories of bending moment and stress'), &
    input_name('response', 'shear_force', logical_input, default='.false.', &
               meaning='histories of the shear force')]

contains

  pure subroutine check_response(response, messages)
    !! Check that no two points are equal, since they are coordinates of the result.
    type(group_values), intent(in) :: response
    type(message_list), intent(inout) :: messages
    integer :: i
    associate (points => response%values(response%at('points')))
      if (.not. points%known .or. .not. points%given) return
      do i = 2, size(points%numbers)
        if (any(points%numbers(:i - 1) == points%numbers(i))) then
          call messages%add(points%lines(i), 'response%points', text_of(points%numbers(i))// &
                            ' is given twice; accepted: each point once')
        end if
      end do
    end associate
  end subroutine check_response

  pure subroutine check_limits(groups, messages)
    !! Reject quantities that do not converge as modes are added: accelerations and shear forces after an instantaneous
    !! blow, accelerations after a load that jumps.
    type(group_values), intent(in) :: groups(:)
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: why
    integer :: g, r
    r = position_of(groups, 'response')
    if (r == 0) return
    why = ''
    if (changes()) then
      why = 'does not converge if bodies come or leave, or a deflection is released; accepted: .false.'
    else if (position_of(groups, 'impact') > 0) then
      if (position_of(groups, 'contact') == 0) then
        why = 'does not converge after an instantaneous blow; accepted: .false., or &contact'
      else if (position_of(groups, 'capture') > 0) then
        why = 'does not converge after a capture, where the contact force ends abruptly; accepted: .false., or no &capture'
      end if
    end if
    if (why /= '') then
      if (asked('acceleration')) call messages%add(groups(r)%line_of('acceleration'), 'response%acceleration', why)
      if (asked('shear_force')) call messages%add(groups(r)%line_of('shear_force'), 'response%shear_force', why)
    end if
    if (why /= '' .or. position_of(groups, 'impact') > 0) return
    if (.not. asked('acceleration')) return
    do g = 1, size(groups)
      if (groups(g)%group /= 'force') cycle
      if (begins_or_ends_at_once(groups(g))) call messages%add(groups(r)%line_of('acceleration'), 'response%acceleration', &
        'does not converge if a force begins or ends abruptly, as that of line '//text_of(groups(g)%line)// &
        '; accepted: another shape, a sine of whole half periods, or no acceleration')
    end do
  contains
    pure logical function changes()
      !! Return whether the motion has jumps that no load causes, at its beginning or later.
      integer :: i
      changes = position_of(groups, 'initial') > 0
      do i = 1, size(groups)
        if (groups(i)%group == 'body') changes = changes .or. groups(i)%given('from') .or. groups(i)%given('until')
      end do
    end function changes

    pure logical function asked(name)
      character(*), intent(in) :: name
      asked = groups(r)%known(name)
      if (asked) asked = groups(r)%values(groups(r)%at(name))%flag
    end function asked
  end subroutine check_limits

  pure type(response_par) function build_response(values) result(response)
    !! Build a response from checked values.
    type(group_values), intent(in) :: values
    response%duration = values%number('duration')
    response%samples = values%whole('samples')
    response%points = values%values(values%at('points'))%numbers
    response%velocity = values%values(values%at('velocity'))%flag
    response%bending_moment = values%values(values%at('bending_moment'))%flag
    response%acceleration = values%values(values%at('acceleration'))%flag
    response%shear_force = values%values(values%at('shear_force'))%flag
  end function build_response

end module bw_response_par
