module bw_amplitudes
  !! How far modes that move may carry the points of a beam: the sums that bw_coherence asks for, of amplitudes without phases. Each
  !! mode may stand for many: then neighbours, and what they show, tell of those that are not looked at.
  use bw_coherence, only: deviation_type, observation_type, path_to, path_type
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: add_amplitudes

  real(dp), parameter :: mean = 2.0_dp/acos(-1.0_dp)  !! of |cos|
  integer, parameter, public :: run_length = 16       !! neighbours that stand for others, by default

  type, public :: moving_modes
    !! How some modes move.
    real(dp), allocatable :: reach(:)             !! how far, where the shape is 1, (modes)
    real(dp), allocatable :: alpha(:)             !! wave number times length, (modes)
    real(dp), allocatable :: tip(:)               !! |Φ(ξ₀)|, (modes)
    logical, allocatable :: swings(:)             !! its sign is as good as random, (modes)
    logical, allocatable :: agrees(:)             !! but may be that of all others at once, (modes)
    real(dp) :: struck_at = 1.0_dp                !! ξ₀
    logical :: uniform = .true.                   !! shapes are those of a uniform clamped beam that is struck at its tip
    integer :: root_power = 2                     !! as that of a set
    integer :: run = run_length                   !! of neighbours among them
    real(dp), allocatable :: mass(:)
      !! M_k of modes that stand for others of a beam with several parts; else unallocated, (modes)
  end type moving_modes

contains

  pure subroutine add_amplitudes(moving, shapes, seen, weight, sums)
    !! Add how far modes that move may carry each point over a stretch of the record, one mode after the other.
    type(moving_modes), intent(in) :: moving
    real(dp), intent(in) :: shapes(:, :)          !! (modes, points)
    type(observation_type), intent(in) :: seen
    real(dp), intent(in) :: weight(:)             !! (modes)
    type(deviation_type), intent(inout) :: sums(:)
    type(deviation_type) :: sum                   ! in registers
    type(path_type) :: path
    real(dp), parameter :: at_free_end = 2.0_dp   ! a bound of |Φ(ξ)| of any beam, nearly
    real(dp) :: amplitude, bound, distance, peak
    logical :: slow
    integer :: k, p
    do p = 1, size(sums)
      path = path_to(seen%points(p), moving%struck_at, moving%uniform, 0.0_dp)
      distance = path%distance
      slow = moving%run*min(seen%points(p), 1.0_dp - seen%points(p), distance) < 1.0_dp .and. seen%points(p) < 1.0_dp
      if (.not. moving%uniform) slow = slow .and. seen%points(p) /= moving%struck_at
      sum = sums(p)
      do k = 1, size(moving%reach)
        amplitude = moving%reach(k)*abs(shapes(k, p))
        peak = amplitude
        if (slow .and. weight(k) > 1.0_dp) then
          bound = at_free_end*min(1.0_dp, (moving%alpha(k)*seen%points(p))**moving%root_power)
          if (moving%uniform) bound = largest_shape(seen%points(p), moving%alpha(k), moving%tip(k))
          peak = max(amplitude, moving%reach(k)*bound)
          amplitude = max(amplitude, mean*peak)
        end if
        if (moving%swings(k)) then
          sum%magnitude = sum%magnitude + weight(k)*amplitude
          sum%square = sum%square + weight(k)*amplitude**2
          if (moving%agrees(k)) sum%agreeing = sum%agreeing + weight(k)*amplitude
          if (peak > sum%largest) then
            sum%largest = peak
            sum%alpha = moving%alpha(k)
          end if
          if (2.0_dp*moving%alpha(k)*seen%stretch%end >= distance) then      ! at the group velocity
            sum%passing = max(sum%passing, peak*sqrt(moving%alpha(k)/distance))
          end if
        else
          sum%growing = sum%growing + weight(k)*amplitude
        end if
      end do
      sums(p) = sum
    end do
    if (allocated(moving%mass)) call add_pairs(moving, shapes, sums)
  end subroutine add_amplitudes

  pure subroutine add_pairs(moving, shapes, sums)
    !! Parts of a beam that hardly move each other, as on both sides of a body that turns with difficulty, have modes of their own,
    !! but where two of these have nearly one frequency: there are two that move both parts, each with the half of the product
    !! u(ξ₀)u(ξ) that the parts have by themselves, u = Φ/√M. They are so few that those that are looked at need not show one.
    type(moving_modes), intent(in) :: moving
    real(dp), intent(in) :: shapes(:, :)          !! (modes, points)
    type(deviation_type), intent(inout) :: sums(:)
    real(dp) :: struck
    integer :: p
    struck = maxval(moving%reach*sqrt(moving%mass))
    do p = 1, size(sums)
      sums(p)%paired = sums(p)%paired + struck*maxval(abs(shapes(:, p))/sqrt(max(moving%mass, tiny(struck))))
    end do
  end subroutine add_pairs

  elemental real(dp) function largest_shape(xi, alpha, tip) result(shape)
    !! A bound of |Φ(ξ)| near one end of the beam, where a run of modes does not see how far its shapes go: √2 and what the
    !! end adds, and nearer to the end the first term of Taylor's series.
    real(dp), intent(in) :: xi, alpha
    real(dp), intent(in) :: tip                   !! |Φ(1)|
    if (xi < 0.5_dp) then
      shape = min(1.6_dp, (alpha*xi)**2)
    else
      shape = min(sqrt(2.0_dp) + 0.5_dp*tip, tip + sqrt(2.0_dp)*alpha*(1.0_dp - xi))
    end if
  end function largest_shape

end module bw_amplitudes
