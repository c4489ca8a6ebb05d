module bw_model_error
  !! How much of a history the effects that a scene leaves out would change: what no number of modes makes up for.
  use bw_kinds, only: dp
  use bw_absent_effects, only: absent_changes, absent_words
  use bw_case_result, only: case_result
  use bw_double_double, only: sqrt
  use bw_scene, only: scene_type
  implicit none (type, external)
  private
  public :: model_errors

contains

  pure function model_errors(scene, result) result(errors)
    !! By each absent effect, over the peak of the displacement: mode by mode its amplitude times what a frequency that is
    !! off by δβ adds up to over the record, min(2, δβ T); all of it where a mode grows that would not. An estimate, within a
    !! factor of three in the tests; the shapes are taken as they are.
    type(scene_type), intent(in) :: scene          !! without sweeps, with a response
    type(case_result), intent(in) :: result        !! of this scene; its first modes are taken
    real(dp) :: errors(size(absent_words))
    real(dp) :: change(result%modes%count, size(absent_words)), amplitude(result%modes%count), beta(result%modes%count)
    logical :: steadies(size(absent_words))
    real(dp) :: peak
    integer :: e, k
    errors = 0.0_dp
    peak = maxval(abs(result%response%displacement(:result%response%finite_samples, :)))
    if (peak == 0.0_dp) return
    call absent_changes(scene, [(k, k=1, result%modes%count)], change, steadies)
    associate (shapes => result%modes%shapes(scene%response%points))
      beta = sqrt(max(0.0_dp, result%modes%beta_squared%hi))/result%units%time%hi
      amplitude = abs(result%modal_velocity*result%approach_velocity)*maxval(abs(shapes), dim=2)
    end associate
    where (beta > 0.0_dp) amplitude = amplitude/beta/peak
    do e = 1, size(errors)
      errors(e) = sum(amplitude*min(2.0_dp, abs(change(:, e))*beta*scene%response%duration), mask=beta > 0.0_dp)
      if (steadies(e)) errors(e) = max(1.0_dp, errors(e))
    end do
  end function model_errors

end module bw_model_error
