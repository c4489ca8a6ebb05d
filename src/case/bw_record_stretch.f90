module bw_record_stretch
  !! For how long the phases of modes must be right: this decides which roots are solved in extended precision.
  use bw_kinds, only: dp
  use bw_modes_par, only: by_tolerance
  use bw_scene, only: scene_type
  implicit none (type, external)
  private
  public :: record_stretch, kept_phase

  real(dp), parameter :: least_phase = 1.0e-13_dp     !! rad, that roots keep over the record, whatever the tolerance
  real(dp), parameter :: share = 1.0e-3_dp            !! of a tolerance that phases may take

contains

  pure real(dp) function record_stretch(scene) result(stretch)
    !! Roots keep phases to `least_phase` over this many times the record. Errors of phases grow with time, so that where a
    !! tolerance lets them be larger it is less than 1.
    type(scene_type), intent(in) :: scene
    stretch = 1.0_dp
    if (scene%modes%extended .or. allocated(scene%recontact)) then
      stretch = sqrt(huge(stretch))                   ! calls for extended precision in every root: contacts amplify errors
    else if (by_tolerance(scene%modes)) then
      stretch = min(1.0_dp, least_phase/(share*scene%modes%tolerance))
    end if
  end function record_stretch

  pure real(dp) function kept_phase(scene) result(error)
    !! How far phases may go wrong over the record, rad.
    type(scene_type), intent(in) :: scene
    error = least_phase/record_stretch(scene)
  end function kept_phase

end module bw_record_stretch
