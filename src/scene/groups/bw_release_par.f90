module bw_release_par
  !! `&release`: a captured mass leaves the beam.
  use bw_input_name, only: input_group, input_name, positive, real_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: release_text

  type, public :: release_par
    real(dp) :: time = 0.0_dp       !! t_r [s], > 0
  end type release_par

  type(input_group), parameter, public :: release_group = input_group( &
    'release', needs='capture', is_event=.true., absent='a captured mass stays', &
    physics='A captured mass leaves at a given time with the velocity of the beam at its place, and the beam continues to '// &
    'vibrate in its own modes.', &
    example='&impact mass_ratio = 0.2 /|&capture /|&release time = 0.1 /|&response duration = 0.5, samples = 4096 /', &
    rules='A sample at exactly that time shows the beam without the mass. A time after the end of the histories '// &
    'changes nothing.')

  type(input_name), parameter, public :: release_names(*) = [ &
    input_name('release', 'time', real_input, 's', positive, required=.true., swept=.true., &
               meaning='time at which the mass leaves the beam')]

contains

  pure function release_text(values) result(text)
    !! Return the text of a report: `release at 0.1 s`.
    type(group_values), intent(in) :: values
    character(:), allocatable :: text
    text = 'release at a swept time'
    if (.not. values%is_swept('time')) text = 'release at '//values%number_or_swept('time', ' s')
  end function release_text

end module bw_release_par
