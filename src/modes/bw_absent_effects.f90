module bw_absent_effects
  !! Estimates of what the effects that a scene leaves out would change in its frequencies and histories, to first order,
  !! without a second solution: Rayleigh's quotient of the shapes without the effect (bw_absent_of_pieces). More modes do not
  !! reduce these errors.
  !!
  !! An effect is estimated if the scene determines its strength: the tension of its rotation (with hub radius 0), the shear of
  !! its section (Poisson's ratio 0.3, the coefficient of a solid circle), and the stretch of a beam bending in the plane of its
  !! rotation. The last has no input group, so only this estimate shows it: Coriolis forces 2ωρAv̇ along the beam stretch it,
  !! which adds 4ω²∫S²/(EA) to the modal mass, with the momentum S = ∫ρAΦ of all beyond a place, the shear force over Λ = β² +
  !! Ω². This holds for modes far slower than longitudinal waves; faster ones hardly stretch the beam.
  use bw_absent_of_pieces, only: highest_estimated, shifts_of_pieces
  use bw_beam_units, only: beam_units, units_of
  use bw_kinds, only: dp
  use bw_mode_set, only: damping_rates, mode_set
  use bw_scene, only: has_parts, scene_type
  implicit none (type, external)
  private
  public :: absent_changes, model_errors

  integer, parameter, public :: absent_stiffening = 1, absent_shear = 2, absent_stretch = 3
  character(*), parameter, public :: absent_words(*) = [character(10) :: 'stiffening', 'shear', 'stretch']   !! by number

contains

  subroutine absent_changes(scene, number, change, steadies, square, inward)
    !! Find the relative change of frequencies by each effect, for the modes after t = 0: with the mass at the tip if it
    !! is captured.
    type(scene_type), intent(in) :: scene                              !! without sweeps
    integer, intent(in) :: number(:)                                   !! of the modes, ascending
    real(dp), intent(out) :: change(size(number), size(absent_words))
      !! 0 if the effect is on or impossible, and for modes beyond `highest_estimated`
    logical, intent(out) :: steadies(size(absent_words))               !! the effect would stabilise an unstable first mode
    real(dp), intent(out) :: square(size(number))                      !! β², approximately; 0 if unknown
    real(dp), intent(out) :: inward(size(number))
      !! relative change of frequency per length by which a captured mass moves inwards; 0 for the paper's beam
    real(dp) :: shift(size(number), size(absent_words)), moved(size(number)), stretch(size(number))
    integer :: e, known
    change = 0.0_dp
    steadies = .false.
    shift = 0.0_dp
    moved = 0.0_dp
    stretch = 0.0_dp
    inward = 0.0_dp
    square = 0.0_dp
    known = count(number <= highest_estimated)
    if (known == 0 .or. allocated(scene%hub)) return   ! the estimate needs a root held alone
    call shifts_of_pieces(scene, number(:known), square(:known), shift(:known, absent_stiffening), &
                          shift(:known, absent_shear), stretch(:known), moved(:known))
    if (is_papers_beam(scene)) moved = 0.0_dp
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
    !! Return whether the beam is one clamped piece with at most a mass at its tip.
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
    damping = 0.5_dp*damping_rates(modes)/units%time%hi
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
    !! Return sin(βt)/β, or t for β = 0.
    real(dp), intent(in) :: beta
    real(dp), intent(in) :: time
    swing = time
    if (beta > 0.0_dp) swing = sin(beta*time)/beta
  end function swing

end module bw_absent_effects
