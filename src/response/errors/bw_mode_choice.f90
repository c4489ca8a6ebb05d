module bw_mode_choice
  !! How many modes of the continuum a tolerance takes.
  !!
  !! The estimated error falls nearly as a power of their number, but for a plateau where the mass is light. So a straight
  !! line through the logarithms of two tries finds the next one: each try samples some hundred modes, and three or four
  !! are cheaper than a bisection.
  use bw_coherence, only: observation_type
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_sources
  use bw_monitor, only: stops
  use bw_release_error, only: release_tail
  use bw_truncation, only: tail_error
  implicit none (type, external)
  private
  public :: modes_for

  integer, parameter, public :: first_modes = 64   !! the least number: enough to know the peak of the motion
  integer, parameter, public :: most_modes = 10000000
  integer, parameter, public :: most_released = 10000
    !! modes that move after a release. More would bring a tolerance down to half at best: then what 10⁷ modes lack of the
    !! tip's velocity when the mass leaves is what is missing (bw_tip_remainder)
  real(dp), parameter :: aim = 0.93_dp          !! of the bound, for the next try
  real(dp), parameter :: near = 0.85_dp         !! of the bound, tuned: no try follows; 6 % of the modes are one too many
  integer, parameter :: fineness = 32           !! as near as the modes that are sampled tell
  real(dp), parameter :: first_slope = -2.5_dp  !! d log(error)/d log(count), usual where the mass is not light
  real(dp), parameter :: least_slope = -0.5_dp  !! a plateau is not taken for the end

  type :: try_type
    integer :: count = 0                        !! 0: none yet
    real(dp) :: error = 0.0_dp
  end type try_type

contains

  subroutine modes_for(bound, sources, force, seen, count, reached, released)
    !! The least number of modes, nearly, whose estimated truncation error is within a bound at every point. After a
    !! release they are those of the beam alone.
    real(dp), intent(in) :: bound             !! of the displacement, in the unit of `force` times l²/h
    type(mode_sources), intent(in) :: sources
    real(dp), intent(in) :: force             !! see `tail_error`
    type(observation_type), intent(in) :: seen   !! from the blow, or after the release, with times from there
    integer, intent(out) :: count             !! the most there may be, where more would be needed
    real(dp), intent(out) :: reached          !! the estimate for `count` modes
    type(dd), intent(in), optional :: released   !! when the mass left, l²/h; absent: it is there
    type(try_type) :: few, enough, try, last
    integer :: most, tries
    most = min(most_modes, sources%loaded%highest)
    if (present(released)) most = min(most_released, sources%loaded%highest, sources%free%highest)
    tries = 0
    try%count = first_modes
    do
      if (present(released)) then
        try%error = maxval(release_tail(try%count, sources, force, released, seen))
      else
        try%error = maxval(tail_error(try%count, sources%loaded, force, seen))
      end if
      if (stops(sources%loaded%monitor)) exit
      tries = tries + 1
      if (try%error <= bound) enough = try
      if (try%error > bound) then
        last = few
        few = try
      end if
      if (few%count >= most .or. enough%count == first_modes) exit
      if (enough%count > 0) then
        if (enough%error >= near*bound .or. enough%count - few%count <= enough%count/fineness) exit
        try%count = between(few, enough, bound, mod(tries, 4) == 0)
      else
        try%count = beyond(last, few, bound, most)
      end if
    end do
    if (enough%count == 0) enough = few
    count = enough%count
    reached = enough%error
  end subroutine modes_for

  pure integer function beyond(last, few, bound, most) result(count)
    !! A number larger than one that is too few, by the slope since the try before it.
    type(try_type), intent(in) :: last, few
    real(dp), intent(in) :: bound
    integer, intent(in) :: most
    real(dp) :: slope
    slope = first_slope
    if (last%count > 0) slope = min(least_slope, log(few%error/last%error)/log(real(few%count, dp)/last%count))
    count = max(few%count + 1, int(min(real(most, dp), few%count*(aim*bound/few%error)**(1.0_dp/slope))))
  end function beyond

  pure integer function between(few, enough, bound, halve) result(count)
    !! A number between too few and enough.
    type(try_type), intent(in) :: few, enough
    real(dp), intent(in) :: bound
    logical, intent(in) :: halve              !! the bracket: where the error falls unevenly, lines may creep
    real(dp) :: part
    part = 0.5_dp
    if (.not. halve) part = log(few%error/(aim*bound))/log(few%error/max(enough%error, tiny(1.0_dp)))
    count = int(few%count*(real(enough%count, dp)/few%count)**part)
    count = max(few%count + 1, min(enough%count - 1, count))
  end function between

end module bw_mode_choice
