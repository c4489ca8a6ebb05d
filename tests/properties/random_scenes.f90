module random_scenes
  !! Scenes drawn at random over the whole range of the model: light to heavy masses, standing to well above the
  !! critical speed, a fraction of a period to thousands of them.
  use bw_closed_form, only: closed_form_modes, closed_form_set
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_text, only: text_of
  use random_streams, only: random_stream
  use written_scenes, only: scene_of
  implicit none (type, external)
  private
  public :: random_scene, scene_of

  character, parameter :: nl = new_line('a')
  integer, parameter :: most_modes = 60, most_samples = 40
  real(dp), parameter :: most_growth = 300.0_dp
    !! |β|T of the fastest growing mode: squares of what has grown by e³⁰⁰ do not overflow

contains

  function random_scene(random) result(text)
    !! A namelist with impact and response, and most often with rotation and capture.
    type(random_stream), intent(inout) :: random
    character(:), allocatable :: text
    real(dp) :: gamma, frequency, speed, first, length
    logical :: captured, in_plane
    type(closed_form_set) :: modes
    call put_beam(random, text, frequency)
    gamma = random%log_between(1e-6_dp, 1e6_dp)
    captured = random%chance(70)
    modes = closed_form_modes(1, merge(gamma, 0.0_dp, captured))
    first = modes%critical_speed%hi                       ! in units of h/l²
    speed = first*speed_ratio(random)
    call put_rotation(random, speed*frequency, text, in_plane)
    call put_impact(random, gamma, text)
    call put_modes(random, captured, text)
    length = duration(random, first, merge(speed, 0.0_dp, in_plane))
    call put_response(random, length/frequency, text)
  end function random_scene

  subroutine put_beam(random, text, frequency)
    !! A round section or any other, and its h/l² [rad/s].
    type(random_stream), intent(inout) :: random
    character(:), allocatable, intent(out) :: text
    real(dp), intent(out) :: frequency
    real(dp) :: length, density, modulus, section, gyration
    length = random%log_between(1e-3_dp, 1e3_dp)
    density = random%log_between(1.0_dp, 1e5_dp)
    modulus = random%log_between(1e3_dp, 1e13_dp)
    section = length*random%log_between(1e-4_dp, 0.3_dp)
    text = '&beam length='//text_of(length)//' density='//text_of(density)//' youngs_modulus='//text_of(modulus)
    if (random%chance(50)) then
      text = text//' diameter='//text_of(section)
      gyration = 0.25_dp*section
    else
      gyration = random%log_between(0.1_dp, 1.0_dp)*section
      text = text//' area='//text_of(section**2)//' second_moment='//text_of((section*gyration)**2)
    end if
    text = text//' /'//nl
    frequency = gyration*sqrt(modulus/density)/length**2
  end subroutine put_beam

  subroutine put_rotation(random, speed, text, in_plane)
    type(random_stream), intent(inout) :: random
    real(dp), intent(in) :: speed                         !! rad/s
    character(:), allocatable, intent(inout) :: text
    logical, intent(out) :: in_plane
    in_plane = random%chance(90)
    if (speed == 0.0_dp .and. in_plane) return            ! no rotation; out of plane: a rotation at rest
    text = text//'&rotation angular_velocity='//text_of(signed(random, speed))
    if (.not. in_plane) text = text//" plane='out'"
    text = text//' /'//nl
  end subroutine put_rotation

  subroutine put_impact(random, gamma, text)
    type(random_stream), intent(inout) :: random
    real(dp), intent(in) :: gamma
    character(:), allocatable, intent(inout) :: text
    real(dp) :: velocity
    velocity = random%log_between(1e-3_dp, 1e3_dp)
    text = text//'&impact mass_ratio='//text_of(gamma)//' approach_velocity='//text_of(signed(random, velocity))
    text = text//' restitution='//text_of(restitution(random))//' profile_points=2 /'//nl
  end subroutine put_impact

  subroutine put_modes(random, captured, text)
    type(random_stream), intent(inout) :: random
    logical, intent(in) :: captured
    character(:), allocatable, intent(inout) :: text
    text = text//'&modes before='//text_of(1 + random%below(most_modes))
    if (captured) text = text//' after='//text_of(1 + random%below(most_modes))
    text = text//' /'//nl
    if (captured) text = text//'&capture /'//nl
  end subroutine put_modes

  subroutine put_response(random, duration, text)
    type(random_stream), intent(inout) :: random
    real(dp), intent(in) :: duration                      !! s
    character(:), allocatable, intent(inout) :: text
    text = text//'&response duration='//text_of(duration)//' samples='//text_of(2 + random%below(most_samples))
    text = text//' points='//points(random)//' velocity=t /'//nl
  end subroutine put_response

  real(dp) function signed(random, value)
    !! A value with a random sign.
    type(random_stream), intent(inout) :: random
    real(dp), intent(in) :: value
    signed = value
    if (random%chance(50)) signed = -value
  end function signed

  real(dp) function speed_ratio(random)
    !! Angular velocity over the critical one.
    type(random_stream), intent(inout) :: random
    select case (random%below(5))
    case (0); speed_ratio = 0.0_dp
    case (1); speed_ratio = random%between(1.0_dp, 30.0_dp)                                        ! several modes grow
    case (2); speed_ratio = 1.0_dp + random%log_between(1e-15_dp, 0.1_dp)*(2*random%below(2) - 1)  ! close to critical
    case default; speed_ratio = random%between(0.0_dp, 1.0_dp)
    end select
  end function speed_ratio

  real(dp) function restitution(random)
    type(random_stream), intent(inout) :: random
    select case (random%below(4))
    case (0); restitution = 0.0_dp
    case (1); restitution = 1.0_dp
    case default; restitution = random%between(0.0_dp, 1.0_dp)
    end select
  end function restitution

  real(dp) function duration(random, first, speed)
    !! In l²/h: a fraction of the first mode's period to thousands of them, unless a mode grows too much.
    type(random_stream), intent(inout) :: random
    real(dp), intent(in) :: first      !! α₁²
    real(dp), intent(in) :: speed      !! in plane
    duration = random%log_between(0.05_dp, 5e3_dp)*2.0_dp*pi/first
    if (speed > first) duration = min(duration, random%log_between(0.1_dp, most_growth)/sqrt(speed**2 - first**2))
  end function duration

  function points(random) result(text)
    !! One to five different places, the root and the tip among them now and then.
    type(random_stream), intent(inout) :: random
    character(:), allocatable :: text
    integer :: i
    text = text_of(random%between(0.0_dp, 1.0_dp))
    do i = 1, random%below(3)
      text = text//', '//text_of(random%between(0.0_dp, 1.0_dp))
    end do
    if (random%chance(20)) text = text//', 0'
    if (random%chance(20)) text = text//', 1'
  end function points

end module random_scenes
