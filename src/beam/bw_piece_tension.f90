module bw_piece_tension
  !! The tension that rotation brings into a beam of pieces: T(ξ) = Ω²[∫ρA(R + ξ)dξ + Σm_b(R + ξ_b)] over all that is beyond ξ.
  !! It jumps at bodies and is quadratic in each piece.
  use bw_double_double, only: to_quad
  use bw_kinds, only: dp, qp
  use bw_piece_beam, only: joint_position, piece_beam
  implicit none (type, external)
  private
  public :: tension_in_pieces

contains

  pure function tension_in_pieces(beam, hub_radius) result(tension)
    !! T/Ω² = t_0 + t_1x + t_2x² in each piece, x from 0 to 1 over it.
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: hub_radius             !! R in l
    real(dp) :: tension(3, size(beam%piece))
    real(qp) :: outer, inner, beyond, length, mass
    integer :: i
    beyond = 0.0_qp
    do i = size(beam%piece), 1, -1
      outer = hub_radius + to_quad(joint_position(beam, i))
      inner = hub_radius + to_quad(joint_position(beam, i - 1))
      length = to_quad(beam%piece(i)%length)
      mass = to_quad(beam%piece(i)%mass)*length
      beyond = beyond + to_quad(beam%joint(i)%mass)*outer
      tension(3, i) = real(-0.5_qp*mass*length, dp)
      tension(2, i) = real(-mass*inner, dp)
      beyond = beyond + mass*0.5_qp*(inner + outer)
      tension(1, i) = real(beyond, dp)
    end do
  end function tension_in_pieces

end module bw_piece_tension
