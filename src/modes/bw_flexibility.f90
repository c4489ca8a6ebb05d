module bw_flexibility
  !! How far a point of a beam of pieces gives to a force there that grows as e^(st): its flexibility at the imaginary frequency
  !! is, β² = −s², where no mode is in the way. As a sum over all modes it is ΣΦ_k(ξ)²/(M_k(β_k² + s²)), so that it tells what
  !! modes that are not summed add to it. Without tension.
  !!
  !! What lies beyond a point leaves it two independent states, and so does what lies between it and the root. Pairs of such states
  !! are carried from joint to joint: across a piece that is shorter than its waves by the powers of its length, across others by
  !! waves that decay from where they start, so that neither differences of nearly equal numbers appear nor exponentials that
  !! grow. Without dimensions, as the beam.
  !!
  !! **Limit**: pieces are uniform. Of a beam that tapers the flexibility is at most that of many uniform pieces which are nowhere
  !! stiffer or heavier (`softest` of bw_varying_beam), so that a bound follows from these.
  use bw_kinds, only: dp
  use bw_lapack, only: zgesv
  use bw_piece_beam, only: beam_joint, beam_root, piece_beam, uniform_piece
  implicit none (type, external)
  private
  public :: mean_square_curvature, mean_square_shape, moment_stiffness, point_flexibility

  type, public :: flexibility_table
    !! Flexibilities of a beam at points, at the shifts s² = 4ʲ that somebody has asked for: each is found once.
    real(dp), allocatable :: at(:, :)            !! (points, j)
  contains
    procedure :: cover
  end type flexibility_table

  type :: flexible_piece
    !! Two waves that decay outwards, and two that decay inwards; a state is v, ψ, M and shear force.
    complex(dp) :: decay(2)                      !! κ, Re κ > 0
    complex(dp) :: state(4, 4)                   !! of each wave where it is 1
    real(dp) :: slope(4, 4)                      !! derivative along the piece of a state, of the state
    complex(dp) :: from_tip(4, 2)                !! two states at the outer end, as the tip allows them
    complex(dp) :: from_root(4, 2)               !! two at the inner end, as the root does
    real(dp) :: length
  end type flexible_piece

contains

  pure subroutine cover(self, beam, xi, first, last)
    !! Find what is not there of the shifts from 4^first to 4^last, and between them and those that are.
    class(flexibility_table), intent(inout) :: self   !! of this beam and these points, if it has any
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: xi(:)                !! (points)
    integer, intent(in) :: first, last
    real(dp), allocatable :: at(:, :)
    integer :: ends(2), known(2), j
    known = [first, first - 1]
    if (allocated(self%at)) known = [lbound(self%at, 2), ubound(self%at, 2)]
    if (known(1) <= first .and. known(2) >= last) return
    ends = [min(first, known(1)), max(last, known(2))]
    allocate (at(size(xi), ends(1):ends(2)))
    if (allocated(self%at)) at(:, known(1):known(2)) = self%at
    do j = ends(1), ends(2)
      if (j < known(1) .or. j > known(2)) at(:, j) = point_flexibility(beam, 4.0_dp**j, xi)
    end do
    call move_alloc(at, self%at)
  end subroutine cover

  pure function point_flexibility(beam, shift, xi) result(flexibility)
    !! ΣΦ_k(ξ)²/(M_k(β_k² + s²)): the deflection of each point under a force of 1 there, (points).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: shift                !! s² > Ω²
    real(dp), intent(in) :: xi(:)                !! 0 ≤ ξ ≤ 1, (points)
    real(dp) :: flexibility(size(xi))
    flexibility = max(0.0_dp, point_response(beam, shift, xi, [0.0_dp, 0.0_dp, 0.0_dp, -1.0_dp], 1))   ! of what is held, rounding
  end function point_flexibility

  pure function moment_stiffness(beam, shift, xi) result(stiffness)
    !! s²ΣB²Φ_k''(ξ)²/(M_kβ_k²(β_k² + s²)): the moment at each point that a kink of 1 there takes beyond the static one, (points).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: shift, xi(:)         !! as those of `point_flexibility`
    real(dp) :: stiffness(size(xi))
    stiffness = max(0.0_dp, -point_response(beam, shift, xi, [0.0_dp, 1.0_dp, 0.0_dp, 0.0_dp], 3))
  end function moment_stiffness

  pure function mean_square_shape(beam, frequency, xi) result(mean)
    !! The mean of Φ_k(ξ)²/M_k over modes about an angular frequency: the flexibility there over Σ1/(β_k² + s²), which modes that are
    !! spaced as waves on long pieces make ¼Σ∫Re κ dx/s², (points).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: frequency            !! s > Ω
    real(dp), intent(in) :: xi(:)                !! (points)
    real(dp) :: mean(size(xi))
    mean = point_flexibility(beam, frequency**2, xi)*(frequency**2/spacing_sum(beam, frequency))
  end function mean_square_shape

  pure function mean_square_curvature(beam, frequency, xi) result(mean)
    !! The same of (BΦ_k''(ξ))²/(M_kβ_k²), (points).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: frequency, xi(:)     !! as those of `mean_square_shape`
    real(dp) :: mean(size(xi))
    mean = moment_stiffness(beam, frequency**2, xi)/spacing_sum(beam, frequency)
  end function mean_square_curvature

  pure real(dp) function spacing_sum(beam, frequency) result(sums)
    !! s²Σ1/(β_k² + s²).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: frequency
    type(flexible_piece) :: waves(size(beam%piece))
    integer :: i
    call find_waves(beam, frequency**2, waves)
    sums = 0.25_dp*sum([(waves(i)%length*sum(real(waves(i)%decay)), i=1, size(waves))])
  end function spacing_sum

  pure function point_response(beam, shift, xi, jump, seen) result(values)
    !! One component of the state at each point, where the state jumps there from the inner side to the outer one, (points).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: shift, xi(:), jump(4)
    integer, intent(in) :: seen                  !! 1 … 4: v, ψ, M or the shear force
    real(dp) :: values(size(xi)), inner, outer, ends(size(beam%piece))
    type(flexible_piece) :: waves(size(beam%piece))
    complex(dp) :: sides(4, 4), amplitude(4, 1), beyond(4, 2)
    real(dp), parameter :: rounding = 1.0e-12_dp
    integer :: i, p
    call find_waves(beam, shift, waves)
    ends = [(sum(waves(:i)%length), i=1, size(ends))]
    do p = 1, size(xi)
      i = min(count(ends < xi(p)) + 1, size(ends))
      outer = max(0.0_dp, ends(i) - xi(p))
      inner = max(0.0_dp, waves(i)%length - outer)
      beyond = across(waves(i), waves(i)%from_tip, -outer)
      sides(:, :2) = beyond
      sides(:, 3:) = -across(waves(i), waves(i)%from_root, inner)
      amplitude(:, 1) = cmplx(jump, 0.0_dp, dp)
      call solve(sides, amplitude)
      values(p) = real(sum(beyond(seen, :)*amplitude(:2, 1)))
      if (abs(values(p)) <= rounding*sum(abs(beyond(seen, :)*amplitude(:2, 1)))) values(p) = 0.0_dp   ! as M at a free end
    end do
  end function point_response

  pure subroutine find_waves(beam, shift, waves)
    !! The waves of every piece, and what comes back to its ends.
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: shift
    type(flexible_piece), intent(out) :: waves(:)
    complex(dp), parameter :: unit(4, 2) = reshape([1.0_dp, 0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp, 0.0_dp, 0.0_dp], [4, 2])
    real(dp) :: lambda, rho
    integer :: i, n
    n = size(waves)
    lambda = -shift
    rho = -shift
    if (beam%in_plane) then
      lambda = lambda + beam%spin_squared%hi
    else
      rho = rho + beam%spin_squared%hi
    end if
    do i = 1, n
      call find_pairs(beam%piece(i), lambda, rho, waves(i))
    end do
    waves(n)%from_tip = joined(beam%joint(n), lambda, -shift, unit, -1.0_dp)
    do i = n - 1, 1, -1
      waves(i)%from_tip = joined(beam%joint(i), lambda, -shift, &
                                 unit_motions(across(waves(i + 1), waves(i + 1)%from_tip, -waves(i + 1)%length)), -1.0_dp)
    end do
    waves(1)%from_root = held(beam%root)
    do i = 2, n
      waves(i)%from_root = joined(beam%joint(i - 1), lambda, -shift, &
                                  unit_motions(across(waves(i - 1), waves(i - 1)%from_root, waves(i - 1)%length)))
    end do
  end subroutine find_waves

  pure subroutine find_pairs(piece, lambda, rho, waves)
    !! e^(κx): Bκ⁴ + (R + smλB)κ² − mλ(1 − sR) = 0, R = ρI ρ; v' = ψ + sN, Bψ' = M, M' = −Rψ − N, N' = −mλv.
    type(uniform_piece), intent(in) :: piece
    real(dp), intent(in) :: lambda, rho
    type(flexible_piece), intent(inout) :: waves
    real(dp), parameter :: apart = 1.0e-7_dp     ! of the two squares, so that waves are independent
    complex(dp) :: root, kappa(4), force(4), turn(4)
    real(dp) :: b, c
    associate (stiffness => piece%stiffness%hi, mass => piece%mass%hi, compliance => piece%compliance%hi)
      b = (piece%rotary%hi*rho + compliance*mass*lambda*stiffness)/stiffness
      c = -mass*lambda*(1.0_dp - compliance*piece%rotary%hi*rho)/stiffness
      root = sqrt(cmplx(0.25_dp*b**2 - c, 0.0_dp, dp))
      if (abs(root) < apart*abs(b)) root = apart*abs(b)
      waves%decay = sqrt([-0.5_dp*b + root, -0.5_dp*b - root])
      kappa = [-waves%decay, waves%decay]
      force = -mass*lambda/kappa
      turn = kappa - compliance*force
      waves%state(1, :) = 1.0_dp
      waves%state(2, :) = turn
      waves%state(3, :) = stiffness*kappa*turn
      waves%state(4, :) = force
      waves%slope = 0.0_dp
      waves%slope(1, 2) = 1.0_dp
      waves%slope(1, 4) = compliance
      waves%slope(2, 3) = 1.0_dp/stiffness
      waves%slope(3, 2) = -piece%rotary%hi*rho
      waves%slope(3, 4) = -1.0_dp
      waves%slope(4, 1) = -mass*lambda
    end associate
    waves%length = piece%length%hi
  end subroutine find_pairs

  pure function joined(joint, lambda, square, inner, sign) result(outer)
    !! States beyond a joint from those before it; with sign −1 the other way.
    type(beam_joint), intent(in) :: joint
    real(dp), intent(in) :: lambda, square       !! λ and β²
    complex(dp), intent(in) :: inner(:, :)       !! (4, any)
    real(dp), intent(in), optional :: sign       !! absent: 1
    complex(dp) :: outer(4, size(inner, 2))
    real(dp) :: way
    way = 1.0_dp
    if (present(sign)) way = sign
    outer = inner
    outer(3, :) = inner(3, :) + way*(joint%turning_stiffness%hi - joint%inertia%hi*square)*inner(2, :)
    outer(4, :) = inner(4, :) + way*(joint%stiffness%hi - joint%mass%hi*lambda)*inner(1, :)
  end function joined

  pure function unit_motions(states) result(unit)
    !! Two states with their combinations in their place of which v, ψ are 1, 0 and 0, 1: what a joint adds to M and the shear force,
    !! however much, then stands in one number of each.
    complex(dp), intent(in) :: states(4, 2)
    complex(dp) :: unit(4, 2), motions(2, 2), turned(2, 4)
    motions = transpose(states(:2, :))
    turned = transpose(states)
    call solve(motions, turned)
    unit = transpose(turned)
    unit(:2, :) = reshape([1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [2, 2])   ! to the last digit
  end function unit_motions

  pure function held(root) result(states)
    !! Two independent states that a root allows.
    type(beam_root), intent(in) :: root
    complex(dp) :: states(4, 2)
    states = 0.0_dp
    states(4, 1) = 1.0_dp
    if (.not. root%holds_deflection) states([1, 4], 1) = [1.0_dp, root%stiffness%hi]
    states(3, 2) = 1.0_dp
    if (.not. root%holds_turning) states([2, 3], 2) = [1.0_dp, root%turning_stiffness%hi]
  end function held

  pure function across(waves, states, way) result(there)
    !! Two states of a piece, seen from a place that lies so far outwards, or inwards where the way is negative.
    type(flexible_piece), intent(in) :: waves
    complex(dp), intent(in) :: states(4, 2)
    real(dp), intent(in) :: way
    integer, parameter :: powers = 24            !! of less than 1, over their factorials
    complex(dp) :: there(4, 2), term(4, 2), amplitude(4, 2), system(4, 4), going(2, 2), coming(2, 2), left(2)
    integer :: i, from, to
    there = states
    if (maxval(abs(waves%decay))*abs(way) < 1.0_dp) then
      term = states
      do i = 1, powers
        term = matmul(waves%slope, term)*(way/i)
        there = there + term
      end do
      return
    end if
    from = merge(1, 3, way < 0.0_dp)             ! the first of the two waves that decay towards where the states are
    to = 4 - from
    system = waves%state
    amplitude = states
    call solve(system, amplitude)
    going = transpose(amplitude(from:from + 1, :))
    coming = transpose(amplitude(to:to + 1, :))
    call solve(going, coming)
    left = exp(-waves%decay*abs(way))
    coming = spread(left, 2, 2)*transpose(coming)*spread(left, 1, 2)
    there = waves%state(:, from:from + 1) + matmul(waves%state(:, to:to + 1), coming)
  end function across

  pure subroutine solve(system, right)
    !! Solve a few equations, each over its largest coefficient.
    complex(dp), intent(inout), contiguous :: system(:, :)   !! overwritten
    complex(dp), intent(inout), contiguous :: right(:, :)    !! then the solution
    real(dp) :: largest
    integer :: i, info, n, pivot(size(right, 1))
    n = size(system, 1)
    do i = 1, n
      largest = maxval(abs(system(i, :)))
      if (largest <= 0.0_dp) cycle
      system(i, :) = system(i, :)/largest
      right(i, :) = right(i, :)/largest
    end do
    call zgesv(n, size(right, 2), system, n, pivot, right, n, info)
    if (info /= 0) right = 0.0_dp                ! no beam that is held by its inertia has such equations
  end subroutine solve

end module bw_flexibility
