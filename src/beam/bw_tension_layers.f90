module bw_tension_layers
  !! Separate pieces for thin layers to which strong tension confines bending.
  !!
  !! At supports, rotational loads and steps, bending decays as e^(−x/δ) with δ = √(B(1 + sT)/T), and where T rises from
  !! 0 with slope T' as an Airy function of x/δ with δ = (B/T')^⅓. Polynomials over a whole piece of length L need
  !! several √(L/δ) to resolve that; over a piece of 20δ a few tens suffice for any tension.
  use bw_double_double, only: dd, to_dd, operator(-)
  use bw_kinds, only: dp
  use bw_piece_beam, only: beam_joint, piece_beam, uniform_piece
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: cut_layers

  real(dp), parameter :: depth = 20.0_dp           !! length of a layer's piece in δ: bending beyond it is 2e-9
  real(dp), parameter :: thin = 0.05_dp            !! thickest layer over the piece that gets its own piece
  real(dp), parameter, public :: most_layers = depth/thin    !! longest piece in δ without separate layers

contains

  pure subroutine cut_layers(beam, pulled, joint)
    !! Cut thin layers off the ends of the pieces of a beam.
    type(piece_beam), intent(inout) :: beam
    type(varying_beam), intent(in) :: pulled       !! the same pieces with their tension
    integer, intent(inout) :: joint                !! number of a joint, updated
    type(piece_beam) :: whole
    type(dd) :: part(3)
    real(dp) :: layer(2)
    integer :: i, j, parts, kept
    whole = beam
    kept = joint
    beam%piece = [uniform_piece ::]
    beam%joint = [beam_joint ::]
    do i = 1, size(whole%piece)
      layer = depth*widths_of(pulled, i)
      call cut_piece(whole%piece(i)%length, layer, part, parts)
      do j = 1, parts
        beam%piece = [beam%piece, whole%piece(i)]
        beam%piece(size(beam%piece))%length = part(j)
        beam%joint = [beam%joint, beam_joint()]
      end do
      beam%joint(size(beam%joint)) = whole%joint(i)
      if (i == kept) joint = size(beam%joint)
    end do
  end subroutine cut_layers

  pure subroutine cut_piece(length, layer, part, parts)
    !! Return the lengths of the parts of a piece, which add to its own.
    type(dd), intent(in) :: length
    real(dp), intent(in) :: layer(2)               !! at the inner and the outer end
    type(dd), intent(out) :: part(3)               !! the first `parts` of them
    integer, intent(out) :: parts
    type(dd) :: rest
    rest = length
    parts = 1
    if (layer(1) < thin*length%hi) then
      part(1) = to_dd(layer(1))
      rest = rest - part(1)
      parts = 2
    end if
    part(parts) = rest
    if (.not. layer(2) < thin*length%hi) return
    part(parts + 1) = to_dd(layer(2))
    part(parts) = rest - part(parts + 1)
    parts = parts + 1
  end subroutine cut_piece

  pure function widths_of(pulled, i) result(width)
    !! Return δ at the inner and the outer end of a piece, in l; at most 1.
    type(varying_beam), intent(in) :: pulled
    integer, intent(in) :: i                       !! the piece
    real(dp) :: width(2), pull(2), rise(2), stiffness(2), compliance(2)
    real(dp), allocatable :: tension(:)            ! T as a polynomial in x from 0 to 1
    integer :: k
    tension = pulled%beam%spin_squared%hi*pulled%tension(i)
    associate (piece => pulled%beam%piece(i), law => pulled%law(i))
      pull = [tension(1), max(0.0_dp, sum(tension))]
      rise = abs([tension(2), sum([(k*tension(k + 1), k=1, size(tension) - 1)])])/piece%length%hi
      stiffness = piece%stiffness%hi*[1.0_dp, sum(law%stiffness)]
      compliance = piece%compliance%hi/[1.0_dp, sum(law%shear)]
    end associate
    width = 1.0_dp/max(sqrt(pull/stiffness/(1.0_dp + compliance*pull)), (rise/stiffness)**(1.0_dp/3.0_dp), 1.0_dp)
  end function widths_of

end module bw_tension_layers
