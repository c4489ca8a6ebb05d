module bw_mode_numbering
  !! This module finds which peak is which mode. A ratio R fits many modes, each with its own α; but all modes of a uniform
  !! beam imply the same mass at the tip (Eq. 19), and lie on one curve ν² = c₁ α⁴ + c₀ with c₁ > 0 and c₀ ≤ 0 (Eq. 30,
  !! whatever h and ω). Two strong peaks taken as two modes give a mass and a curve; the peaks that agree with both number
  !! themselves.
  !!
  !! Each agreement is worth the logarithm of how unlikely it is by chance. Peaks are numbered where the best numbering is
  !! worth much, and every other that contradicts it is worth much less.
  use bw_kinds, only: dp
  use bw_line_group, only: resolution
  use bw_line_peaks, only: peak_type
  use bw_mode_curve, only: as_mode, chance_on_curve, chance_of_mass, curve_through, curve_type, mode_type, on_curve, same_mass
  use bw_mode_ratio, only: mode_near
  implicit none (type, external)
  private
  public :: number_modes

  integer, parameter :: most_anchors = 6         !! strongest peaks that are tried as pairs
  integer, parameter :: highest_anchor = 50      !! mode
  real(dp), parameter :: clear_position = 0.3_dp !! bins; peaks with larger errors number nothing
  real(dp), parameter :: clear_ratio = 0.05_dp   !! of the angle whose tangent is R
  real(dp), parameter :: gap_costs = log(10.0_dp)  !! a mode below the highest that has no peak; as many more numberings are tried

  type :: numbering_type
    type(mode_type), allocatable :: modes(:)     !! of each peak
    real(dp) :: worth = 0
  end type numbering_type

  type :: candidates_type
    !! The clear peaks, and what each would be as every mode.
    logical, allocatable :: clear(:)             !! (peak)
    integer, allocatable :: order(:)             !! the clear ones, the strongest first
    type(mode_type), allocatable :: role(:, :)   !! (mode, peak)
    integer :: at_edge = 0                       !! peaks that may be modes but tell nothing
  end type candidates_type

contains

  subroutine number_modes(peaks, possible, chance, modes)
    !! Number the peaks: those that cannot be numbered keep the number 0. A line that stands alone is the first mode, or the first
    !! after those that move without a frequency, if its ratio allows.
    type(peak_type), intent(in) :: peaks(:)
    logical, intent(in) :: possible(:)           !! whether each peak may be a mode, and is not known to be folded or none
    real(dp), intent(in) :: chance               !! that a numbering is taken that agrees with the peaks by chance
    type(mode_type), intent(out) :: modes(:)     !! one for each peak
    type(candidates_type) :: candidates
    type(numbering_type) :: best, other
    logical :: at_zero(size(peaks))
    integer :: pairs
    candidates = candidates_of(peaks, possible)
    best = best_numbering(peaks, candidates)
    at_zero = peaks%at_edge .and. peaks%position < resolution
    pairs = max(1, anchors_of(candidates)*(anchors_of(candidates) - 1)/2)
    if (best%worth >= log(pairs/chance)) then
      other = best_numbering(peaks, candidates, best)
      if (best%worth - other%worth >= -log(chance)) modes = best%modes
    else if (count(possible .and. .not. peaks%at_edge) == 1) then
      where (candidates%clear) modes = as_mode(peaks, 1 + count(possible .and. at_zero))
    end if
  end subroutine number_modes

  function candidates_of(peaks, possible) result(candidates)
    !! The peaks that are known well enough to be numbered, and what each would be as every mode.
    type(peak_type), intent(in) :: peaks(:)
    logical, intent(in) :: possible(:)
    type(candidates_type) :: candidates
    integer :: i, k
    candidates%clear = possible .and. peaks%position_error < clear_position &
      & .and. peaks%ratio_error/hypot(1.0_dp, peaks%ratio) < clear_ratio*hypot(1.0_dp, peaks%ratio)
    candidates%order = descending(pack([(i, i=1, size(peaks))], candidates%clear), peaks%strength)
    candidates%at_edge = count(peaks%at_edge)
    allocate (candidates%role(highest_anchor, size(peaks)))
    do i = 1, size(peaks)
      if (candidates%clear(i)) candidates%role(:, i) = [(as_mode(peaks(i), k), k=1, highest_anchor)]
    end do
  end function candidates_of

  pure function descending(chosen, strength) result(order)
    !! The chosen peaks by falling strength.
    integer, intent(in) :: chosen(:)
    real(dp), intent(in) :: strength(:)          !! of all
    integer :: order(size(chosen)), i, j
    do i = 1, size(chosen)
      j = count(strength(chosen(:i - 1)) >= strength(chosen(i))) + 1
      order(j + 1:i) = order(j:i - 1)
      order(j) = chosen(i)
    end do
  end function descending

  function best_numbering(peaks, candidates, besides) result(best)
    !! The numbering that is worth most, of all or of those that contradict `besides`.
    type(peak_type), intent(in) :: peaks(:)
    type(candidates_type), intent(in) :: candidates
    type(numbering_type), intent(in), optional :: besides
    type(numbering_type) :: best, trial
    integer :: i, j, k, m, anchors
    allocate (best%modes(size(peaks)))
    anchors = anchors_of(candidates)
    do i = 1, anchors
      do j = 1, anchors
        if (peaks(candidates%order(i))%position >= peaks(candidates%order(j))%position) cycle
        associate (low => candidates%role(:, candidates%order(i)), high => candidates%role(:, candidates%order(j)))
          do k = 1, highest_anchor
            if (low(k)%number == 0) cycle
            do m = k + 1, highest_anchor
              if (high(m)%number == 0) cycle
              if (.not. same_mass(low(k), high(m))) cycle
              trial = numbering_by(low(k), high(m), peaks, candidates)
              if (trial%worth <= best%worth) cycle
              if (present(besides)) then
                if (agree(trial, besides)) cycle
              end if
              best = trial
            end do
          end do
        end associate
      end do
    end do
  end function best_numbering

  pure integer function anchors_of(candidates)
    !! How many of the strongest clear peaks are tried in pairs.
    type(candidates_type), intent(in) :: candidates
    anchors_of = min(most_anchors, size(candidates%order))
  end function anchors_of

  pure logical function agree(one, other)
    !! Whether two numberings have peaks in common, enough for a curve, and number all of these alike.
    type(numbering_type), intent(in) :: one, other
    logical :: common(size(one%modes))
    common = one%modes%number > 0 .and. other%modes%number > 0
    agree = count(common) > 1 .and. all(one%modes%number == other%modes%number .or. .not. common)
  end function agree

  function numbering_by(low, high, peaks, candidates) result(numbering)
    !! The numbering that two peaks as two modes make of all others, the strongest first: each number is given once. It is worth
    !! nothing where more modes below the highest have no peak than have one.
    type(mode_type), intent(in) :: low, high
    type(peak_type), intent(in) :: peaks(:)
    type(candidates_type), intent(in) :: candidates
    type(numbering_type) :: numbering
    type(curve_type) :: curve
    type(mode_type) :: mode
    logical :: possible
    integer :: i, gaps
    allocate (numbering%modes(size(peaks)))
    call curve_through(low, high, curve, possible)
    if (.not. possible) return
    do i = 1, size(candidates%order)
      associate (peak => candidates%order(i))
        mode = role_on(curve, peaks(peak), candidates%role(:, peak))
        if (mode%number == 0 .or. any(numbering%modes%number == mode%number)) cycle
        if (.not. (on_curve(mode, curve) .and. same_mass(mode, low) .and. same_mass(mode, high))) cycle
        numbering%modes(peak) = mode
        if (mode%number /= low%number) numbering%worth = numbering%worth - log(chance_of_mass(mode, curve))
        if (all(mode%number /= [low%number, high%number])) numbering%worth = numbering%worth - log(chance_on_curve(mode, curve))
      end associate
    end do
    associate (number => numbering%modes%number)
      gaps = max(0, maxval(number) - count(number > 0) - candidates%at_edge)  ! a mode may grow, or hide at 0
      numbering%worth = merge(numbering%worth - gaps*gap_costs, 0.0_dp, gaps <= count(number > 0))
    end associate
  end function numbering_by

  pure type(mode_type) function role_on(curve, peak, role) result(mode)
    !! The peak as the mode that its frequency asks for.
    type(curve_type), intent(in) :: curve
    type(peak_type), intent(in) :: peak
    type(mode_type), intent(in) :: role(:)       !! the peak as each of the first modes
    integer :: k
    k = mode_near(sqrt(sqrt(max(0.0_dp, (peak%position**2 - curve%start)/curve%slope))))
    if (k <= size(role)) then
      mode = role(k)
    else
      mode = as_mode(peak, k)
    end if
  end function role_on

end module bw_mode_numbering
