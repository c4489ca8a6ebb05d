module bw_release_error
  !! How far the motion after a release is from that of infinitely many modes.
  !!
  !! The release hands the motion of short waves on to modes of nearly the same number, which then move as far as those of
  !! beam and mass did. And the force between beam and mass ends of a sudden: what it held bent moves on in all modes of the
  !! beam alone, with displacements that fall as k⁻⁴ only. A motion that has grown leaves more in this way than the blow did.
  !!
  !! With counts of modes the mass leaves with the velocity that these give the tip; what they lack of it the beam keeps in
  !! all its modes, low ones too. That is why this error falls only as n^(−3/2). The state of four times the modes just after
  !! the release is found in the same way, and the amplitudes of its difference add up as those of bw_tail do. Where there are
  !! no more modes, what the tip's velocity lacks is judged without them (bw_tip_rest).
  use bw_coherence, only: combined, deviation_type, largest, stretch_type
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_mode_set, only: first_numbers, mode_set, mode_source
  use bw_monitor, only: monitor_type, stops
  use bw_reach, only: amplitude_of, turns
  use bw_release, only: tip_rest
  use bw_segment, only: move
  use bw_tail, only: add_amplitudes, add_tail, moving_modes, negligible, sample_window
  use bw_tip_rest, only: find_tip_rest
  implicit none (type, external)
  private
  public :: blow_reach, release_error, release_tail

  integer, parameter :: fewest = 256              !! modes of the better state
  integer, parameter :: most_more = 6000          !! at most so many more: the projection takes the square of their number
  real(dp), parameter :: margin = 1.25_dp         !! empirical: for what the better state lacks itself
  real(dp), parameter :: tip_share = 0.05_dp      !! of the tip's velocity that a sum lacks; so well is the better state's known
  integer, parameter :: tip_times = 64            !! by at most so many times its modes; light masses would ask for far more

contains

  function release_tail(count, loaded, alone, force, released, points, stretch, velocity) result(error)
    !! Estimates of what the modes of the beam alone beyond the first `count` add after the release, (points), where
    !! those start with all that the tip's velocity gives them (bw_tip_rest).
    integer, intent(in) :: count
    class(mode_source), intent(in) :: loaded, alone
    real(dp), intent(in) :: force                 !! as that of `release_error`, and the others
    type(dd), intent(in) :: released
    real(dp), intent(in) :: points(:)
    type(stretch_type), intent(in) :: stretch
    logical, intent(in) :: velocity
    real(dp) :: error(size(points))
    class(mode_set), allocatable :: low
    real(dp) :: q(count), rate(count)
    call loaded%find(first_numbers(count), low)
    q = 0.0_dp
    rate = force*low%tip/low%modal_mass
    call move(low, released, q, rate)
    error = blow_left(count, loaded, alone, force, released, points, stretch, velocity) &
      + force_left(low, q, rate, alone, points, stretch, velocity)
  end function release_tail

  function blow_left(count, loaded, alone, force, released, points, stretch, velocity) result(error)
    !! What the blow gave the modes beyond the first `count`, handed on number by number, (points).
    integer, intent(in) :: count
    class(mode_source), intent(in) :: loaded, alone
    real(dp), intent(in) :: force
    type(dd), intent(in) :: released
    real(dp), intent(in) :: points(:)
    type(stretch_type), intent(in) :: stretch
    logical, intent(in) :: velocity
    real(dp) :: error(size(points))
    type(deviation_type) :: sums(size(points))
    type(stretch_type) :: whole
    whole = stretch_type(released%hi + stretch%start, released%hi + stretch%end, stretch%step)
    call add_tail(count, loaded, force, points, whole, velocity, sums, shown=alone)
    error = largest(sums, points, whole, alone%quadratic)
  end function blow_left

  function force_left(low, q, rate, alone, points, stretch, velocity) result(error)
    !! What the modes of the beam alone beyond the first of beam and mass get from these, (points).
    class(mode_set), intent(in) :: low            !! of beam and mass
    real(dp), intent(in) :: q(:), rate(:)         !! their state when the mass leaves
    class(mode_source), intent(in) :: alone
    real(dp), intent(in) :: points(:)
    type(stretch_type), intent(in) :: stretch
    logical, intent(in) :: velocity
    real(dp) :: error(size(points))
    class(mode_set), allocatable :: free
    type(deviation_type) :: sums(size(points)), before(size(points))
    integer, allocatable :: number(:)
    real(dp), allocatable :: weight(:)
    integer :: first, last
    first = low%count + 1
    do while (first <= alone%highest)
      last = min(2*first, alone%highest)
      before = sums
      call sample_window(first, last, number, weight)
      call alone%find(number, free)
      call add_state(free, free%overlap_far_below(low, q)/free%modal_mass, free%overlap_far_below(low, rate)/free%modal_mass, &
                     points, stretch, velocity, weight, sums)
      if (all(sums%magnitude + sums%growing - before%magnitude - before%growing &
              <= negligible*(sums%magnitude + sums%growing))) exit
      first = last + 1
    end do
    error = largest(sums, points, stretch, alone%quadratic)
  end function force_left

  function blow_reach(free, points, stretch, velocity, quadratic) result(reach)
    !! How far a blow of 1 at its tip drives the beam alone at most, (points).
    class(mode_set), intent(in) :: free           !! the modes that move
    real(dp), intent(in) :: points(:)
    type(stretch_type), intent(in) :: stretch
    logical, intent(in) :: velocity
    logical, intent(in) :: quadratic              !! see `largest`
    real(dp) :: reach(size(points))
    type(deviation_type) :: sums(size(points))
    call add_state(free, 0.0_dp*free%tip, free%tip/free%modal_mass, points, stretch, velocity, every(free), sums)
    reach = largest(sums, points, stretch, quadratic)
  end function blow_reach

  function release_error(q, rate, loaded, alone, count, force, released, points, stretch, velocity, monitor) result(error)
    !! Estimates of the largest error over the samples after the release, (points).
    real(dp), intent(in) :: q(:), rate(:)         !! state of the beam alone just after the release, (modes)
    class(mode_source), intent(in) :: loaded      !! modes with the mass
    class(mode_source), intent(in) :: alone       !! and without
    integer, intent(in) :: count                  !! of the modes with the mass that were summed
    real(dp), intent(in) :: force                 !! the continuum's modal velocities are force·Φ_k(1)/M_k
    type(dd), intent(in) :: released              !! time of the release, l²/h
    real(dp), intent(in) :: points(:)             !! ξ, (points)
    type(stretch_type), intent(in) :: stretch     !! after it, times from the release
    logical, intent(in) :: velocity               !! of the velocity, else of the displacement
    class(monitor_type), intent(inout), optional :: monitor   !! the estimates mean nothing where it asks to stop
    real(dp) :: error(size(points))
    class(mode_set), allocatable :: many, free
    type(deviation_type) :: sums(size(points))
    type(tip_rest) :: rest
    real(dp) :: usual
    real(dp), allocatable :: lacking(:), lacking_rate(:), start(:), start_rate(:)
    integer :: n
    error = 0.0_dp
    if (force == 0.0_dp) return
    n = max(count, size(q))
    n = min(max(fewest, min(4*n, n + most_more)), loaded%highest, alone%highest)
    call loaded%find(first_numbers(n), many, monitor=monitor)
    call alone%find(first_numbers(n), free, monitor=monitor)
    if (stops(monitor)) return
    allocate (start(n), source=0.0_dp)
    start_rate = force*many%tip/many%modal_mass
    usual = sqrt(0.5_dp*sum((many%tip(count + 1:)*start_rate(count + 1:))**2))    ! were the phases random
    call find_tip_rest(loaded, force, n, released, tip_share*usual, rest, highest=tip_times*n, monitor=monitor)
    call move(many, released, start, start_rate)
    lacking = (free%overlap_of_beam(many, start, monitor) - loaded%gamma*rest%displacement*free%tip)/free%modal_mass
    lacking_rate = (free%overlap_of_beam(many, start_rate, monitor) - loaded%gamma*rest%velocity*free%tip)/free%modal_mass
    lacking(:size(q)) = lacking(:size(q)) - q
    lacking_rate(:size(q)) = lacking_rate(:size(q)) - rate
    call add_state(free, lacking, lacking_rate, points, stretch, velocity, every(free), sums)
    error = margin*largest(combined(deviation_type(), sums), points, stretch, alone%quadratic) &
      + blow_left(n, loaded, alone, force, released, points, stretch, velocity) &
      + force_left(many, start, start_rate, alone, points, stretch, velocity) &
      + loaded%gamma*rest%uncertainty*blow_reach(free, points, stretch, velocity, alone%quadratic)
  end function release_error

  pure subroutine add_state(modes, q, rate, points, stretch, velocity, weight, sums)
    !! Amplitudes of modes that start from any state.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q(:), rate(:)         !! (modes)
    real(dp), intent(in) :: points(:)
    type(stretch_type), intent(in) :: stretch
    logical, intent(in) :: velocity
    real(dp), intent(in) :: weight(:)             !! for how many modes each stands, (modes)
    type(deviation_type), intent(inout) :: sums(:)
    type(moving_modes) :: moving
    real(dp) :: c(modes%count)
    c = 0.0_dp
    if (allocated(modes%damping)) c = modes%damping
    moving = moving_modes(amplitude_of(modes%beta_squared, c, q, rate, stretch, velocity), modes%alpha, &
                          abs(modes%tip), turns(modes%beta_squared, c))
    call add_amplitudes(moving, modes%shapes(points), points, stretch, weight, sums)
  end subroutine add_state

  pure function every(modes) result(weight)
    !! Each mode stands for itself.
    class(mode_set), intent(in) :: modes
    real(dp) :: weight(modes%count)
    weight = 1.0_dp
  end function every

end module bw_release_error
