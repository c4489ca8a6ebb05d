module bw_mode_count
  !! The number of modes of a beam below a frequency (Wittrick and Williams 1971, doi:10.1093/qjmam/24.3.263).
  !!
  !! All joints are held, the modes of the pieces are counted, and joints are released in order from the root: each adds
  !! the number of negative eigenvalues of its dynamic stiffness S + L, with S of the beam inwards and L of attachments
  !! and the next piece. S is never formed: the inner part admits two motions D with forces F = SD, and S + L has as
  !! many negative eigenvalues as DᵀF + DᵀLD, whose elements stay moderate where S has a pole or little stiffness.
  use bw_joint_elimination, only: elimination, joint_loads
  use bw_kinds, only: dp
  use bw_piece_beam, only: beam_root
  use bw_piece_ends, only: inner_stiffness, piece_ends
  implicit none (type, external)
  private
  public :: modes_below

contains

  pure subroutine modes_below(root, loads, ends, factors, number, regular)
    type(beam_root), intent(in) :: root
    type(joint_loads), intent(in) :: loads(0:)   !! (0:n)
    type(piece_ends), intent(in) :: ends(:)      !! (n)
    type(elimination), intent(in) :: factors     !! of this frequency
    integer, intent(out) :: number
    real(dp), intent(out) :: regular             !! below 1e-3 a piece is too close to one of its clamped modes and should be cut
    real(dp) :: d(2, 2), f(2, 2), k(2, 2), own
    integer :: clamped, i
    call inner_stiffness(ends(1), k, number, regular)
    call root_motions(root, loads(0), d, f)
    number = number + negatives(d, f, k)
    do i = 1, size(ends)
      d = factors%state(1:2, :, i)
      f = factors%state([4, 3], :, i)
      k = 0.0_dp
      if (i < size(ends)) then
        call inner_stiffness(ends(i + 1), k, clamped, own)
        number = number + clamped
        regular = min(regular, own)
      end if
      k(1, 1) = k(1, 1) + loads(i)%deflection
      k(2, 2) = k(2, 2) + loads(i)%turning
      number = number + negatives(d, f, k)
    end do
  end subroutine modes_below

  pure subroutine root_motions(root, load, d, f)
    !! Find deflection and rotation that the root admits, and the forces of its springs.
    type(beam_root), intent(in) :: root
    type(joint_loads), intent(in) :: load
    real(dp), intent(out) :: d(2, 2), f(2, 2)
    d = 0.0_dp
    f = 0.0_dp
    if (.not. root%holds_deflection) d(1, 1) = 1.0_dp
    if (.not. root%holds_turning) d(2, 2) = 1.0_dp
    f(1, 1) = load%deflection*d(1, 1)
    f(2, 2) = load%turning*d(2, 2)
  end subroutine root_motions

  pure integer function negatives(deflections, forces, load) result(number)
    !! Count the negative eigenvalues of DᵀF + DᵀLD. The motions are combined so that only one moves the stiffer
    !! direction of L; a stiff spring then does not hide the other.
    real(dp), intent(in) :: deflections(2, 2), forces(2, 2)   !! (v and ψ, motion), (N and M, motion)
    real(dp), intent(in) :: load(2, 2)
    real(dp) :: d(2, 2), f(2, 2), q11, q12, q22, ratio
    integer :: held
    d = deflections
    f = forces
    held = merge(1, 2, abs(load(1, 1))*(d(1, 1)**2 + d(1, 2)**2) >= abs(load(2, 2))*(d(2, 1)**2 + d(2, 2)**2))
    if (abs(d(held, 2)) > abs(d(held, 1))) then
      d = d(:, [2, 1])
      f = f(:, [2, 1])
    end if
    if (d(held, 1) /= 0.0_dp) then
      ratio = d(held, 2)/d(held, 1)
      d(:, 2) = d(:, 2) - ratio*d(:, 1)
      f(:, 2) = f(:, 2) - ratio*f(:, 1)
      d(held, 2) = 0.0_dp
    end if
    q11 = sum(d(:, 1)*(f(:, 1) + load(:, 1)*d(1, 1) + load(:, 2)*d(2, 1)))
    q22 = sum(d(:, 2)*(f(:, 2) + load(:, 1)*d(1, 2) + load(:, 2)*d(2, 2)))
    q12 = 0.5_dp*(sum(d(:, 1)*f(:, 2)) + sum(d(:, 2)*f(:, 1))) + sum(d(:, 1)*(load(:, 1)*d(1, 2) + load(:, 2)*d(2, 2)))
    number = negative_pivots(q11, q12, q22)
  end function negatives

  elemental integer function negative_pivots(q11, q12, q22) result(number)
    !! Count the negative eigenvalues of a symmetric matrix of order 2.
    real(dp), intent(in) :: q11, q12, q22
    real(dp) :: det
    det = q11*q22 - q12**2
    number = 0
    if (det < 0.0_dp) then
      number = 1
    else if (q11 + q22 < 0.0_dp) then
      number = merge(2, 1, det > 0.0_dp)
    end if
  end function negative_pivots

end module bw_mode_count
