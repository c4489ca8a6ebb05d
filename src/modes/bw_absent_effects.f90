module bw_absent_effects
  !! What the effects that a scene leaves out would do to its frequencies: closed estimates from the inputs, no solve.
  !!
  !! An effect is estimated where the scene itself says how strong it would be: the tension of its rotation (of a hub
  !! without radius), the shear of its section (Poisson's ratio 0.3, the coefficient of a solid circle).
  use bw_kinds, only: dp
  use bw_beam_operator, only: shear_numbers
  use bw_beam_units, only: beam_units, units_of
  use bw_double_double, only: dd
  use bw_effect_estimates, only: shear_shift, tension_shift
  use bw_root_list, only: solve_roots
  use bw_rotation, only: acts_in_plane, dimensionless_speed, tension_of
  use bw_scene, only: scene_type
  use bw_shape, only: shape_type, shapes_of
  use bw_shear, only: shear_of
  use bw_shear_par, only: shear_par, usual_shear
  implicit none (type, external)
  private
  public :: absent_changes, spin_squared

  integer, parameter, public :: absent_stiffening = 1, absent_shear = 2
  character(*), parameter, public :: absent_words(*) = [character(10) :: 'stiffening', 'shear']   !! by number

contains

  pure subroutine absent_changes(scene, number, change, steadies)
    !! By how much each effect would change the frequencies, relatively, of the modes in force after t = 0: those with the mass at
    !! the tip where it is captured.
    type(scene_type), intent(in) :: scene                              !! without sweeps
    integer, intent(in) :: number(:)                                   !! of the modes, ascending
    real(dp), intent(out) :: change(size(number), size(absent_words))  !! 0 where the effect is on or cannot be
    logical, intent(out) :: steadies(size(absent_words))               !! the first mode grows, and would not
    type(shape_type) :: shape(size(number))
    real(dp) :: square(size(number)), shift(size(number), size(absent_words))
    integer :: e
    shape = shapes_of(solve_roots(number, tip_mass(scene)))
    shift(:, absent_stiffening) = tension_shifts(scene, shape)
    shift(:, absent_shear) = shear_shifts(scene, shape)
    square = shape%alpha**4 - spin_squared(scene)
    if (allocated(scene%stiffening)) then
      square = square + shift(:, absent_stiffening)
      shift(:, absent_stiffening) = 0.0_dp
    end if
    if (allocated(scene%shear)) then
      square = square + shift(:, absent_shear)
      shift(:, absent_shear) = 0.0_dp
    end if
    do e = 1, size(absent_words)
      change(:, e) = relative_change(square, shift(:, e))
      steadies(e) = square(1) <= 0.0_dp .and. square(1) + shift(1, e) > 0.0_dp
    end do
  end subroutine absent_changes

  elemental real(dp) function relative_change(square, shift) result(change)
    !! The relative change of a frequency whose square is shifted; 0 where there is no frequency.
    real(dp), intent(in) :: square, shift
    change = 0.0_dp
    if (square > 0.0_dp) change = shift/square/(1.0_dp + sqrt(1.0_dp + max(-1.0_dp, shift/square)))
  end function relative_change

  pure real(dp) function tip_mass(scene) result(gamma)
    !! The mass ratio at the tip after t = 0: 0 where no mass is captured.
    type(scene_type), intent(in) :: scene
    gamma = 0.0_dp
    if (allocated(scene%capture)) gamma = scene%impact%mass_ratio
  end function tip_mass

  pure real(dp) function spin_squared(scene) result(square)
    !! Ω², by which rotation in the plane of the motion lowers every β²; 0 where there is none.
    type(scene_type), intent(in) :: scene
    type(dd) :: omega
    square = 0.0_dp
    if (.not. allocated(scene%rotation)) return
    omega = dimensionless_speed(scene%rotation, units_of(scene%beam))
    if (acts_in_plane(scene%rotation)) square = omega%hi**2
  end function spin_squared

  pure function tension_shifts(scene, shape) result(shifts)
    !! What the tension of the scene's rotation adds to each β², (modes); 0 where nothing rotates.
    type(scene_type), intent(in) :: scene
    type(shape_type), intent(in) :: shape(:)
    real(dp) :: shifts(size(shape))
    type(beam_units) :: units
    type(dd) :: omega
    real(dp) :: hub
    integer :: i
    shifts = 0.0_dp
    if (.not. allocated(scene%rotation)) return
    units = units_of(scene%beam)
    omega = dimensionless_speed(scene%rotation, units)
    hub = 0.0_dp
    if (allocated(scene%stiffening)) hub = scene%stiffening%hub_radius/units%length
    shifts = [(tension_shift(shape(i), tension_of(omega%hi, hub, tip_mass(scene))), i=1, size(shape))]
  end function tension_shifts

  pure function shear_shifts(scene, shape) result(shifts)
    !! What shear of the scene's section, or of the usual one, adds to each β², (modes).
    type(scene_type), intent(in) :: scene
    type(shape_type), intent(in) :: shape(:)
    real(dp) :: shifts(size(shape))
    type(shear_numbers) :: numbers
    type(shear_par) :: shear
    integer :: i
    shear = usual_shear()
    if (allocated(scene%shear)) shear = scene%shear
    numbers = shear_of(shear, scene%beam)
    shifts = [(shear_shift(shape(i), numbers%compliance, numbers%rotary), i=1, size(shape))]
  end function shear_shifts

end module bw_absent_effects
