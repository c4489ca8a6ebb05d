module bw_truncation_error
  !! The truncation error of a sum of the first n modes: a proved bound, and an estimate.
  !!
  !! **Bound.** Modes beyond the n-th have the energy E_n, the difference between the energy of the motion and that of the first
  !! n, which does not grow while they are stable. R_n(ξ) = Σ_{k>n}Φ_k(ξ)²/(M_kβ_k²) is their flexibility at the point. By the
  !! Cauchy–Schwarz inequality |Σ_{k>n}Φ_kq_k(t)| ≤ √(2E_nR_n) at all times. R_n is computed without cancellation at an
  !! imaginary frequency (bw_flexibility): R_n ≤ (1 + s²/β²_{n+1})Σ_{k>n}Φ_k²/(M_k(β_k² + s²)) for any s. Surveyed modes beyond
  !! the n-th contribute at most their amplitudes; the bound applies to the modes beyond the survey.
  !!
  !! With a light mass most energy is in modes far beyond the n-th, which hardly move any point. After an impact
  !! amplitudes are fΦ_k(ξ)Φ_k(ξ₀)/(M_kβ_k), and by the same inequality their sum is at most f√(T(ξ)T(ξ₀)), T(ξ) =
  !! Σ_{k>n}Φ_k(ξ)²/(M_kβ_k). With 1/β ≤ ½Σ_j 2ʲb/(β² + 4ʲb²), j ≥ −2, for β ≥ b, these are flexibilities at imaginary
  !! frequencies as well. All shifts s² are powers of 4, and b a power of 2, so a few flexibilities serve every n.
  !!
  !! **Estimate.** Omitted modes rarely add up to the bound: phases are practically random, or agree at some samples as
  !! those of the summed modes do. So the last two octaves of the sum are summed separately. Their ratios of sum to sum
  !! of amplitudes, and the change per octave, give that ratio for all further octaves. For velocities and curvatures
  !! sums of amplitudes diverge. A multiple of the root mean square is used, from the energy E_n and mean square shapes.
  use bw_damping, only: damping_law
  use bw_double_double, only: dd
  use bw_flexibility, only: mean_square_curvature, mean_square_shape
  use bw_kinds, only: dp
  use bw_modal_flow, only: damping_factor_beyond
  use bw_mode_set, only: curvatures
  use bw_mode_survey, only: mode_survey
  use bw_piece_beam, only: piece_beam
  use bw_projection, only: likely
  use bw_reach, only: turns
  implicit none (type, external)
  private
  public :: lowest_cutoff, block_ends, displacement_error, falling_part, find_rates, find_tail, phase_agreement, rate_error
  public :: spread_of_samples, crest_factor

  real(dp), parameter, public :: rate_likely = 2.0_dp  !! tuned: the same for velocities, in root mean squares
  real(dp), parameter :: least_fall = 0.5_dp       !! largest asymptotic ratio of amplitude sums per octave, with shear
  real(dp), parameter :: steady = 1.5_dp           !! tuned: safety factor if octaves continue to fall as the last two
  integer, parameter :: counted = 5                !! octaves of these sums: velocities may have no bound, and no sum is larger
  real(dp), parameter :: schwarz = 1.35_dp         !! of the sum of amplitudes for similar modes: √(4/3)·π/√8, rounded up
  integer, parameter :: shifts(2) = [-2, 2]        !! j for s² = 4ʲ near β²; the last is for beams with tension, which is neglected
  real(dp), parameter, public :: no_bound = 1.0e100_dp  !! where no bound is known
  real(dp), parameter :: rounding = 1.0e-13_dp     !! relative error of a flexibility
  integer, parameter, public :: fewest = 4         !! least number of modes with two octaves and others before
  integer, parameter :: lowest = -2, highest = 16  !! j, beyond which flexibilities fall as s^(−3/2)
  integer, parameter :: octaves = 8                !! of modes for mean square shapes

  type, public :: tail_type
    !! Possible contributions of modes beyond the first n, (points).
    integer :: count = 0                           !! n
    real(dp), allocatable :: bound(:)              !! of displacements, at all times of the interval
    real(dp), allocatable :: reach(:)              !! approximate sum of amplitudes
    real(dp), allocatable :: largest(:)            !! largest amplitude of a surveyed mode
    real(dp), allocatable :: rate_mean(:)          !! from `find_rates`: root mean square of velocities or curvatures
    real(dp), allocatable :: rate_bound(:)         !! of velocities, at points with a body
  end type tail_type

contains

  pure function block_ends(count) result(ends)
    !! Return the last modes of three blocks: the first count/4 modes, and the two octaves after them.
    integer, intent(in) :: count
    integer :: ends(3)
    ends = [count/4, count/2, count]
  end function block_ends

  subroutine find_tail(survey, beam, law, energy, count, tail, force, place)
    !! Find the truncation error of displacements. The survey holds at least the first `count` modes.
    type(mode_survey), intent(inout) :: survey     !! caches flexibilities
    type(piece_beam), intent(in) :: beam           !! of these modes, without its tension
    type(damping_law), intent(in), optional :: law !! absent: undamped
    real(dp), intent(in) :: energy                 !! of all modes, m_iV²
    integer, intent(in) :: count                   !! n, at the end of a bin
    type(tail_type), intent(out) :: tail
    real(dp), intent(in), optional :: force        !! f, if all modes start undeflected with velocities fΦ_k(ξ₀)/M_k
    real(dp), intent(in), optional :: place        !! ξ₀
    real(dp) :: beyond(size(survey%points))
    integer :: b
    b = survey%bin_of(count)
    tail%count = count
    if (survey%bound_energy < energy .or. survey%bound_energy > energy .or. .not. allocated(survey%bound)) then
      call find_schwarz(survey%bins, beyond)
      survey%bound = beyond
      survey%bound_energy = energy
    end if
    tail%largest = 0.0_dp*survey%bound
    tail%bound = survey%bound
    tail%reach = survey%bound
    if (survey%bins == b) return
    associate (at => survey%at(:, b + 1:survey%bins))
      tail%largest = maxval(at%largest, 2)
      tail%bound = min(no_bound, survey%bound + sum(at%reach, 2))
      tail%reach = min(no_bound, schwarz*tail%bound)
    end associate
  contains
    subroutine find_schwarz(b, bound)
      !! Return √(2ER) of the modes beyond a bin, or f√(TT) if they have most of the energy.
      integer, intent(in) :: b
      real(dp), intent(out) :: bound(size(survey%points))
      real(dp) :: left
      integer :: level
      bound = no_bound
      if (survey%quantity == curvatures .or. survey%bin(b)%square <= 0.0_dp) return
      left = energy_beyond(survey, energy, b)
      call find_residual(survey, beam, b, bound)
      bound = sqrt(2.0_dp*left*bound)
      if (present(force) .and. present(place)) then
        level = level_of(survey%bin(b)%square)
        if (left > 0.5_dp*energy .and. level + lowest >= lowest_level(beam) &
            .and. all(beam%piece%compliance%hi <= 0.0_dp)) then    ! with shear T diverges
          call survey%flexibility%cover(beam, survey%points, level + lowest, level + highest)
          call survey%struck%cover(beam, [place], level + lowest, level + highest)
          bound = min(bound, bound_of_blow(survey, force, b))
        end if
      end if
      bound = left_by_damping(survey, law, b)*bound
    end subroutine find_schwarz
  end subroutine find_tail

  pure subroutine find_rates(survey, beam, law, energy, tail)
    !! Find the same for velocities, or for curvatures.
    type(mode_survey), intent(in) :: survey
    type(piece_beam), intent(in) :: beam
    type(damping_law), intent(in), optional :: law
    real(dp), intent(in) :: energy
    type(tail_type), intent(inout) :: tail
    integer :: b
    b = survey%bin_of(tail%count)
    tail%rate_mean = sqrt(half_squares(survey, b + 1, survey%bins) + left_by_damping(survey, law, survey%bins)**2 &
                          *energy_beyond(survey, energy, survey%bins)*mean_shapes(survey, beam))
    if (survey%quantity /= curvatures) tail%rate_bound = left_by_damping(survey, law, b) &
      *sqrt(2.0_dp*energy_beyond(survey, energy, b)*mobility_beyond(survey, beam, b))
  end subroutine find_rates

  elemental integer function level_of(square) result(level)
    !! Return j of the largest 4ʲ ≤ β².
    real(dp), intent(in) :: square                 !! β² > 0
    level = floor(0.5_dp*log(square)/log(2.0_dp))
  end function level_of

  pure integer function lowest_level(beam) result(level)
    !! Return j of the least shift, well above the frequency of rotation.
    type(piece_beam), intent(in) :: beam
    level = minexponent(1.0_dp)
    if (beam%spin_squared%hi > 0.0_dp) level = level_of(1.5_dp*beam%spin_squared%hi) + 1
  end function lowest_level

  pure real(dp) function energy_beyond(survey, energy, b) result(left)
    !! Return the energy of the modes beyond a bin, with its rounding error.
    type(mode_survey), intent(in) :: survey
    real(dp), intent(in) :: energy
    integer, intent(in) :: b
    real(dp), parameter :: unit = 4.0_dp*epsilon(1.0_dp)
    left = max(0.0_dp, energy - sum(survey%bin(:b)%energy)) + unit*(abs(energy) + sum(survey%bin(:b)%size_of_energy))
  end function energy_beyond

  pure subroutine find_residual(survey, beam, b, residual)
    !! Bound Σ_{k>n}Φ_k(ξ)²/(M_kβ_k²) by the smallest shift without cancellation. As tension stiffens a beam, the flexibility
    !! without tension is a bound as well, sharper at higher frequency; so larger shifts are tried while they help.
    type(mode_survey), intent(inout) :: survey     !! caches flexibilities
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: b                       !! with β² > 0 of its last mode
    real(dp), intent(out) :: residual(:)           !! (points)
    real(dp), dimension(size(residual)) :: now
    real(dp) :: shift
    integer :: first, j
    residual = huge(residual)
    first = max(level_of(survey%bin(b)%square) + shifts(1), lowest_level(beam))
    do j = first, max(first, level_of(survey%bin(b)%square) + shifts(2))
      shift = 4.0_dp**j
      call survey%flexibility%cover(beam, survey%points, j, j)
      now = (1.0_dp + shift/survey%bin(b)%square)*remaining(survey%flexibility%at(:, j), taken(survey, b, shift))
      if (all(now >= residual)) exit
      residual = min(residual, now)
    end do
  end subroutine find_residual

  pure function bound_of_blow(survey, force, b) result(bound)
    !! Return f√(T(ξ)T(ξ₀)) of the modes beyond a bin.
    type(mode_survey), intent(in) :: survey        !! with flexibilities at all shifts, also at the struck point
    real(dp), intent(in) :: force                  !! see `find_tail`
    integer, intent(in) :: b                       !! with β² > 0 of its last mode
    real(dp) :: bound(size(survey%points)), shift
    real(dp), dimension(size(survey%points) + 1) :: beyond, left
    integer :: j, level
    level = level_of(survey%bin(b)%square)
    beyond = 0.0_dp
    do j = lowest, highest
      shift = 4.0_dp**(level + j)
      left = remaining([survey%flexibility%at(:, level + j), survey%struck%at(:, level + j)], [taken(survey, b, shift), &
        & sum((2.0_dp*survey%bin(:b)%energy/force)/force/(survey%bin(:b)%mean_square + shift))])   ! energies are ½f²Φ_k(ξ₀)²/M_k
      beyond = beyond + 2.0_dp**j*left
    end do
    beyond = beyond + 2.0_dp**highest*left/(sqrt(2.0_dp) - 1.0_dp)
    bound = 0.5_dp*force*sqrt(4.0_dp**level*beyond(:size(bound))*beyond(size(beyond)))
  end function bound_of_blow

  elemental real(dp) function remaining(whole, taken)
    !! Return the remainder of a flexibility, with its rounding error.
    real(dp), intent(in) :: whole, taken
    remaining = rounding*whole + max(0.0_dp, whole - taken)
  end function remaining

  pure function taken(survey, b, shift)
    !! Return the flexibility of the modes up to a bin, (points).
    type(mode_survey), intent(in) :: survey
    integer, intent(in) :: b
    real(dp), intent(in) :: shift
    real(dp) :: taken(size(survey%points))
    integer :: i
    taken = 0.0_dp
    do i = 1, b
      taken = taken + survey%at(:, i)%share/(survey%bin(i)%mean_square + shift)
    end do
  end function taken

  pure real(dp) function left_by_damping(survey, law, b) result(left)
    !! Return the factor of damping for amplitudes of modes beyond a bin at the first sample; 1 if undamped.
    type(mode_survey), intent(in) :: survey
    type(damping_law), intent(in), optional :: law
    integer, intent(in) :: b
    left = 1.0_dp
    if (.not. present(law)) return
    left = damping_factor_beyond(dd(survey%bin(b)%square), survey%bin(b)%damping, law%stiffness, survey%stretch%start)
  end function left_by_damping

  pure function mobility_beyond(survey, beam, b) result(mobility)
    !! Return Σ_{k>n}Φ_k(ξ)²/M_k: over all modes it is the reciprocal mass of a body at the point; without a body it is unbounded.
    type(mode_survey), intent(in) :: survey
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: b
    real(dp), parameter :: same_place = 8.0_dp*epsilon(1.0_dp)
    real(dp) :: mobility(size(survey%points)), place
    integer :: i, p
    mobility = no_bound
    place = 0.0_dp
    do i = 1, size(beam%joint)
      place = place + beam%piece(i)%length%hi
      if (beam%joint(i)%mass%hi <= 0.0_dp) cycle
      do p = 1, size(mobility)
        if (abs(survey%points(p) - place) > same_place) cycle
        mobility(p) = max(0.0_dp, 1.0_dp/beam%joint(i)%mass%hi - sum(survey%at(p, :b)%share)) &
          + 4.0_dp*epsilon(place)/beam%joint(i)%mass%hi
      end do
    end do
  end function mobility_beyond

  pure function mean_shapes(survey, beam) result(mean)
    !! Return the mean of Φ²/M, or of squared curvature over M β², for modes beyond the survey, weighted by an energy
    !! that halves per octave. At points near the impact higher modes matter more.
    type(mode_survey), intent(in) :: survey
    type(piece_beam), intent(in) :: beam
    real(dp) :: mean(size(survey%points)), frequency, weight
    integer :: i
    mean = 0.0_dp
    frequency = sqrt(max(survey%bin(survey%bins)%square, 1.5_dp*beam%spin_squared%hi))
    do i = 1, octaves
      weight = 0.5_dp**min(i, octaves - 1)
      if (survey%quantity == curvatures) then
        mean = mean + weight*mean_square_curvature(beam, frequency, survey%points)
      else
        mean = mean + weight*mean_square_shape(beam, frequency, survey%points)
      end if
      frequency = 4.0_dp*frequency
    end do
  end function mean_shapes

  pure function displacement_error(tail, part) result(error)
    !! Estimate the largest displacement due to modes beyond the first n, (points).
    type(tail_type), intent(in) :: tail
    real(dp), intent(in) :: part(:)                !! from `phase_agreement`, (points)
    real(dp) :: error(size(part))
    error = min(tail%bound, tail%largest + likely*part*tail%reach)
  end function displacement_error

  pure function rate_error(tail, times, largest) result(error)
    !! Estimate the same for velocities, or for curvatures. If samples are instants at which waves of all lengths meet,
    !! octaves hardly fall, and add up.
    type(tail_type), intent(in) :: tail
    real(dp), intent(in) :: times(:)               !! from `crest_factor`, (points)
    real(dp), intent(in) :: largest(:, :)          !! of each block, (points, 2)
    real(dp) :: error(size(times)), falling(size(times))
    integer :: i
    error = rate_likely*times*tail%rate_mean
    falling = part_of(largest(:, 2), largest(:, 1))
    error = max(error, steady*largest(:, 2)*sum(spread(falling, 2, counted)**spread([(i, i=1, counted)], 1, size(times)), 2))
    if (allocated(tail%rate_bound)) error = min(error, tail%rate_bound)
  end function rate_error

  pure real(dp) function lowest_cutoff(beam) result(square)
    !! Return β² of the lowest cutoff of a beam with shear. Beyond it waves hardly disperse and phases agree: a block
    !! has the same ratio of sum to sum of amplitudes as at the cutoff.
    type(piece_beam), intent(in) :: beam
    square = 1.0_dp/max(maxval(beam%piece%compliance%hi*beam%piece%rotary%hi), tiny(1.0_dp))
  end function lowest_cutoff

  pure function phase_agreement(survey, count, samples, largest) result(part)
    !! Return the ratio of sum to sum of amplitudes for modes beyond the first `count`, extrapolated from the blocks
    !! before them, (points). With random phases it falls by √½ per octave; as far as blocks exceed random sums, phases
    !! agree, and it falls less. With fewer than four modes it is 1.
    type(mode_survey), intent(in) :: survey
    integer, intent(in) :: count                   !! modes summed
    integer, intent(in) :: samples                 !! number of samples
    real(dp), intent(in), optional :: largest(:, :)   !! of each block, (points, 2); absent: random phases
    real(dp) :: part(size(survey%points))
    real(dp), dimension(size(survey%points), 2) :: random, reach, shown
    real(dp), dimension(size(survey%points)) :: fall, less
    real(dp), parameter :: by_chance = 3.0_dp      ! the largest of many exceeds its mean by so much in one of twenty
    real(dp) :: chance
    integer :: b, ends(3)
    part = 1.0_dp
    if (count < fewest) return
    ends = block_bins(survey, count)
    do b = 1, 2
      associate (at => survey%at(:, ends(b) + 1:ends(b + 1)))
        reach(:, b) = sum(at%reach, 2)
        random(:, b) = part_of(spread_of_samples(samples_alive(survey, ends(b + 1), samples))*sqrt(0.5_dp*sum(at%square, 2)), &
                               reach(:, b))
      end associate
    end do
    shown = random
    if (present(largest)) shown = part_of(largest, reach)
    fall = sqrt(0.5_dp)
    chance = 1.0_dp + by_chance/spread_of_samples(samples)**2
    where (random(:, 1) > 0.0_dp .and. random(:, 2) > 0.0_dp) &
      fall = min(1.0_dp, sqrt(0.5_dp)*max(1.0_dp, maxval(shown/max(random, tiny(fall)), 2)/chance))
    less = min(least_fall, part_of(reach(:, 2), reach(:, 1)))    ! ratio of amplitude sums per octave
    part = max(random(:, 2), shown(:, 2), fall*shown(:, 1))
    part = min(1.0_dp, part*fall*(1.0_dp - less)/(1.0_dp - less*fall))
  end function phase_agreement

  pure function falling_part(tail, largest) result(part)
    !! Return the same if octaves continue to fall as the last two, by half or more, (points). This is larger if damping
    !! or the place leaves most modes without phases, so that sums of amplitudes say little.
    type(tail_type), intent(in) :: tail
    real(dp), intent(in) :: largest(:, :)          !! of each block, (points, 2)
    real(dp) :: part(size(largest, 1)), fall(size(largest, 1))
    fall = min(least_fall, part_of(largest(:, 2), largest(:, 1)))
    part = min(1.0_dp, part_of(steady/likely*largest(:, 2)*fall/(1.0_dp - fall), tail%reach))
  end function falling_part

  pure function crest_factor(survey, count, samples, largest) result(times)
    !! Return velocities or curvatures of a block over their root mean square, (points).
    type(mode_survey), intent(in) :: survey
    integer, intent(in) :: count, samples          !! see `phase_agreement`
    real(dp), intent(in), optional :: largest(:, :)
    real(dp) :: times(size(survey%points))
    integer :: ends(3)
    times = spread_of_samples(samples)
    if (count < fewest) return
    ends = block_bins(survey, count)
    times = spread_of_samples(samples_alive(survey, ends(3), samples))
    if (.not. present(largest)) return
    times = max(times, times_of(largest(:, 1), half_squares(survey, ends(1) + 1, ends(2))), &
                times_of(largest(:, 2), half_squares(survey, ends(2) + 1, ends(3))))
  end function crest_factor

  pure function half_squares(survey, first, last) result(squares)
    !! Return ½ΣA² of velocities, or of curvatures, over some bins.
    type(mode_survey), intent(in) :: survey
    integer, intent(in) :: first, last
    real(dp) :: squares(size(survey%points))
    if (survey%quantity == curvatures) then
      squares = 0.5_dp*sum(survey%at(:, first:last)%square, 2)
    else
      squares = 0.5_dp*sum(survey%at(:, first:last)%rate_square, 2)
    end if
  end function half_squares

  pure integer function samples_alive(survey, b, samples) result(alive)
    !! Count the samples at which modes beyond a bin still have phases: until damping leaves e⁻² of a mode; 1 if it does
    !! not oscillate.
    type(mode_survey), intent(in) :: survey
    integer, intent(in) :: b, samples
    alive = samples
    associate (bin => survey%bin(b))
      if (.not. turns(dd(bin%square), bin%damping)) then
        alive = 1
      else if (bin%damping > 0.0_dp) then
        alive = int(min(real(samples, dp), 1.0_dp + 4.0_dp/(bin%damping*survey%stretch%step)))
      end if
    end associate
  end function samples_alive

  pure function block_bins(survey, count) result(bins)
    !! Return the last bins of the blocks, or those in which blocks end.
    type(mode_survey), intent(in) :: survey
    integer, intent(in) :: count
    integer :: bins(3), ends(3), i
    ends = block_ends(count)
    bins = [(findloc(survey%bin(:survey%bins)%last >= ends(i), .true., dim=1), i=1, 3)]
  end function block_bins

  elemental real(dp) function part_of(value, whole) result(part)
    !! Return a ratio, at most 1; 1 for 0/0.
    real(dp), intent(in) :: value, whole
    part = 1.0_dp
    if (value < whole) part = value/whole
  end function part_of

  elemental real(dp) function times_of(value, square) result(times)
    !! Return a value over a root mean square; 0 without motion.
    real(dp), intent(in) :: value, square
    times = 0.0_dp
    if (square > 0.0_dp) times = value/sqrt(square)
  end function times_of

  elemental real(dp) function spread_of_samples(samples) result(spread)
    !! Return the expected largest of N sums of modes with random phases over their root mean square. For small N it is
    !! that of normal deviates; with quadratic phases values above R are as rare as R⁻⁶ (J. Marklof, Limit theorems for
    !! theta sums, 1999).
    integer, intent(in) :: samples
    real(dp), parameter :: of_quadratic = 1.25_dp  ! tuned: the largest of 10³ to 10⁵ sums of 200 to 1000 modes
    spread = max(sqrt(2.0_dp*log(2.0_dp*max(1, samples))), of_quadratic*max(1, samples)**(1.0_dp/6.0_dp))
  end function spread_of_samples

end module bw_truncation_error
