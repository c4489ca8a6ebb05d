module bw_coherence
  !! What many modes add up to at the worst of the samples of a history, from sums of their amplitudes alone.
  !!
  !! The phase of a far mode k at the time τ is π²k²τ, and terms linear in k that depend on the point. A sum of such modes is
  !! a theta sum, which is large where ϑ = πτ/2 is near a fraction p/q: at the distance ε from it, modes with amplitudes that
  !! fall from A on add up to no more than the smaller of Σ|A| and A/√ε, over √q, or √(q/2) where q is even, and times a
  !! factor of about 1, whatever the linear terms are (sums of Gauss, and chords of Cornu's spiral). Of K modes no q above K
  !! counts (Dirichlet). What is beside this leading term is as large as random phases make it.
  !!
  !! The samples are ϑ_j = jϑ, j ≤ N: qϑ_j is as far from a whole number as mϑ with m = qj, which is nearest for the
  !! denominators m of the continued fraction of ϑ, and q ≥ m/N. So the worst sample of all is known after some ten divisions.
  !! After a release the samples are ϑ₀ + jϑ instead, ϑ₀ whatever it may be: there each q has its own nearest sample, which some
  !! twenty divisions find, and so many q count until Σ|A|/√q is less than what has been found.
  !! Of steps that are commensurable with the waves one m is very good; those that are farthest from it leave
  !! 1 to 2.8 N^(1/4) times the mean square's root.
  !!
  !! Waves of shear run nearly all at one speed: beyond the cutoff, from which sections swing on their own, the front of the blow
  !! keeps its shape, and where it passes the phases of all modes agree. Of a beam of several pieces the waves of each come to
  !! agree at times of their own. There Σ|A| is what is known.
  !!
  !! **Empirical**: the factors. `tests/scenes/tails.py` shows what they are worth.
  !! **Source**: Fiedler, Jurkat and Körner, Asymptotic expansions of finite theta series, Acta Arithmetica 32 (1977) 129–146.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: combined, from_tip, largest, path_to, seen_from_blow

  real(dp), parameter :: chord = 0.5_dp
    !! of A/√ε: 28000 sums asked for less. The longest chord is 0.83, but mostly one of a mode's two waves is near its fraction
  real(dp), parameter :: random = 3.6_dp         !! of √(½ΣA²)
  real(dp), parameter :: passage = 0.5_dp        !! of A√(α/d): 1.17/√(2π) where amplitudes do not fall
  real(dp), parameter :: apart = 2.0_dp          !! times Σ|A|/A: modes that may agree
  real(dp), parameter :: safety = 2.5_dp         !! of random phases alone
  real(dp), parameter :: revival = 2.0_dp        !! of N^(1/4), to which phases that are nearly quadratic add up
  real(dp), parameter :: returns = 3.0_dp        !! empirical, times a first passage
  real(dp), parameter :: at_blow = 2.0_dp
    !! of α|A|, nearer to the blow than a wave and when the mass has left: velocities there fall as 1/k, and Σ|A| has no bound
  real(dp), parameter :: normal = 1.4_dp         !! empirical, of the largest of N numbers that fall as Gauss' do, √(2 ln 2N)
  real(dp), parameter, public :: pinned = 3.0_dp !! αγ from which a mass is as good as a pin
  integer, parameter :: most_families = 64       !! so many are as good as random
  real(dp), parameter :: half_pi = acos(0.0_dp)

  type, public :: stretch_type
    !! Samples of a part of a history, times in l²/h from the start of the motion.
    real(dp) :: start = 0.0_dp                   !! the first sample: one step after the blow, or any time after a release
    real(dp) :: end = 0.0_dp                     !! a step after the last
    real(dp) :: step = 0.0_dp                    !! from sample to sample
  end type stretch_type

  type, public :: observation_type
    !! What of a motion is looked at.
    real(dp), allocatable :: points(:)           !! ξ, (points)
    type(stretch_type) :: stretch                !! when
    logical :: velocity = .false.                !! velocities, else displacements
  end type observation_type

  type, public :: deviation_type
    !! Of one point: sums over modes.
    real(dp) :: magnitude = 0.0_dp               !! Σ|A|
    real(dp) :: square = 0.0_dp                  !! ΣA²
    real(dp) :: largest = 0.0_dp                 !! of the |A|
    real(dp) :: passing = 0.0_dp                 !! the largest |A|√(α/d) of waves that come as far as the distance d in time
    real(dp) :: alpha = huge(1.0_dp)             !! of that mode
    real(dp) :: growing = 0.0_dp                 !! the largest value of what grows, or creeps back
    real(dp) :: agreeing = 0.0_dp                !! Σ|A| of modes whose phases may agree at any sample
    real(dp) :: paired = 0.0_dp                  !! what pairs of modes may add that none of those that were looked at shows
  end type deviation_type

  type, public :: path_type
    !! What waves of the blow run along to a point.
    real(dp) :: distance = 1.0_dp                !! d of the point from the blow
    logical :: uniform = .true.                  !! of a uniform beam, from its tip: nothing comes back but from the root
    real(dp) :: struck_at = 1.0_dp               !! ξ₀
    real(dp) :: gamma = 0.0_dp                   !! of the mass that stays there
  end type path_type

  type :: fraction_type
    !! One of the continued fraction of ϑ, and the one before it.
    real(dp) :: m = 1.0_dp                       !! denominator
    real(dp) :: m_before = 0.0_dp
    real(dp) :: distance = 0.0_dp                !! of mϑ from a whole number
    real(dp) :: distance_before = 1.0_dp
  end type fraction_type

contains

  pure type(observation_type) function seen_from_blow(points, longest, samples, velocity) result(seen)
    !! All of a history that begins with the blow, but for its first sample, when nothing has moved yet.
    real(dp), intent(in) :: points(:)            !! ξ, (points)
    real(dp), intent(in) :: longest              !! its duration, l²/h
    integer, intent(in) :: samples               !! N
    logical, intent(in) :: velocity              !! velocities, else displacements
    seen = observation_type(points, stretch_type(longest/samples, longest, longest/samples), velocity)
  end function seen_from_blow

  elemental type(deviation_type) function combined(sums, others) result(both)
    !! Modes whose amplitudes fall from number to number, and others whose amplitudes also rise: those count twice where
    !! phases agree.
    type(deviation_type), intent(in) :: sums, others
    both%magnitude = sums%magnitude + others%magnitude
    both%square = sums%square + others%square
    both%largest = sums%largest + 2.0_dp*others%largest
    both%passing = sums%passing + 2.0_dp*others%passing
    both%alpha = min(sums%alpha, others%alpha)
    both%growing = sums%growing + others%growing
    both%agreeing = sums%agreeing + others%agreeing
    both%paired = sums%paired + others%paired
  end function combined

  elemental type(path_type) function from_tip(xi) result(path)
    !! Of a uniform beam; at the tip itself the distance is so small that what is over it says nothing.
    real(dp), intent(in) :: xi                   !! ξ
    path = path_type(max(1.0_dp - xi, sqrt(tiny(xi))))
  end function from_tip

  elemental type(path_type) function path_to(xi, struck_at, uniform, gamma) result(path)
    !! From a blow anywhere, on any beam.
    real(dp), intent(in) :: xi                   !! ξ
    real(dp), intent(in) :: struck_at            !! ξ₀
    logical, intent(in) :: uniform               !! as that of `path_type`
    real(dp), intent(in) :: gamma                !! as that of `path_type`
    path = path_type(max(abs(struck_at - xi), sqrt(tiny(xi))), uniform, struck_at, gamma)
  end function path_to

  elemental real(dp) function largest(sums, path, stretch, quadratic) result(motion)
    !! What the modes add up to at most at one of the samples.
    type(deviation_type), intent(in) :: sums
    type(path_type), intent(in) :: path          !! to the point
    type(stretch_type), intent(in) :: stretch
    logical, intent(in) :: quadratic             !! phases are quadratic in the mode's number; else nothing is known of them
    real(dp) :: first
    integer :: families
    motion = sums%growing + sums%paired
    if (sums%largest <= 0.0_dp) return
    first = first_passage(sums, path, stretch)
    if (quadratic .and. .not. path%uniform) first = min(first, returns*near_sum(sums, half_pi*stretch%start))
    families = families_of(path, sums%alpha)
    if (quadratic .and. families == 1) then
      motion = motion + min(sums%magnitude, theta_sum(sums, first, stretch))
    else if (quadratic) then
      motion = motion + min(sums%magnitude, family_sum(sums, families, first, stretch))
    else
      motion = motion + min(sums%magnitude, max(random_sum(sums, stretch), first, agreement(sums)))
    end if
  end function largest

  elemental real(dp) function first_passage(sums, path, stretch) result(motion)
    !! While waves pass for the first time after the blow, near the fraction 0/1, and come back from the root. Before they
    !! come and after they have gone they leave the largest amplitude over the distance from its wave to the point, since there
    !! the waves end of a sudden; that distance is least at the last sample. Of a blow inboard, and where pieces meet, waves come
    !! back from more places than one.
    type(deviation_type), intent(in) :: sums
    type(path_type), intent(in) :: path
    type(stretch_type), intent(in) :: stretch
    real(dp) :: distance, edge, gone, way
    distance = path%distance
    way = 2.0_dp*sums%alpha*stretch%end
    edge = 1.0_dp/distance
    if (way < distance) edge = min(1.0_dp/(distance - way), edge + passage*sqrt(sums%alpha/distance))
    motion = passage*sums%passing*2.0_dp/(2.0_dp - distance) + sums%largest*edge
    if (.not. path%uniform) then
      motion = returns*motion
      if (path%distance*sums%alpha < 1.0_dp .and. path%gamma <= 0.0_dp) then
        motion = min(motion, returns*at_blow*sums%largest*sums%alpha)
      end if
      return
    end if
    gone = 2.0_dp*sums%alpha*stretch%start - distance      ! beyond the point at the first sample
    if (gone > 0.0_dp .and. way < 2.0_dp - distance) motion = min(motion, sums%largest/gone)
    motion = min(motion, near_sum(sums, half_pi*stretch%start))
  end function first_passage

  elemental real(dp) function agreement(sums) result(motion)
    !! Where the phases of all modes agree that may. Of velocities, whose amplitudes fall as 1/k, that is a wave front, as high as
    !! k|A| tells.
    type(deviation_type), intent(in) :: sums
    real(dp), parameter :: front = 2.5_dp        ! empirical: 1.85 of Gibbs' phenomenon, and more where fronts meet
    motion = min(sums%agreeing, front*sums%largest*sums%alpha/(2.0_dp*half_pi))
  end function agreement

  elemental real(dp) function near_sum(sums, distance) result(motion)
    !! So near a fraction.
    type(deviation_type), intent(in) :: sums
    real(dp), intent(in) :: distance             !! qε
    motion = chord*sums%largest/sqrt(max(distance, tiny(distance)))
  end function near_sum

  elemental real(dp) function theta_sum(sums, first, stretch) result(motion)
    !! Of quadratic phases.
    type(deviation_type), intent(in) :: sums
    real(dp), intent(in) :: first                !! while waves pass for the first time
    type(stretch_type), intent(in) :: stretch
    logical :: one_passage
    one_passage = 2.0_dp*sums%alpha*stretch%end < 1.0_dp     ! only short ones have crossed the beam
    motion = 0.0_dp
    if (half_pi*stretch%end < 0.5_dp) motion = first
    if (is_offset(stretch)) then
      call look_at_offset_samples(sums, stretch, one_passage, motion)
    else
      call look_at_samples(sums, stretch, one_passage, motion)
    end if
    if (.not. one_passage) motion = hypot(motion, random*sqrt(0.5_dp*sums%square))
  end function theta_sum

  elemental integer function families_of(path, alpha) result(families)
    !! In how many sequences the modes of a uniform beam come whose phases are quadratic, each in its own numbers: far modes with a
    !! mass inboard are those of a beam that is pinned there, whose wave numbers repeat after qπ if ξ₀ = p/q. A light mass holds
    !! nothing yet, and what is nearer to a fraction than a wave is that fraction; nor are there more than half waves in the shorter
    !! span. Where the mass is, all have one sign.
    type(path_type), intent(in) :: path
    real(dp), intent(in) :: alpha                !! of the modes that move farthest
    families = 1
    if (path%gamma*alpha < pinned .or. path%distance*alpha < 1.0_dp) return
    do families = 1, min(most_families, 1 + int(0.5_dp*alpha/half_pi*min(path%struck_at, 1.0_dp - path%struck_at))) - 1
      if (abs(path%struck_at - anint(families*path%struck_at)/families)*alpha < 1.0_dp) exit
    end do
  end function families_of

  elemental real(dp) function family_sum(sums, families, first, stretch) result(motion)
    !! Of several sequences of quadratic phases, two of which may agree and the others do so at random; at the start of the motion
    !! all agree.
    type(deviation_type), intent(in) :: sums
    integer, intent(in) :: families
    real(dp), intent(in) :: first                !! while waves pass for the first time
    type(stretch_type), intent(in) :: stretch
    logical :: one_passage
    real(dp) :: samples
    one_passage = 2.0_dp*sums%alpha*stretch%end < 1.0_dp
    motion = 0.0_dp
    if (is_offset(stretch)) then
      call look_at_offset_samples(sums, stretch, one_passage, motion)
    else
      call look_at_samples(sums, stretch, one_passage, motion)
    end if
    samples = max(2.0_dp, (stretch%end - stretch%start)/stretch%step)
    motion = max(first, motion/sqrt(0.5_dp*families), normal*sqrt(2.0_dp*log(2.0_dp*samples))*sqrt(0.5_dp*sums%square))
  end function family_sum

  elemental logical function is_offset(stretch)
    !! The first sample is not one step from the start of the motion.
    type(stretch_type), intent(in) :: stretch
    is_offset = abs(stretch%start/stretch%step - 1.0_dp) > 8.0_dp*epsilon(1.0_dp)
  end function is_offset

  elemental subroutine look_at_samples(sums, stretch, one_passage, motion)
    !! The largest of the sums near fractions p/q, of samples jϑ.
    type(deviation_type), intent(in) :: sums
    type(stretch_type), intent(in) :: stretch
    logical, intent(inout) :: one_passage        !! false where a fraction but 0/1 is near
    real(dp), intent(inout) :: motion            !! what is known already; if it is 0, also the fractions p/1 are looked at
    real(dp), parameter :: rounding = 4.0_dp*epsilon(1.0_dp)
    type(fraction_type) :: fraction
    real(dp) :: samples, turns, gauss, share
    turns = half_pi*stretch%step
    samples = max(1.0_dp, anint(stretch%end/stretch%step) - 1.0_dp)
    fraction = fraction_type(distance=abs(turns - anint(turns)))
    if (motion <= 0.0_dp) motion = near_sum(sums, fraction%distance)
    do while (fraction%distance > rounding*fraction%m*max(1.0_dp, turns))
      call find_next(fraction)
      if (fraction%m > samples*max(1.0_dp, apart*sums%magnitude/sums%largest)) exit
      one_passage = .false.
      gauss = merge(sqrt(2.0_dp), 1.0_dp, modulo(fraction%m, 2.0_dp) < 1.0_dp)
      share = min(1.0_dp, gauss*sqrt(samples/fraction%m))
      if (share*sums%magnitude <= motion) exit
      motion = max(motion, min(share*sums%magnitude, gauss*near_sum(sums, fraction%distance)))
    end do
  end subroutine look_at_samples

  elemental subroutine look_at_offset_samples(sums, stretch, one_passage, motion)
    !! The same of samples ϑ₀ + jϑ, from 1/q on, which is the first fraction that the samples come near but for 0/1.
    type(deviation_type), intent(in) :: sums
    type(stretch_type), intent(in) :: stretch
    logical, intent(inout) :: one_passage
    real(dp), intent(inout) :: motion
    integer, parameter :: most_looked_at = 5000  ! that far more modes cost no more; their bound is then a little higher
    real(dp) :: gauss, q, samples, share
    integer :: looked_at
    samples = max(1.0_dp, anint((stretch%end - stretch%start)/stretch%step))
    q = max(1.0_dp, aint(0.5_dp/(half_pi*stretch%end)) + 1.0_dp)
    looked_at = 0
    do while (q <= max(1.0_dp, apart*sums%magnitude/sums%largest))
      if (looked_at == most_looked_at) motion = max(motion, sqrt(2.0_dp/q)*sums%magnitude)
      if (sqrt(2.0_dp/q)*sums%magnitude <= motion) exit
      looked_at = looked_at + 1
      one_passage = .false.
      gauss = merge(sqrt(2.0_dp), 1.0_dp, modulo(q, 2.0_dp) < 1.0_dp)
      share = min(1.0_dp, gauss/sqrt(q))
      if (share*sums%magnitude > motion) motion = max(motion, min(share*sums%magnitude, &
        gauss*near_sum(sums, nearest_whole(q*(half_pi*stretch%start), q*(half_pi*stretch%step), samples))))
      q = q + 1.0_dp
    end do
  end subroutine look_at_offset_samples

  elemental real(dp) function nearest_whole(start, step, samples) result(distance)
    !! The least distance of start + j·step from a whole number, 0 ≤ j < samples, or a little less.
    real(dp), intent(in) :: start, step, samples
    real(dp), parameter :: rounding = 2.0_dp*epsilon(1.0_dp)
    distance = min(least_fraction(start, step, samples), least_fraction(-start, -step, samples))
    distance = max(0.0_dp, distance - rounding*(abs(start) + abs(step)*samples))
  end function nearest_whole

  elemental real(dp) function least_fraction(start, step, samples) result(least)
    !! The least fractional part of start + j·step, 0 ≤ j < samples. From one record to the next lower one leads the smallest
    !! number of steps that lowers the fractional part by no more than it is: one of those that approach whole numbers best
    !! from below.
    real(dp), intent(in) :: start, step, samples
    real(dp) :: down, up           ! how far the fractional part sinks in `sinking` steps, and rises in `rising`
    real(dp) :: sinking, rising, left, times
    least = modulo(start, 1.0_dp)
    left = samples - 1.0_dp
    up = modulo(step, 1.0_dp)
    down = 1.0_dp - up
    sinking = 1.0_dp
    rising = 1.0_dp
    do while (sinking <= left .and. min(up, down) > epsilon(up))
      if (down <= least) then
        times = min(aint(least/down), aint(left/sinking))
        least = max(0.0_dp, least - times*down)
        left = left - times*sinking
      else if (down > up) then
        times = min(max(1.0_dp, aint((down - least)/up)), aint(down/up))
        down = down - times*up
        sinking = sinking + times*rising
      else
        times = aint(up/down)
        up = up - times*down
        rising = rising + times*sinking
      end if
    end do
  end function least_fraction

  elemental subroutine find_next(fraction)
    !! The next of the continued fraction.
    type(fraction_type), intent(inout) :: fraction
    real(dp) :: part
    part = aint(fraction%distance_before/fraction%distance)
    fraction = fraction_type(fraction%m_before + part*fraction%m, fraction%m, &
                             fraction%distance_before - part*fraction%distance, fraction%distance)
  end subroutine find_next

  elemental real(dp) function random_sum(sums, stretch) result(motion)
    !! Of phases that are as good as random, or nearly quadratic.
    type(deviation_type), intent(in) :: sums
    type(stretch_type), intent(in) :: stretch
    real(dp) :: samples
    samples = max(2.0_dp, (stretch%end - stretch%start)/stretch%step)
    motion = max(safety*sqrt(2.0_dp*log(2.0_dp*samples)), revival*sqrt(sqrt(samples)))*sqrt(0.5_dp*sums%square)
  end function random_sum

end module bw_coherence
