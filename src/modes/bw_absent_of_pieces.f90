module bw_absent_of_pieces
  !! First-order shifts of β² of a beam of pieces: by tension ∫Tv'²/M, by shear and rotary inertia (−∫sN² − β²∫ρIv'²)/M with the
  !! shear force N, integrals over shapes without these effects. And the relative increase of M by Coriolis stretch:
  !! 4Ω²∫S²/(EA)/M, with the momentum S of all beyond a place: N and the forces of springs beyond, over Λ = β² + Ω².
  use bw_beam_units, only: beam_units, units_of
  use bw_constants, only: pi
  use bw_double_double, only: to_dd
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_piece_beam, only: cut_all, piece_beam, uniform_piece
  use bw_piece_set, only: piece_set
  use bw_piece_shape, only: states_inside
  use bw_piece_source, only: piece_source, source_of_pieces
  use bw_piece_waves, only: frequency_at, parts_at_rest, piece_frequency, piece_numbers
  use bw_scene, only: scene_type
  use bw_scene_pieces, only: in_uniform_parts, pieces_of, struck_beam
  use bw_shear_par, only: usual_shear
  use bw_varying_beam, only: tension_in_pieces
  implicit none (type, external)
  private
  public :: place_shifts, shifts_of_pieces

  integer, parameter, public :: highest_estimated = 1000   !! mode; higher shapes would need too many points
  real(dp), parameter :: pinned = 1.0e12_dp    !! mass over that of the beam; heavier ones do not move either

contains

  subroutine shifts_of_pieces(scene, number, square, tension, shear, stretch, place)
    !! Find β² of the beam without either effect, its shifts by each, (modes), and that of moving a captured mass
    !! inwards (`place_shifts`). Rotation and shear are those of the scene, or hub radius 0 and usual shear by default.
    type(scene_type), intent(in) :: scene                  !! without sweeps
    integer, intent(in) :: number(:)                       !! of the modes, ascending, ≤ `highest_estimated`
    real(dp), intent(out) :: square(:), tension(:), shear(:), stretch(:), place(:)
    type(scene_type) :: plain, sheared
    type(beam_units) :: units
    type(piece_source) :: source
    type(struck_beam) :: pieces
    type(piece_beam) :: full
    class(mode_set), allocatable :: modes
    real(dp) :: hub
    plain = scene
    if (allocated(plain%impact)) then
      if (plain%impact%mass_ratio > pinned) then
        plain%impact%mass_ratio = pinned
        plain%impact%mass_ratio_low = 0.0_dp
      end if
    end if
    if (allocated(plain%shear)) deallocate (plain%shear)
    if (allocated(plain%stiffening)) deallocate (plain%stiffening)
    sheared = plain
    sheared%shear = usual_shear()
    if (allocated(scene%shear)) sheared%shear = scene%shear
    units = units_of(scene%beam)
    hub = 0.0_dp
    if (allocated(scene%stiffening)) hub = scene%stiffening%hub_radius/units%length
    pieces = pieces_of(plain, units, allocated(scene%capture))
    call in_uniform_parts(pieces)
    source = source_of_pieces(pieces)
    pieces = pieces_of(sheared, units, allocated(scene%capture))
    call in_uniform_parts(pieces)
    full = pieces%beam
    tension = 0.0_dp
    shear = 0.0_dp
    stretch = 0.0_dp
    place = 0.0_dp
    call source%find(number, modes)
    square = modes%beta_squared%hi
    if (.not. modes%resolved) return
    select type (modes)
    type is (piece_set)
      if (size(modes%modes%system%piece) > size(full%piece)) full = cut_all(full, parts_at_rest(source%pieces%beam))
      call add_integrals(modes, full, full%spin_squared%hi*tension_in_pieces(full, hub), tension, shear, stretch)
      place = place_shifts(modes, source%gamma)
    end select
  end subroutine shifts_of_pieces

  pure function place_shifts(modes, gamma) result(shifts)
    !! Return the increase of β² per length of the beam by which a captured body moves inwards: (Λγ(Φ²)' + β²J(Ψ²)')/M
    !! at its place, Ψ' the mean of both sides. Moments elsewhere are those of the inner piece.
    type(piece_set), intent(in) :: modes
    real(dp), intent(in) :: gamma                          !! mass of the body; 0: none
    real(dp) :: shifts(modes%count)
    real(dp), dimension(modes%count) :: curvature, square
    real(dp) :: state(4, modes%count, 1)
    shifts = 0.0_dp
    if (gamma == 0.0_dp) return
    square = modes%beta_squared%hi
    associate (turning => modes%modes%turning(modes%struck_joint, :), inertia => modes%body_inertia)
      shifts = modes%modes%lambda%hi*gamma*2.0_dp*modes%struck*turning
      if (inertia > 0.0_dp) then
        state = modes%states(1, modes%count, [modes%struck_at])
        curvature = (state(3, :, 1) - 0.5_dp*square*inertia*turning) &
          /modes%modes%system%piece(modes%struck_joint)%stiffness%hi
        shifts = shifts + square*inertia*2.0_dp*turning*curvature
      end if
    end associate
    shifts = shifts/modes%modal_mass
  end function place_shifts

  subroutine add_integrals(modes, full, pull, tension, shear, stretch)
    !! Add the integrals by the midpoint rule, with several points in each half wave of a mode.
    type(piece_set), intent(in) :: modes
    type(piece_beam), intent(in) :: full                   !! pieces of the modes, with compliance and rotary inertia
    real(dp), intent(in) :: pull(:, :)                     !! T = t_0 + t_1x + t_2x² in each piece, (3, pieces)
    real(dp), intent(out) :: tension(:), shear(:), stretch(:)
    integer, parameter :: fewest = 16, of_half_wave = 12   ! points
    real(dp), dimension(modes%count) :: taken, elastic
    type(piece_frequency) :: frequency
    real(dp) :: both, held, beyond             ! forces of springs further out; shear force beyond a joint
    integer :: i, k, points
    tension = 0.0_dp
    taken = 0.0_dp
    stretch = 0.0_dp
    held = 0.0_dp
    both = sum(full%piece%length%hi*full%piece%compliance%hi*full%piece%rotary%hi)
    elastic = max(tiny(1.0_dp), modes%modes%lambda%hi)
    do k = 1, modes%count
      frequency = frequency_at(modes%modes%system%beam, modes%modes%lambda(k))
      held = 0.0_dp
      beyond = 0.0_dp
      do i = size(full%piece), 1, -1
        points = fewest + ceiling(of_half_wave*full%piece(i)%length%hi*modes%alpha(k)/pi)
        call add_points(midpoints(points), full%piece(i), modes%modes%system%piece(i))
      end do
    end do
    tension = tension/modes%modal_mass
    stretch = 4.0_dp*merge(full%spin_squared%hi, 0.0_dp, full%in_plane)*stretch/modes%modal_mass
    taken = 1.0_dp + taken/modes%modal_mass
    shear = elastic*(2.0_dp/(taken + sqrt(max(0.0_dp, taken**2 - 4.0_dp*both*elastic))) - 1.0_dp)
  contains
    subroutine add_points(x, piece, numbers)
      !! Add the points of piece i for mode k.
      real(dp), intent(in) :: x(:)                         !! relative to its length, (points)
      type(uniform_piece), intent(in) :: piece
      type(piece_numbers), intent(in) :: numbers
      real(dp) :: part, state(4, size(x)), ends(4, 2)
      ends = states_inside(numbers, frequency, modes%modes%amplitude(:, i, k), to_dd([-0.5_dp, 0.5_dp]*piece%length%hi))
      if (full%joint(i)%stiffness%hi > 0.0_dp) &
        held = held + beyond - ends(4, 2) + full%joint(i)%mass%hi*elastic(k)*ends(1, 2)
      beyond = ends(4, 1)
      state = states_inside(numbers, frequency, modes%modes%amplitude(:, i, k), to_dd(piece%length%hi*(x - 0.5_dp)))
      part = piece%length%hi/size(x)
      tension(k) = tension(k) + part*sum((pull(1, i) + x*(pull(2, i) + x*pull(3, i)))*state(2, :)**2)
      taken(k) = taken(k) + part*sum(piece%compliance%hi*state(4, :)**2/elastic(k) + piece%rotary%hi*state(2, :)**2)
      if (piece%rotary%hi > 0.0_dp) stretch(k) = stretch(k) + part/axial_stiffness(piece)*sum(((state(4, :) + held)/elastic(k))**2)
    end subroutine add_points
  end subroutine add_integrals

  pure real(dp) function axial_stiffness(piece) result(stiffness)
    !! Return EA = B ρA/(ρI).
    type(uniform_piece), intent(in) :: piece               !! with rotary inertia
    stiffness = piece%stiffness%hi*piece%mass%hi/piece%rotary%hi
  end function axial_stiffness

  pure function midpoints(number) result(x)
    !! Return the midpoints of equal parts of [0, 1].
    integer, intent(in) :: number
    real(dp) :: x(number)
    integer :: i
    x = [((i - 0.5_dp)/number, i=1, number)]
  end function midpoints

end module bw_absent_of_pieces
