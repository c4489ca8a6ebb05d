module bw_beam_states
  !! Motions e^(st) of a beam of pieces that satisfy the conditions at its far end, for any complex s: imaginary s = iΩ
  !! for harmonic forces, real s without resonances. A state is v, ψ, M and the shear force N.
  !!
  !! The beam beyond a point admits two independent states. Such pairs are propagated along a leg, from the end of the
  !! beam piece by piece: by power series across pieces shorter than their waves, across others by waves that do not
  !! grow away from their start. This avoids both cancellation and growing exponentials. Both legs run towards the
  !! force; the leg of the root is seen from there, with ψ and N reversed.
  !!
  !! Without dimensions, as the beam; without tension.
  use bw_kinds, only: dp
  use bw_lapack, only: zgesv
  use bw_piece_beam, only: beam_joint, beam_root, piece_beam, uniform_piece
  implicit none (type, external)
  private
  public :: propagated, support_states, inertia_at, states_before_joint, lead_from_root, lead_from_tip, mirrored, motion_within, &
    solve, waves_of

  integer, parameter, public :: deflection = 1, turning = 2, moment = 3, shear_force = 4   !! components of a state

  type, public :: inertia_type
    !! Factors of inertia in a motion: β² = −s², with Ω² where rotation acts.
    complex(dp) :: lambda                        !! λ, for deflections
    complex(dp) :: rho                           !! ρ, for rotation of sections
    complex(dp) :: square                        !! β², for rotation of bodies
  end type inertia_type

  type, public :: piece_state
    !! Waves e^(∓κx) of a piece, those that decay outwards first. For v = 1, ψ and N are ∓ and M is ± the stored values.
    complex(dp) :: decay(2)                      !! κ, Re κ ≥ 0
    complex(dp) :: turn(2)                       !! ψ
    complex(dp) :: bend(2)                       !! M
    complex(dp) :: force(2)                      !! N
    complex(dp) :: inertia, rotary               !! mλ, ρI ρ
    real(dp) :: compliance, flexibility          !! 1/(κGA), 1/EI
    real(dp) :: length
  end type piece_state

  type, public :: crossing_type
    !! A piece of a leg, from its far end to its near end.
    type(piece_state) :: piece
    complex(dp) :: far(4, 2)                     !! two states at the far end, with v, ψ equal to 1, 0 and 0, 1 unless it is held
    complex(dp) :: near(4, 2)                    !! two states at the near end
    complex(dp) :: outwards(2, 2)                !! amplitudes of the far pair by those of the near pair
    complex(dp) :: coming(2, 2)                  !! amplitudes of waves starting at the far end by those of the near pair
    complex(dp) :: onwards(2, 2)                 !! amplitudes of the next piece's near pair by those of the far pair
    logical :: short = .false.                   !! shorter than its waves
  end type crossing_type

contains

  pure type(inertia_type) function inertia_at(beam, square, loss) result(inertia)
    !! Return the factors for a motion with β², of a beam with elasticity (1 + `loss`) times its own. Dividing all
    !! inertia by that instead multiplies the response by 1 + `loss`.
    type(piece_beam), intent(in) :: beam
    complex(dp), intent(in) :: square
    complex(dp), intent(in), optional :: loss    !! absent: 0
    real(dp) :: spin
    spin = beam%spin_squared%hi
    inertia%square = square
    inertia%lambda = square + merge(spin, 0.0_dp, beam%in_plane)
    inertia%rho = square + merge(0.0_dp, spin, beam%in_plane)
    if (.not. present(loss)) return
    inertia%square = inertia%square/(1.0_dp + loss)
    inertia%lambda = inertia%lambda/(1.0_dp + loss)
    inertia%rho = inertia%rho/(1.0_dp + loss)
  end function inertia_at

  elemental type(piece_state) function waves_of(piece, inertia) result(waves)
    !! Return the waves e^(κx): Bκ⁴ + (R + smλB)κ² − mλ(1 − sR) = 0, R = ρI ρ; v' = ψ + sN, Bψ' = M, M' = −Rψ − N, N' = −mλv.
    type(uniform_piece), intent(in) :: piece
    type(inertia_type), intent(in) :: inertia
    real(dp), parameter :: least_separation = 1.0e-7_dp     ! relative difference of the two squares, to keep waves independent
    complex(dp) :: root, b, c
    associate (stiffness => piece%stiffness%hi, mass => piece%mass%hi)
      waves%length = piece%length%hi
      waves%compliance = piece%compliance%hi
      waves%flexibility = 1.0_dp/stiffness
      waves%inertia = mass*inertia%lambda
      waves%rotary = piece%rotary%hi*inertia%rho
      b = (waves%rotary + waves%compliance*stiffness*waves%inertia)/stiffness
      c = -waves%inertia*(1.0_dp - waves%compliance*waves%rotary)/stiffness
      root = sqrt(0.25_dp*b**2 - c)
      if (abs(root) < least_separation*abs(b)) root = least_separation*abs(b)
      waves%decay = sqrt([-0.5_dp*b + root, -0.5_dp*b - root])
      waves%force = -waves%inertia/waves%decay
      waves%turn = waves%decay - waves%compliance*waves%force
      waves%bend = stiffness*waves%decay*waves%turn
    end associate
  end function waves_of

  pure subroutine lead_from_tip(beam, from, inertia, leg)
    !! Build the leg of the pieces beyond a joint, outermost last.
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: from                  !! joint; 0 is the root
    type(inertia_type), intent(in) :: inertia
    type(crossing_type), intent(inout) :: leg(:) !! (n − from)
    integer :: i
    do i = size(leg), 1, -1
      if (i == size(leg)) then
        leg(i)%far = states_before_joint(beam%joint(from + i), inertia, support_states(beam_root(.false., .false.)))
      else
        call turn_to_motions(leg(i + 1)%near, leg(i)%far, leg(i)%onwards)
        leg(i)%far = states_before_joint(beam%joint(from + i), inertia, leg(i)%far)
      end if
      leg(i)%piece = waves_of(beam%piece(from + i), inertia)
      call cross(leg(i))
    end do
  end subroutine lead_from_tip

  pure subroutine lead_from_root(beam, to, inertia, leg)
    !! Build the leg of the pieces up to a joint, that of the root last.
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: to                    !! the joint
    type(inertia_type), intent(in) :: inertia
    type(crossing_type), intent(inout) :: leg(:) !! (to)
    integer :: i
    do i = to, 1, -1
      if (i == to) then
        leg(i)%far = support_states(beam%root)
      else
        call turn_to_motions(leg(i + 1)%near, leg(i)%far, leg(i)%onwards)
        leg(i)%far = states_before_joint(beam%joint(to - i), inertia, leg(i)%far)
      end if
      leg(i)%piece = waves_of(beam%piece(to + 1 - i), inertia)
      call cross(leg(i))
    end do
  end subroutine lead_from_root

  pure function support_states(root) result(states)
    !! Return two independent states at an end with given support, as seen towards it.
    type(beam_root), intent(in) :: root
    complex(dp) :: states(4, 2)
    states = 0.0_dp
    states(shear_force, 1) = 1.0_dp
    if (.not. root%holds_deflection) states([1, 4], 1) = [1.0_dp, -root%stiffness%hi]
    states(moment, 2) = 1.0_dp
    if (.not. root%holds_turning) states([2, 3], 2) = [1.0_dp, -root%turning_stiffness%hi]
  end function support_states

  pure function states_before_joint(joint, inertia, beyond) result(before)
    !! Return the states before a joint from those beyond it.
    type(beam_joint), intent(in) :: joint
    type(inertia_type), intent(in) :: inertia
    complex(dp), intent(in) :: beyond(4, 2)
    complex(dp) :: before(4, 2)
    before = beyond
    before(3, :) = beyond(3, :) - (joint%turning_stiffness%hi - joint%inertia%hi*inertia%square)*beyond(2, :)
    before(4, :) = beyond(4, :) - (joint%stiffness%hi - joint%mass%hi*inertia%lambda)*beyond(1, :)
  end function states_before_joint

  pure subroutine turn_to_motions(states, unit, amplitudes)
    !! Replace two states by combinations with v, ψ equal to 1, 0 and 0, 1. What a joint adds to M and N, however large,
    !! then affects one number of each.
    complex(dp), intent(in) :: states(4, 2)
    complex(dp), intent(out) :: unit(4, 2)
    complex(dp), intent(out) :: amplitudes(2, 2)   !! of the two states in each combination
    amplitudes = inverse_of(states(:2, :))
    unit(3:, :) = matmul(states(3:, :), amplitudes)
    unit(:2, :) = reshape([1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [2, 2])
  end subroutine turn_to_motions

  pure function inverse_of(matrix) result(inverse)
    complex(dp), intent(in) :: matrix(2, 2)
    complex(dp) :: inverse(2, 2)
    complex(dp) :: determinant
    determinant = matrix(1, 1)*matrix(2, 2) - matrix(1, 2)*matrix(2, 1)
    inverse = reshape([matrix(2, 2), -matrix(2, 1), -matrix(1, 2), matrix(1, 1)], [2, 2])/determinant
  end function inverse_of

  pure subroutine cross(crossing)
    !! Propagate the states from the far end of a piece to its near end.
    type(crossing_type), intent(inout) :: crossing
    crossing%short = is_short(crossing%piece, crossing%piece%length)
    if (crossing%short) then
      crossing%near = by_powers(crossing%piece, crossing%far, -crossing%piece%length)
      crossing%outwards = reshape([1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [2, 2])
    else
      call by_waves(crossing%piece, crossing%far, crossing%piece%length, crossing%near, crossing%outwards, crossing%coming)
    end if
  end subroutine cross

  pure function propagated(piece, states, way) result(there)
    !! Return combinations of two states at the far end of a piece, propagated by a given distance.
    type(piece_state), intent(in) :: piece
    complex(dp), intent(in) :: states(4, 2)
    real(dp), intent(in) :: way                  !! ≥ 0
    complex(dp) :: there(4, 2)
    complex(dp) :: outwards(2, 2), coming(2, 2)
    if (is_short(piece, way)) then
      there = by_powers(piece, states, -way)
    else
      call by_waves(piece, states, way, there, outwards, coming)
    end if
  end function propagated

  pure logical function is_short(piece, way)
    type(piece_state), intent(in) :: piece
    real(dp), intent(in) :: way
    is_short = maxval(abs(piece%decay))*way < 1.0_dp
  end function is_short

  pure function by_powers(piece, states, way) result(there)
    !! Propagate states by a power series, for |κ| times the distance below 1.
    type(piece_state), intent(in) :: piece
    complex(dp), intent(in) :: states(:, :)
    real(dp), intent(in) :: way
    integer, parameter :: powers = 24            ! powers of less than 1, over factorials
    complex(dp) :: there(4, size(states, 2)), term(4), last(4)
    integer :: i, j
    there = states
    do j = 1, size(states, 2)
      term = states(:, j)
      do i = 1, powers
        last = term*(way/i)
        term(1) = last(2) + piece%compliance*last(4)
        term(2) = piece%flexibility*last(3)
        term(3) = -piece%rotary*last(2) - last(4)
        term(4) = -piece%inertia*last(1)
        there(:, j) = there(:, j) + term
      end do
    end do
  end function by_powers

  pure subroutine by_waves(piece, states, way, there, outwards, coming)
    !! Return combinations of states whose outward waves are 1, 0 and 0, 1 at a given distance.
    type(piece_state), intent(in) :: piece
    complex(dp), intent(in) :: states(4, 2)
    real(dp), intent(in) :: way
    complex(dp), intent(out) :: there(4, 2), outwards(2, 2), coming(2, 2)   !! see crossing_type
    complex(dp) :: even(2, 2), odd(2, 2), left(2), back(2, 2)   ! v, M and ψ, N of both waves together; (waves, states)
    integer :: i, j
    even(1, :) = (piece%bend(2)*states(1, :) - states(3, :))/(piece%bend(2) - piece%bend(1))
    even(2, :) = (states(3, :) - piece%bend(1)*states(1, :))/(piece%bend(2) - piece%bend(1))
    associate (determinant => piece%turn(1)*piece%force(2) - piece%turn(2)*piece%force(1))
      odd(1, :) = (piece%force(2)*states(2, :) - piece%turn(2)*states(4, :))/determinant
      odd(2, :) = (piece%turn(1)*states(4, :) - piece%force(1)*states(2, :))/determinant
    end associate
    left = exp(-piece%decay*way)
    outwards = inverse_of(0.5_dp*(even - odd))
    do j = 1, 2
      outwards(:, j) = outwards(:, j)*left(j)
    end do
    coming = matmul(0.5_dp*(even + odd), outwards)
    do j = 1, 2
      back(:, j) = left*coming(:, j)
      there(:, j) = 0.0_dp
      do i = 1, 2
        associate (out => merge(1.0_dp, 0.0_dp, i == j))
          there(1, j) = there(1, j) + (out + back(i, j))
          there(2, j) = there(2, j) + piece%turn(i)*(back(i, j) - out)
          there(3, j) = there(3, j) + piece%bend(i)*(out + back(i, j))
          there(4, j) = there(4, j) + piece%force(i)*(back(i, j) - out)
        end associate
      end do
    end do
  end subroutine by_waves

  pure complex(dp) function motion_within(crossing, amplitudes, way) result(v)
    !! Return the deflection of a piece at a distance beyond its near end.
    type(crossing_type), intent(in) :: crossing
    complex(dp), intent(in) :: amplitudes(2)     !! of the near pair
    real(dp), intent(in) :: way                  !! 0 … the piece's length
    complex(dp) :: state(4, 1)
    if (crossing%short) then
      state(:, 1) = matmul(crossing%near, amplitudes)
      state = by_powers(crossing%piece, state, way)
      v = state(1, 1)
    else
      associate (piece => crossing%piece)
        v = sum(exp(-piece%decay*way)*amplitudes + exp(-piece%decay*(piece%length - way))*matmul(crossing%coming, amplitudes))
      end associate
    end if
  end function motion_within

  pure function mirrored(states) result(seen)
    !! Return states as seen in the opposite direction.
    complex(dp), intent(in) :: states(4, 2)
    complex(dp) :: seen(4, 2)
    seen = states
    seen([2, 4], :) = -states([2, 4], :)
  end function mirrored

  pure subroutine solve(system, right)
    !! Solve a small system with rows scaled by their largest coefficients.
    complex(dp), intent(inout), contiguous :: system(:, :)   !! overwritten
    complex(dp), intent(inout), contiguous :: right(:)       !! then the solution
    real(dp) :: largest
    integer :: i, info, n, pivot(size(right))
    n = size(right)
    do i = 1, n
      largest = maxval(abs(system(i, :)))
      if (largest <= 0.0_dp) cycle
      system(i, :) = system(i, :)/largest
      right(i) = right(i)/largest
    end do
    call zgesv(n, 1, system, n, pivot, right, n, info)
    if (info /= 0) right = 0.0_dp                ! cannot happen for a beam held by its inertia
  end subroutine solve

end module bw_beam_states
