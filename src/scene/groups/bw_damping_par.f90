module bw_damping_par
  !! `&damping`: the same ratio for every mode, or Rayleigh's two constants.
  use bw_input_name, only: input_group, input_name, not_negative, real_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_scene_messages, only: message_list
  implicit none (type, external)
  private
  public :: build_damping, by_ratio, check_damping, damping_text, complete_damping

  real(dp), parameter, public :: usual_ratio = 0.01_dp   !! tried if a scene gives no damping

  type, public :: damping_par
    real(dp) :: ratio = missing                    !! ζ of every mode, ≥ 0; `missing` with Rayleigh's constants
    real(dp) :: mass_proportional = 0.0_dp         !! a [1/s], ≥ 0
    real(dp) :: stiffness_proportional = 0.0_dp    !! b [s], ≥ 0
  end type damping_par

  type(input_group), parameter, public :: damping_group = input_group( &
    'damping', is_effect=.true., absent='undamped', &
    physics='Viscous damping. With `ratio` every mode k has the damping force 2 zeta beta_k M_k q_k''; Rayleigh damping '// &
    'has the matrix a M + b K, hence the ratio a/(2 beta) + b beta/2.', &
    example='&damping mass_proportional = 0.5, stiffness_proportional = 1e-6 /', &
    rules='Give `ratio`, or one or both constants of Rayleigh damping. M is the mass matrix and K the elastic stiffness alone. '// &
    '`ratio` refers to the frequency that follows from K and M: rotation and tension change the frequency, but not the damping.')

  type(input_name), parameter, public :: damping_names(*) = [ &
    input_name('damping', 'ratio', real_input, '1', not_negative, swept=.true., &
               excludes='mass_proportional stiffness_proportional', &
               meaning='damping over critical damping, the same for every mode'), &
    input_name('damping', 'mass_proportional', real_input, 's-1', not_negative, swept=.true., excludes='ratio', &
               meaning='a of Rayleigh damping; 0 if only b is given'), &
    input_name('damping', 'stiffness_proportional', real_input, 's', not_negative, swept=.true., excludes='ratio', &
               meaning='b of Rayleigh damping; 0 if only a is given')]

contains

  pure subroutine check_damping(damping, messages)
    !! Check that at least one number is given.
    type(group_values), intent(in) :: damping
    type(message_list), intent(inout) :: messages
    if (any(damping%values%given)) return
    call messages%add(0, 'damping%ratio', &
                      'is missing; accepted: ratio, or mass_proportional and stiffness_proportional')
  end subroutine check_damping

  pure subroutine complete_damping(damping)
    !! Set the constant of Rayleigh that is not given to 0.
    type(group_values), intent(inout) :: damping
    if (damping%given('ratio')) return
    if (.not. damping%given('mass_proportional')) call damping%derive('mass_proportional', 0.0_dp, 0)
    if (.not. damping%given('stiffness_proportional')) call damping%derive('stiffness_proportional', 0.0_dp, 0)
  end subroutine complete_damping

  pure type(damping_par) function build_damping(values) result(damping)
    !! Build the damping from checked values.
    type(group_values), intent(in) :: values   !! complete
    if (values%known('ratio')) then
      damping%ratio = values%number('ratio')
    else
      damping%mass_proportional = values%number('mass_proportional')
      damping%stiffness_proportional = values%number('stiffness_proportional')
    end if
  end function build_damping

  pure logical function by_ratio(damping)
    !! Return whether all modes have the same ratio, rather than Rayleigh's constants.
    type(damping_par), intent(in) :: damping
    by_ratio = .not. is_missing(damping%ratio)
  end function by_ratio

  pure function damping_text(values) result(text)
    !! Return the text of a report, with the ratio or Rayleigh's constants.
    type(group_values), intent(in) :: values   !! complete
    character(:), allocatable :: text
    if (values%known('ratio')) then
      text = 'damping (ratio '//values%number_or_swept('ratio', '')//')'
    else
      text = 'damping ('//values%number_or_swept('mass_proportional', ' 1/s')//' of the mass, '// &
        values%number_or_swept('stiffness_proportional', ' s')//' of the stiffness)'
    end if
  end function damping_text

end module bw_damping_par
