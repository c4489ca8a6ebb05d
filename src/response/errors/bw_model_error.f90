module bw_model_error
  !! How much of a history the effects that a scene leaves out would change: what no number of modes makes up for.
  use bw_kinds, only: dp
  use bw_absent_effects, only: absent_changes, absent_words
  use bw_beam_units, only: beam_units, units_of
  use bw_double_double, only: sqrt
  use bw_mode_set, only: mode_set
  use bw_scene, only: scene_type
  implicit none (type, external)
  private
  public :: model_errors

contains

  pure function model_errors(scene, modes, velocity, displacement) result(errors)
    !! By each absent effect, over the peak of the displacement: mode by mode its amplitude times what a frequency that is
    !! off by δβ adds up to over the record, min(2, δβ T); all of it where a mode grows that would not. An estimate, within a
    !! factor of three in the tests; the shapes are taken as they are.
    type(scene_type), intent(in) :: scene          !! without sweeps, with a response
    class(mode_set), intent(in) :: modes           !! the first modes that move
    real(dp), intent(in) :: velocity(:)            !! (modes), what they start with, m/s
    real(dp), intent(in) :: displacement(:, :)     !! (samples, points), m
    real(dp) :: errors(size(absent_words))
    real(dp) :: change(modes%count, size(absent_words)), amplitude(modes%count), beta(modes%count)
    logical :: steadies(size(absent_words))
    type(beam_units) :: units
    real(dp) :: peak
    integer :: e, k
    errors = 0.0_dp
    peak = maxval(abs(displacement))
    if (peak == 0.0_dp) return
    units = units_of(scene%beam)
    call absent_changes(scene, [(k, k=1, modes%count)], change, steadies)
    beta = sqrt(max(0.0_dp, modes%beta_squared%hi))/units%time%hi
    amplitude = abs(velocity)*maxval(abs(modes%shapes(scene%response%points)), dim=2)
    where (beta > 0.0_dp) amplitude = amplitude/beta/peak
    do e = 1, size(errors)
      errors(e) = sum(amplitude*min(2.0_dp, abs(change(:, e))*beta*scene%response%duration), mask=beta > 0.0_dp)
      if (steadies(e)) errors(e) = max(1.0_dp, errors(e))
    end do
  end function model_errors

end module bw_model_error
