module bw_absent_effects
  !! Estimates of what the effects that a scene leaves out would change in its frequencies and histories: closed form
  !! from the inputs, to first order, without a second solution. More modes do not reduce these errors.
  !!
  !! An effect is estimated if the scene determines its strength: the tension of its rotation (with hub radius 0), the shear of
  !! its section (Poisson's ratio 0.3, the coefficient of a solid circle), and the stretch of a beam bending in the plane of its
  !! rotation. The last has no input group, so only this estimate shows it: Coriolis forces 2ωρAv̇ along the beam stretch it,
  !! which adds 4ω²∫S²/(EA) to the modal mass, with the momentum S = ∫ρAΦ of all beyond a place, the shear force over Λ = β² +
  !! Ω². This holds for modes far slower than longitudinal waves; faster ones hardly stretch the beam.
  !!
  !! Tension, rotary inertia and shear need integrals of squared derivatives of a shape, known in closed form. By Φ''''
  !! = α⁴Φ the shape is the sum of p = ½(Φ + Φ''/α²), p'' = α²p, and q = ½(Φ − Φ''/α²), q'' = −α²q. Then p'² − α²p² and
  !! q'² + α²q² are constant, 2p'q' = (pq)'' and 2α²pq = (p'q − pq')', so every integral follows from end values by
  !! parts. For a built-up beam they are sums over points (bw_absent_of_pieces).
  !!
  !! Integrals and shifts are in the beam's own units. **Errors** of the integrals: 1e-10 relatively, for k to 10⁵; 1e-7
  !! for mode 1 where γ > 10⁵. **Source**: Rayleigh's quotient of the shape without the effect.
  use bw_absent_of_pieces, only: highest_estimated, shifts_of_pieces
  use bw_beam_units, only: beam_units, shear_numbers, shear_of, slenderness, units_of
  use bw_double_double, only: dd, sqrt
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_root_list, only: solve_roots
  use bw_rotation, only: acts_in_plane, dimensionless_speed, tension_of
  use bw_scene, only: has_parts, scene_type
  use bw_shape, only: shape_type, shapes_of
  use bw_shear_par, only: shear_par, usual_shear
  implicit none (type, external)
  private
  public :: absent_changes, spin_squared, shear_shift, stretch_mass, tension_shift, model_errors
  public :: slope_integrals_of                      ! for its own test

  integer, parameter, public :: absent_stiffening = 1, absent_shear = 2, absent_stretch = 3
  character(*), parameter, public :: absent_words(*) = [character(10) :: 'stiffening', 'shear', 'stretch']   !! by number

  type, public :: slope_integrals
    real(dp) :: slope(0:2) = 0.0_dp     !! ∫₀¹ ξⁿΦ'² dξ, n = 0, 1, 2
    real(dp) :: third = 0.0_dp          !! ∫₀¹ Φ'''² dξ over α⁴
  end type slope_integrals

  type :: end_values
    !! p and q with their derivatives at one end.
    real(dp) :: p = 0.0_dp, p_slope = 0.0_dp, q = 0.0_dp, q_slope = 0.0_dp
  end type end_values

  real(dp), parameter :: static_below = 0.04_dp   !! α of mode 1 below which its shape is that of a static tip force to 1e-7

contains

  subroutine absent_changes(scene, number, change, steadies, square, inward)
    !! Find the relative change of frequencies by each effect, for the modes after t = 0: with the mass at the tip if it
    !! is captured.
    type(scene_type), intent(in) :: scene                              !! without sweeps
    integer, intent(in) :: number(:)                                   !! of the modes, ascending
    real(dp), intent(out) :: change(size(number), size(absent_words))
      !! 0 if the effect is on or impossible, and for modes of a built-up beam beyond `highest_estimated`
    logical, intent(out) :: steadies(size(absent_words))               !! the effect would stabilise an unstable first mode
    real(dp), intent(out) :: square(size(number))                      !! β², approximately; 0 if unknown
    real(dp), intent(out) :: inward(size(number))
      !! relative change of frequency per length by which a captured mass moves inwards; 0 for the paper's beam
    type(shape_type) :: shape(size(number))
    real(dp) :: shift(size(number), size(absent_words)), moved(size(number)), stretch(size(number))
    integer :: e, known
    change = 0.0_dp
    steadies = .false.
    shift = 0.0_dp
    moved = 0.0_dp
    stretch = 0.0_dp
    inward = 0.0_dp
    if (allocated(scene%hub)) then           ! the estimate needs a root held alone
      known = 0
      square = 0.0_dp
    else if (is_papers_beam(scene)) then
      known = size(number)
      shape = shapes_of(solve_roots(number, tip_mass(scene)))
      shift(:, absent_stiffening) = tension_shifts(scene, shape)
      shift(:, absent_shear) = shear_shifts(scene, shape)
      square = shape%alpha**4 - spin_squared(scene)
      stretch = stretch_mass(shape, spin_squared(scene), slenderness(scene%beam)**2)
    else
      known = count(number <= highest_estimated)
      square = 0.0_dp
      call shifts_of_pieces(scene, number(:known), square(:known), shift(:known, absent_stiffening), &
                            shift(:known, absent_shear), stretch(:known), moved(:known))
    end if
    if (known == 0) return
    if (allocated(scene%stiffening)) then
      square = square + shift(:, absent_stiffening)
      shift(:, absent_stiffening) = 0.0_dp
    end if
    if (allocated(scene%shear)) then
      square = square + shift(:, absent_shear)
      shift(:, absent_shear) = 0.0_dp
    end if
    shift(:, absent_stretch) = -square*stretch/(1.0_dp + stretch)
    do e = 1, size(absent_words)
      change(:, e) = relative_change(square, shift(:, e))
      steadies(e) = square(1) <= 0.0_dp .and. square(1) + shift(1, e) > 0.0_dp
    end do
    where (square > 0.0_dp) inward = 0.5_dp*moved/square
  end subroutine absent_changes

  pure logical function is_papers_beam(scene) result(is)
    !! Tell whether the beam is one clamped piece with at most a mass at its tip.
    type(scene_type), intent(in) :: scene
    is = .not. has_parts(scene%groups)
    if (is .and. allocated(scene%capture)) is = scene%impact%position == 1.0_dp
  end function is_papers_beam

  elemental real(dp) function relative_change(square, shift) result(change)
    !! Return the relative change of a frequency whose square is shifted; 0 for an unstable mode.
    real(dp), intent(in) :: square, shift
    change = 0.0_dp
    if (square > 0.0_dp) change = shift/square/(1.0_dp + sqrt(1.0_dp + max(-1.0_dp, shift/square)))
  end function relative_change

  pure real(dp) function tip_mass(scene) result(gamma)
    !! Return the mass ratio at the tip after t = 0; 0 without capture.
    type(scene_type), intent(in) :: scene
    gamma = 0.0_dp
    if (allocated(scene%capture)) gamma = scene%impact%mass_ratio
  end function tip_mass

  pure real(dp) function spin_squared(scene) result(square)
    !! Return Ω², by which rotation in the plane of motion lowers every β²; else 0.
    type(scene_type), intent(in) :: scene
    type(dd) :: omega
    square = 0.0_dp
    if (.not. allocated(scene%rotation)) return
    omega = dimensionless_speed(scene%rotation, units_of(scene%beam))
    if (acts_in_plane(scene%rotation)) square = omega%hi**2
  end function spin_squared

  pure function tension_shifts(scene, shape) result(shifts)
    !! Return the shift of each β² by the tension of the scene's rotation, (modes); 0 without rotation.
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
    !! Return the shift of each β² by shear of the scene's section, or of a usual one, (modes).
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

  pure real(dp) function tension_shift(shape, tension) result(shift)
    !! Return the shift ∫TΦ'²/M of β² by a tension T(ξ) = t_0 + t_1ξ + t_2ξ², an upper bound for the lowest mode.
    type(shape_type), intent(in) :: shape
    real(dp), intent(in) :: tension(3)           !! t_0, t_1, t_2 in EI/l²
    type(slope_integrals) :: integrals
    integrals = slope_integrals_of(shape)
    shift = dot_product(tension, integrals%slope)/shape%modal_mass
  end function tension_shift

  pure real(dp) function shear_shift(shape, compliance, rotary) result(shift)
    !! Return the shift < 0 of β² by shear and rotary inertia.
    !!
    !! Long waves lose the fraction s²α² + r²α² of α⁴, at the ends with ∫Φ'''²/α⁴ and ∫Φ'² over M in place of α². Short
    !! waves take the lower root of Timoshenko's relation \( r^2s^2\beta^4 - (1 + (r^2+s^2)\alpha^2)\beta^2 + \alpha^4 =
    !! 0 \), so that none is faster than sound.
    type(shape_type), intent(in) :: shape
    real(dp), intent(in) :: compliance           !! s² = EI/(κGAl²)
    real(dp), intent(in) :: rotary               !! r² = I/(Al²)
    type(slope_integrals) :: integrals
    real(dp) :: square, sum, discriminant
    integrals = slope_integrals_of(shape)
    square = shape%alpha**4
    sum = 1.0_dp + (rotary*integrals%slope(0) + compliance*integrals%third)/shape%modal_mass
    discriminant = max(0.0_dp, sum**2 - 4.0_dp*rotary*compliance*square)
    shift = square*(2.0_dp/(sum + sqrt(discriminant)) - 1.0_dp)
  end function shear_shift

  elemental real(dp) function stretch_mass(shape, spin_squared, rotary) result(mass)
    !! Return the relative increase of modal mass due to Coriolis forces in the plane of rotation: 4Ω²r²∫Φ'''²/α⁸ over M.
    type(shape_type), intent(in) :: shape
    real(dp), intent(in) :: spin_squared         !! Ω²
    real(dp), intent(in) :: rotary               !! r² = I/(Al²): EI/(EA) in l²
    type(slope_integrals) :: integrals
    mass = 0.0_dp
    if (spin_squared == 0.0_dp) return
    integrals = slope_integrals_of(shape)
    mass = 4.0_dp*spin_squared*rotary*integrals%third/shape%alpha**4/shape%modal_mass
  end function stretch_mass

  ! Integrals

  elemental type(slope_integrals) function slope_integrals_of(shape) result(integrals)
    !! Return the integrals of one mode; for the first with a very heavy mass those of a static tip force.
    type(shape_type), intent(in) :: shape
    type(end_values) :: root, tip
    real(dp) :: growing(0:2), turning(0:2), both(0:2)
    if (shape%alpha < static_below) then
      integrals%slope = shape%tip**2*[1.2_dp, 0.825_dp, 87.0_dp/140.0_dp]     ! Φ = Φ(1)(3ξ² − ξ³)/2
      integrals%third = 9.0_dp*shape%tip**2/shape%alpha**4
      return
    end if
    root = end_values(-1.0_dp, shape%sigma*shape%alpha, 1.0_dp, -shape%sigma*shape%alpha)
    tip = end_values(0.5_dp*shape%tip, 0.5_dp*(shape%tip_slope - shape%alpha*shape%tip_force), &
                     0.5_dp*shape%tip, 0.5_dp*(shape%tip_slope + shape%alpha*shape%tip_force))
    growing = square_moments(root%p, root%p_slope, tip%p, tip%p_slope, shape%alpha**2)
    turning = square_moments(root%q, root%q_slope, tip%q, tip%q_slope, -shape%alpha**2)
    both = product_moments(root, tip, shape%alpha)
    integrals%slope = growing + turning + both
    integrals%third = growing(0) + turning(0) - both(0)
  end function slope_integrals_of

  pure function square_moments(root, root_slope, tip, tip_slope, square) result(moments)
    !! Return ∫ξⁿf'² dξ, n = 0, 1, 2, for f with f'' = `square` f.
    real(dp), intent(in) :: root, root_slope, tip, tip_slope, square
    real(dp) :: moments(0:2)
    real(dp) :: constant, product, of_value
    constant = root_slope**2 - square*root**2
    product = tip*tip_slope
    moments(0) = 0.5_dp*(product - root*root_slope) + 0.5_dp*constant
    of_value = (moments(0) - constant)/square                        ! ∫f²
    moments(1) = 0.5_dp*product - 0.25_dp*(tip**2 - root**2) + 0.25_dp*constant
    moments(2) = 0.5_dp*product - 0.5_dp*tip**2 + 0.5_dp*of_value + constant/6.0_dp
  end function square_moments

  pure function product_moments(root, tip, alpha) result(moments)
    !! Return 2∫ξⁿp'q' dξ, n = 0, 1, 2.
    type(end_values), intent(in) :: root, tip
    real(dp), intent(in) :: alpha
    real(dp) :: moments(0:2)
    real(dp) :: slope, product, of_values
    slope = tip%p*tip%q_slope + tip%p_slope*tip%q
    product = tip%p*tip%q
    of_values = (tip%p_slope*tip%q - tip%p*tip%q_slope - (root%p_slope*root%q - root%p*root%q_slope))/(2.0_dp*alpha**2)
    moments(0) = slope - (root%p*root%q_slope + root%p_slope*root%q)
    moments(1) = slope - (product - root%p*root%q)
    moments(2) = slope - 2.0_dp*(product - of_values)
  end function product_moments

  function model_errors(scene, modes, velocity, displacement) result(errors)
    !! Estimate the error due to each absent effect over the peak displacement: the largest difference of the history of
    !! these modes with and without shifted frequencies; 1 if an unstable mode would be stable. Within a factor of three
    !! in the tests. Shapes are unchanged, and a later release is ignored.
    type(scene_type), intent(in) :: scene          !! without sweeps, with a response
    class(mode_set), intent(in) :: modes           !! the first modes that move
    real(dp), intent(in) :: velocity(:)            !! (modes), initial velocities, m/s
    real(dp), intent(in) :: displacement(:, :)     !! (samples, points), m
    real(dp) :: errors(size(absent_words))
    integer, parameter :: most_times = 500
    real(dp) :: change(modes%count, size(absent_words)), shapes(modes%count, size(scene%response%points))
    real(dp), dimension(modes%count) :: beta, damping, estimated, inward, moved
    logical :: steadies(size(absent_words))
    type(beam_units) :: units
    real(dp) :: peak, time
    integer :: e, j, k, times
    errors = 0.0_dp
    peak = maxval(abs(displacement))
    if (peak == 0.0_dp) return
    units = units_of(scene%beam)
    call absent_changes(scene, [(k, k=1, modes%count)], change, steadies, estimated, inward)
    beta = sqrt(max(0.0_dp, modes%beta_squared%hi))/units%time%hi
    damping = 0.0_dp
    if (allocated(modes%damping)) damping = 0.5_dp*modes%damping/units%time%hi
    shapes = modes%shapes(scene%response%points)
    times = min(most_times, size(displacement, 1) - 1)
    do e = 1, size(errors)
      do j = 1, times
        time = scene%response%duration*j/times
        moved = velocity*exp(-damping*time)*(swing((1.0_dp + change(:, e))*beta, time) - swing(beta, time))
        errors(e) = max(errors(e), maxval(abs(matmul(merge(moved, 0.0_dp, beta > 0.0_dp), shapes)))/peak)
      end do
      if (steadies(e)) errors(e) = max(1.0_dp, errors(e))
    end do
  end function model_errors

  elemental real(dp) function swing(beta, time)
    !! sin(βt)/β, t for β = 0.
    real(dp), intent(in) :: beta                   !! Return sin(βt)/β, or t for β = 0.
    real(dp), intent(in) :: time
    swing = time
    if (beta > 0.0_dp) swing = sin(beta*time)/beta
  end function swing

end module bw_absent_effects
