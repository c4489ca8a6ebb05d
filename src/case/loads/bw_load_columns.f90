module bw_load_columns
  !! The quantities of histories under loads, and the modal weights that give them.
  use bw_beam_units, only: beam_units
  use bw_case_moments, only: scale_of_moments
  use bw_kinds, only: dp
  use bw_load_modes, only: effective_mass, find_residuals, total_mass
  use bw_load_sum, only: load_view
  use bw_mode_set, only: curvatures, deflections, mode_set, turns, values_at
  use bw_monitor, only: monitor_type
  use bw_placed_loads, only: find_drive, placed_loads
  use bw_response_par, only: response_par
  use bw_scene, only: scene_type
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: factor_of_quantity, list_columns, make_view

  integer, parameter, public :: quantities = 6  !! displacement, velocity, acceleration, bending moment, shear force, hub rotation
  integer, parameter :: weight_of(quantities) = [1, 1, 1, 2, 3, 4], order_of(quantities) = [0, 1, 2, 0, 0, 0]

contains

  pure subroutine list_columns(response, asked, quantity, point)
    !! List the requested quantities at all points; hub rotation, the last, has one column.
    type(response_par), intent(in) :: response
    logical, intent(in) :: asked(quantities)
    integer, allocatable, intent(out) :: quantity(:), point(:)   !! (columns)
    integer :: p, points, q
    allocate (quantity(0), point(0))
    do q = 1, quantities
      if (.not. asked(q)) cycle
      points = merge(1, size(response%points), q == quantities)
      quantity = [quantity, spread(q, 1, points)]
      point = [point, [(p, p=1, points)]]
    end do
  end subroutine list_columns

  pure real(dp) function factor_of_quantity(scene, units, quantity) result(factor)
    !! Return the factor to SI units, given modal displacements in m.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    integer, intent(in) :: quantity
    factor = 1.0_dp/units%time%hi**order_of(quantity)
    select case (weight_of(quantity))
    case (2); factor = factor*scale_of_moments(scene)
    case (3); factor = factor*scale_of_moments(scene)/units%length
    case (4); factor = factor/units%length
    end select
  end function factor_of_quantity

  subroutine make_view(given, modes, summed, loads, points, quantity, point, monitor, view, flexibility)
    !! Set up the modal loads, and the weights and residuals of the requested quantities.
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: summed
    type(placed_loads), intent(in) :: loads
    real(dp), intent(in) :: points(:)                    !! ξ
    integer, intent(in) :: quantity(:), point(:)         !! (columns)
    class(monitor_type), intent(inout) :: monitor        !! results are invalid if it requests a stop
    type(load_view), intent(out) :: view
    real(dp), allocatable, intent(out) :: flexibility(:) !! residual flexibility at the points and at each load, (points + loads)
    real(dp), allocatable :: drive(:, :), residual(:, :, :), terms(:, :, :), soft(:)
    real(dp) :: weights(modes%count, size(points), maxval(weight_of))
    integer :: c, l, sheared
    sheared = merge(size(points), 0, any(weight_of(quantity) == 3))   ! points with requested shear forces
    weights = 0.0_dp
    call find_drive(given, modes, loads%place, loads%accelerated, monitor, drive, points(:sheared), weights(:, :sheared, 3))
    if (monitor%stop_requested()) return
    weights(:, :, 1) = values_at(modes, deflections, 1, modes%count, points)
    weights(:, :, 2) = values_at(modes, curvatures, 1, modes%count, points)
    weights(:, :, 4) = values_at(modes, turns, 1, modes%count, points)
    allocate (residual(size(drive, 2), size(points), size(weights, 3)), soft(size(points) + size(loads%place)))
    allocate (terms, mold=residual)
    view%summed = min(summed, modes%count)
    call find_residuals(given, modes, view%summed, loads%place, loads%accelerated, drive, weights, points, residual, terms, &
                        soft)
    associate (kind => loads%kind)
      flexibility = [soft(:size(points)), spread(0.0_dp, 1, size(kind))]
      allocate (view%drive(modes%count, size(kind)), view%weight(modes%count, size(quantity)), &
                view%residual(size(kind), size(quantity)), view%terms(size(kind), size(quantity)))
      view%course = loads%course
      view%order = order_of(quantity)
      do l = 1, size(kind)
        view%drive(:, l) = drive(:, kind(l))/modes%modal_mass
        if (kind(l) <= size(loads%place)) then
          flexibility(size(points) + l) = soft(size(points) + kind(l))
        else
          flexibility(size(points) + l) = max(0.0_dp, total_mass(given) - effective_mass(modes, drive(:view%summed, kind(l)))) &
            /max(modes%beta_squared(view%summed)%hi, 1.0_dp)
        end if
      end do
      do c = 1, size(quantity)
        view%weight(:, c) = weights(:, point(c), weight_of(quantity(c)))
        view%residual(:, c) = residual(kind, point(c), weight_of(quantity(c)))
        view%terms(:, c) = terms(kind, point(c), weight_of(quantity(c)))
      end do
    end associate
  end subroutine make_view

end module bw_load_columns
