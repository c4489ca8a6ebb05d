module bw_flexibility
  !! The flexibility of a beam of pieces at an imaginary frequency is, β² = −s², below all resonances: the displacement
  !! of a point under a force there that grows as e^(st). As a modal sum it is ΣΦ_k(ξ)²/(M_k(β_k² + s²)), and so gives
  !! the part of omitted modes. Without tension.
  !! Without dimensions, as the beam.
  !!
  !! **Limit**: pieces are uniform. The flexibility of a tapering beam is at most that of many uniform pieces that are
  !! nowhere stiffer or heavier (`softest` of bw_varying_beam), which gives a bound.
  use bw_beam_states, only: propagated, crossing_type, deflection, inertia_at, inertia_type, lead_from_root, lead_from_tip, &
    mirrored, &
    moment, piece_state, solve, waves_of
  use bw_kinds, only: dp
  use bw_piece_beam, only: piece_beam
  implicit none (type, external)
  private
  public :: mean_square_curvature, mean_square_shape, moment_stiffness, point_flexibility

  type, public :: flexibility_table
    !! Flexibilities of a beam at points, at requested shifts s² = 4ʲ, each computed once.
    real(dp), allocatable :: at(:, :)            !! (points, j); negative: not computed
  contains
    procedure :: cover
  end type flexibility_table

contains

  pure subroutine cover(self, beam, xi, first, last)
    !! Compute missing flexibilities for shifts from 4^first to 4^last.
    class(flexibility_table), intent(inout) :: self   !! of this beam and these points, if not empty
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: xi(:)                !! (points)
    integer, intent(in) :: first, last
    real(dp), parameter :: unknown = -1.0_dp
    real(dp), allocatable :: at(:, :)
    integer :: ends(2), j
    ends = [first, last]
    if (allocated(self%at)) ends = [min(first, lbound(self%at, 2)), max(last, ubound(self%at, 2))]
    if (.not. allocated(self%at)) then
      allocate (self%at(size(xi), first:last), source=unknown)
    else if (ends(1) < lbound(self%at, 2) .or. ends(2) > ubound(self%at, 2)) then
      allocate (at(size(xi), ends(1):ends(2)), source=unknown)
      at(:, lbound(self%at, 2):ubound(self%at, 2)) = self%at
      call move_alloc(at, self%at)
    end if
    do j = first, last
      if (any(self%at(:, j) < 0.0_dp)) self%at(:, j) = point_flexibility(beam, 4.0_dp**j, xi)
    end do
  end subroutine cover

  pure function point_flexibility(beam, shift, xi) result(flexibility)
    !! Return ΣΦ_k(ξ)²/(M_k(β_k² + s²)), the deflection of each point under a force of 1 there, (points).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: shift                !! s² > Ω²
    real(dp), intent(in) :: xi(:)                !! 0 ≤ ξ ≤ 1, (points)
    real(dp) :: flexibility(size(xi))
    flexibility = point_response(beam, shift, xi, [0.0_dp, 0.0_dp, 0.0_dp, -1.0_dp], deflection)
    flexibility = max(0.0_dp, flexibility)       ! rounding at a support
  end function point_flexibility

  pure function moment_stiffness(beam, shift, xi) result(stiffness)
    !! Return s²ΣB²Φ_k''(ξ)²/(M_kβ_k²(β_k² + s²)), the moment at each point due to a kink of 1 there, less the static
    !! one, (points).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: shift, xi(:)         !! see `point_flexibility`
    real(dp) :: stiffness(size(xi))
    stiffness = max(0.0_dp, -point_response(beam, shift, xi, [0.0_dp, 1.0_dp, 0.0_dp, 0.0_dp], moment))
  end function moment_stiffness

  pure function mean_square_shape(beam, frequency, xi) result(mean)
    !! Return the mean of Φ_k(ξ)²/M_k over modes near an angular frequency: the flexibility over Σ1/(β_k² + s²), which
    !! is ¼Σ∫Re κ dx/s² for modes spaced as waves on long pieces, (points).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: frequency            !! s > Ω
    real(dp), intent(in) :: xi(:)                !! (points)
    real(dp) :: mean(size(xi))
    mean = point_flexibility(beam, frequency**2, xi)*(frequency**2/spacing_sum(beam, frequency))
  end function mean_square_shape

  pure function mean_square_curvature(beam, frequency, xi) result(mean)
    !! Return the mean of (BΦ_k''(ξ))²/(M_kβ_k²) likewise, (points).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: frequency, xi(:)     !! see `mean_square_shape`
    real(dp) :: mean(size(xi))
    mean = moment_stiffness(beam, frequency**2, xi)/spacing_sum(beam, frequency)
  end function mean_square_curvature

  pure real(dp) function spacing_sum(beam, frequency) result(sums)
    !! Return s²Σ1/(β_k² + s²).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: frequency
    type(piece_state) :: waves(size(beam%piece))
    integer :: i
    waves = waves_of(beam%piece, inertia_at(beam, cmplx(-frequency**2, 0.0_dp, dp)))
    sums = 0.25_dp*sum([(waves(i)%length*sum(real(waves(i)%decay)), i=1, size(waves))])
  end function spacing_sum

  pure function point_response(beam, shift, xi, jump, seen) result(values)
    !! Return one component of the state at each point for a jump of the state there, (points).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: shift, xi(:), jump(4)
    integer, intent(in) :: seen                  !! component of the state
    real(dp) :: values(size(xi)), inner, outer, ends(size(beam%piece))
    type(crossing_type) :: to_tip(size(beam%piece)), to_root(size(beam%piece))
    type(inertia_type) :: inertia
    complex(dp) :: sides(4, 4), amplitude(4), beyond(4, 2)
    real(dp), parameter :: rounding = 1.0e-12_dp
    integer :: i, n, p
    n = size(beam%piece)
    inertia = inertia_at(beam, cmplx(-shift, 0.0_dp, dp))
    call lead_from_tip(beam, 0, inertia, to_tip)
    call lead_from_root(beam, n, inertia, to_root)
    ends = [(sum(beam%piece(:i)%length%hi), i=1, n)]
    do p = 1, size(xi)
      i = min(count(ends < xi(p)) + 1, n)
      outer = max(0.0_dp, ends(i) - xi(p))
      inner = max(0.0_dp, beam%piece(i)%length%hi - outer)
      beyond = propagated(to_tip(i)%piece, to_tip(i)%far, outer)
      sides(:, :2) = beyond
      sides(:, 3:) = -mirrored(propagated(to_root(n + 1 - i)%piece, to_root(n + 1 - i)%far, inner))
      amplitude = jump
      call solve(sides, amplitude)
      values(p) = real(sum(beyond(seen, :)*amplitude(:2)))
      if (abs(values(p)) <= rounding*sum(abs(beyond(seen, :)*amplitude(:2)))) values(p) = 0.0_dp   ! as M at a free end
    end do
  end function point_response

end module bw_flexibility
