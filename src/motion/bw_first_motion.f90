module bw_first_motion
  !! The initial motion of a beam in its modes: the static deflection and the rotation of &initial.
  !!
  !! A free hub is held until t = 0 and released together with the beam. The potential energy depends on deflections
  !! from the hub's line alone, so modal displacements are those of a beam on a hub with prescribed motion:
  !! FΦ_k(ξ_F)/(M_kβ_k²). The rigid rotation, with Φ = 0, returns the hub to where it was held.
  use bw_beam_motion, only: beam_motion
  use bw_case_bodies, only: beam_of
  use bw_kinds, only: dp
  use bw_load_modes, only: find_residuals
  use bw_mode_set, only: mode_set
  use bw_scene, only: scene_type
  use bw_static_shape, only: hub_turn
  use bw_text, only: append
  use bw_timeline, only: configurations_of
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: find_first_motion

contains

  subroutine find_first_motion(scene, configuration, motion, q, rate)
    !! Find the static deflection and the rotation of &initial in the modes; both are 0 without that group. If a mode
    !! has no static deflection, the case becomes unresolved.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: configuration           !! that moves
    class(beam_motion), intent(inout) :: motion
    real(dp), allocatable, intent(out) :: q(:), rate(:)   !! m over the unit of time, and m/s, (modes)
    real(dp), allocatable :: shape(:, :)
    real(dp) :: force, turn
    integer :: first                               ! mode that bends the beam
    associate (modes => motion%modes%configuration(configuration)%set, units => motion%units)
      q = 0.0_dp*modes%modal_mass
      rate = q
      if (.not. allocated(scene%initial)) return
      force = scene%initial%force*units%time%hi/units%mass
      turn = scene%initial%angular_velocity*units%length
      if (turn /= 0.0_dp) rate = turn*modes%share_of_turn()/modes%modal_mass
      if (force == 0.0_dp) return
      first = merge(2, 1, allocated(scene%hub) .and. modes%beta_squared(1)%hi == 0.0_dp)
      if (any(modes%beta_squared(first:)%hi <= 0.0_dp)) then
        call append(motion%notes, 'not converged: a rigid-body or unstable mode has no static deflection under the force of '// &
                    '&initial; all numbers of the case are missing')
        motion%modes%resolved = .false.
        return
      end if
      shape = modes%some_shapes(1, modes%count, [scene%initial%position])
      q(first:) = force*shape(first:, 1)/(modes%modal_mass(first:)*modes%beta_squared(first:)%hi)
      if (first == 1) return
      associate (carried => configurations_of(scene))
        q(1) = force*turn_back(beam_of(scene, units, carried(configuration)), modes, scene%initial%position)
      end associate
    end associate
  end subroutine find_first_motion

  real(dp) function turn_back(given, modes, place) result(turn)
    !! Return the modal displacement of the rigid rotation under a static force of 1 with the hub held, so that all
    !! modes together rotate it by 0: −Σθ_kΦ_k(ξ)/(M_kβ_k²) of infinitely many others, over its own θ_1.
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: place                  !! ξ of the force
    real(dp), dimension(1, 1, hub_turn) :: residual, terms
    real(dp) :: drive(modes%count, 1), flexibility(2), turns(modes%count), weights(modes%count, 1, hub_turn)
    turns = modes%hub_turns()
    drive = modes%some_shapes(1, modes%count, [place])
    weights = 0.0_dp
    weights(:, 1, hub_turn) = turns
    call find_residuals(given, modes, modes%count, [place], .false., drive, weights, [place], residual, terms, flexibility, &
                        from_line=[.true.])
    turn = -(sum(turns(2:)*drive(2:, 1)/(modes%modal_mass(2:)*modes%beta_squared(2:)%hi)) + residual(1, 1, hub_turn))/turns(1)
  end function turn_back

end module bw_first_motion
