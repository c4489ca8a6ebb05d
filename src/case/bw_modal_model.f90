module bw_modal_model
  !! The modal model of a case, for other programs: modal loads of forces at points and of a base motion, modal
  !! displacements there, and the residual flexibility of all omitted modes. In SI:
  !!
  !!     M_k q̈_k + C_k q̇_k + K_k q_k = Σ_f Φ_k(ξ_f) F_f − P_k a,    v(ξ) = Σ Φ_k(ξ) q_k + Σ_f R(ξ, ξ_f) F_f + R_a(ξ) a,
  !!
  !! F_f are forces, a is the acceleration of the base, P_k = ∫ρAΦ_k dx + Σ m_bΦ_k(ξ_b), and R is the residual
  !! flexibility. On a free hub v is the displacement from the hub's line, which rotates by θ = Σ θ_kq_k + …. Forces and
  !! base acceleration act on the whole motion of a mode, Φ_k + (R + x)θ_k with R the hub radius.
  use bw_beam_units, only: beam_units
  use bw_case_moments, only: scale_of_moments
  use bw_case_result, only: case_result, modal_model
  use bw_kinds, only: dp
  use bw_load_modes, only: find_residuals, total_mass
  use bw_mode_set, only: curvatures, damping_rates, deflections, mode_set, turns, values_at
  use bw_monitor, only: monitor_type
  use bw_piece_beam, only: holds_tip
  use bw_placed_loads, only: find_drive
  use bw_scene, only: scene_type
  use bw_scene_pieces, only: pieces_of, varying_of
  use bw_static_shape, only: hub_turn
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: find_modal_model

contains

  subroutine find_modal_model(scene, room, monitor, result)
    !! Find the modal model for the modes that a result holds.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: room                    !! modes it may hold; 0: they are unknown
    class(monitor_type), intent(inout) :: monitor  !! the model is invalid if it requests a stop
    type(case_result), intent(inout) :: result
    type(varying_beam) :: given
    real(dp), allocatable :: points(:)
    if (allocated(result%model)) deallocate (result%model)
    allocate (result%model)
    if (room == 0) return
    given = varying_of(scene, result%units, pieces_of(scene, result%units, allocated(scene%capture)))
    if (allocated(scene%response)) then
      points = scene%response%points
    else
      points = scene%frequency_response%points
    end if
    associate (model => result%model, units => result%units, modes => result%modes)
      call find_modes(units, modes, points, model)
      call find_shapes(scene, units, given, modes, min(room, modes%count), points, monitor, model)
      model%mass = moving_mass(given)*units%mass
      allocate (model%initial_displacement(modes%count), model%initial_velocity(modes%count), source=0.0_dp)
      if (allocated(result%modal_displacement)) &
        model%initial_displacement = result%modal_displacement(:modes%count)*result%approach_velocity*units%time%hi
      if (allocated(result%modal_velocity)) model%initial_velocity = result%modal_velocity(:modes%count)*result%approach_velocity
    end associate
  end subroutine find_modal_model

  pure real(dp) function moving_mass(given) result(mass)
    !! Return the mass of all that moves, thus without that at a tip whose deflection is held.
    type(varying_beam), intent(in) :: given
    logical :: held(2)
    held = holds_tip(given%beam)
    mass = total_mass(given)
    if (held(1)) mass = mass - given%beam%joint(size(given%beam%joint))%mass%hi
  end function moving_mass

  pure subroutine find_modes(units, modes, points, model)
    !! Find stiffness, damping, participation and slopes of each mode.
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: points(:)
    type(modal_model), intent(inout) :: model
    real(dp) :: motion(modes%count, 2)
    integer :: p
    model%stiffness = modes%modal_mass*units%mass*modes%beta_squared%hi*units%frequency**2
    model%damping = modes%modal_mass*units%mass*damping_rates(modes)*units%frequency
    model%turn_participation = modes%share_of_turn()*units%mass*units%length
    allocate (model%slope(size(points), modes%count))
    do p = 1, size(points)
      motion = modes%motion_at(points(p))
      model%slope(p, :) = (motion(:, 2) - modes%hub_turns())/units%length
    end do
    model%hub_turn = modes%hub_turns()/units%length
  end subroutine find_modes

  subroutine find_shapes(scene, units, given, modes, kept, points, monitor, model)
    !! Find shapes, moments, shear forces and participation of the modes, and the residuals of all others.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: kept                    !! modes in the model, at most all
    real(dp), intent(in) :: points(:)
    class(monitor_type), intent(inout) :: monitor
    type(modal_model), intent(inout) :: model
    real(dp), allocatable :: drive(:, :), residual(:, :, :), terms(:, :, :), weights(:, :, :)
    real(dp) :: flexibility(2*size(points)), factor(3)
    integer :: n, q
    n = size(points)
    allocate (weights(modes%count, n, hub_turn), residual(n + 1, n, hub_turn))
    allocate (terms, mold=residual)
    call find_drive(given, modes, points, .true., monitor, drive, points, weights(:, :, 3))
    if (monitor%stop_requested()) return
    weights(:, :, 1) = values_at(modes, deflections, 1, modes%count, points)
    weights(:, :, 2) = values_at(modes, curvatures, 1, modes%count, points)
    weights(:, :, hub_turn) = values_at(modes, turns, 1, modes%count, points)
    call find_residuals(given, modes, kept, points, .true., drive, weights, points, residual, terms, flexibility)
    factor = [1.0_dp, scale_of_moments(scene), scale_of_moments(scene)/units%length]
    model%participation = drive(:, n + 1)*units%mass
    model%shape = transpose(weights(:, :, 1))
    model%moment = transpose(weights(:, :, 2))*factor(2)
    model%shear = transpose(weights(:, :, 3))*factor(3)
    allocate (model%residual(n, n, 3), model%base_residual(n, 3))
    do q = 1, 3
      model%residual(:, :, q) = residual(:n, :, q)*(units%time%hi**2/units%mass*factor(q))
      model%base_residual(:, q) = -residual(n + 1, :, q)*(units%time%hi**2*factor(q))
    end do
    model%hub_residual = residual(:n, 1, hub_turn)*(units%time%hi**2/units%mass/units%length)
    model%base_hub_residual = -residual(n + 1, 1, hub_turn)*(units%time%hi**2/units%length)
  end subroutine find_shapes

end module bw_modal_model
