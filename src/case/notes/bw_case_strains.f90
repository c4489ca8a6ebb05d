module bw_case_strains
  !! The largest strains of a beam, by bending and by the centrifugal force, and where they are. Linear theory holds for
  !! small strains only.
  use bw_beam_par, only: area_of, beam_par, beam_piece, pieces_of_beam, second_moment_of, section_at
  use bw_beam_piece, only: fibre_of, mass_moments
  use bw_kinds, only: dp, qp
  use bw_missing, only: is_missing, scaled
  use bw_mode_set, only: mode_set
  use bw_scene, only: scene_type
  implicit none (type, external)
  private
  public :: centrifugal_strain, largest_bending

  type, public :: placed_strain
    real(dp) :: strain = 0.0_dp                    !! largest, or an estimate of it
    real(dp) :: position = 0.0_dp                  !! ξ of it, 0 at the root
  end type placed_strain

  type :: fibre
    !! The outermost fibre of a section.
    real(dp) :: position = 0.0_dp                  !! ξ
    real(dp) :: strain = 0.0_dp                    !! at a curvature M/(EI of the root piece) of 1/l
  end type fibre

  real(dp), parameter :: quarters(3) = [0.25_dp, 0.5_dp, 0.75_dp]

contains

  function largest_bending(scene, modes, amplitude) result(found)
    !! Estimate the largest strain c v'' of an outermost fibre by the sum of the amplitudes of the first modes, in V l²/h over
    !! l. A uniform clamped beam struck at its tip bends most at its root: for captured masses of 0.05 to 50 times the beam's
    !! the sum there is 0.9 to 1.5 times the largest strain. Other beams are searched wherever the largest may be.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: amplitude(:)           !! of the first modes, V l²/h
    type(placed_strain) :: found
    type(fibre), allocatable :: places(:)
    real(dp), allocatable :: curvature(:, :), strain(:)
    integer :: p
    places = [fibre(0.0_dp, fibre_strain(scene%beam%beam_piece, scene%beam))]
    if (.not. modes%uniform) places = places_of(scene)
    curvature = modes%some_curvatures(1, size(amplitude), places%position)
    strain = [(scaled(sum(abs(curvature(:, p))*amplitude), places(p)%strain), p=1, size(places))]
    p = maxloc(strain, dim=1)
    found = placed_strain(strain(p), places(p)%position)
  end function largest_bending

  pure function places_of(scene) result(places)
    !! Return the root, both sides of each joint, body and struck place, where moments jump or end, and some places between.
    type(scene_type), intent(in) :: scene
    type(fibre), allocatable :: places(:)
    real(dp), parameter :: beside = 8.0_dp*epsilon(1.0_dp)     ! relative distance of the sides of a joint
    type(beam_piece), allocatable :: pieces(:)
    real(dp), allocatable :: between(:)
    real(dp) :: inner, outer
    integer :: b, i, p
    pieces = pieces_of_beam(scene%beam)
    between = quarters
    if (allocated(scene%impact)) between = [between, [1.0_dp - beside, 1.0_dp + beside]*scene%impact%position]
    if (allocated(scene%bodies)) then
      do b = 1, size(scene%bodies)
        between = [between, [1.0_dp - beside, 1.0_dp + beside]*scene%bodies(b)%position]
      end do
    end if
    allocate (places(0))
    inner = 0.0_dp
    do i = 1, size(pieces)
      outer = real(sum(real(pieces(:i)%length, qp))/sum(real(pieces%length, qp)), dp)
      associate (here => [inner*(1.0_dp + beside), inner + quarters*(outer - inner), outer*(1.0_dp - beside), &
                          pack(between, between > inner .and. between < outer)])
        places = [places, [(fibre(here(p), fibre_strain(section_at(scene%beam, here(p)), scene%beam)), p=1, size(here))]]
      end associate
      inner = outer
    end do
  end function places_of

  pure real(dp) function fibre_strain(piece, beam) result(strain)
    !! Return c/l over EI of the section by that of the root. c is the distance of the outermost fibre from the axis: as
    !! given, else D/2 of a circle, h/2 of a rectangle, or 2√(I/A), which is D/2 of a circle; 0 if unknown.
    type(beam_piece), intent(in) :: piece
    type(beam_par), intent(in) :: beam
    real(qp) :: c
    c = 2*sqrt(second_moment_of(piece)/area_of(piece))
    if (piece%is_lumped) c = 0
    if (.not. is_missing(fibre_of(piece))) c = fibre_of(piece)
    c = c/beam%length*(beam%youngs_modulus*second_moment_of(beam%beam_piece))/(piece%youngs_modulus*second_moment_of(piece))
    strain = real(min(c, real(huge(strain), qp)), dp)
  end function fibre_strain

  pure function centrifugal_strain(scene) result(found)
    !! Find the largest strain T/(EA) due to the centrifugal force, with or without tension in the equations: at the
    !! inner end of a piece, due to all that lies beyond.
    type(scene_type), intent(in) :: scene
    type(placed_strain) :: found
    type(beam_piece), allocatable :: pieces(:)
    real(qp) :: hub, inner, pull, strain, moments(2)
    integer :: b, i
    if (.not. allocated(scene%rotation) .or. scene%beam%is_lumped) return
    pieces = pieces_of_beam(scene%beam)
    hub = 0.0_qp
    if (allocated(scene%stiffening)) hub = scene%stiffening%hub_radius
    pull = 0.0_qp
    do i = size(pieces), 1, -1
      inner = sum(real(pieces(:i - 1)%length, qp))
      moments = mass_moments(pieces(i), pieces(i))
      if (allocated(scene%beam%outer)) moments = mass_moments(pieces(i), scene%beam%outer(i))
      pull = pull + moments(1)*(hub + inner) + moments(2)
      strain = pull
      if (allocated(scene%bodies)) then
        do b = 1, size(scene%bodies)
          strain = strain + force_of(scene%bodies(b)%mass, scene%bodies(b)%position)
        end do
      end if
      if (allocated(scene%capture)) strain = strain + force_of(scene%impact%mass, scene%impact%position)
      strain = strain*real(scene%rotation%angular_velocity, qp)**2/(pieces(i)%youngs_modulus*area_of(pieces(i)))
      if (strain <= found%strain) cycle
      found = placed_strain(real(min(strain, real(huge(1.0_dp), qp)), dp), real(inner/scene%beam%length, dp))
    end do
  contains
    pure real(qp) function force_of(mass, position) result(force)
      !! Return the force of a body beyond the inner end over ω², else 0.
      real(dp), intent(in) :: mass, position
      force = 0.0_qp
      if (position*scene%beam%length > inner) force = mass*(hub + real(position, qp)*scene%beam%length)
    end function force_of
  end function centrifugal_strain

end module bw_case_strains
